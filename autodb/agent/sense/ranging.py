"""Forces of cuts, measured and by calibrated current ranges, each cut once a calibration."""

from collections.abc import Callable, Iterable
from pathlib import Path

from sqlalchemy import Select, exists, select
from sqlalchemy.orm import Session

from autodb.agent.rows.calibration_records import as_calibration
from autodb.agent.rows.calibrations import current_calibrations
from autodb.agent.rows.drifted import corrected
from autodb.agent.rows.recordings import cuts_as_table
from autodb.agent.rows.refresh_cursor import Span
from autodb.agent.rows.sensed_forces import MEASURED, Calibrations
from autodb.agent.sense.measured import take_measured
from autodb.sensing.ranges.chosen import sense_each
from autodb.store import models
from autodb.wording import stored_msgid

RANGE_ESTIMATOR = "range"
NO_ESTIMATOR = "none"

NO_CALIBRATION = stored_msgid("no usable calibration of force.{component}")
SENSING = stored_msgid("sensing force.{component} from {axis}")


def sense_cuts(
    session: Session, owner: models.Machine, span: Span, progress: Callable[[str], None]
) -> list[Calibrations]:
    """Take what was measured in the cuts of a span; sense what they lack, or note why it is not.

    Return the calibrations of each axis that feels force.
    """
    take_measured(session, owner, span)
    sensed: dict[str, Calibrations] = {}
    cuts = _cuts(owner.id, span)
    for axis in owner.axes:
        current = current_calibrations(session, owner.id, axis.name)
        if any(row.offered for row in current):
            component = current[0].component
            progress(SENSING.format(component=component, axis=axis.name))
            _sense(session, cuts, current)
            sensed[component] = current
    _note_unsensed(session, cuts, sensed)
    session.flush()
    return list(sensed.values())


def known_otherwise(session: Session, machine_id: int) -> bool:
    """Say whether a force of the machine's cuts was measured, or sensed by no calibrated range."""
    own = select(models.Estimator.id).where(models.Estimator.machine_id == machine_id)
    measured = models.SensedForce.estimator == MEASURED
    measured &= models.SensedForce.cut.has(
        models.Cut.recording.has(machine_id=machine_id)
        & models.counting_cut(models.Cut.superseded_at)
    )
    query = select(models.SensedForce.id).where(
        models.SensedForce.estimator_id.in_(own) | measured, models.SensedForce.value_N.is_not(None)
    )
    return session.scalar(query.limit(1)) is not None


def _cuts(machine_id: int, span: Span) -> Select[models.Cut]:
    return (
        select(models.Cut)
        .where(
            models.Cut.id > span.after,
            models.Cut.id <= span.upto,
            models.counting_cut(models.Cut.superseded_at),
            models.Cut.recording.has(machine_id=machine_id),
        )
        .order_by(models.Cut.id)
    )


def _sense(session: Session, among: Select[models.Cut], current: Calibrations) -> None:
    """Add the force that an axis feels to every cut that lacks it, or why it does not.

    A cut that none feels is noted with the newest calibration: another one is a reason to look
    again.
    """
    newest = current[0].id
    looked_at = exists().where(
        models.SensedForce.cut_id == models.Cut.id,
        models.SensedForce.component == current[0].component,
        models.SensedForce.estimator == RANGE_ESTIMATOR,
        models.SensedForce.calibration_id.in_([row.id for row in current]),
        models.SensedForce.value_N.is_not(None) | (models.SensedForce.calibration_id == newest),
    )
    cuts = list(session.scalars(among.where(~looked_at)))
    if not cuts:
        return
    table = cuts_as_table(cuts, path=Path(cuts[0].recording.path))
    sensed = sense_each(table, [as_calibration(row) for row in current])
    for cut, read in zip(cuts, sensed, strict=True):
        one = corrected(current, cut, read)
        session.add(
            models.SensedForce(
                cut_id=cut.id,
                component=current[0].component,
                estimator=RANGE_ESTIMATOR,
                calibration_id=newest if one.by is None else current[one.by].id,
                value_N=one.force_N,
                sd_N=one.sd_N,
                common=one.common,
                reason=one.reason,
            )
        )


def _note_unsensed(session: Session, among: Select[models.Cut], sensed: Iterable[str]) -> None:
    """Say once for every cut which components no offered calibration feels."""
    for component in sorted({"x", "y", "z"} - set(sensed)):
        noted = exists().where(
            models.SensedForce.cut_id == models.Cut.id,
            models.SensedForce.component == component,
        )
        for cut in session.scalars(among.where(~noted)):
            session.add(
                models.SensedForce(
                    cut_id=cut.id,
                    component=component,
                    estimator=NO_ESTIMATOR,
                    reason=NO_CALIBRATION.format(component=component),
                )
            )
