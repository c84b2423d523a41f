"""Machines at a glance: what each has, when it was last heard, and what waits for a person."""

from dataclasses import dataclass

from sqlalchemy import func, select
from sqlalchemy.orm import Session, selectinload

from autodb.agent.calibrations import as_calibration, current_calibrations
from autodb.agent.machines import as_file, find_machine, limits_of
from autodb.machinefile import Limits
from autodb.sensing.ranges import COMPONENT_OF_AXIS
from autodb.store import models


@dataclass(frozen=True)
class MachineSeen:
    """A machine: its axes, its newest recording and when that came in, mismatches undecided."""

    name: str
    axes: tuple[str, ...]
    recordings: int
    newest_recording_at: str | None
    last_refreshed_at: str | None
    open_mismatches: int


@dataclass(frozen=True)
class MachineSaid(MachineSeen):
    """A machine with what its file states: its control, and its limits by axis."""

    dialect: str | None
    units: str | None
    limits: dict[str, Limits]


@dataclass(frozen=True)
class CalibrationSaid:
    """A calibration in use, or why it is not: its equation, and its error on cuts left out.

    ``rmse`` in ``unit``.
    """

    id: int
    axis: str
    component: str
    channel: str
    version: int
    equation: str
    holds_for: str
    unit: str
    rmse: float
    r_squared: float
    offered: bool
    verdict: str
    created_at: str


@dataclass(frozen=True)
class MismatchSaid:
    """What a simulation left out of a recording: ``term`` by name, in one sentence, and how sure.

    ``alternatives``: what it may be otherwise; ``to_tell_apart``: the move or cut that would tell.
    """

    id: int
    machine: str
    recording_id: int
    channel: str
    term: str
    kind: str
    confidence: float
    statement: str
    status: str
    alternatives: tuple[str, ...]
    to_tell_apart: str | None
    created_at: str
    decided_at: str | None
    decided_by: str | None
    confirmed_term: str | None


_OF_MISMATCH = (
    *("id", "recording_id", "channel", "term", "kind", "confidence", "statement", "status"),
    *("to_tell_apart", "created_at", "decided_at", "decided_by", "confirmed_term"),
)


def machines_seen(session: Session, *, most: int, after: str = "") -> list[MachineSeen]:
    """Return machines by name, from behind ``after`` on, ``most`` at a time."""
    rows = session.scalars(
        select(models.Machine)
        .where(models.Machine.name > after)
        .order_by(models.Machine.name)
        .limit(most)
        .options(selectinload(models.Machine.axes))
    ).all()
    return [_seen(session, row) for row in rows]


def machine_said(session: Session, name: str) -> MachineSaid:
    """Return one machine; raises NotThere."""
    row = find_machine(session, name)
    file = as_file(row)
    return MachineSaid(
        **vars(_seen(session, row)), dialect=file.dialect, units=file.units, limits=limits_of(row)
    )


def _seen(session: Session, row: models.Machine) -> MachineSeen:
    recording, done = models.Recording, models.RefreshPass
    newest = session.execute(
        select(recording.imported_at)
        .where(recording.machine_id == row.id)
        .order_by(recording.id.desc())
        .limit(1)
    ).scalar()
    count = session.scalar(
        select(func.count()).select_from(recording).where(recording.machine_id == row.id)
    )
    refreshed = session.scalar(
        select(func.max(done.finished_at)).where(done.machine_id == row.id, done.status == "done")
    )
    undecided = session.scalar(
        select(func.count())
        .select_from(models.Mismatch)
        .join(recording)
        .where(recording.machine_id == row.id, models.Mismatch.status == "open")
    )
    axes = tuple(axis.name for axis in row.axes)
    return MachineSeen(row.name, axes, count or 0, newest, refreshed, undecided or 0)


def mismatch_said(session: Session, row: models.Mismatch) -> MismatchSaid:
    """Return a mismatch as it stands."""
    machine = session.get_one(models.Machine, row.recording.machine_id).name
    own = {name: getattr(row, name) for name in _OF_MISMATCH}
    return MismatchSaid(machine=machine, alternatives=tuple(row.alternatives or ()), **own)


def calibrations_said(session: Session, machine: str) -> list[CalibrationSaid]:
    """Return a machine's calibrations that hold now, by axis; raises NotThere."""
    owner = find_machine(session, machine)
    return [
        _calibration(row)
        for axis in COMPONENT_OF_AXIS
        for row in current_calibrations(session, owner.id, axis)
    ]


def _calibration(row: models.Calibration) -> CalibrationSaid:
    found = as_calibration(row)
    return CalibrationSaid(
        id=row.id,
        axis=row.axis,
        component=row.component,
        channel=row.channel,
        version=row.version,
        equation=found.form.equation(found.coefficients, row.unit, row.current_unit),
        holds_for=found.holds.words() or "any cut",
        unit=row.unit,
        rmse=found.scores.rmse,
        r_squared=found.scores.r_squared,
        offered=row.offered,
        verdict=row.verdict,
        created_at=row.created_at,
    )
