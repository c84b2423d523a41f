"""A person's word on a cause: a confirmed term becomes part of the machine's model."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.ingest.as_imported import as_imported, signed
from autodb.agent.ingest.uncounted import counted
from autodb.agent.learn.learnt_from import wear_words
from autodb.agent.operate.refreshing import learn_confirmed
from autodb.agent.rows.machines import find_machine
from autodb.agent.rows.posteriors import as_posterior, pair_name
from autodb.agent.sense.identifying import (
    KeptModel,
    Refit,
    add_version,
    newest_model,
    refitted,
    stored_terms,
    version_names,
)
from autodb.errors import NotThere, UnusableInput, near
from autodb.explain.engine.candidates import UNKNOWN
from autodb.files.channels import effort_channels
from autodb.records import Recording
from autodb.sensing.drives.feed_axis import cross_test
from autodb.sensing.drives.fit.axis_model import IdentifiedTerm
from autodb.store import Also, Store, models, nothing_else
from autodb.store.models import now
from autodb.terms import COGGING, FRICTION_RIPPLE
from autodb.terms.vocabulary import of_the_machine


@dataclass(frozen=True)
class Decided:
    """A mismatch as it stands after a decision; ``kept``: the version that holds the term now.

    ``error_before``: relative error of the version before on the mismatch' recording, ``error`` of
    ``kept``; None without a version. ``pairs``: the versions of pairs that hold the term, in words.
    ``alternatives``: those that a model could hold; ``stale``:
    numbers of the channel's open mismatches, found before ``kept`` was there.
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
    error_before: float | None = None
    error: float | None = None
    stale: tuple[int, ...] = ()

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
    by: str | None = None,
    progress: Callable[[str], None] = lambda _: None,
    also: Also = nothing_else,
) -> Decided:
    """Confirm a mismatch, as it is named or as one of its alternatives (``term``).

    A term that belongs to the machine is fitted to the mismatch' recording together with those of
    the channel's newest version, which makes the next version; wear found in forces is fitted with
    the law to the cuts of each of its pairs, of all its recordings, and of five outlying cuts
    for another cause a state of the pair is learnt. Decision and version are written together. Any
    other belongs to its recording: only the decision is kept. ``also``: what else is written then.

    Raises UnusableInput when there is no such mismatch or alternative, it was decided otherwise,
    its recording is not there any more, or its moves do not excite the term: it then stays open.
    """
    with store.reading() as session:
        row = mismatch(session, number)
        wanted = _wanted(row, term)
        if _is_decided(row, "confirmed", wanted):
            return _decided(session, row, wanted, already=True)
        step = _fit(session, row, wanted, progress) if wanted in of_the_machine() else None
    with store.writing() as session:
        row = mismatch(session, number)
        if _is_decided(row, "confirmed", wanted):  # another process was faster
            return _decided(session, row, wanted, already=True)
        version = _keep_version(session, row, step) if step else None
        for recording in row.recordings:
            counted(session, recording.id)
        row.confirmed_term = wanted
        _decide(row, "confirmed", by)
        also(session, number)
        done = _decided(session, row, wanted, already=False)
        if done.of_cuts and wanted != UNKNOWN:
            session.flush()
            done = replace(done, pairs=_in_pairs(learn_confirmed(session, row, progress)))
        open_ones = mismatches(session, done.machine, decided=False)
        stale = tuple(one.id for one in open_ones if one.channel == row.channel)
    if step is None or version is None:
        return done
    kept = KeptModel(step.refit.model, version, step.refit.parent, step.refit.already_there)
    return replace(done, kept=kept, error_before=step.before, error=step.after, stale=stale)


def _in_pairs(versions: Sequence[models.CuttingParameters]) -> tuple[str, ...]:
    return tuple(
        f"{pair_name(row.pair)}, {row.state}: version {row.version} from {row.n_cuts} cuts"
        if row.state is not None
        else f"{pair_name(row.pair)}: version {row.version} from {row.n_cuts} cuts: "
        f"{wear_words(as_posterior(row))}"
        for row in versions
    )


def reject(
    store: Store, number: int, *, by: str | None = None, also: Also = nothing_else
) -> Decided:
    """Reject a mismatch. Raises UnusableInput when there is none, or it was confirmed."""
    with store.writing() as session:
        row = mismatch(session, number)
        already = _is_decided(row, "rejected", None)
        if not already:
            _decide(row, "rejected", by)
            also(session, number)
        return _decided(session, row, row.term, already=already)


def mismatch(session: Session, number: int) -> models.Mismatch:
    """Return a mismatch; raises NotThere when there is none of that number."""
    row = session.get(models.Mismatch, number)
    if row is None:
        raise NotThere(
            f"there is no mismatch {number}; list a machine's with 'autodb mismatch list NAME'"
        )
    return row


def _wanted(row: models.Mismatch, term: str | None) -> str:
    """Return the term that is confirmed; raises UnusableInput where the row does not name it."""
    names = [row.term, *(row.alternatives or ())]
    if term is not None and term not in names:
        raise UnusableInput(
            f"--as: mismatch {row.id} may be {' or '.join(names)}, not '{term}'{near(term, names)}"
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
    was = f"{row.status} as {row.confirmed_term}" if row.confirmed_term else row.status
    by = f" by {row.decided_by}" if row.decided_by else ""
    raise UnusableInput(
        f"mismatch {row.id} was {was}{by} on {row.decided_at} already; a decision stands"
    )


def _decide(row: models.Mismatch, status: str, by: str | None) -> None:
    row.status, row.decided_at, row.decided_by = status, now(), by


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


@dataclass(frozen=True)
class _Step:
    """A fit with the term, the version that was the newest then, and the errors of both."""

    refit: Refit
    newest_id: int
    before: float
    after: float


def _fit(
    session: Session, row: models.Mismatch, term: str, progress: Callable[[str], None]
) -> _Step:
    """Fit the newest version's terms and the confirmed one to the mismatch' recording.

    Raises UnusableInput when the moves do not excite the term.
    """
    progress("reading")
    owner = session.get_one(models.Machine, row.recording.machine_id)
    newest = newest_model(session, owner.id, row.channel)
    if newest is None:
        raise UnusableInput(
            f"machine '{owner.name}' has no model of {row.channel}; make one with 'autodb identify'"
        )
    moves = signed(_moves(row), owner)
    progress("fitting")
    names = list(dict.fromkeys([*version_names(newest), term]))
    try:
        refit = refitted(newest, moves, row.recording.sha256, axis=newest.axis, terms=names)
    except UnusableInput as error:
        raise UnusableInput(f"mismatch {row.id} stays open: {error}") from error
    _refuse_unexcited(row, refit, term)
    before, after = (
        cross_test(moves, newest.axis, refit.model.protocol, terms)
        for terms in (stored_terms(newest), refit.model.terms)
    )
    return _Step(refit, newest.id, before, after)


def _moves(row: models.Mismatch) -> Recording:
    """Read a mismatch' recording as it was imported, with no other effort than the mismatch'."""
    try:
        moves = as_imported(row.recording)
    except UnusableInput as error:
        raise UnusableInput(f"mismatch {row.id} stays open: {error}") from None
    if not isinstance(moves, Recording):
        raise UnusableInput(f"{moves.path}: a table of cuts; {row.channel} needs moves over time")
    others = {n for n in effort_channels(list(moves.channels)) if n != row.channel}
    kept = {name: values for name, values in moves.channels.items() if name not in others}
    return replace(moves, channels=kept)


def _refuse_unexcited(row: models.Mismatch, refit: Refit, term: str) -> None:
    if of_term(refit.model.fitted, term):
        return
    needed = [said for said in refit.model.not_excited if said.split(" ", 1)[0] == term]
    raise UnusableInput(
        f"mismatch {row.id} stays open: {Path(row.recording.path).name} does not excite {term}"
        + "".join(f"; {said}" for said in needed[:1])
    )


def of_term(terms: Sequence[IdentifiedTerm], name: str) -> list[IdentifiedTerm]:
    """Return the parameters of a term; asked for as `cogging`, of a ripple of either kind."""
    ripple = FRICTION_RIPPLE.name, FRICTION_RIPPLE.form
    if name == COGGING.name:
        return [t for t in terms if t.term == name or (t.term, t.form) == ripple]
    return [t for t in terms if t.term == name and (t.term, t.form) != ripple]


def _keep_version(session: Session, row: models.Mismatch, step: _Step) -> int:
    """Add the version, or take the newest where it is the same, link it, and return its number.

    Raises UnusableInput when the channel got another version meanwhile: what that one added would
    be lost.
    """
    newest = newest_model(session, row.recording.machine_id, row.channel)
    if newest is None or newest.id != step.newest_id:
        raise UnusableInput(
            f"mismatch {row.id} stays open: {row.channel} got another version during the fit; "
            "run the same command again"
        )
    if not step.refit.already_there:
        newest = add_version(session, row.recording.machine_id, step.refit, row.recording_id)
    row.models.append(newest)
    return newest.version
