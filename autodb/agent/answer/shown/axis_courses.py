"""How a machine's axes went over the weeks: gain, friction, force, and what was done to them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from autodb.agent.answer.drifted_gains import sensed_beside_expected
from autodb.agent.answer.shown.due_lines import DueLine, due_on
from autodb.agent.matching.taken_by_cuts import offered_calibrations
from autodb.agent.rows.calibration_records import as_calibration
from autodb.agent.rows.machines import find_machine
from autodb.agent.rows.recordings import stated_start
from autodb.agent.rows.refresh_cursor import Span
from autodb.agent.sense.identifying import stored_terms
from autodb.fitting.gaussian import NORMAL_95
from autodb.sensing.ranges.forms import MeasuredCuts
from autodb.sensing.ranges.points import COMPONENT_OF_AXIS
from autodb.store import models
from autodb.terms.friction import COULOMB
from autodb.wording import phrase

NEWEST = 100
"""Recordings whose air currents are shown. Chosen: about as many as a plot tells apart."""


@dataclass(frozen=True)
class CoursePoint:
    """A value at a time, with its 95 % interval where it is known.

    ``evidence``: the number of the recording, calibration or model that it is of.
    """

    at: str
    value: float
    low: float | None
    high: float | None
    evidence: int


@dataclass(frozen=True)
class AxisMark:
    """What was done on an axis, and when: a calibration or a decision; ``number`` of its row."""

    at: str
    kind: str
    number: int
    words: str


@dataclass(frozen=True)
class AxisCourse:
    """One axis over time, each oldest first, in the units beside.

    ``gain``: force or torque an ampere, by calibration; ``air``: its current in air, A, by
    recording; ``friction``: its dry friction, by drive model; ``residual``: by what share, %, the
    force of cuts is above what their pair expects, by recording.
    """

    axis: str
    component: str
    gain: tuple[CoursePoint, ...]
    gain_unit: str
    air: tuple[CoursePoint, ...]
    friction: tuple[CoursePoint, ...]
    friction_unit: str
    residual: tuple[CoursePoint, ...]
    marks: tuple[AxisMark, ...]


@dataclass(frozen=True)
class MachineCourse:
    """A machine over the weeks: its axes that sense force, and what is due."""

    machine: str
    axes: tuple[AxisCourse, ...]
    due: tuple[DueLine, ...]


def machine_course(session: Session, machine: str) -> MachineCourse:
    """Return how a machine's axes went; raises NotThere for an unknown machine."""
    owner = find_machine(session, machine)
    shares = _residuals(session, owner)
    axes = (
        _axis(session, owner, axis.name, COMPONENT_OF_AXIS[axis.name], shares)
        for axis in owner.axes
        if axis.name in COMPONENT_OF_AXIS
    )
    return MachineCourse(machine, tuple(axes), tuple(due_on(session, machine)))


def _axis(
    session: Session,
    owner: models.Machine,
    axis: str,
    component: str,
    shares: dict[str, list[CoursePoint]],
) -> AxisCourse:
    calibrations = _calibrations(session, owner, axis)
    units = (calibrations[-1].unit, calibrations[-1].current_unit) if calibrations else ()
    fitted = _models(session, owner, axis)
    friction = [point for one in fitted if (point := _dry_friction(one)) is not None]
    return AxisCourse(
        axis=axis,
        component=component,
        gain=tuple(p for one in calibrations if (p := _gain(one)) is not None),
        gain_unit="/".join(units),
        air=tuple(_air(session, owner, axis)),
        friction=tuple(friction),
        friction_unit=fitted[-1].unit if fitted else "",
        residual=tuple(shares.get(component, ())),
        marks=tuple(_marks(session, owner, axis, component, calibrations)),
    )


# Traces


def _calibrations(
    session: Session, owner: models.Machine, axis: str
) -> Sequence[models.CalibrationVersion]:
    table = models.CalibrationVersion
    own = table.machine_id == owner.id, table.axis == axis, table.undone_at.is_(None)
    newest = session.scalars(select(table).where(*own).order_by(table.id.desc()).limit(NEWEST))
    return list(reversed(newest.all()))


def _gain(row: models.CalibrationVersion) -> CoursePoint | None:
    """Return the target an ampere over the range of the current, or None; it has no sign.

    All else is in the middle of what the calibration was made with.
    """
    found = as_calibration(row)
    ends = np.array([found.current_low, found.current_high])
    ranges = {} if found.domain is None else found.domain.ranges
    speed, feed, warm = (
        np.full(2, np.mean(ranges.get(name, (np.nan, np.nan))))
        for name in ("speed_rpm", "feed_mm_s", "temperature_C")
    )
    nothing = np.full(2, np.nan)
    at = MeasuredCuts(ends, feed, speed, nothing, nothing, warm)
    value = np.diff(found.form.value(found.coefficients, at)) / np.diff(ends)
    slope = np.diff(found.form.slopes(found.coefficients, at), axis=0)[0] / np.diff(ends)
    if not np.isfinite(value).all():
        return None
    half = NORMAL_95 * float(np.sqrt(slope @ found.covariance @ slope))
    return _point(row.created_at, abs(float(value[0])), half, row.id)


def _models(session: Session, owner: models.Machine, axis: str) -> Sequence[models.ChannelModel]:
    table = models.ChannelModel
    own = table.machine_id == owner.id, table.axis == axis, table.undone_at.is_(None)
    newest = session.scalars(select(table).where(*own).order_by(table.id.desc()).limit(NEWEST))
    return list(reversed(newest.all()))


def _dry_friction(row: models.ChannelModel) -> CoursePoint | None:
    """Return the level of a model's dry friction; None where it has none, or in no number."""
    for term in stored_terms(row):
        if term.term == COULOMB.name and term.sd is not None and term.parameter == "level":
            return _point(row.created_at, term.value, NORMAL_95 * term.sd, row.id)
    return None


def _air(session: Session, owner: models.Machine, axis: str) -> list[CoursePoint]:
    """Return the mean current in air of the newest recordings' cuts, those of the usual operation.

    In another the axis may stand, or move otherwise.
    """
    recording, cut = models.StoredRecording, models.Cut
    own = recording.machine_id == owner.id
    newest = select(recording.id).where(own).order_by(recording.id.desc()).limit(NEWEST)
    some = cut.recording_id.in_(newest), models.counting_cut(cut.superseded_at)
    usual = select(cut.operation).where(*some, cut.operation.is_not(None))
    usual = usual.group_by(cut.operation).order_by(func.count().desc()).limit(1)
    means = (
        select(
            cut.recording_id,
            func.min(cut.started_at).label("first"),
            func.avg(cut.measured[f"{axis}.current.air"].as_float()).label("mean"),
        )
        .where(*some, cut.operation == usual.scalar_subquery())
        .group_by(cut.recording_id)
        .subquery()
    )
    query = select(recording, means.c.first, means.c.mean).join(
        means, means.c.recording_id == recording.id
    )
    found = [
        _point(_began(row, first), float(mean), None, row.id)
        for row, first, mean in session.execute(query.where(means.c.mean.is_not(None)))
    ]
    return sorted(found, key=lambda one: one.at)


def _residuals(session: Session, owner: models.Machine) -> dict[str, list[CoursePoint]]:
    """Return by component by what share cuts' forces are above those expected, by recording."""
    newest = session.scalar(select(func.max(models.Cut.id))) or 0
    span = Span(after=0, upto=newest, old=0, force=0, anew=False)
    sensed = offered_calibrations(session, owner)
    every: dict[tuple[str, int], list[float]] = {}
    began: dict[int, str] = {}
    for one in sensed_beside_expected(session, owner, span, sensed) if sensed else ():
        cut, component = one.force.cut, one.force.component
        share = 100.0 * ((one.force.value_N or 0.0) / one.expected_N - 1.0)
        every.setdefault((component, cut.recording_id), []).append(share)
        at = _began(cut.recording, cut.started_at)
        began[cut.recording_id] = min(began.get(cut.recording_id, at), at)
    found: dict[str, list[CoursePoint]] = {}
    for (component, number), shares in sorted(every.items()):
        mean = float(np.mean(shares))
        half = _half_of_mean(shares)
        found.setdefault(component, []).append(_point(began[number], mean, half, number))
    return {name: sorted(some, key=lambda one: one.at) for name, some in found.items()}


def _began(row: models.StoredRecording, first_cut_at: str | None) -> str:
    """Return when a recording began, as stated or by its first cut; else when it came in."""
    stated = stated_start(row)
    return stated.isoformat() if stated else first_cut_at or row.imported_at


def _half_of_mean(values: Sequence[float]) -> float | None:
    """Return half the 95 % interval of a mean; None of fewer than three values."""
    if len(values) < 3:
        return None
    return NORMAL_95 * float(np.std(values, ddof=1)) / float(np.sqrt(len(values)))


def _point(at: str, value: float, half: float | None, evidence: int) -> CoursePoint:
    low, high = (None, None) if half is None else (value - half, value + half)
    return CoursePoint(at, value, low, high, evidence)


# What was done


def _marks(
    session: Session,
    owner: models.Machine,
    axis: str,
    component: str,
    calibrations: Iterable[models.CalibrationVersion],
) -> list[AxisMark]:
    """Return calibrations of an axis, and decisions on mismatches in what it senses."""
    found = [
        AxisMark(
            one.created_at,
            "calibration",
            one.id,
            phrase("calibration, version {version}", version=one.version),
        )
        for one in calibrations
    ]
    decision, mismatch = models.MismatchDecision, models.Mismatch
    query = (
        select(decision, mismatch)
        .join(mismatch, mismatch.id == decision.mismatch_id)
        .join(models.StoredRecording, models.StoredRecording.id == mismatch.recording_id)
        .where(
            models.StoredRecording.machine_id == owner.id,
            mismatch.channel.startswith(f"{axis}.") | (mismatch.channel == f"force.{component}"),
        )
        .order_by(decision.id)
    )
    for taken, of in session.execute(query):
        status = phrase("taken back") if taken.status == "open" else phrase(taken.status)
        words = phrase("{term}: {status}", term=of.term, status=status)
        found.append(AxisMark(taken.decided_at, "mismatch", of.id, words))
    return sorted(found, key=lambda one: one.at)
