"""Refresh: what came in since the last time becomes sensed forces and new parameter versions.

One pass is one transaction: killed in the middle, the database is as it was, and the next pass does
the whole work again.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from sqlalchemy import Select, exists, select
from sqlalchemy.orm import Session

from autodb.agent.beliefs import (
    Start,
    as_belief,
    chain,
    columns_of,
    latest,
    newest_version,
    pair_name,
    start_of,
)
from autodb.agent.calibrations import as_calibration, current_calibrations
from autodb.agent.felt import Calibrations, Felt, as_observed, forces_of_pair
from autodb.agent.importing import cuts_as_table
from autodb.agent.machines import find_machine
from autodb.errors import UnusableInput
from autodb.pairs.learning import learn
from autodb.pairs.observed import Observed
from autodb.sensing.chosen import sense_each
from autodb.store import Store, models

AT_ONCE = 200
"""Cuts of a pair up to which all of them are learnt at once when there are new ones; beyond, the
new ones change the belief. Chosen: a second's work."""
RANGE_ESTIMATOR = "range"
NO_ESTIMATOR = "none"


@dataclass
class Refreshed:
    """What a refresh did: forces; versions as (pair, version, cuts behind it)."""

    sensed: int = 0
    not_sensed: int = 0
    versions: list[tuple[str, int, int]] = field(default_factory=list)
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
            if progress:
                progress(f"updating {pair_name(pair)}")
            _update_pair(session, owner.id, pair, list(felt.values()), done)
    return done


def _say_refused(current: Calibrations, done: Refreshed) -> None:
    for row in current:
        if not row.offered:
            called = as_calibration(row).called
            done.set_aside.append(f"axis {called}: its calibration is {row.verdict}")


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


def _update_pair(
    session: Session,
    machine_id: int,
    pair: models.Pair,
    felt: Sequence[Calibrations],
    done: Refreshed,
) -> None:
    """Add a version when the pair has forces that its last one has not seen.

    It builds on the last one where that one's forces all count still, and learns a pair of few
    cuts from the start again: what the law bends between them is then linearised once.
    """
    found = forces_of_pair(session, machine_id, pair, felt)
    _say_left_out(pair, found, done)
    last = latest(session, machine_id, pair.id)
    seen = seen_by(last)
    builds_on = bool(seen) and seen <= {force.id for force in found.forces}
    fresh = [force for force in found.forces if not builds_on or force.id not in seen]
    if not fresh:
        return
    try:
        start, readings = _readings(session, machine_id, found, fresh, last)
        learnt = learn(start.belief, readings)
    except UnusableInput as error:
        done.set_aside.append(f"{pair_name(pair)}: {error}")
        return
    version = newest_version(session, machine_id, pair.id) + 1
    session.add(
        models.CuttingParameters(
            machine_id=machine_id,
            pair_id=pair.id,
            version=version,
            started_from=start.said,
            relative=start.row,
            previous=last if builds_on else None,
            forces=fresh,
            **columns_of(learnt),
        )
    )
    done.versions.append((pair_name(pair), version, learnt.cuts))


def _readings(
    session: Session,
    machine_id: int,
    found: Felt,
    fresh: list[models.SensedForce],
    last: models.CuttingParameters | None,
) -> tuple[Start, Observed]:
    """Return the belief to learn from, and the readings that it has not learnt."""
    new = {force.id for force in fresh}
    known = {force.cut_id for force in found.forces if force.id not in new}
    if last is not None and len(known) >= AT_ONCE:
        start = Start(as_belief(last), last.started_from, last.relative)
        return start, as_observed(fresh, known=known)
    pair = found.pair
    start = start_of(session, machine_id, pair.material.name, pair.tool.name)
    return start, as_observed(found.forces)


def _say_left_out(pair: models.Pair, found: Felt, done: Refreshed) -> None:
    for reason, cuts in found.left_out.items():
        done.set_aside.append(f"{pair_name(pair)}: {cuts} cuts not learnt from: {reason}")


def seen_by(parameters: models.CuttingParameters | None) -> set[int]:
    """Return the sensed forces that a version and those before it learnt from."""
    versions = [] if parameters is None else chain(parameters)
    return {force.id for version in versions for force in version.forces}
