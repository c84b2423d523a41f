"""What a pair's cuts of all recordings have in common is kept as one mismatch a cause.

When more cuts of it come in, it is brought up to date; what a person rejected is not opened again
for the same recordings.
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session, selectinload

from autodb.agent.answer.explaining import Key, cause_columns, key_of
from autodb.agent.answer.pooled.asked_before import GROWN, AskedBefore, KeptInquiry, kept_inquiry
from autodb.agent.answer.pooled.pooling import PooledCuts, cuts_of_pair
from autodb.agent.learn.inferred_hardness import inferred_harder_cuts
from autodb.agent.learn.learnt_from import excluded_cuts
from autodb.agent.rows.mismatches import is_cause, mismatch_line, recordings_of
from autodb.agent.rows.posteriors import latest
from autodb.agent.rows.recorded_edges import edge_label
from autodb.agent.rows.recordings import counted_cuts
from autodb.agent.rows.sensed_forces import usable
from autodb.explain import Explained
from autodb.explain.engine.candidates import UNKNOWN
from autodb.pairs.posterior import WEAR
from autodb.store import models
from autodb.wording import stored_msgid

MOST = 400
"""Cuts that are explained together at most, of the newest recordings. Chosen: some 10 s of work."""
LOOKED_BACK = 10_000
"""Cuts of a pair among which excluded ones are looked for, the newest: older ones were new once.
Chosen."""
EXPLAINING = stored_msgid("explaining {called}")


@dataclass(frozen=True)
class NotUsual:
    """What a pass found to be explained, by id: outlying cuts, and pairs all of whose cuts together
    show wear that is not expected. ``upto``: the last cut that was examined.
    """

    outlying_cuts: Sequence[int]
    wearing_pairs: Sequence[int]
    upto: int


def open_mismatches(
    session: Session,
    owner: models.Machine,
    strange: NotUsual,
    asked: AskedBefore,
    *,
    progress: Callable[[str], None] = lambda _: None,
) -> list[str]:
    """Explain what excluded cuts have in common, and wear; keep it as mismatches.

    Of each pair all cuts of recordings that hold excluded ones and that nobody has decided on; for
    wear that these do not name, all cuts. What is explained already is left as it is, and what was
    ``asked`` of the same evidence is not asked again; what is asked now is kept there. Returns
    what to say.
    """
    said, of = [], _PairPools(session, owner, strange)
    for pool in of.outlying():
        said += _explained(of, pool, asked, progress)
    for number in strange.wearing_pairs:
        pair = session.get_one(models.Pair, number)
        of_excluded = of.pair(pair)
        if not (of_excluded.cuts and _is_known(session, of_excluded, term=WEAR)):
            said += _explained(of, of.pair(pair, about=WEAR), asked, progress)
    return said


def _explained(
    of: "_PairPools", pool: PooledCuts, asked: AskedBefore, progress: Callable[[str], None]
) -> list[str]:
    """Explain a pool, if it is not known, and keep what is found; return what to say."""
    session, owner = of.session, of.owner
    if not pool.cuts or _is_known(session, pool):
        return []
    before = asked.about(pool)
    if before is not None and _is_much_the_same(of, pool, before):
        return []
    found = pool.explainable(session, owner)
    if found is None:
        return []
    now = kept_inquiry(session, owner, pool, found)
    if before is not None and before.says_the_same(now):
        return []
    progress(EXPLAINING.format(called=pool.called))
    asked.keep(now)
    return _Keeping(session, pool).kept(found.explained())


def _is_much_the_same(of: "_PairPools", pool: PooledCuts, before: KeptInquiry) -> bool:
    """Say whether all cuts of a pair that were asked ``before`` say the same still.

    And fewer than a GROWN share of them came since, none of them excluded. Never of what excluded
    cuts have in common.
    """
    if pool.pair is None or pool.about is None:
        return False
    if any(number > before.upto for number in pool.excluded):
        return False
    if sum(cut.id > before.upto for cut in pool.cuts) >= GROWN * before.cuts:
        return False
    then = of.pair(pool.pair, about=pool.about, asked=before)
    found = then.explainable(of.session, of.owner) if then.cuts else None
    return found is not None and before.says_the_same(
        kept_inquiry(of.session, of.owner, then, found)
    )


class _PairPools:
    """What to explain of a machine's pairs, by what a pass found."""

    def __init__(self, session: Session, owner: models.Machine, strange: NotUsual) -> None:
        self.session, self.owner, self._strange = session, owner, strange
        self._excluded: dict[int, Sequence[models.Cut]] = {}

    def outlying(self) -> list[PooledCuts]:
        """Return each pair's cuts, or all of a recording, where no pair has another.

        As few cuts of several pairs as one file may hold tell more together.
        """
        outlying = models.Cut.id.in_(self._strange.outlying_cuts)
        new = self.session.scalars(select(models.Cut).where(outlying)).all()
        pairs = {cut.pair.id: cut.pair for cut in new if cut.pair is not None}
        pools = [self.pair(pair) for _, pair in sorted(pairs.items())]
        pools = [pool for pool in pools if pool.cuts]
        shared = {row.id for pool in pools if len(pool.recordings) > 1 for row in pool.recordings}
        found: dict[tuple[int, int], PooledCuts] = {}
        for pool in pools:
            first = pool.recordings[0]
            whole = [cut for cut in counted_cuts(first) if usable(cut)]
            several = len({cut.pair_id for cut in whole}) > 1
            if len(pool.recordings) == 1 and several and first.id not in shared:
                found[(0, first.id)] = PooledCuts(None, whole, pool.excluded)
            elif pool.pair is not None:
                found[(pool.pair.id, 0)] = pool
        return list(found.values())

    def pair(
        self, pair: models.Pair, *, about: str | None = None, asked: KeptInquiry | None = None
    ) -> PooledCuts:
        """Return a pair's cuts of its newest recordings that nobody has decided on.

        Of those that hold excluded cuts; of all, where it is explained for what they are ``about``.
        ``asked``: those that it was asked of, as they are now; None: the newest MOST.
        """
        excluded = self._excluded_of(pair)
        there = {cut.recording_id: cut.recording for cut in excluded}
        if about is not None:
            there = {row.id: row for row in self._recordings_of(pair, asked)}
        held = _held_by(self.session, self.owner, pair)
        decided = _decided(self.session, pair, there, held=held)
        cuts: list[models.Cut] = []
        for number in sorted(there.keys() - decided, reverse=True):
            own = cuts_of_pair(there[number], pair)
            if asked is not None:
                own = [cut for cut in own if cut.id <= asked.upto]
            elif cuts and len(cuts) + len(own) > MOST:
                break
            cuts = [*own, *cuts]
        return PooledCuts(pair, cuts, frozenset(cut.id for cut in excluded), about)

    def _excluded_of(self, pair: models.Pair) -> Sequence[models.Cut]:
        """Return the excluded ones among a pair's newest cuts, asked for once.

        But those of harder work: what they are was found while the pair was learnt.
        """
        if pair.id not in self._excluded:
            every = excluded_cuts(
                self.session, self.owner.id, pair.id, upto=self._strange.upto, newest=LOOKED_BACK
            )
            known = inferred_harder_cuts(self.session, pair.id)
            self._excluded[pair.id] = [cut for cut in every if cut.id not in known]
        return self._excluded[pair.id]

    def _recordings_of(
        self, pair: models.Pair, asked: KeptInquiry | None
    ) -> Sequence[models.StoredRecording]:
        """Return the recordings of a pair's newest MOST cuts that count, or of those ``asked``."""
        recording, cut = models.StoredRecording, models.Cut
        newest = select(cut.recording_id).where(
            cut.recording.has(machine_id=self.owner.id),
            cut.pair_id == pair.id,
            cut.id <= self._strange.upto,
            models.counting_cut(cut.superseded_at),
        )
        if asked is None:
            newest = newest.order_by(cut.id.desc()).limit(MOST)
        else:
            newest = newest.where(cut.recording_id >= asked.since, cut.id <= asked.upto)
        query = select(recording).where(recording.id.in_(newest))
        return self.session.scalars(query.options(selectinload(recording.cuts))).all()


def _held_by(session: Session, owner: models.Machine, pair: models.Pair) -> set[int]:
    """Return the confirmed mismatches, by id, that a pair's newest posterior has in it."""
    usual = latest(session, owner.id, pair.id)
    return set() if usual is None else {row.id for row in usual.mismatches}


def _decided(
    session: Session, pair: models.Pair, recordings: Iterable[int], *, held: Collection[int]
) -> set[int]:
    """Return the recordings, by id, of which a cause is confirmed, or all are rejected.

    Confirmed ones that the pair's posterior has in it (``held``) are expected, and decide nothing.
    """
    rows = [row for row in _found_in(session, pair, recordings) if row.id not in held]
    confirmed, rejected, waiting = (
        recordings_of(row for row in rows if row.status == status)
        for status in ("confirmed", "rejected", "open")
    )
    return confirmed | (rejected - waiting)


def _found_in(
    session: Session, pair: models.Pair | None, recordings: Iterable[int]
) -> Sequence[models.Mismatch]:
    """Return the mismatches of a pair's forces in some recordings, by id, oldest first.

    A drifted gain and a new edge are not among them.
    """
    query = select(models.Mismatch).where(
        models.Mismatch.found_in_any(list(recordings)), models.Mismatch.channel.startswith("force.")
    )
    if pair is not None:
        query = query.where(models.Mismatch.of_pair(pair.id))
    rows = session.scalars(query.order_by(models.Mismatch.id))
    return [row for row in rows if is_cause(row)]


def _is_known(session: Session, pool: PooledCuts, *, term: str | None = None) -> bool:
    """Say whether all that would be explained was, together, and no cut came to it since.

    ``term``: whether a mismatch of that name is one of what was found.
    """
    numbers = {row.id for row in pool.recordings}
    for row in _found_in(session, pool.pair, numbers):
        cuts = None if row.found_in is None else row.found_in["cuts"]
        as_now = numbers <= recordings_of([row]) and cuts in (None, len(_all_cuts(row, pool)))
        if as_now and term in (None, row.term):
            return True
    return False


def _all_cuts(row: models.Mismatch, pool: PooledCuts) -> list[models.Cut]:
    """Return the cuts that count of all recordings of a mismatch, of the pool's pair."""
    if pool.pair is None:
        return pool.cuts
    return [cut for one in row.recordings for cut in cuts_of_pair(one, pool.pair)]


class _Keeping:
    """What is there of a pool's mismatches, and how an explanation changes it."""

    def __init__(self, session: Session, pool: PooledCuts) -> None:
        self._session, self._pool = session, pool
        self._known = _found_in(session, pool.pair, [row.id for row in pool.recordings])

    def kept(self, explained: Explained) -> list[str]:
        """Open a mismatch for each new cause, bring those up to date that are open; say which."""
        said = []
        for channel, answer in explained.explanation.channels.items():
            of_it = [one for one in answer.missing if self._pool.about in (None, one.term)]
            causes = {(channel, one.term, one.kind): one for one in reversed(of_it)}
            for key, cause in reversed(causes.items()):
                columns = cause_columns(channel, answer, cause)
                named = UNKNOWN not in {one.term for one in of_it}
                again = self._open_one(key, named=named)
                row = again or self._new_one(columns)
                if row is None:
                    continue
                if again is not None:
                    self._bring_up_to_date(again, columns)
                row.found_in = self._counted(row)
                self._session.add(row)
                self._session.flush()
                said.append(mismatch_line(row, again=again is not None))
        return said

    def _open_one(self, key: Key, *, named: bool) -> models.Mismatch | None:
        """Return the open mismatch of a cause; where all are ``named``, one unknown as yet."""
        alike = self._waiting(key)
        if not alike and named:
            alike = self._waiting((key[0], UNKNOWN, key[2]))
        return next(iter(alike), None)

    def _waiting(self, key: Key) -> list[models.Mismatch]:
        """Return the open mismatches of a cause that were found in no other pair's cuts."""
        return [
            row
            for row in self._known
            if row.status == "open" and key_of(row) == key and self._is_of_pair(row)
        ]

    def _is_of_pair(self, row: models.Mismatch) -> bool:
        """Say whether a mismatch is of the pool's pair alone; of a whole recording, if that is."""
        pair = self._pool.pair
        if pair is None or row.pairs:
            return row.pairs == ([] if pair is None else [pair])
        cuts = [cut for one in row.recordings for cut in counted_cuts(one)]
        return {cut.pair_id for cut in cuts} == {pair.id}

    def _new_one(self, columns: dict[str, object]) -> models.Mismatch | None:
        """Return a mismatch of the recordings in which nobody has decided on this cause yet."""
        key = columns["channel"], columns["term"], columns["kind"]
        decided = recordings_of(row for row in self._known if key_of(row) == key)
        left = [row for row in self._pool.recordings if row.id not in decided]
        if not left:
            return None
        pairs = [] if self._pool.pair is None else [self._pool.pair]
        return models.Mismatch(recording=left[0], further=left[1:], pairs=pairs, **columns)

    def _bring_up_to_date(self, row: models.Mismatch, columns: dict[str, object]) -> None:
        """Have an open mismatch hold what all recordings show; others of the same cause end."""
        for name, value in columns.items():
            setattr(row, name, value)
        same = [one for one in self._waiting(key_of(row)) if one is not row]
        for one in same:
            one.status, one.decided_at = "rejected", models.now()
            one.decided_by = f"refresh, as one with mismatch {row.id}"
        every = [*self._pool.recordings, *(r for one in same for r in one.recordings)]
        there = recordings_of([row])
        row.further += list({one.id: one for one in every if one.id not in there}.values())
        row.pairs = [] if self._pool.pair is None else [self._pool.pair]

    def _counted(self, row: models.Mismatch) -> dict[str, object] | None:
        """Return what a mismatch keeps of the cuts that it was found in."""
        if self._pool.pair is None:
            return None
        cuts = _all_cuts(row, self._pool)
        edges = {label for label in map(edge_label, cuts) if label is not None}
        return {
            "cuts": len(cuts),
            "excluded": len({cut.id for cut in cuts} & self._pool.excluded),
            "edges": sorted(edges),
        }
