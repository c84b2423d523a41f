"""Refresh: what came in since the last time becomes sensed forces and new parameter versions.

One pass is one transaction: killed in the middle, the database is as it was, and the next pass does
the whole work again.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

from sqlalchemy import Select, exists, select
from sqlalchemy.orm import Session

from autodb.agent.beliefs import pair_name
from autodb.agent.calibrations import as_calibration, current_calibrations
from autodb.agent.feeling import FeltOverTime, feel_over_time
from autodb.agent.felt import Calibrations, forces_of_pair
from autodb.agent.importing import cuts_as_table
from autodb.agent.learning import learn_pair
from autodb.agent.machines import find_machine
from autodb.agent.states import open_mismatches
from autodb.sensing.chosen import sense_each
from autodb.store import Store, models

RANGE_ESTIMATOR = "range"
NO_ESTIMATOR = "none"


@dataclass
class Refreshed:
    """What a refresh did: forces; versions as (pair, version, cuts behind it); what
    stands aside, and the mismatches opened for it.
    """

    sensed: int = 0
    not_sensed: int = 0
    versions: list[tuple[str, int, int]] = field(default_factory=list)
    set_aside: list[str] = field(default_factory=list)
    mismatches: list[str] = field(default_factory=list)


def refresh(
    store: Store, machine: str, *, progress: Callable[[str], None] | None = None
) -> Refreshed:
    """Sense the forces of every cut not sensed yet with the newest calibrations; update the pairs.

    Cuts of recordings over time are felt by what the machine has beside calibrated ranges. Cuts
    that are not of a pair's usual state are explained, and mismatches opened for them.

    Raises UnusableInput for an unknown machine.
    """
    done = Refreshed()
    odd: list[int] = []
    tell = progress or (lambda _: None)
    over_time = feel_over_time(store, machine, progress=tell)
    with store.writing() as session:
        owner = find_machine(session, machine)
        _keep_felt(session, over_time, done)
        felt = _felt(session, owner, done, tell)
        for pair in session.scalars(_pairs(owner.id)):
            tell(f"updating {pair_name(pair)}")
            found = forces_of_pair(session, owner.id, pair, felt)
            outcome = learn_pair(session, owner.id, found, progress=tell)
            done.versions += outcome.versions
            done.set_aside += outcome.set_aside
            odd += outcome.odd
        done.mismatches += open_mismatches(session, owner, odd, progress=tell)
    return done


def _keep_felt(session: Session, over_time: FeltOverTime, done: Refreshed) -> None:
    """Keep what was felt over time, but what another agent kept meanwhile."""
    for one in over_time.means:
        there = session.scalar(
            select(models.SensedForce.id).where(
                models.SensedForce.cut_id == one.cut_id,
                models.SensedForce.component == one.component,
                models.SensedForce.estimator_id == one.estimator_id,
            )
        )
        if there is None:
            session.add(one.row())
            done.sensed += one.reason is None
            done.not_sensed += one.reason is not None
    done.set_aside += over_time.notes
    session.flush()


def learn_confirmed(
    session: Session, row: models.Mismatch, progress: Callable[[str], None]
) -> list[models.CuttingParameters]:
    """Learn the pairs of a confirmed mismatch' recording; return their newest that hold it."""
    owner = session.get_one(models.Machine, row.recording.machine_id)
    felt = _felt(session, owner, Refreshed(), progress)
    pairs = {cut.pair_id: cut.pair for cut in row.recording.cuts if cut.pair is not None}
    for _, pair in sorted(pairs.items(), key=lambda one: one[0] or 0):
        progress(f"updating {pair_name(pair)}")
        learn_pair(
            session, owner.id, forces_of_pair(session, owner.id, pair, felt), progress=progress
        )
    session.flush()
    session.refresh(row)
    made = {(one.pair_id, one.state): one for one in row.parameters_of_pairs}
    return list(made.values())


def _felt(
    session: Session, owner: models.Machine, done: Refreshed, progress: Callable[[str], None]
) -> list[Calibrations]:
    """Sense what was not sensed yet; return the calibrations of each axis that feels force."""
    felt: dict[str, Calibrations] = {}
    for axis in owner.axes:
        current = current_calibrations(session, owner.id, axis.name)
        _say_refused(current, done)
        if any(row.offered for row in current):
            component = current[0].component
            progress(f"sensing force.{component} from {axis.name}")
            _sense(session, owner.id, current, done)
            felt[component] = current
    if not felt and not _sensed_otherwise(session, owner.id):
        done.set_aside.append(
            "no calibration is offered: nothing can be sensed ('calibrate' first)"
        )
    _note_unsensed(session, owner.id, felt, done)
    session.flush()
    return list(felt.values())


def _sensed_otherwise(session: Session, machine_id: int) -> bool:
    """Say whether something beside calibrated ranges has felt a force of the machine's cuts."""
    query = (
        select(models.SensedForce.id)
        .join(models.Cut)
        .join(models.Recording)
        .where(
            models.Recording.machine_id == machine_id,
            models.SensedForce.estimator_id.is_not(None),
            models.SensedForce.value_N.is_not(None),
        )
        .limit(1)
    )
    return session.scalar(query) is not None


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
