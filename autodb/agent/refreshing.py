"""Refresh: what came in since the last time becomes sensed forces and new parameter versions.

One pass is one transaction: killed in the middle, the database is as it was, and the next pass does
the whole work again.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from sqlalchemy import ColumnElement, Select, exists, func, select
from sqlalchemy.orm import Session

from autodb.agent import holding
from autodb.agent.calibrating import as_calibration, latest_calibration
from autodb.agent.importing import cuts_as_table
from autodb.agent.machines import find_machine
from autodb.cutting import law
from autodb.fitting import Gaussian
from autodb.inverse import Parameters, SensedCuts, learn
from autodb.jobs import OPERATIONS
from autodb.sensing import ranges
from autodb.store import Store, models

UNSAID_OPERATION = "turn"
"""What a cut counts as that does not say its operation."""

RANGE_ESTIMATOR = "range"
NO_ESTIMATOR = "none"


@dataclass
class Refreshed:
    """What a refresh did: forces; versions as (pair and operation, component, version, cuts)."""

    sensed: int = 0
    not_sensed: int = 0
    versions: list[tuple[str, str, int, int]] = field(default_factory=list)
    set_aside: list[str] = field(default_factory=list)


def refresh(
    store: Store, machine: str, *, progress: Callable[[str], None] | None = None
) -> Refreshed:
    """Sense the forces of every cut not sensed yet with the newest calibrations; update the pairs.

    Raises UnusableInput for an unknown machine.
    """
    done = Refreshed()
    with store.writing() as session:
        owner = find_machine(session, machine)
        calibrations = _offered(session, owner, done)
        for row in calibrations:
            if progress:
                progress(f"sensing force.{row.component} from {row.axis}")
            _sense(session, owner.id, row, done)
        _note_unsensed(session, owner.id, {row.component for row in calibrations}, done)
        session.flush()
        for pair in session.scalars(_pairs(owner.id)):
            for operation in operations_of(session, owner.id, pair.id):
                for row in calibrations:
                    if progress:
                        progress(f"updating {pair_name(pair)}, {operation}, force.{row.component}")
                    _update_pair(session, pair, row, done, operation=operation)
    return done


def pair_name(pair: models.Pair) -> str:
    """Return 'material / tool'."""
    return f"{pair.material.name} / {pair.tool.name}"


def _offered(session: Session, owner: models.Machine, done: Refreshed) -> list[models.Calibration]:
    found: list[models.Calibration] = []
    for axis in owner.axes:
        row = latest_calibration(session, owner.id, axis.name)
        if row is not None and row.offered:
            found.append(row)
        elif row is not None:
            done.set_aside.append(f"axis {axis.name}: its calibration is {row.verdict}")
    if not found:
        done.set_aside.append(
            "no calibration is offered: nothing can be sensed ('calibrate' first)"
        )
    return found


def _sense(session: Session, machine_id: int, row: models.Calibration, done: Refreshed) -> None:
    """Add the force that one calibration feels to every cut that lacks it."""
    has_it = exists().where(
        models.SensedForce.cut_id == models.Cut.id,
        models.SensedForce.calibration_id == row.id,
    )
    query = _cuts(machine_id).where(~has_it)
    cuts = list(session.scalars(query))
    if not cuts:
        return
    table = cuts_as_table(cuts, path=Path(cuts[0].recording.path))
    sensed = ranges.sense(table, as_calibration(row))
    for i, cut in enumerate(cuts):
        reason = sensed.not_sensed[i] or holding.why_not(row, cut.recording)
        felt = reason is None
        session.add(
            models.SensedForce(
                cut_id=cut.id,
                component=row.component,
                estimator=RANGE_ESTIMATOR,
                calibration_id=row.id,
                value_N=float(sensed.force_N[i]) if felt else None,
                sd_N=float(sensed.sd_N[i]) if felt else None,
                common=sensed.common[i].tolist() if felt else None,
                reason=reason,
            )
        )
        done.sensed += felt
        done.not_sensed += not felt


def _cuts(machine_id: int) -> Select[models.Cut]:
    return (
        select(models.Cut)
        .join(models.Recording)
        .where(models.Recording.machine_id == machine_id)
        .order_by(models.Cut.id)
    )


def _note_unsensed(session: Session, machine_id: int, felt: Iterable[str], done: Refreshed) -> None:
    """Say once for every cut which components no offered calibration feels."""
    for component in sorted({"x", "y", "z"} - set(felt)):
        noted = exists().where(
            models.SensedForce.cut_id == models.Cut.id,
            models.SensedForce.component == component,
        )
        for cut in session.scalars(_cuts(machine_id).where(~noted)):
            session.add(
                models.SensedForce(
                    cut_id=cut.id,
                    component=component,
                    estimator=NO_ESTIMATOR,
                    reason=f"no offered calibration feels force.{component}",
                )
            )
            done.not_sensed += 1


def _pairs(machine_id: int) -> Select[models.Pair]:
    ids = (
        select(models.Cut.pair_id)
        .join(models.Recording)
        .where(models.Recording.machine_id == machine_id)
        .distinct()
    )
    return select(models.Pair).where(models.Pair.id.in_(ids)).order_by(models.Pair.id)


def operation_of(cut: models.Cut) -> str:
    """Return the operation of a cut; one that does not say it counts as turning."""
    return cut.operation or UNSAID_OPERATION


def operations_of(session: Session, machine_id: int, pair_id: int) -> list[str]:
    """Return the turning operations in which a machine has cut a pair, in a fixed order."""
    query = (
        select(models.Cut.operation)
        .join(models.Recording)
        .where(models.Recording.machine_id == machine_id, models.Cut.pair_id == pair_id)
        .distinct()
    )
    cut = {operation or UNSAID_OPERATION for operation in session.scalars(query)}
    return [operation for operation in OPERATIONS if operation in cut]


def forces_of_pair(
    session: Session, machine_id: int, pair_id: int, operation: str, calibration_id: int
) -> list[models.SensedForce]:
    """Return the forces that a calibration felt on a pair in one operation, oldest first."""
    query = (
        select(models.SensedForce)
        .join(models.Cut)
        .join(models.Recording)
        .where(
            models.Recording.machine_id == machine_id,
            models.Cut.pair_id == pair_id,
            models.SensedForce.calibration_id == calibration_id,
            models.SensedForce.value_N.is_not(None),
        )
        .order_by(models.Cut.id)
    )
    return [
        force
        for force in session.scalars(query)
        if operation_of(force.cut) == operation
        and {"cutting.feed", "cutting.depth"} <= set(force.cut.conditions)
    ]


def as_sensed_cuts(forces: list[models.SensedForce], row: models.Calibration) -> SensedCuts:
    """Return stored forces of one calibration as arrays for the semi-inverse."""
    calibration = as_calibration(row)
    return SensedCuts(
        feed_mm=np.array([f.cut.conditions["cutting.feed"] for f in forces]),
        depth_mm=np.array([f.cut.conditions["cutting.depth"] for f in forces]),
        force_N=np.array([f.value_N for f in forces], dtype=np.float64),
        sd_N=np.array([f.sd_N for f in forces], dtype=np.float64),
        common=np.array([f.common for f in forces], dtype=np.float64),
        calibration_covariance=calibration.shared_covariance,
        form=calibration.form,
        coefficients=len(calibration.coefficients),
    )


def _update_pair(
    session: Session,
    pair: models.Pair,
    row: models.Calibration,
    done: Refreshed,
    *,
    operation: str,
) -> None:
    """Add a version when the pair has forces in this operation that its last one has not seen."""
    machine_id = row.machine_id
    forces = forces_of_pair(session, machine_id, pair.id, operation, row.id)
    last = latest_parameters(session, machine_id, pair.id, operation, row.component)
    seen = _seen(last) if last is not None and _calibration_of(last) == row.id else None
    fresh = [force for force in forces if seen is None or force.id not in seen]
    if not fresh:
        return
    learnt = learn(as_sensed_cuts(forces, row))
    version = _newest_version(session, machine_id, pair.id, operation, row.component) + 1
    session.add(
        models.CuttingParameters(
            machine_id=machine_id,
            pair_id=pair.id,
            operation=operation,
            component=row.component,
            version=version,
            law=law.NAME,
            mean=learnt.belief.mean.tolist(),
            covariance=learnt.belief.covariance.tolist(),
            process_share=learnt.process_share,
            misfit_N=learnt.misfit_N,
            n_cuts=learnt.n_cuts,
            previous=last if seen is not None else None,
            forces=fresh,
        )
    )
    name = f"{pair_name(pair)}, {operation}"
    done.versions.append((name, row.component, version, learnt.n_cuts))


def latest_parameters(
    session: Session, machine_id: int, pair_id: int, operation: str, component: str
) -> models.CuttingParameters | None:
    """Return the newest version of a pair's parameters that was not taken back."""
    return session.scalar(
        select(models.CuttingParameters)
        .where(
            *_key(machine_id, pair_id, operation, component),
            models.CuttingParameters.undone_at.is_(None),
        )
        .order_by(models.CuttingParameters.version.desc())
        .limit(1)
    )


def _newest_version(
    session: Session, machine_id: int, pair_id: int, operation: str, component: str
) -> int:
    """Return the highest version number in use, also of versions taken back; 0: none yet."""
    newest = select(func.max(models.CuttingParameters.version))
    return session.scalar(newest.where(*_key(machine_id, pair_id, operation, component))) or 0


def _key(
    machine_id: int, pair_id: int, operation: str, component: str
) -> tuple[ColumnElement[bool], ...]:
    return (
        models.CuttingParameters.machine_id == machine_id,
        models.CuttingParameters.pair_id == pair_id,
        models.CuttingParameters.operation == operation,
        models.CuttingParameters.component == component,
    )


def chain(parameters: models.CuttingParameters) -> list[models.CuttingParameters]:
    """Return a version and those it was built on, newest first."""
    versions = [parameters]
    while versions[-1].previous is not None:
        versions.append(versions[-1].previous)
    return versions


def _seen(parameters: models.CuttingParameters) -> set[int]:
    return {force.id for version in chain(parameters) for force in version.forces}


def _calibration_of(parameters: models.CuttingParameters) -> int | None:
    return parameters.forces[0].calibration_id


def as_parameters(row: models.CuttingParameters) -> Parameters:
    """Return a stored version as the record that the forward model takes."""
    belief = Gaussian(np.array(row.mean), np.array(row.covariance))
    return Parameters(belief, row.process_share, row.misfit_N, row.n_cuts)
