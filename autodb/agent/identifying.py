"""Identify an axis of a machine: the last version is where the next one starts from."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.importing import import_file
from autodb.agent.machines import find_machine, signed
from autodb.checksums import checksum
from autodb.errors import UnusableInput
from autodb.records import Recording
from autodb.sensing.axis_model import Beliefs, Identified, IdentifiedTerm
from autodb.sensing.drives import identify
from autodb.sensing.prepared import effort_axis, effort_channel
from autodb.store import Store, models


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


def newest_model(session: Session, machine_id: int, channel: str) -> models.ChannelModel | None:
    """Return the newest version of a channel's model, or None."""
    return session.scalar(
        select(models.ChannelModel)
        .where(models.ChannelModel.machine_id == machine_id, models.ChannelModel.channel == channel)
        .order_by(models.ChannelModel.version.desc())
        .limit(1)
    )


def identify_on_machine(
    store: Store,
    machine: str,
    path: Path,
    moves: Recording,
    *,
    columns: Path | None = None,
    axis: str | None = None,
    terms: Sequence[str] | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> KeptModel:
    """Identify an axis and keep the model as the next version of its channel.

    ``moves`` is what ``path`` holds. Without ``terms`` those of the newest version are fitted, or
    the symmetric four. The newest version that has not seen this recording is believed beforehand;
    the same terms on the recording that the newest version came from are already there.

    Raises UnusableInput when the machine has no such axis, or as ``identify`` does.
    """
    sha256 = checksum(path)
    with store.reading() as session:
        owner = find_machine(session, machine)
        name = effort_axis(moves, axis)
        if name not in [a.name for a in owner.axes]:
            raise UnusableInput(f"machine '{machine}' has no axis '{name}'")
        newest = newest_model(session, owner.id, effort_channel(moves, axis))
        parent = _unseen(newest, sha256)
        names = terms or (_names(newest) if newest else None)
        progress("fitting")
        model = identify(
            signed(moves, owner),
            axis=axis,
            terms=names,
            beliefs=_beliefs(parent) if parent else None,
        )
        version = parent.version if parent else None
        if newest is not None and _same(newest, model, sha256):
            return KeptModel(model, newest.version, version, already_there=True)
    recording_id = import_file(store, path, machine=machine, columns=columns).recording_id
    with store.writing() as session:
        owner = find_machine(session, machine)
        row = _row(session, owner, model, recording_id, version)
        session.add(row)
        return KeptModel(model, row.version, version, already_there=False)


def _same(row: models.ChannelModel, model: Identified, sha256: str) -> bool:
    """Say whether a version came from the same recording and holds the same numbers."""
    return [r.sha256 for r in row.recordings] == [sha256] and stored_terms(row) == list(model.terms)


def _names(row: models.ChannelModel) -> list[str]:
    """Return the names of a version's terms, ripples as `cogging`, which looks for either kind."""
    names = [("cogging" if t.form else t.term) for t in stored_terms(row)]
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


def _beliefs(row: models.ChannelModel) -> Beliefs | None:
    known = stored_terms(row)[: len(row.covariance)]
    if not known:
        return None
    return Beliefs(
        names=tuple((t.key, t.parameter) for t in known),
        mean=np.array([t.value for t in known]),
        covariance=np.array(row.covariance),
    )


def _row(
    session: Session,
    owner: models.Machine,
    model: Identified,
    recording_id: int,
    parent: int | None,
) -> models.ChannelModel:
    """Return the next version; ``parent``: number of the version that it started from."""
    newest = newest_model(session, owner.id, model.channel)
    before = session.scalar(
        select(models.ChannelModel).where(
            models.ChannelModel.machine_id == owner.id,
            models.ChannelModel.channel == model.channel,
            models.ChannelModel.version == parent,
        )
    )
    return models.ChannelModel(
        machine_id=owner.id,
        axis=model.axis,
        channel=model.channel,
        version=newest.version + 1 if newest else 1,
        unit=model.unit,
        terms=[asdict(term) for term in model.terms],
        covariance=model.covariance.tolist(),
        relative_error=model.relative_error,
        protocol=str(model.protocol),
        parent=before,
        recordings=[session.get_one(models.Recording, recording_id)],
    )
