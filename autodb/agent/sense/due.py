"""Calibrations that are due: what the cuts that came in say of how the machine feels forces."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.rows.calibration_records import as_calibration
from autodb.agent.rows.calibrations import current_calibrations, holds_for
from autodb.agent.rows.recordings import cuts_as_table
from autodb.agent.rows.refresh_cursor import Span
from autodb.sensing.ranges.feeding import moving
from autodb.sensing.ranges.points import current_signal
from autodb.sensing.ranges.sensed_force import left_domain
from autodb.sensing.ranges.validity import holds_of
from autodb.store import models
from autodb.wording import significant, stored_msgid

MANY, SHARE = 5, 0.2
"""Cuts, and share of those that came in, which make a calibration due. Chosen."""
OLD_DAYS = 365
"""Age at which a calibration is due anyway. Chosen: the usual interval of measuring equipment."""
SENSOR_TERMS = ("gain", "sensor_drift")
"""Causes of a mismatch that say that what feels the force has changed."""
DUE = stored_msgid("{axis}: {why}")
ITS_VERDICT = stored_msgid("its calibration is {verdict}")
NOT_SENSED = stored_msgid("{some} of the {count} new cuts were not sensed: {why}")
BEYOND = stored_msgid(
    "{some} of the {count} new cuts took more than the {least} that it was calibrated up to, the "
    "most {most}"
)
OUT = stored_msgid("{some} of the {count} new cuts are {said}; their intervals are wider")
SAYS = stored_msgid("mismatch {number} says {term}")
OLD = stored_msgid("its calibration is {days} days old")


@dataclass(frozen=True)
class _Look:
    """What the checks see: a machine, the cuts that came in since the last pass, and why axes did
    not feel some, with the calibration's id.
    """

    session: Session
    owner: models.Machine
    cuts: list[models.Cut]
    reasons: list[tuple[int | None, str]]


def calibrations_due(session: Session, owner: models.Machine, span: Span) -> list[str]:
    """Return which calibrations of a machine are due, and why; a sentence each."""
    force = models.SensedForce
    new = models.Cut.id > span.old, models.Cut.id <= span.upto
    own = models.Cut.recording.has(machine_id=owner.id)
    cuts = session.scalars(select(models.Cut).where(*new, own)).all()
    why = (
        select(force.calibration_id, force.reason)
        .where(force.cut_id > span.old, force.cut_id <= span.upto, force.reason.is_not(None))
        .where(force.cut.has(own))
    )
    reasons = [(number, str(reason)) for number, reason in session.execute(why)]
    look = _Look(session, owner, list(cuts), reasons)
    return [
        DUE.format(axis=as_calibration(row).called, why=said)
        for axis in owner.axes
        for row in current_calibrations(session, owner.id, axis.name)
        for check in CHECKS
        if (said := check(look, row)) is not None
    ]


def refused(_look: _Look, row: models.CalibrationVersion) -> str | None:
    """Say that a calibration was not good enough to be offered."""
    return None if row.offered else ITS_VERDICT.format(verdict=row.verdict)


def other_conditions(look: _Look, row: models.CalibrationVersion) -> str | None:
    """Say in which conditions, of those that came in, no calibration of the axis holds."""
    begins = f"{row.axis} was calibrated with"
    reasons = [
        said for number, said in look.reasons if number == row.id and said.startswith(begins)
    ]
    if not _many(len(reasons), look):
        return None
    usual = max(set(reasons), key=reasons.count)
    return NOT_SENSED.format(some=len(reasons), count=len(look.cuts), why=usual)


def beyond_calibrated(look: _Look, row: models.CalibrationVersion) -> str | None:
    """Say that currents go beyond those that the axis was calibrated with, in cuts like these."""
    if not look.cuts:
        return None
    table = cuts_as_table(look.cuts, path=Path(look.cuts[0].recording.path))
    signal = current_signal(table, row.axis)
    if signal is None or signal[0] != row.channel:
        return None
    alike = [not holds_for(row).against(cut) for cut in holds_of(table, row.axis)]
    read = np.abs(signal[1][np.array(alike) & moving(table, row.axis)])
    most = max(abs(row.current_low), abs(row.current_high))
    high = read[read > most]
    if not _many(len(high), look):
        return None
    return BEYOND.format(
        some=len(high), count=len(look.cuts), least=f"{significant(most)} {row.current_unit}",
        most=f"{significant(high.max())} {row.current_unit}",
    )  # fmt: skip


def outside_domain(look: _Look, row: models.CalibrationVersion) -> str | None:
    """Say that cuts were made with what the axis was not calibrated with."""
    found = as_calibration(row)
    if not look.cuts or found.domain is None:
        return None
    every = cuts_as_table(look.cuts, path=Path(look.cuts[0].recording.path))
    alike = [not found.holds.against(cut) for cut in holds_of(every, row.axis)]
    some = [cut for cut, is_alike in zip(look.cuts, alike, strict=True) if is_alike]
    if not some:
        return None
    count, said = left_domain(cuts_as_table(some, path=every.path), found)
    if not _many(count, look):
        return None
    return OUT.format(some=count, count=len(look.cuts), said=said)


def sensor_changed(look: _Look, row: models.CalibrationVersion) -> str | None:
    """Say that a mismatch since the calibration says that the sensor has changed."""
    found = look.session.scalar(
        select(models.Mismatch)
        .join(models.StoredRecording)
        .where(
            models.StoredRecording.machine_id == look.owner.id,
            models.Mismatch.channel == f"force.{row.component}",
            models.Mismatch.status != "rejected",
            models.Mismatch.term.in_(SENSOR_TERMS),
            models.Mismatch.created_at >= row.created_at,
        )
        .limit(1)
    )
    return None if found is None else SAYS.format(number=found.id, term=found.term)


def old(_look: _Look, row: models.CalibrationVersion) -> str | None:
    """Say that a calibration is old."""
    age = datetime.now(UTC) - datetime.fromisoformat(row.created_at)
    return OLD.format(days=age.days) if age.days >= OLD_DAYS else None


CHECKS: tuple[Callable[[_Look, models.CalibrationVersion], str | None], ...] = (
    refused,
    other_conditions,
    beyond_calibrated,
    outside_domain,
    sensor_changed,
    old,
)


def _many(count: int, look: _Look) -> bool:
    return count >= MANY and count >= SHARE * len(look.cuts)
