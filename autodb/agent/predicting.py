"""Predict a job from the pair's newest parameters, and keep what was answered."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb import forward
from autodb.agent.machines import as_file, find_machine
from autodb.agent.refreshing import (
    as_parameters,
    chain,
    latest_parameters,
    operations_of,
    pair_name,
)
from autodb.cutting.law import COMPONENTS
from autodb.errors import UnusableInput
from autodb.exceeding import Exceeding, exceeding, unknown
from autodb.forward import PredictedCut
from autodb.jobs import Job
from autodb.machinefile import Limits
from autodb.store import Store, models

Behind = dict[str, dict[str, models.CuttingParameters]]


@dataclass(frozen=True)
class Predicted:
    """The answer for a job: a row per cut; ``behind``: version and cuts by operation, component.

    ``exceeds``: limits of the machine that a cut may go beyond.
    """

    prediction_id: int
    job: Job
    cuts: tuple[PredictedCut, ...]
    behind: dict[str, dict[str, tuple[int, int]]]
    notes: tuple[str, ...] = ()
    exceeds: tuple[Exceeding, ...] = ()


def predict_job(store: Store, machine: str, job: Job) -> Predicted:
    """Predict every cut of a job; the prediction is stored with the parameter versions it used.

    Raises UnusableInput when the machine has not learnt the pair, or an operation of the job.
    """
    with store.writing() as session:
        owner = find_machine(session, machine)
        pair = _pair(session, machine, job)
        rows = _behind(session, owner, pair, job)
        known = {
            operation: {component: as_parameters(row) for component, row in found.items()}
            for operation, found in rows.items()
        }
        cuts = tuple(forward.predict(cut, known[cut.operation]) for cut in job.cut)
        stored = models.Prediction(
            machine_id=owner.id,
            job=job.model_dump(mode="json"),
            cuts=[asdict(cut) for cut in cuts],
            parameters=[row for found in rows.values() for row in found.values()],
        )
        session.add(stored)
        session.flush()
        behind = {
            operation: {component: (row.version, row.n_cuts) for component, row in found.items()}
            for operation, found in rows.items()
        }
        limits = {name: axis.limits for name, axis in as_file(owner).axes.items()}
        return Predicted(
            prediction_id=stored.id,
            job=job,
            cuts=cuts,
            behind=behind,
            notes=(*_outside(job, rows), *_not_told(cuts, limits)),
            exceeds=exceeding(cuts, limits),
        )


def _behind(session: Session, owner: models.Machine, pair: models.Pair, job: Job) -> Behind:
    """Return the newest parameters for each operation of a job, by component."""
    rows: Behind = {}
    for operation in dict.fromkeys(cut.operation for cut in job.cut):
        rows[operation] = pair_parameters(session, owner.id, pair.id, operation)
        if rows[operation]:
            continue
        cut = operations_of(session, owner.id, pair.id)
        if operation in cut or not cut:
            raise UnusableInput(
                f"machine '{owner.name}' has no parameters for {pair_name(pair)} yet "
                f"(operation '{operation}'); import cuts of it and run 'autodb refresh'"
            )
        raise UnusableInput(
            f"machine '{owner.name}' has never cut {pair_name(pair)} in operation '{operation}'; "
            f"it has cut: {', '.join(cut)}"
        )
    return rows


def _not_told(cuts: Sequence[PredictedCut], limits: Mapping[str, Limits]) -> list[str]:
    """Say of which axes nothing tells whether a cut exceeds what they give."""
    return [
        f"{axis}'s {limits[axis].force_N:g} N: no force of this axis is sensed, so nothing tells "
        "whether a cut exceeds it"
        for axis in unknown(cuts, limits)
    ]


def _outside(job: Job, rows: Behind) -> list[str]:
    """Say which cuts lie outside the depths and feeds that their operation was learnt from."""
    conditions_of = {
        operation: [f.cut.conditions for r in found.values() for v in chain(r) for f in v.forces]
        for operation, found in rows.items()
    }
    notes = []
    for number, cut in enumerate(job.cut, start=1):
        learnt = conditions_of[cut.operation]
        for what, channel, value, unit in (
            ("depth", "cutting.depth", cut.depth_mm, "mm"),
            ("feed", "cutting.feed", cut.feed_mm_rev, "mm/rev"),
        ):
            low = min(conditions[channel] for conditions in learnt)
            high = max(conditions[channel] for conditions in learnt)
            if not low * 0.999 <= value <= high * 1.001:
                notes.append(
                    f"cut {number} '{cut.name}': {what} {value:g} {unit} was never cut ({low:g} to "
                    f"{high:g}): its interval is not to be trusted"
                )
    return notes


def pair_parameters(
    session: Session, machine_id: int, pair_id: int, operation: str
) -> dict[str, models.CuttingParameters]:
    """Return a pair's newest parameters in an operation; a component never felt is left out."""
    found = {c: latest_parameters(session, machine_id, pair_id, operation, c) for c in COMPONENTS}
    return {component: row for component, row in found.items() if row is not None}


def _pair(session: Session, machine: str, job: Job) -> models.Pair:
    pair = session.scalar(
        select(models.Pair)
        .join(models.Material)
        .join(models.Tool)
        .where(models.Material.name == job.material, models.Tool.name == job.tool)
    )
    if pair is None:
        have = [pair_name(p) for p in session.scalars(select(models.Pair))]
        raise UnusableInput(
            f"machine '{machine}' has never cut {job.material} / {job.tool}; "
            f"it knows: {', '.join(have) or 'no pair yet'}"
        )
    return pair
