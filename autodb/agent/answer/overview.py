"""Machines at a glance: what each has, when it was last heard, and what waits for a person."""

from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy import func, select
from sqlalchemy.orm import Session, selectinload

from autodb.agent.rows.calibration_records import as_calibration
from autodb.agent.rows.calibrations import current_calibrations, holding
from autodb.agent.rows.machines import as_file, find_machine, limits_of
from autodb.agent.rows.mismatches import decision_words, found_words
from autodb.files.machine import AxisLimits
from autodb.sensing.ranges.points import COMPONENT_OF_AXIS
from autodb.store import models
from autodb.terms.homes import kept_words


@dataclass(frozen=True)
class MachineSeen:
    """A machine: its axes, the force components that calibrations of its drives sense, recordings.

    ``newest_recording_at``: when it came in; ``calibrations_due`` at the last refresh;
    ``open_mismatches``: those that nobody has decided on.
    """

    name: str
    axes: tuple[str, ...]
    feels: tuple[str, ...]  # the key in JSON, by which programs read it
    recordings: int
    newest_recording_at: str | None
    last_refreshed_at: str | None
    calibrations_due: int
    open_mismatches: int


@dataclass(frozen=True)
class MachineSaid(MachineSeen):
    """A machine with what its file states: its control, and its limits by axis."""

    dialect: str | None
    units: str | None
    limits: dict[str, AxisLimits]


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

    ``alternatives``: what it may be otherwise; ``to_tell_apart``: the move or cut that would
    distinguish. ``recordings``: all that it was found in, by id, ``recording_id`` the first;
    ``found_in``: of how many cuts, recordings and edges, in words, where they are several.
    ``once_confirmed``: where its term is kept then, and what that changes; ``lot``: of the material
    that it was confirmed for; ``decisions``: a line each, oldest first.
    """

    id: int
    machine: str
    recording_id: int
    recordings: tuple[int, ...]
    found_in: str
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
    once_confirmed: str
    lot: str | None
    decisions: tuple[str, ...]


_OF_MISMATCH = (
    *("id", "recording_id", "channel", "term", "kind", "confidence", "statement", "status"),
    *("to_tell_apart", "created_at", "decided_at", "decided_by", "confirmed_term"),
)


def machines_seen(
    session: Session, *, most: int, after: str = "", like: str = ""
) -> list[MachineSeen]:
    """Return machines by name, from behind ``after`` on, ``most`` at a time.

    ``like``: a part of their names, whatever its case.
    """
    rows = session.scalars(
        select(models.Machine)
        .where(
            models.Machine.name > after,
            func.lower(models.Machine.name).contains(like.lower(), autoescape=True),
        )
        .order_by(models.Machine.name)
        .limit(most)
        .options(selectinload(models.Machine.axes))
    ).all()
    return _seen(session, rows)


def every_machine(session: Session) -> list[MachineSeen]:
    """Return all machines by name."""
    rows = session.scalars(
        select(models.Machine)
        .order_by(models.Machine.name)
        .options(selectinload(models.Machine.axes))
    )
    return _seen(session, rows.all())


def machine_said(session: Session, name: str) -> MachineSaid:
    """Return one machine; raises NotThere."""
    row = find_machine(session, name)
    file = as_file(row)
    (seen,) = _seen(session, [row])
    return MachineSaid(**vars(seen), dialect=file.dialect, units=file.units, limits=limits_of(row))


def _seen(session: Session, rows: Sequence[models.Machine]) -> list[MachineSeen]:
    """Return machines with what is asked of all of them at once."""
    numbers = [row.id for row in rows]
    recordings, passes = _recordings(session, numbers), _passes(session, numbers)
    senses, undecided = _senses(session, numbers), _undecided(session, numbers)
    found = []
    for row in rows:
        count, newest = recordings.get(row.id, (0, None))
        refreshed, due = passes.get(row.id, (None, 0))
        axes = tuple(axis.name for axis in row.axes)
        sensed = tuple(sorted(senses.get(row.id, ())))
        waiting = undecided.get(row.id, 0)
        found.append(MachineSeen(row.name, axes, sensed, count, newest, refreshed, due, waiting))
    return found


def _recordings(session: Session, numbers: Sequence[int]) -> dict[int, tuple[int, str]]:
    """Return how many recordings machines have, and when the newest came in."""
    recording = models.StoredRecording
    each = (
        select(
            recording.machine_id, func.count().label("count"), func.max(recording.id).label("id")
        )
        .where(recording.machine_id.in_(numbers))
        .group_by(recording.machine_id)
        .subquery()
    )
    query = select(each.c.machine_id, each.c.count, recording.imported_at).join(
        recording, recording.id == each.c.id
    )
    return {number: (count, at) for number, count, at in session.execute(query)}


def _passes(session: Session, numbers: Sequence[int]) -> dict[int, tuple[str | None, int]]:
    """Return when machines were last refreshed, and how many calibrations were due then."""
    done = models.RefreshPass
    newest = (
        select(func.max(done.id))
        .where(done.machine_id.in_(numbers), done.status == "done")
        .group_by(done.machine_id)
    )
    rows = session.execute(
        select(done.machine_id, done.finished_at, done.report["due"]).where(done.id.in_(newest))
    )
    return {number: (at, len(due or ())) for number, at, due in rows}


def _undecided(session: Session, numbers: Sequence[int]) -> dict[int, int]:
    """Return how many mismatches of machines nobody has decided on."""
    query = (
        select(models.StoredRecording.machine_id, func.count().label("waiting"))
        .select_from(models.Mismatch)
        .join(models.StoredRecording)
        .where(models.StoredRecording.machine_id.in_(numbers), models.Mismatch.status == "open")
        .group_by(models.StoredRecording.machine_id)
    )
    return {row.machine_id: row.waiting for row in session.execute(query)}


def _senses(session: Session, numbers: Sequence[int]) -> dict[int, set[str]]:
    """Return the force components that machines sense by calibrations that hold now."""
    rows = session.scalars(
        select(models.CalibrationVersion)
        .where(models.CalibrationVersion.machine_id.in_(numbers))
        .order_by(models.CalibrationVersion.version.desc())
    )
    of_axes: dict[tuple[int, str], list[models.CalibrationVersion]] = {}
    for row in rows:
        of_axes.setdefault((row.machine_id, row.axis), []).append(row)
    found: dict[int, set[str]] = {}
    for (machine, _), some in of_axes.items():
        sensed = {row.component for row in holding(some) if row.offered}
        found.setdefault(machine, set()).update(sensed)
    return found


def mismatch_said(session: Session, row: models.Mismatch) -> MismatchSaid:
    """Return a mismatch as it stands."""
    machine = session.get_one(models.Machine, row.recording.machine_id).name
    own = {name: getattr(row, name) for name in _OF_MISMATCH}
    return MismatchSaid(
        machine=machine,
        recordings=tuple(one.id for one in row.recordings),
        found_in=found_words(row),
        alternatives=tuple(row.alternatives or ()),
        once_confirmed=kept_words(row.confirmed_term or row.term, row.channel),
        lot=row.lot,
        decisions=tuple(map(decision_words, row.decisions)),
        **own,
    )


def calibrations_said(session: Session, machine: str) -> list[CalibrationSaid]:
    """Return a machine's calibrations that hold now, by axis; raises NotThere."""
    owner = find_machine(session, machine)
    return [
        _calibration(row)
        for axis in COMPONENT_OF_AXIS
        for row in current_calibrations(session, owner.id, axis)
    ]


def _calibration(row: models.CalibrationVersion) -> CalibrationSaid:
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
