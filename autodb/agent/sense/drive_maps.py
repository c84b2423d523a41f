"""A drive's model as it is kept: its terms, and its effort over place and velocity of its moves."""

from dataclasses import dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.ingest.as_imported import as_imported, signed
from autodb.agent.ingest.importing import whole_file
from autodb.agent.rows.machines import find_machine
from autodb.agent.sense.identifying import newest_model, off_law_of, stored_terms
from autodb.errors import NotThere, near_words
from autodb.records.tables import Recording
from autodb.sensing.drives.field import EffortField, field
from autodb.sensing.drives.fit.axis_model import IdentifiedTerm, readable
from autodb.sensing.drives.moves.motion import protocol_of
from autodb.store import models
from autodb.wording import phrase


@dataclass(frozen=True)
class DriveMap:
    """The newest model of a channel, and its field; None where its moves are there no more.

    ``protocol``: how it was fitted, in words; ``of``: the recording that the field is of.
    """

    channel: str
    axis: str
    unit: str
    version: int
    made_at: str
    relative_error: float
    protocol: str
    terms: tuple[IdentifiedTerm, ...]
    of: str | None
    field: EffortField | None


def modelled_channels(session: Session, machine_id: int) -> list[str]:
    """Return the channels that a machine has a drive model of."""
    table = models.ChannelModel
    own = table.machine_id == machine_id, table.undone_at.is_(None)
    query = select(table.channel).where(*own).distinct()
    return sorted(session.scalars(query))


def drive_map(session: Session, machine: str, channel: str) -> DriveMap:
    """Return a channel's model and field; raises NotThere where there is none."""
    owner = find_machine(session, machine)
    row = newest_model(session, owner.id, channel)
    if row is None:
        known = modelled_channels(session, owner.id)
        raise NotThere(
            phrase(
                "machine '{machine}' has no model of '{channel}'{hint}",
                machine=machine, channel=channel, hint=near_words(channel, known),
            )
        )  # fmt: skip
    terms = stored_terms(row)
    moves = _moves(row)
    drawn = None
    if moves is not None:
        own = signed(moves, owner)
        protocol = protocol_of(own, row.axis)
        drawn = field(own, row.axis, protocol, terms, off_law_of(row))
    return DriveMap(
        channel=channel,
        axis=row.axis,
        unit=row.unit,
        version=row.version,
        made_at=row.created_at,
        relative_error=row.relative_error,
        protocol=row.protocol,
        terms=tuple(readable(terms)),
        of=None if moves is None else moves.path.name,
        field=drawn,
    )


def _moves(row: models.ChannelModel) -> Recording | None:
    """Read the newest recording of a model whose file is there as it was imported."""
    for recording in sorted(row.recordings, key=lambda one: -one.id):
        if whole_file(recording) is not None:
            read = as_imported(recording)
            if isinstance(read, Recording):
                return read
    return None
