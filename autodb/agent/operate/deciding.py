"""A person's word on a cause: a confirmed term becomes part of the machine's model."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from autodb.agent.answer.notes import terms_words
from autodb.agent.ingest.uncounted import counted
from autodb.agent.operate.clamping import keep_runout
from autodb.agent.operate.correcting import correct
from autodb.agent.operate.fitting_confirmed import fit_with, keep_version
from autodb.agent.operate.refreshing import learn_confirmed
from autodb.agent.operate.reversing import take_back
from autodb.agent.rows.machines import find_machine
from autodb.agent.rows.mismatches import decided_words
from autodb.agent.rows.posteriors import as_posterior, pair_name
from autodb.agent.sense.identifying import KeptModel
from autodb.errors import NotThere, UnusableInput, near_words
from autodb.explain.engine.candidates import UNKNOWN
from autodb.fitting.gaussian import NORMAL_95
from autodb.store import Also, Store, models, nothing_else
from autodb.store.models import now
from autodb.terms.term import Home
from autodb.terms.vocabulary import effect_called, of_the_machine, where_kept
from autodb.wording import day, listed, phrase


@dataclass(frozen=True)
class Decided:
    """A mismatch as it stands after a decision; ``kept``: the version that holds the term now.

    ``error_before``: relative error of the version before on the mismatch' recording, ``error`` of
    ``kept``; None without a version. ``pairs``, ``calibrations`` and ``tool``: what holds the term,
    in words; ``back``: those that were taken back; ``notes``: what was not learnt from, and
    why. ``alternatives``: those that a model could
    hold; ``stale``: numbers of the channel's open mismatches, found before ``kept`` was there.
    """

    number: int
    machine: str
    recording: str
    channel: str
    term: str
    already: bool
    alternatives: tuple[str, ...] = ()
    kept: KeptModel | None = None
    pairs: tuple[str, ...] = ()
    calibrations: tuple[str, ...] = ()
    tool: str | None = None
    back: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    error_before: float | None = None
    error: float | None = None
    stale: tuple[int, ...] = ()

    @property
    def changed(self) -> tuple[str, ...]:
        """What holds the term now, of a cause found in forces, in words."""
        return (*([] if self.tool is None else [self.tool]), *self.calibrations, *self.pairs)

    @property
    def home(self) -> Home:
        """Where its term is kept once it is confirmed."""
        return where_kept(self.term, self.channel)

    @property
    def of_cuts(self) -> bool:
        """Whether it was found in the forces of cuts."""
        return self.channel.startswith("force.")


def mismatches(session: Session, machine: str, *, decided: bool) -> Sequence[models.Mismatch]:
    """Return a machine's open mismatches, or all of them, oldest first."""
    owner = find_machine(session, machine)
    query = (
        select(models.Mismatch)
        .join(models.Mismatch.recording)
        .where(models.StoredRecording.machine_id == owner.id)
        .order_by(models.Mismatch.id)
    )
    return session.scalars(
        query if decided else query.where(models.Mismatch.status == "open")
    ).all()


def confirm(
    store: Store,
    number: int,
    *,
    term: str | None = None,
    lot: str | None = None,
    by: str | None = None,
    why: str | None = None,
    progress: Callable[[str], None] = lambda _: None,
    also: Also = nothing_else,
) -> Decided:
    """Confirm a mismatch, as it is named or as one of its alternatives (``term``).

    Where the term belongs decides what changes (``autodb.terms.term.Home``). A machine's is fitted
    to the mismatch' recording together with those of the channel's newest version, which makes the
    next version. One of a pair, or of a ``lot`` of its material, is fitted with the law to the cuts
    of each pair, of all its recordings; a gain corrects the calibrations of its force. Of five
    outlying cuts for a cause that a pair cannot hold a state of the pair is learnt. Decision and
    version are written together. Any other belongs to its recording: only the decision is kept.
    ``why``: the reason that is kept with it; ``also``: what else is written then.

    Raises UnusableInput when there is no such mismatch or alternative, it was decided otherwise,
    its recording is not there any more, or its moves do not excite the term: it then stays open.
    """
    with store.reading() as session:
        row = mismatch(session, number)
        wanted = _wanted(row, term)
        if _is_decided(row, "confirmed", wanted):
            return _decided(session, row, wanted, already=True)
        _refuse_lot(wanted, lot)
        step = fit_with(session, row, wanted, progress) if wanted in of_the_machine() else None
    with store.writing() as session:
        row = mismatch(session, number)
        if _is_decided(row, "confirmed", wanted):  # another process was faster
            return _decided(session, row, wanted, already=True)
        version = keep_version(session, row, step) if step else None
        _count(session, row)
        _decide(row, "confirmed", wanted, by=by, why=why)
        also(session, number)
        done = _decided(session, row, wanted, already=False)
        if done.of_cuts and wanted != UNKNOWN:
            session.flush()
            done = _in_forces(session, row, done, lot=lot, progress=progress)
        open_ones = mismatches(session, done.machine, decided=False)
        stale = tuple(one.id for one in open_ones if one.channel == row.channel)
    if step is None or version is None:
        return done
    kept = KeptModel(step.refit.model, version, step.refit.parent, step.refit.already_there)
    return replace(done, kept=kept, error_before=step.before, error=step.after, stale=stale)


def _in_forces(
    session: Session,
    row: models.Mismatch,
    done: Decided,
    *,
    lot: str | None,
    progress: Callable[[str], None],
) -> Decided:
    """Put a cause found in forces where it belongs; return the decision with what changed."""
    if done.home == "tool":
        return replace(done, tool=keep_runout(session, row))
    corrected = correct(session, row) if done.home == "calibration" else []
    pairs, notes = learn_confirmed(session, row, progress, lot=lot)
    said = _in_calibrations(row, corrected)
    return replace(done, calibrations=said, pairs=_in_pairs(pairs), notes=tuple(notes))


def _count(session: Session, row: models.Mismatch) -> None:
    """Have recordings count that came in to be explained alone, and keep which."""
    looked_at = [one.id for one in row.recordings if one.looked_at is not None]
    for number in looked_at:
        counted(session, number)
    if looked_at:
        row.applied = {**(row.applied or {}), "recordings": looked_at}


def _refuse_lot(term: str, lot: str | None) -> None:
    """Raise UnusableInput where a lot is named of what belongs to none."""
    if lot is not None and effect_called(term).belongs_to != "lot":
        raise UnusableInput(
            phrase("--lot: {term} is of no lot of material; leave out --lot", term=term)
        )


def _in_calibrations(
    row: models.Mismatch, made: Sequence[models.CalibrationVersion]
) -> tuple[str, ...]:
    """Return corrected calibrations in words."""
    return tuple(
        phrase(
            "calibration of {axis}: version {version}: {channel} is divided by {factor} ± {half} "
            "from recording {number} on",
            axis=one.axis, version=one.version, channel=row.channel,
            factor=f"{one.corrections[-1]['factor']:.3g}",
            half=f"{NORMAL_95 * one.corrections[-1]['sd']:.2g}",
            number=one.corrections[-1]["recording"]
        )
        for one in made
        if one.corrections
    )  # fmt: skip


def _in_pairs(versions: Sequence[models.CuttingParameters]) -> tuple[str, ...]:
    return tuple(_in_pair(row) for row in versions)


def _in_pair(row: models.CuttingParameters) -> str:
    pair = pair_name(row.pair)
    called = pair if row.state is None else f"{pair}, {row.state}"
    said = phrase(
        "{pair}: version {version} from {count} cuts",
        pair=called, version=row.version, count=row.n_cuts
    )  # fmt: skip
    if row.state is not None:
        return said
    held = (str(one.confirmed_term) for one in row.mismatches)
    terms = [*terms_words(as_posterior(row), held)]
    return listed([said, listed(terms, "; ")], ": ") if terms else said


def reject(
    store: Store,
    number: int,
    *,
    by: str | None = None,
    why: str | None = None,
    also: Also = nothing_else,
) -> Decided:
    """Reject a mismatch; what confirming it had changed is taken back (``reversing``).

    Raises UnusableInput when there is none.
    """
    return _taken_back(store, number, "rejected", by=by, why=why, also=also)


def reopen(
    store: Store,
    number: int,
    *,
    by: str | None = None,
    why: str | None = None,
    also: Also = nothing_else,
) -> Decided:
    """Take back the decision on a mismatch, and what it had changed (``reversing``).

    Raises UnusableInput when there is none.
    """
    return _taken_back(store, number, "open", by=by, why=why, also=also)


def _taken_back(
    store: Store, number: int, status: str, *, by: str | None, why: str | None, also: Also
) -> Decided:
    """Give a mismatch a status in which it changes nothing; what it had changed is taken back."""
    with store.writing() as session:
        row = mismatch(session, number)
        already, back = row.status == status, list[str]()
        if not already:
            back = take_back(session, row)
            if status == "rejected":
                last = session.scalar(select(func.max(models.CuttingParameters.id)))
                row.applied = {"after": last or 0}
            _decide(row, status, None, by=by, why=why)
            also(session, number)
        return replace(_decided(session, row, row.term, already=already), back=tuple(back))


def mismatch(session: Session, number: int) -> models.Mismatch:
    """Return a mismatch; raises NotThere when there is none of that number."""
    row = session.get(models.Mismatch, number)
    if row is None:
        raise NotThere(
            phrase(
                "there is no mismatch {number}; list a machine's with "
                "'autodb mismatch list --machine NAME'",
                number=number,
            )
        )
    return row


def _wanted(row: models.Mismatch, term: str | None) -> str:
    """Return the term that is confirmed; raises UnusableInput where the row does not name it."""
    names = [row.term, *(row.alternatives or ())]
    if term is not None and term not in names:
        raise UnusableInput(
            phrase(
                "--as: mismatch {number} may be {names}, not '{term}'{hint}",
                number=row.id,
                names=listed(names, phrase(" or ")),
                term=term,
                hint=near_words(term, names),
            )
        )
    return term or row.term


def _is_decided(row: models.Mismatch, status: str, term: str | None) -> bool:
    """Say whether a mismatch was decided like this already; an unknown one may get its name later.

    Raises UnusableInput when it was decided otherwise: a version may rest on that.
    """
    named_late = row.confirmed_term == UNKNOWN and status == "confirmed" and term != UNKNOWN
    if row.status == "open" or named_late:
        return False
    if (row.status, row.confirmed_term) == (status, term):
        return True
    was = decided_words(row.status, row.confirmed_term, row.decided_by)
    raise UnusableInput(
        phrase(
            "mismatch {number} was {decided} on {day} already; take that back first with "
            "'autodb mismatch reopen {number}'",
            number=row.id,
            decided=was,
            day=day(str(row.decided_at)),
        )
    )


def _decide(
    row: models.Mismatch, status: str, term: str | None, *, by: str | None, why: str | None
) -> None:
    """Keep a decision as what stands now, and in the history."""
    at = now()
    row.status, row.confirmed_term, row.decided_by = status, term, by
    row.decided_at = None if status == "open" else at
    if status == "open":
        row.decided_by = None
    row.decisions.append(
        models.MismatchDecision(status=status, term=term, why=why, decided_by=by, decided_at=at)
    )


def _decided(session: Session, row: models.Mismatch, term: str, *, already: bool) -> Decided:
    return Decided(
        number=row.id,
        machine=session.get_one(models.Machine, row.recording.machine_id).name,
        recording=Path(row.recording.path).name,
        channel=row.channel,
        term=term,
        already=already,
        alternatives=tuple(name for name in row.alternatives or () if name in of_the_machine()),
    )
