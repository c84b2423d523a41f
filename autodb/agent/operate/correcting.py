"""A confirmed gain of what senses a force becomes a corrected version of its calibrations."""

from typing import Any

from sqlalchemy import func, inspect, select
from sqlalchemy.orm import Session

from autodb.agent.answer.pooled.pooling import common_stamps
from autodb.agent.rows.calibrations import current_calibrations
from autodb.agent.rows.recordings import counted_cuts
from autodb.fitting.gaussian import NORMAL_95
from autodb.store import models

FACTOR, START, DURATION = "factor", "start", "duration"
"""Parameters of the term `gain`."""
_OWN = ("id", "version", "created_at", "undone_at", "corrections")


def correct(session: Session, row: models.Mismatch) -> list[models.CalibrationVersion]:
    """Add a corrected version of each calibration that a confirmed gain is of, and return them.

    From the cut on at which half of the change has come. None where the mismatch states no factor,
    or no calibration of the machine senses the force.
    """
    said = row.parameters.get(FACTOR)
    axes = select(models.CalibrationVersion.axis).where(
        models.CalibrationVersion.machine_id == row.recording.machine_id,
        models.CalibrationVersion.component == row.channel.removeprefix("force."),
    )
    first = _first_changed(row)
    if said is None or first is None:
        return []
    correction = {
        FACTOR: said["value"],
        "sd": (said["high"] - said["low"]) / (2.0 * NORMAL_95),
        "recording": first.recording_id,
        "t_s": float(first.conditions.get("t", 0.0)),
    }
    made: list[models.CalibrationVersion] = []
    for axis in session.scalars(axes.distinct().order_by(models.CalibrationVersion.axis)).all():
        current = current_calibrations(session, row.recording.machine_id, axis)
        made += [
            _next_version(session, old, [*(old.corrections or ()), correction])
            for old in reversed(current)
        ]
    row.calibrations += made
    session.flush()
    return made


def _first_changed(row: models.Mismatch) -> models.Cut | None:
    """Return the first cut for which half of a gain's change has come."""
    cuts = [cut for one in row.recordings for cut in counted_cuts(one)]
    if not cuts:
        return None
    stamps = common_stamps(cuts) if row.further else {}
    t_s = {
        cut.id: stamps.get(cut.id, (0.0, float(cut.conditions.get("t", 0.0))))[1] for cut in cuts
    }
    parts = (row.parameters.get(name, {}).get("value", 0.0) for name in (START, DURATION))
    start_s, duration_s = parts
    later = [cut for cut in cuts if t_s[cut.id] >= start_s + 0.5 * duration_s]
    return min(later, key=lambda cut: (cut.recording_id, t_s[cut.id]), default=None)


def _next_version(
    session: Session, old: models.CalibrationVersion, corrections: list[Any]
) -> models.CalibrationVersion:
    """Add a version that is as another one but for its corrections."""
    made = models.CalibrationVersion
    newest = select(func.max(made.version)).where(
        made.machine_id == old.machine_id, made.axis == old.axis
    )
    columns = {one.key: getattr(old, one.key) for one in inspect(made).column_attrs}
    kept = {name: value for name, value in columns.items() if name not in _OWN}
    row = made(
        **kept,
        version=(session.scalar(newest) or 0) + 1,
        corrections=corrections,
        recordings=list(old.recordings),
        repeats=list(old.repeats),
    )
    session.add(row)
    session.flush()
    return row
