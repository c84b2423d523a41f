"""Predict a job from what the machine believes of its pair, and keep what was answered."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb import forward
from autodb.agent.beliefs import LAW, as_belief, chain, latest, learnt, pair_name, start_of
from autodb.agent.felt import numbers_of, operation_of
from autodb.agent.machines import as_file, find_machine
from autodb.errors import UnusableInput
from autodb.exceeding import Exceeding, exceeding
from autodb.forward import PredictedCut, ToolOf
from autodb.jobs import Job, JobCut
from autodb.pairs.belief import Belief
from autodb.pairs.engaged import BY_NAME
from autodb.pairs.observed import Variant
from autodb.store import Store, models

RANGES = (("cutting.depth", "depth", "mm"), ("cutting.feed", "feed", "mm"))


@dataclass(frozen=True)
class Behind:
    """What a prediction rests on.

    ``parameters``, ``version`` and ``cuts`` of the pair's own belief; None and 0 where the machine
    has not cut it, and then it rests on what ``started_from`` says.
    """

    parameters: int | None
    version: int | None
    cuts: int
    started_from: str | None


@dataclass(frozen=True)
class Predicted:
    """The answer for a job: a row per cut; ``exceeds``: limits that a cut may go beyond."""

    prediction_id: int
    job: Job
    cuts: tuple[PredictedCut, ...]
    behind: Behind
    notes: tuple[str, ...] = ()
    exceeds: tuple[Exceeding, ...] = ()


@dataclass(frozen=True)
class Known:
    """What a machine knows of a pair: its belief, its tool, the rows that these are from.

    ``row``: the pair's newest parameters, or a related pair's; None: no machine's.
    """

    belief: Belief
    tool: ToolOf
    behind: Behind
    row: models.CuttingParameters | None

    @property
    def own(self) -> bool:
        """Whether the machine has learnt this pair."""
        return self.behind.parameters is not None


def predict_job(store: Store, machine: str, job: Job) -> Predicted:
    """Predict every cut of a job; the prediction is stored with the parameters it used.

    A pair that the machine has not cut is predicted from a related one or from conventional values,
    and the notes say so. Raises UnusableInput for an unknown machine, or where the tool cannot make
    a cut.
    """
    with store.writing() as session:
        owner = find_machine(session, machine)
        known = known_of(session, owner, job.material, job.tool)
        cuts = forward.predict(known.belief, known.tool, job.cut)
        stored = models.Prediction(
            machine_id=owner.id,
            job=job.model_dump(mode="json"),
            cuts=[asdict(cut) for cut in cuts],
            parameters=[known.row] if known.row is not None else [],
        )
        session.add(stored)
        session.flush()
        limits = {name: axis.limits for name, axis in as_file(owner).axes.items()}
        return Predicted(
            prediction_id=stored.id,
            job=job,
            cuts=cuts,
            behind=known.behind,
            notes=(*_not_learnt(session, owner, known, job), *_notes(known, job)),
            exceeds=exceeding(cuts, limits),
        )


def known_of(session: Session, owner: models.Machine, material: str, tool: str) -> Known:
    """Return what a machine knows of a pair, learnt or not.

    Raises UnusableInput where the pair was learnt under an earlier law only.
    """
    its_tool = session.scalar(select(models.Tool).where(models.Tool.name == tool))
    called = ToolOf(tool, numbers_of(its_tool) if its_tool is not None else {})
    pair = _pair(session, material, tool)
    row = latest(session, owner.id, pair.id) if pair is not None else None
    if row is not None:
        behind = Behind(row.id, row.version, row.n_cuts, row.started_from)
        return Known(as_belief(row), called, behind, row)
    _refuse_earlier_law(session, owner, pair)
    start = start_of(session, owner.id, material, tool)
    return Known(start.belief, called, Behind(None, None, 0, start.said), start.row)


def _refuse_earlier_law(session: Session, owner: models.Machine, pair: models.Pair | None) -> None:
    """Raise UnusableInput where a pair's parameters are all of an earlier law."""
    earlier = pair is not None and session.scalar(
        select(models.CuttingParameters.law)
        .where(
            models.CuttingParameters.machine_id == owner.id,
            models.CuttingParameters.pair_id == pair.id,
            models.CuttingParameters.law != LAW,
        )
        .limit(1)
    )
    if earlier:
        raise UnusableInput(
            f"machine '{owner.name}': its parameters of the pair are of an earlier autodb's law; "
            f"'autodb refresh --machine {owner.name}' learns it anew from the same cuts"
        )


def _not_learnt(session: Session, owner: models.Machine, known: Known, job: Job) -> Iterable[str]:
    """Say what stands in for a pair that the machine has not learnt, and what it has learnt."""
    if not known.own:
        pairs = ", ".join(pair_name(row.pair) for row in learnt(session, owner.id))
        yield (
            f"{owner.name} has not learnt {job.material} / {job.tool}: predicted from "
            f"{known.behind.started_from}; it has learnt: {pairs or 'no pair yet'}"
        )


def _notes(known: Known, job: Job) -> Iterable[str]:
    yield from assumed(known, job.cut)
    if known.own and known.row is not None:
        yield from _outside(known.row, job)


def assumed(known: Known, cuts: Sequence[JobCut]) -> Iterable[str]:
    """Say which geometry of the tool is assumed because nobody stated it."""
    names = [
        one.key
        for operation in dict.fromkeys(cut.operation for cut in cuts)
        for one in _assumed_in(known.tool, next(c for c in cuts if c.operation == operation))
    ]
    if names:
        listed = ", ".join(dict.fromkeys(name.partition(": ")[2] for name in names))
        yield (
            f"assumed of {known.tool.name}, because nobody stated it: {listed}; a tool file would "
            "narrow the intervals"
        )


def _assumed_in(tool: ToolOf, cut: JobCut) -> Iterable[Variant]:
    made = BY_NAME[cut.operation].cuts(
        tool.numbers, [cut.conditions(tool.diameter_mm)], called=tool.name
    )
    return made.variants


def _outside(row: models.CuttingParameters, job: Job) -> Iterable[str]:
    """Say which cuts lie outside the depths, feeds and operations that the pair was learnt from."""
    cuts = {force.cut_id: force.cut for version in chain(row) for force in version.forces}.values()
    made = {operation_of(cut) for cut in cuts}
    for operation in dict.fromkeys(cut.operation for cut in job.cut):
        if operation not in made:
            yield f"operation '{operation}' was never cut: from the law alone, wider"
    for number, asked in enumerate(job.cut, start=1):
        stated = asked.conditions(row.pair.tool.diameter_mm)
        for channel, what, unit in RANGES:
            values = [cut.conditions[channel] for cut in cuts if channel in cut.conditions]
            if channel not in stated or not values:
                continue
            value, low, high = stated[channel], min(values), max(values)
            if not low * 0.999 <= value <= high * 1.001:
                yield (
                    f"cut {number} '{asked.name}': {what} {value:g} {unit} was never cut "
                    f"({low:g} to {high:g} {unit})"
                )


def _pair(session: Session, material: str, tool: str) -> models.Pair | None:
    return session.scalar(
        select(models.Pair)
        .join(models.Material)
        .join(models.Tool)
        .where(models.Material.name == material, models.Tool.name == tool)
    )
