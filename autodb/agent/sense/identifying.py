"""Identify an axis of a machine: the last version is where the next one starts from."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from autodb.agent.ingest.as_imported import signed
from autodb.agent.ingest.importing import import_file
from autodb.agent.rows.machines import find_machine
from autodb.errors import UnusableInput
from autodb.files.checksums import checksum
from autodb.files.side import StatedColumns
from autodb.records.plausible import refuse_doubtful
from autodb.records.summary import summary_of
from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import cross_test, identify
from autodb.sensing.drives.fit.axis_model import Identified, IdentifiedTerm, Posteriors
from autodb.sensing.drives.fit.discrepancy import FrictionDiscrepancy
from autodb.sensing.drives.moves.motion import SPINDLE, protocol_of
from autodb.sensing.drives.moves.prepared import effort_axis, effort_channel
from autodb.sensing.ranges import faults
from autodb.store import Store, models
from autodb.wording import localized, phrase

STRANGE, KNOWN, ALIKE = 0.3, 0.25, 0.5
"""Moves are another axis' where this one's model leaves more than a share of the effort, and the
other's less than a share and than that part of what this one's leaves. Chosen.
"""


@dataclass(frozen=True)
class KeptModel:
    """A drive model and its version, the version it started from, whether it was there already."""

    model: Identified
    version: int
    parent: int | None
    already_there: bool


def stored_terms(row: models.ChannelModel) -> list[IdentifiedTerm]:
    """Return the terms of a stored version."""
    return [IdentifiedTerm(**term) for term in row.terms]


def off_law_of(row: models.ChannelModel) -> FrictionDiscrepancy | None:
    """Return what friction is off a stored version's laws; None where the terms are all."""
    return FrictionDiscrepancy.of(row.off_law) if row.off_law else None


def newest_model(session: Session, machine_id: int, channel: str) -> models.ChannelModel | None:
    """Return the newest version of a channel's model that was not taken back, or None."""
    return session.scalar(
        select(models.ChannelModel)
        .where(
            models.ChannelModel.machine_id == machine_id,
            models.ChannelModel.channel == channel,
            models.ChannelModel.undone_at.is_(None),
        )
        .order_by(models.ChannelModel.version.desc())
        .limit(1)
    )


def identify_on_machine(
    store: Store,
    machine: str,
    path: Path,
    moves: Recording,
    *,
    columns: StatedColumns = None,
    axis: str | None = None,
    terms: Sequence[str] | None = None,
    update: bool = False,
    progress: Callable[[str], None] = lambda _: None,
) -> KeptModel:
    """Identify an axis and keep the model as the next version of its channel.

    ``moves`` is what ``path`` holds. Without ``terms`` those of the newest version are fitted, or
    the symmetric four. The newest version that has not seen this recording is believed beforehand;
    the same terms on the recording that the newest version came from are already there. With
    ``update`` there must be a version.

    Raises UnusableInput when the machine has no such axis, or as ``identify`` does.
    """
    sha256 = checksum(path)
    with store.reading() as session:
        owner = find_machine(session, machine)
        name = effort_axis(moves, axis)
        if name not in [a.name for a in owner.axes]:
            raise UnusableInput(
                phrase("machine '{machine}' has no axis '{name}'", machine=machine, name=name)
            )
        newest = newest_model(session, owner.id, effort_channel(moves, axis))
        if update and newest is None:
            raise UnusableInput(
                phrase(
                    "--update: machine '{machine}' has no version of {moves} yet; leave out "
                    "--update",
                    machine=machine,
                    moves=effort_channel(moves, axis),
                )
            )
        names = terms or (version_names(newest) if newest else None)
        own = signed(moves, owner)
        refuse_faults(own, axis)
        _refuse_another(session, owner, own, name)
        progress("fitting")
        refit = refitted(newest, own, sha256, axis=axis, terms=names)
        if newest is not None and refit.already_there:
            return KeptModel(refit.model, newest.version, refit.parent, already_there=True)
    recording_id = import_file(store, path, machine=machine, columns=columns).recording_id
    with store.writing(machine) as session:
        owner = find_machine(session, machine)
        newest = newest_model(session, owner.id, refit.model.channel)
        if newest is not None and _same(newest, refit.model, sha256):  # another did it meanwhile
            return KeptModel(refit.model, newest.version, refit.parent, already_there=True)
        row = add_version(session, owner.id, refit, recording_id)
        return KeptModel(refit.model, row.version, refit.parent, already_there=False)


@dataclass(frozen=True)
class ModelVersion:
    """One version of a channel's model: when, from which recordings, and its terms with numbers."""

    number: int
    day: str
    recordings: tuple[str, ...]
    terms: tuple[IdentifiedTerm, ...]


def versions_of(store: Store, machine: str, channel: str) -> list[ModelVersion]:
    """Return all versions of a channel's model, oldest first: how the axis drifted."""
    with store.reading() as session:
        owner = find_machine(session, machine)
        rows = session.scalars(
            select(models.ChannelModel)
            .where(
                models.ChannelModel.machine_id == owner.id, models.ChannelModel.channel == channel
            )
            .order_by(models.ChannelModel.version)
        )
        return [
            ModelVersion(
                row.version,
                row.created_at[:10],
                tuple(Path(recording.path).name for recording in row.recordings),
                tuple(stored_terms(row)[: len(row.covariance)]),
            )
            for row in rows
        ]


def check_moves(moves: Recording, axis: str | None) -> Recording:
    """Return moves over time; raises UnusableInput where a channel cannot be what it claims."""
    summary = summary_of(moves, axis=effort_axis(moves, axis))
    refuse_doubtful(moves.path, summary, moves.side)
    return moves


def refuse_faults(moves: Recording, axis: str | None) -> None:
    """Raise UnusableInput where moves show a fault: a turned sign, another's effort, a brake."""
    faults.refuse(moves.path, faults.faults_of_moves(moves, effort_axis(moves, axis)))


def _refuse_another(session: Session, owner: models.Machine, moves: Recording, axis: str) -> None:
    """Raise UnusableInput where another axis' model predicts moves that this axis' does not."""
    unit = moves.unit(effort_channel(moves, axis))
    left: dict[str, float] = {}
    for name in [a.name for a in owner.axes if (a.name == SPINDLE) == (axis == SPINDLE)]:
        channel = effort_channel(moves, axis).replace(f"{axis}.", f"{name}.")
        row = newest_model(session, owner.id, channel)
        if row is not None and row.unit == unit:
            left[name] = cross_test(
                moves,
                axis,
                protocol_of(moves, axis),
                stored_terms(row),
                off_law_of(row),
            )
    if left.get(axis, 0.0) < STRANGE:
        return
    best = min(left, key=lambda name: left[name])
    if left[best] < KNOWN and left[best] < ALIKE * left[axis]:
        raise UnusableInput(
            phrase(
                "{file}: these look like moves of axis {best}, not {axis}; the model of {best} "
                "leaves {left} % of the effort as residual, that of {axis} {left_2} %; use "
                "--axis {best} with its columns",
                file=moves.path,
                best=best,
                axis=axis,
                left=localized(f"{100.0 * left[best]:.0f}"),
                left_2=localized(f"{100.0 * left[axis]:.0f}"),
            )
        )


@dataclass(frozen=True)
class Refit:
    """A fit that may become the next version of a channel's model.

    ``parent``: number of the version that was believed; ``already_there``: the newest version came
    from the same recording and holds the same numbers.
    """

    model: Identified
    parent: int | None
    already_there: bool


def refitted(
    newest: models.ChannelModel | None,
    moves: Recording,
    sha256: str,
    *,
    axis: str | None,
    terms: Sequence[str] | None,
) -> Refit:
    """Fit terms to moves, from what the line of ``newest`` knows without having seen them.

    ``moves`` have the machine's signs, ``sha256`` is that of their file. Raises UnusableInput as
    ``identify`` does.
    """
    parent = _unseen(newest, sha256)
    posteriors = _posteriors(parent) if parent else None
    model = identify(moves, axis=axis, terms=terms, posteriors=posteriors)
    same = newest is not None and _same(newest, model, sha256)
    return Refit(model, parent.version if parent else None, same)


def _same(row: models.ChannelModel, model: Identified, sha256: str) -> bool:
    """Say whether a version came from the same recording and holds the same numbers."""
    return [r.sha256 for r in row.recordings] == [sha256] and stored_terms(row) == list(model.terms)


def version_names(row: models.ChannelModel) -> list[str]:
    """Return the names of a version's terms, ripples as `cogging`, which looks for either kind."""
    names = [("cogging" if t.form == "periodic" else t.term) for t in stored_terms(row)]
    return list(dict.fromkeys(names))


def _unseen(row: models.ChannelModel | None, sha256: str) -> models.ChannelModel | None:
    """Return the newest version in a line whose knowledge does not hold the recording already."""
    while row is not None:
        ancestor: models.ChannelModel | None = row
        while ancestor is not None and sha256 not in [r.sha256 for r in ancestor.recordings]:
            ancestor = ancestor.parent
        if ancestor is None:
            return row
        row = ancestor.parent
    return None


def _posteriors(row: models.ChannelModel) -> Posteriors | None:
    terms = stored_terms(row)
    known, others = terms[: len(row.covariance)], terms[len(row.covariance) :]
    if not known:
        return None
    return Posteriors(
        names=tuple((t.key, t.parameter) for t in known),
        mean=np.array([t.value for t in known]),
        covariance=np.array(row.covariance),
        others={(t.key, t.parameter): t.value for t in others},
    )


def add_version(
    session: Session, machine_id: int, refit: Refit, recording_id: int
) -> models.ChannelModel:
    """Add a fit as the next version of its channel, and return it."""
    model = refit.model
    own = models.ChannelModel.machine_id == machine_id, models.ChannelModel.channel == model.channel
    newest = session.scalar(select(func.max(models.ChannelModel.version)).where(*own)) or 0
    parent = session.scalar(
        select(models.ChannelModel).where(*own, models.ChannelModel.version == refit.parent)
    )
    row = models.ChannelModel(
        machine_id=machine_id,
        axis=model.axis,
        channel=model.channel,
        version=newest + 1,
        unit=model.unit,
        terms=[asdict(term) for term in model.terms],
        covariance=model.covariance.tolist(),
        relative_error=model.relative_error,
        protocol=str(model.protocol),
        errors=asdict(model.errors) if model.errors else None,
        off_law=model.off_law.kept() if model.off_law else None,
        parent=parent,
        recordings=[session.get_one(models.StoredRecording, recording_id)],
    )
    session.add(row)
    return row
