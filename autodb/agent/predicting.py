"""Predict a job from the pair's newest parameters, and keep what was answered."""

from dataclasses import asdict, dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb import forward
from autodb.agent.machines import find_machine
from autodb.agent.refreshing import as_parameters, chain, latest_parameters, pair_name
from autodb.cutting.law import COMPONENTS
from autodb.errors import UnusableInput
from autodb.forward import PredictedCut
from autodb.jobs import Job
from autodb.store import Store, models


@dataclass(frozen=True)
class Predicted:
    """The answer for a job: a row per cut, and per component the version and the cuts behind it."""

    prediction_id: int
    job: Job
    cuts: tuple[PredictedCut, ...]
    behind: dict[str, tuple[int, int]]
    notes: tuple[str, ...] = ()


def predict_job(store: Store, machine: str, job: Job) -> Predicted:
    """Predict every cut of a job; the prediction is stored with the parameter versions it used.

    Raises UnusableInput when the machine has not learnt the pair.
    """
    with store.writing() as session:
        owner = find_machine(session, machine)
        pair = _pair(session, machine, job)
        rows = pair_parameters(session, owner.id, pair.id)
        if not rows:
            raise UnusableInput(
                f"machine '{machine}' has no parameters for {pair_name(pair)} yet; "
                "import cuts of it and run 'autodb refresh'"
            )
        known = {component: as_parameters(row) for component, row in rows.items()}
        cuts = tuple(forward.predict(cut, known) for cut in job.cut)
        stored = models.Prediction(
            machine_id=owner.id,
            job=job.model_dump(mode="json"),
            cuts=[asdict(cut) for cut in cuts],
            parameters=list(rows.values()),
        )
        session.add(stored)
        session.flush()
        behind = {component: (row.version, row.n_cuts) for component, row in rows.items()}
        return Predicted(stored.id, job, cuts, behind, tuple(_outside(job, list(rows.values()))))


def _outside(job: Job, rows: list[models.CuttingParameters]) -> list[str]:
    """Say which cuts lie outside the depths and feeds that the pair was learnt from."""
    learnt = [f.cut.conditions for row in rows for version in chain(row) for f in version.forces]
    notes = []
    for number, cut in enumerate(job.cut, start=1):
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
    session: Session, machine_id: int, pair_id: int
) -> dict[str, models.CuttingParameters]:
    """Return the newest parameters of a pair by component; a component never felt is left out."""
    found = {c: latest_parameters(session, machine_id, pair_id, c) for c in COMPONENTS}
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
