"""A confirmed term of a machine, fitted with the newest version's to the mismatch' recording."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from sqlalchemy.orm import Session

from autodb.agent.ingest.as_imported import as_imported, signed
from autodb.agent.sense.identifying import (
    Refit,
    add_version,
    newest_model,
    refitted,
    stored_terms,
    version_names,
)
from autodb.errors import UnusableInput
from autodb.files.channels import effort_channels
from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import cross_test
from autodb.sensing.drives.fit.axis_model import IdentifiedTerm
from autodb.store import models
from autodb.terms.drive import COGGING, FRICTION_RIPPLE
from autodb.wording import listed, phrase


@dataclass(frozen=True)
class ConfirmedFit:
    """A fit with the term, the version that was the newest then, and the errors of both."""

    refit: Refit
    newest_id: int
    before: float
    after: float


def fit_with(
    session: Session, row: models.Mismatch, term: str, progress: Callable[[str], None]
) -> ConfirmedFit:
    """Fit the newest version's terms and the confirmed one to the mismatch' recording.

    Raises UnusableInput when the moves do not excite the term.
    """
    progress("reading")
    owner = session.get_one(models.Machine, row.recording.machine_id)
    newest = newest_model(session, owner.id, row.channel)
    if newest is None:
        raise UnusableInput(
            phrase(
                "machine '{owner}' has no model of {channel}; make one with 'autodb identify'",
                owner=owner.name,
                channel=row.channel,
            )
        )
    moves = signed(_moves(row), owner)
    progress("fitting")
    names = list(dict.fromkeys([*version_names(newest), term]))
    try:
        refit = refitted(newest, moves, row.recording.sha256, axis=newest.axis, terms=names)
    except UnusableInput as error:
        raise UnusableInput(
            phrase("mismatch {number} stays open: {error}", number=row.id, error=error.line)
        ) from error
    _refuse_unexcited(row, refit, term)
    before, after = (
        cross_test(moves, newest.axis, refit.model.protocol, terms)
        for terms in (stored_terms(newest), refit.model.terms)
    )
    return ConfirmedFit(refit, newest.id, before, after)


def _moves(row: models.Mismatch) -> Recording:
    """Read a mismatch' recording as it was imported, with no other effort than the mismatch'."""
    try:
        moves = as_imported(row.recording)
    except UnusableInput as error:
        raise UnusableInput(
            phrase("mismatch {number} stays open: {error}", number=row.id, error=error.line)
        ) from None
    if not isinstance(moves, Recording):
        raise UnusableInput(
            phrase(
                "{file}: a table of cuts; {channel} needs moves over time",
                file=moves.path,
                channel=row.channel,
            )
        )
    others = {n for n in effort_channels(list(moves.channels)) if n != row.channel}
    kept = {name: values for name, values in moves.channels.items() if name not in others}
    return replace(moves, channels=kept)


def _refuse_unexcited(row: models.Mismatch, refit: Refit, term: str) -> None:
    if of_term(refit.model.fitted, term):
        return
    needed = [said for said in refit.model.not_excited if said.split(" ", 1)[0] == term]
    unmoved = phrase(
        "mismatch {number} stays open: {file} does not excite {term}",
        number=row.id,
        file=Path(row.recording.path).name,
        term=term,
    )
    raise UnusableInput(listed([unmoved, *needed[:1]], "; "))


def of_term(terms: Sequence[IdentifiedTerm], name: str) -> list[IdentifiedTerm]:
    """Return the parameters of a term; asked for as `cogging`, of a ripple of either kind."""
    ripple = FRICTION_RIPPLE.name, FRICTION_RIPPLE.form
    if name == COGGING.name:
        return [t for t in terms if t.term == name or (t.term, t.form) == ripple]
    return [t for t in terms if t.term == name and (t.term, t.form) != ripple]


def keep_version(session: Session, row: models.Mismatch, step: ConfirmedFit) -> int:
    """Add the version, or take the newest where it is the same, link it, and return its number.

    Raises UnusableInput when the channel got another version meanwhile: what that one added would
    be lost.
    """
    newest = newest_model(session, row.recording.machine_id, row.channel)
    if newest is None or newest.id != step.newest_id:
        raise UnusableInput(
            phrase(
                "mismatch {number} stays open: {channel} got another version during the fit; "
                "run the same command again",
                number=row.id,
                channel=row.channel,
            )
        )
    if not step.refit.already_there:
        newest = add_version(session, row.recording.machine_id, step.refit, row.recording_id)
        session.flush()
    made = [] if step.refit.already_there else [newest.id]
    row.applied = {**(row.applied or {}), "models": made}
    row.models.append(newest)
    return newest.version
