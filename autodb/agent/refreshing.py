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

from autodb.agent.calibrations import as_calibration, current_calibrations
from autodb.agent.importing import cuts_as_table
from autodb.agent.machines import find_machine
from autodb.cutting import law
from autodb.fitting import Gaussian
from autodb.inverse import Parameters, SensedCuts, Shared, learn
from autodb.jobs import OPERATIONS
from autodb.sensing.chosen import choose, sense_each
from autodb.sensing.ranges import Calibration
from autodb.store import Store, models

UNSAID_OPERATION = "turn"
"""What a cut counts as that does not say its operation."""

Calibrations = list[models.Calibration]
"""Those of one axis that hold now, newest first."""
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
        felt: dict[str, Calibrations] = {}
        for axis in owner.axes:
            current = current_calibrations(session, owner.id, axis.name)
            _say_refused(current, done)
            if any(row.offered for row in current):
                component = current[0].component
                if progress:
                    progress(f"sensing force.{component} from {axis.name}")
                _sense(session, owner.id, current, done)
                felt[component] = current
        if not felt:
            done.set_aside.append(
                "no calibration is offered: nothing can be sensed ('calibrate' first)"
            )
        _note_unsensed(session, owner.id, felt, done)
        session.flush()
        for pair in session.scalars(_pairs(owner.id)):
            for operation in operations_of(session, owner.id, pair.id):
                for component, current in felt.items():
                    if progress:
                        progress(f"updating {pair_name(pair)}, {operation}, force.{component}")
                    _update_pair(session, pair, current, done, operation=operation)
    return done


def _say_refused(current: Calibrations, done: Refreshed) -> None:
    for row in current:
        if not row.offered:
            called = as_calibration(row).called
            done.set_aside.append(f"axis {called}: its calibration is {row.verdict}")


def pair_name(pair: models.Pair) -> str:
    """Return 'material / tool'."""
    return f"{pair.material.name} / {pair.tool.name}"


def _sense(session: Session, machine_id: int, current: Calibrations, done: Refreshed) -> None:
    """Add the force that an axis feels to every cut that lacks it, or why it does not.

    A cut that none feels is noted with the newest calibration: another one is a reason to look
    again.
    """
    newest = current[0].id
    looked_at = exists().where(
        models.SensedForce.cut_id == models.Cut.id,
        models.SensedForce.calibration_id.in_([row.id for row in current]),
        models.SensedForce.value_N.is_not(None) | (models.SensedForce.calibration_id == newest),
    )
    cuts = list(session.scalars(_cuts(machine_id).where(~looked_at)))
    if not cuts:
        return
    table = cuts_as_table(cuts, path=Path(cuts[0].recording.path))
    sensed = sense_each(table, [as_calibration(row) for row in current])
    for cut, one in zip(cuts, sensed, strict=True):
        felt = one.reason is None
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
    session: Session, machine_id: int, pair_id: int, operation: str, current: Calibrations
) -> list[models.SensedForce]:
    """Return the forces that an axis felt on a pair in one operation, oldest first.

    ``current``: its calibrations. A force counts where the one that felt it is still the one that
    holds for the cut: of a cut that did not state what, a later calibration may say otherwise.
    """
    query = (
        select(models.SensedForce)
        .join(models.Cut)
        .join(models.Recording)
        .where(
            models.Recording.machine_id == machine_id,
            models.Cut.pair_id == pair_id,
            models.SensedForce.calibration_id.in_([row.id for row in current]),
            models.SensedForce.value_N.is_not(None),
        )
        .order_by(models.Cut.id)
    )
    felt = [
        force
        for force in session.scalars(query)
        if operation_of(force.cut) == operation
        and {"cutting.feed", "cutting.depth"} <= set(force.cut.conditions)
    ]
    if len(current) == 1 or not felt:
        return felt
    cuts = [force.cut for force in felt]
    table = cuts_as_table(cuts, path=Path(cuts[0].recording.path))
    chosen = choose(table, [as_calibration(row) for row in current])
    ids = [row.id for row in current]
    return [
        force
        for force, by in zip(felt, chosen, strict=True)
        if isinstance(by, int) and force.calibration_id == ids[by]
    ]


def as_sensed_cuts(forces: list[models.SensedForce]) -> SensedCuts:
    """Return stored forces of one component, felt by calibrations, for the semi-inverse."""
    rows = {f.calibration.id: f.calibration for f in forces if f.calibration is not None}
    number = {id_: i for i, id_ in enumerate(rows)}
    source = np.array([number[f.calibration_id] for f in forces if f.calibration_id is not None])
    shared = [_shared(as_calibration(row)) for row in rows.values()]
    ends = np.cumsum([0, *(len(one.references) for one in shared)])
    common = np.zeros((len(forces), int(ends[-1])))
    for i, force in enumerate(forces):
        common[i, ends[source[i]] : ends[source[i] + 1]] = force.common
    return SensedCuts(
        feed_mm=np.array([f.cut.conditions["cutting.feed"] for f in forces]),
        depth_mm=np.array([f.cut.conditions["cutting.depth"] for f in forces]),
        force_N=np.array([f.value_N for f in forces], dtype=np.float64),
        sd_N=np.array([f.sd_N for f in forces], dtype=np.float64),
        common=common,
        source=source,
        shared=tuple(shared),
    )


def _shared(calibration: Calibration) -> Shared:
    covariance, p = calibration.shared_covariance, len(calibration.coefficients)
    references = np.zeros(len(covariance))
    scaling = calibration.form.scaling(calibration.coefficients)
    references[:p] = calibration.errors.reference_share * scaling
    return Shared(calibration.form, p, covariance, references)


def _update_pair(
    session: Session,
    pair: models.Pair,
    current: Calibrations,
    done: Refreshed,
    *,
    operation: str,
) -> None:
    """Add a version when the pair has forces in this operation that its last one has not seen.

    It builds on the last one where that one's forces all count still.
    """
    machine_id, component = current[0].machine_id, current[0].component
    forces = forces_of_pair(session, machine_id, pair.id, operation, current)
    last = latest_parameters(session, machine_id, pair.id, operation, component)
    seen = _seen(last) if last is not None else set()
    builds_on = bool(seen) and seen <= {force.id for force in forces}
    fresh = [force for force in forces if not builds_on or force.id not in seen]
    if not fresh:
        return
    learnt = learn(as_sensed_cuts(forces))
    version = _newest_version(session, machine_id, pair.id, operation, component) + 1
    session.add(
        models.CuttingParameters(
            machine_id=machine_id,
            pair_id=pair.id,
            operation=operation,
            component=component,
            version=version,
            law=law.NAME,
            mean=learnt.belief.mean.tolist(),
            covariance=learnt.belief.covariance.tolist(),
            process_share=learnt.process_share,
            misfit_N=learnt.misfit_N,
            n_cuts=learnt.n_cuts,
            previous=last if builds_on else None,
            forces=fresh,
        )
    )
    name = f"{pair_name(pair)}, {operation}"
    done.versions.append((name, component, version, learnt.n_cuts))


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


def as_parameters(row: models.CuttingParameters) -> Parameters:
    """Return a stored version as the record that the forward model takes."""
    belief = Gaussian(np.array(row.mean), np.array(row.covariance))
    return Parameters(belief, row.process_share, row.misfit_N, row.n_cuts)
