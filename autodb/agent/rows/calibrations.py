"""Calibrations as the database keeps them: versions of an axis, and which of them hold now."""

from collections.abc import Iterable, Sequence
from typing import Any

from sqlalchemy import Row, select
from sqlalchemy.orm import Session

from autodb.pairs.posterior import CALIBRATION
from autodb.sensing.ranges.validity import Holds
from autodb.store import models

BEYOND = " beyond its range"


def beyond_its_range(number: int) -> str:
    """Return the key of the error by which a calibration may be off beyond what it was made with.

    A posterior has it where some force that it was learnt from was sensed there.
    """
    return f"{CALIBRATION} {number}{BEYOND}"


def used_beyond(session: Session, keys: Iterable[str]) -> Sequence[Row[Any, Any, Any, Any]]:
    """Return the calibrations that errors of these keys say were used beyond their ranges: of each
    its ``id``, ``axis``, ``version`` and ``component``.
    """
    some = [key for key in keys if key.startswith(CALIBRATION) and key.endswith(BEYOND)]
    numbers = [int(key.removeprefix(CALIBRATION).removesuffix(BEYOND)) for key in some]
    if not numbers:
        return []
    row = models.table_of(models.CalibrationVersion).c
    query = select(row.id, row.axis, row.version, row.component).where(row.id.in_(numbers))
    return session.connection().execute(query.order_by(row.id)).all()


def holds_for(row: models.CalibrationVersion) -> Holds:
    """Return what a stored calibration holds for."""
    return Holds(row.gear_range, row.coolant, row.spindle_state, row.feed_direction)


def current_calibrations(
    session: Session, machine_id: int, axis: str
) -> list[models.CalibrationVersion]:
    """Return an axis' calibrations that hold now, newest first, offered or not."""
    rows = session.scalars(
        select(models.CalibrationVersion)
        .where(
            models.CalibrationVersion.machine_id == machine_id,
            models.CalibrationVersion.axis == axis,
            models.CalibrationVersion.undone_at.is_(None),
        )
        .order_by(models.CalibrationVersion.version.desc())
    )
    return holding(rows)


def holding(rows: Iterable[models.CalibrationVersion]) -> list[models.CalibrationVersion]:
    """Return those of an axis' calibrations, newest first, that no newer one took the place of.

    A newer one takes the place of those that could hold for the same cut: of two that are left no
    cut has both.
    """
    current: list[models.CalibrationVersion] = []
    for row in rows:
        if all(holds_for(row).against(holds_for(newer)) for newer in current):
            current.append(row)
    return current
