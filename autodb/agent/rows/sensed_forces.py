"""Which forces of stored cuts count, and the cuts as elements that a law is worked out for.

A force of a cut counts once: where it was measured, what is sensed of it does not count.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from sqlalchemy import Select, select
from sqlalchemy.orm import Session, contains_eager

from autodb.agent.rows.catalogue import numbers_of
from autodb.agent.rows.edges_in_use import conditions_in_use
from autodb.errors import UnusableInput
from autodb.pairs.engaged import BY_NAME, UNSAID
from autodb.pairs.observed import PairCuts, X, Y, Z
from autodb.store import models
from autodb.wording import localized, phrase, stored_msgid

Calibrations = list[models.CalibrationVersion]
"""Those of one axis that hold now, newest first."""
MEASURED = "dynamometer"
"""What a measured force has as its estimator."""

NO_MODEL = stored_msgid("operation '{operation}' has no model")
LACKS = stored_msgid("{operation} without {names}")


QUANTITY = {"x": X, "y": Y, "z": Z}


@dataclass(frozen=True)
class PairForces:
    """Forces of one pair, oldest cut first; how many cuts are not learnt from, by the reason.

    ``after``: only of cuts with larger ids, no version has learnt any; 0: all of the pair's.
    """

    pair: models.Pair
    forces: list[models.SensedForce]
    left_out: dict[str, int]
    after: int = 0


def operation_of(cut: models.Cut) -> str:
    """Return the operation of a cut; one that does not say it counts as turning."""
    return cut.operation or UNSAID


def forces_of_pair(
    session: Session,
    machine_id: int,
    pair: models.Pair,
    calibrations: Sequence[Calibrations],
    *,
    cuts: tuple[int, int] | None = None,
) -> PairForces:
    """Return the forces that were measured on a pair, or sensed by axes and other sensors.

    ``cuts``: of those alone with an id above the first, up to the second.

    ``calibrations``: those of each axis. A sensed force counts where the one that sensed it is
    still the one that holds for the cut: of a cut that did not state what, a later calibration may
    say otherwise. Of several sensors of a force the surest counts, and a measured force before all.
    """
    sensed = _sensed(machine_id, pair.id)
    if cuts is not None:
        sensed = sensed.where(models.Cut.id > cuts[0], models.Cut.id <= cuts[1])
    forces = [f for current in calibrations for f in _of_axis(session, sensed, current)]
    forces = _surest([*forces, *_of_others(session, sensed)], _measured(session, sensed))
    reasons = {force.cut_id: _unusable(force.cut) for force in forces}
    left_out: dict[str, int] = {}
    for reason in reasons.values():
        if reason is not None:
            left_out[reason] = left_out.get(reason, 0) + 1
    forces.sort(key=lambda force: (force.cut_id, force.component))
    kept = [force for force in forces if reasons[force.cut_id] is None]
    return PairForces(pair, kept, left_out, after=0 if cuts is None else cuts[0])


def forces_of_cuts(
    session: Session, cuts: Sequence[int], calibrations: Sequence[Calibrations]
) -> list[models.SensedForce]:
    """Return one force of each component of some cuts, by id, as ``forces_of_pair`` chooses it."""
    known = (
        select(models.SensedForce)
        .join(models.Cut)
        .options(contains_eager(models.SensedForce.cut))
        .where(models.Cut.id.in_(cuts), models.SensedForce.value_N.is_not(None))
    )
    forces = [f for current in calibrations for f in _of_axis(session, known, current)]
    return _surest([*forces, *_of_others(session, known)], _measured(session, known))


def _sensed(machine_id: int, pair_id: int) -> Select[models.SensedForce]:
    """Return what asks for the forces that were sensed on a pair."""
    return (
        select(models.SensedForce)
        .join(models.Cut)
        .options(contains_eager(models.SensedForce.cut))
        .where(
            models.Cut.recording.has(machine_id=machine_id),
            models.Cut.pair_id == pair_id,
            models.counting_cut(models.Cut.superseded_at),
            models.SensedForce.value_N.is_not(None),
        )
    )


def _of_axis(
    session: Session, sensed: Select[models.SensedForce], current: Calibrations
) -> list[models.SensedForce]:
    by_these = models.SensedForce.calibration_id.in_([row.id for row in current])
    measured = list(session.scalars(sensed.where(by_these).order_by(models.Cut.id)))
    if len(current) == 1 or not measured:
        return measured
    return _of_several(measured, current)


def _of_several(
    measured: Sequence[models.SensedForce], current: Calibrations
) -> list[models.SensedForce]:
    """Return those forces that were sensed by the one of several calibrations that holds."""
    from autodb.agent.rows.calibration_records import as_calibration
    from autodb.agent.rows.recordings import cuts_as_table
    from autodb.sensing.ranges.chosen import choose

    cuts = [force.cut for force in measured]
    table = cuts_as_table(cuts, path=Path(cuts[0].recording.path))
    chosen = choose(table, [as_calibration(row) for row in current])
    ids = [row.id for row in current]
    return [
        force
        for force, by in zip(measured, chosen, strict=True)
        if isinstance(by, int) and force.calibration_id == ids[by]
    ]


def _of_others(session: Session, sensed: Select[models.SensedForce]) -> list[models.SensedForce]:
    """Return what sensors that are no calibrated ranges sensed; of each kind its newest version."""
    sensor = models.SensedForce.estimator_id
    query = sensed.where(sensor.is_not(None)).order_by(sensor)
    return list({(f.cut_id, f.component, f.estimator): f for f in session.scalars(query)}.values())


def _measured(session: Session, sensed: Select[models.SensedForce]) -> list[models.SensedForce]:
    """Return the forces that were measured, of each the newest row."""
    query = sensed.where(models.SensedForce.estimator == MEASURED).order_by(models.SensedForce.id)
    return list({(f.cut_id, f.component): f for f in session.scalars(query)}.values())


def _surest(
    forces: Sequence[models.SensedForce], measured: Sequence[models.SensedForce]
) -> list[models.SensedForce]:
    """Return one force of each component of a cut: measured, else of the least sd."""
    found = {(force.cut_id, force.component): force for force in measured}
    known = set(found)
    for force in forces:
        key = force.cut_id, force.component
        if key in known:
            continue
        if key not in found or _whole_sd_N(force) < _whole_sd_N(found[key]):
            found[key] = force
    return list(found.values())


def _whole_sd_N(force: models.SensedForce) -> float:
    """Return a force's standard deviation; with its gain's of a sensor that is no range.

    Of a range with what the form's choice adds beyond what its calibration was made with.
    """
    shared = 0.0 if force.sensor is None else gain_share(force) * float(force.value_N or 0.0)
    if force.common and force.calibration is not None and force.calibration.domain is not None:
        shared = float(force.common[-1])
    return float(np.hypot(float(force.sd_N or 0.0), shared))


def gain_share(force: models.SensedForce) -> float:
    """Return the relative sd of the gain of what sensed a force, if it is no calibrated range."""
    return float(force.common[0]) if force.common else 0.0


def usable(cut: models.Cut) -> bool:
    """Say whether a cut states what its forces are worked out from."""
    return cut.pair_id is not None and _unusable(cut) is None


def _unusable(cut: models.Cut) -> str | None:
    """Return why a cut is not learnt from; None: it is."""
    operation = BY_NAME.get(operation_of(cut))
    if operation is None:
        return NO_MODEL.format(operation=cut.operation)
    lacking = operation.lacking(cut.conditions)
    return LACKS.format(operation=operation.name, names=" and ".join(lacking)) if lacking else None


def as_cuts(cuts: Sequence[models.Cut]) -> tuple[dict[int, int], tuple[PairCuts, ...]]:
    """Return cuts of one pair as elements, by operation, and the number of each by its id."""
    number: dict[int, int] = {}
    made = []
    for name in dict.fromkeys(operation_of(cut) for cut in cuts):
        some = [cut for cut in cuts if operation_of(cut) == name]
        number |= {cut.id: len(number) + k for k, cut in enumerate(some)}
        tool = some[0].pair.tool if some[0].pair else None
        if tool is None:
            raise UnusableInput(
                phrase(
                    "cut {number}: its work-tool pair is not known",
                    number=localized(f"{some[0].number:g}"),
                )
            )
        conditions = conditions_in_use(some)
        its = BY_NAME[name].cuts(numbers_of(tool), conditions, called=tool.name)
        made.append(replace(its, lots=tuple(cut.lot for cut in some)))
    return number, tuple(made)
