"""Refresh: what came in since the last time becomes sensed forces and new parameter versions.

One pass is one transaction, and goes on from the mark that the last one left: killed in the middle,
the database is as it was, and the next pass does its work again. So it is where a server went away.

Watch an inbox: a pass whenever something came in, for as long as nobody stops it.
"""

import time
from collections.abc import Callable
from contextlib import AbstractContextManager

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from autodb.agent.answer.drifted_gains import open_drifted_gains
from autodb.agent.answer.pooled.asked_before import AskedBefore
from autodb.agent.answer.pooled.pooled_mismatches import NotUsual, open_mismatches
from autodb.agent.ingest.entries import inbox_entries
from autodb.agent.ingest.inbox import Inbox
from autodb.agent.learn.inferred_bands import infer_speed_band
from autodb.agent.learn.inferred_edges import infer_edge_changes, newest_cuts, newest_forces
from autodb.agent.learn.inferred_hardness import open_harder_work
from autodb.agent.learn.learning import AT_ONCE, learn_pair
from autodb.agent.learn.lots import name_lot
from autodb.agent.learn.passes import (
    PassRecord,
    RefreshReport,
    files_came_in,
    files_since,
    keep_pass,
)
from autodb.agent.matching.made_cuts import match_new
from autodb.agent.matching.taken_by_cuts import take_new_forces
from autodb.agent.operate.retaining import retain
from autodb.agent.rows.machines import find_machine
from autodb.agent.rows.posteriors import latest, pair_name
from autodb.agent.rows.refresh_cursor import Span, basis_of, last_mark, next_span
from autodb.agent.rows.sensed_forces import Calibrations, forces_of_pair
from autodb.agent.sense.due import calibrations_due
from autodb.agent.sense.measured import measure_over_time
from autodb.agent.sense.over_time import feel_over_time
from autodb.agent.sense.ranging import known_otherwise, sense_cuts
from autodb.store import Store, models, retried
from autodb.terms.chip import HARD_SPOT
from autodb.wording import stored_msgid

Progress = Callable[[str], None]
NO_FORCE = stored_msgid(
    "no force was measured and no calibration is usable, so no force is known; import cuts with "
    "force.*, or run 'autodb calibrate'"
)
UPDATING = stored_msgid("updating {pair}: {k} of {n}")
"""Step of a pass: a pair, which one of those that have something to learn it is."""


def refresh(
    store: Store, machine: str, *, inbox: Inbox | None = None, progress: Progress | None = None
) -> RefreshReport:
    """Sense the forces of every cut not sensed yet with the newest calibrations; update the pairs.

    Cuts of recordings over time are sensed by what the machine has beside calibrated ranges. Cuts
    that are not of a pair's usual state are explained, and mismatches opened for them. Many new
    cuts are several passes. In the end recordings are compressed and dropped that the machine's
    file says are old.

    ``inbox``: a folder whose recordings are imported first. Raises UnusableInput for an unknown
    machine, or an inbox that is no folder.
    """
    tell = progress or (lambda _: None)
    done = RefreshReport()
    if inbox is not None:
        done.set_aside += retried(lambda: inbox.take_in(store, machine, tell), tell)
    done.set_aside += retried(lambda: measure_over_time(store, machine, progress=tell), tell)
    over_time = retried(lambda: feel_over_time(store, machine, progress=tell), tell)
    done.set_aside += over_time.notes
    examined = -1
    while examined < over_time.last_cut:
        one, examined = retried(lambda: _one_pass(store, machine, over_time.last_cut, tell), tell)
        done.also(one)
    done.retained = retried(lambda: retain(store, machine, progress=tell), tell).lines()
    return done


def _one_pass(
    store: Store, machine: str, newest_cut: int, progress: Progress
) -> tuple[RefreshReport, int]:
    """Do one pass; return what it did, and the last cut that it examined."""
    with store.writing(machine) as session:
        one = _Pass(session, find_machine(session, machine), newest_cut, progress)
        return one.run(), one.span.upto


class _Pass:
    """One pass over a span of a machine's cuts."""

    def __init__(
        self, session: Session, owner: models.Machine, newest_cut: int, progress: Progress
    ) -> None:
        self._session, self._owner, self._progress = session, owner, progress
        self._basis = basis_of(session, owner)
        mark = last_mark(session, owner.id)
        self.span = next_span(session, owner.id, mark, self._basis, newest_cut=newest_cut)
        self._asked = AskedBefore(() if mark is None else mark.asked)
        self._files = files_since(session, owner.id)
        self._wearing: list[int] = []
        self._done = RefreshReport(came_in=files_came_in(session, self._files, self.span))

    def run(self) -> RefreshReport:
        """Sense, learn and explain; keep that it was done where there was anything to do."""
        done, session, owner = self._done, self._session, self._owner
        sensed = sense_cuts(session, owner, self.span, self._progress)
        if not sensed and not known_otherwise(session, owner.id):
            done.set_aside.append(NO_FORCE)
        self._match(sensed)
        outliers: list[int] = []
        pairs = [session.get_one(models.Pair, pair_id) for pair_id in self._pairs()]
        for k, pair in enumerate(pairs, start=1):
            self._progress(UPDATING.format(pair=pair_name(pair), k=k, n=len(pairs)))
            outliers += self._learn(pair, sensed)
        done.mismatches += open_drifted_gains(session, owner, self.span, sensed)
        strange = NotUsual(outliers, self._wearing, self.span.upto)
        done.mismatches += open_mismatches(
            session, owner, strange, self._asked, progress=self._progress
        )
        done.measured, done.sensed, done.not_sensed = self._counted()
        done.due, done.waiting = calibrations_due(session, owner, self.span), self._waiting()
        if done.anything or self.span.anew or self.span.upto > self.span.old:
            kept = PassRecord(done, self.span, self._basis, self._files, self._asked.rows)
            keep_pass(session, owner.id, kept)
        return done

    def _match(self, sensed: list[Calibrations]) -> None:
        """Link new cuts with what was predicted of them, and keep what they took."""
        session, owner, span = self._session, self._owner, self.span
        found = match_new(session, owner, after=span.old, upto=span.upto)
        self._done.predicted, self._done.asked = len(found.links), found.asked
        take_new_forces(session, owner, span, sensed)

    def _waiting(self) -> int:
        """Return how many of the machine's mismatches nobody has decided on."""
        query = (
            select(func.count())
            .select_from(models.Mismatch)
            .join(models.StoredRecording)
            .where(
                models.StoredRecording.machine_id == self._owner.id,
                models.Mismatch.status == "open",
            )
        )
        return self._session.scalar(query) or 0

    def _learn(self, pair: models.Pair, sensed: list[Calibrations]) -> list[int]:
        """Learn a pair; return the outlying cuts, by id."""
        span = self.span
        after = span.old if self._goes_on(pair) else 0
        cuts = (after, span.upto)
        found = forces_of_pair(self._session, self._owner.id, pair, sensed, cuts=cuts)
        self._infer(pair, sensed)
        outcome = learn_pair(
            self._session, self._owner.id, found, old=span.old, progress=self._progress
        )
        self._done.versions += outcome.versions
        self._done.shifts += outcome.shifts
        self._done.set_aside += outcome.not_used
        self._done.mismatches += open_harder_work(self._session, found, outcome.harder)
        return outcome.outliers

    def _infer(self, pair: models.Pair, sensed: list[Calibrations]) -> None:
        """Look in a pair's newest cuts for what nobody wrote down, before they are learnt."""
        session, owner, upto = self._session, self._owner, self.span.upto
        recent = newest_forces(session, owner.id, pair, sensed, upto=upto)
        newest = newest_cuts(session, owner.id, recent)
        if newest is not None:
            self._done.mismatches += infer_edge_changes(session, newest)
            self._wearing += [pair.id] if newest.show_wear else []
        if pair.id not in self._wearing:  # what nothing is known of yet would pass for other things
            self._done.mismatches += infer_speed_band(session, owner.id, recent, upto=upto)

    def _goes_on(self, pair: models.Pair) -> bool:
        """Say whether new cuts change a pair's posterior; what was learnt is left as it is."""
        if self.span.anew or pair.id in self._stirred():
            return False
        last = latest(self._session, self._owner.id, pair.id)
        return last is not None and last.n_cuts >= AT_ONCE

    def _pairs(self) -> list[int]:
        """Return the pairs, by id, that may have something to learn."""
        own = select(models.Cut.pair_id).where(
            models.Cut.id > (0 if self.span.anew else self.span.old),
            models.Cut.id <= self.span.upto,
            models.Cut.pair_id.is_not(None),
            models.Cut.recording.has(machine_id=self._owner.id),
        )
        found = {number for number in self._session.scalars(own.distinct()) if number is not None}
        return sorted(found | self._stirred())

    def _stirred(self) -> set[int]:
        """Return the pairs, by id, of old cuts that have new forces: a part was inspected, say."""
        of_old = select(models.SensedForce.cut_id).where(
            models.SensedForce.id > self.span.force, models.SensedForce.cut_id <= self.span.old
        )
        pairs = (
            select(models.Cut.pair_id)
            .where(
                models.Cut.id.in_(of_old),
                models.Cut.pair_id.is_not(None),
                models.Cut.recording.has(machine_id=self._owner.id),
            )
            .distinct()
        )
        return {number for number in self._session.scalars(pairs) if number is not None}

    def _counted(self) -> tuple[int, int, int]:
        """Return how many forces were measured, sensed, and not sensed since the last pass."""
        own = models.Cut.recording.has(machine_id=self._owner.id)
        query = select(
            func.count(models.SensedForce.errors),
            func.count(models.SensedForce.value_N),
            func.count(),
        ).where(
            models.SensedForce.id > self.span.force,
            models.SensedForce.cut_id <= self.span.upto,
            models.SensedForce.cut.has(own),
        )
        measured, known, every = self._session.execute(query).one()
        return measured, known - measured, every - known


def learn_confirmed(
    session: Session, row: models.Mismatch, progress: Progress, *, lot: str | None = None
) -> tuple[list[models.CuttingParameters], list[str]]:
    """Learn the pairs of a confirmed mismatch; return their newest versions that do, or are new.

    And what is to be said of cuts that are not used. ``lot``: of the material that a hard spot is
    of; None: as its cuts say.
    """
    said, made = list[str](), models.CuttingParameters
    last = session.scalar(select(func.max(made.id))) or 0
    owner = session.get_one(models.Machine, row.recording.machine_id)
    newest_cut = session.scalar(select(func.max(models.Cut.id))) or 0
    every = Span(0, newest_cut, old=newest_cut, force=0, anew=True)
    sensed = sense_cuts(session, owner, every, progress)
    if row.confirmed_term == HARD_SPOT.name and row.lot is None:
        name_lot(session, row, lot, upto=newest_cut)
    cuts = [cut for recording in row.recordings for cut in recording.cuts]
    pairs = {cut.pair_id: cut.pair for cut in cuts if cut.pair is not None}
    if row.pairs:
        pairs = {pair.id: pair for pair in row.pairs}
    for _, pair in sorted(pairs.items(), key=lambda one: one[0] or 0):
        progress(f"updating {pair_name(pair)}")
        forces = forces_of_pair(session, owner.id, pair, sensed)
        said += learn_pair(session, owner.id, forces, progress=progress).not_used
    session.flush()
    session.refresh(row)
    held = [one for one in row.parameters_of_pairs if one.undone_at is None]
    new = session.scalars(select(made).where(made.id > last).order_by(made.id)).all()
    return list({(one.pair_id, one.state): one for one in (*held, *new)}.values()), said


Opens = Callable[[], AbstractContextManager[Store]]
Excuse = Callable[[Exception], str | None]


def watch(
    opens: Opens,
    machine: str,
    inbox: Inbox,
    *,
    tell: Callable[[RefreshReport], None],
    say: Callable[[str], None],
    excuse: Excuse,
    every_s: float,
    progress: Progress = lambda _: None,
    goes_on: Callable[[], bool] = lambda: True,
) -> None:
    """Refresh a machine whenever files came into its inbox, while ``goes_on``.

    The first pass is made at once, and what is wrong with it is raised. Later, what ``excuse`` has
    a line for (a database that is locked or away, a folder that is not there) is said once and
    tried again: the files wait in the inbox.
    """
    with opens() as store:
        tell(refresh(store, machine, inbox=inbox, progress=progress))
    seen, said = inbox_entries(inbox.folder).files, ""
    while goes_on():
        time.sleep(every_s)
        try:
            there = inbox_entries(inbox.folder).files
            if there == seen and not said:
                continue
            with opens() as store:
                done = refresh(store, machine, inbox=inbox, progress=progress)
            if done.anything:
                tell(done)
            seen, said = there, ""
        except Exception as error:
            line = excuse(error)
            if line is None:
                raise
            if line != said:
                say(f"{line}; trying again every {every_s:g} s")
            said = line
