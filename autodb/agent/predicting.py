"""Predict a job from what the machine believes of its pair, and keep what was answered."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Protocol

from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb import along, programs
from autodb.agent import in_state
from autodb.agent.beliefs import LAW, as_belief, latest, learnt_pairs
from autodb.agent.felt import numbers_of
from autodb.agent.learnt_from import LearntFrom, learnt_from
from autodb.agent.machines import as_file, find_machine, limits_of
from autodb.agent.starting import start_of
from autodb.agent.wearing import said_of_wear
from autodb.cutting import tools
from autodb.errors import UnusableInput, near
from autodb.exceeding import Exceeding, exceeding
from autodb.forward import PredictedCut, ToolOf
from autodb.jobs import Job
from autodb.pairs.belief import Belief
from autodb.pairs.engaged import BY_NAME, DEPTH, FEED
from autodb.store import Store, models

RANGES = ((DEPTH, "depth", "mm"), (FEED, "feed", "mm"))


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
    """The answer for a job: a row per cut, or line of a program that cuts.

    ``exceeds``: limits that a cut may go beyond.
    """

    prediction_id: int
    job: Job
    cuts: tuple[PredictedCut, ...]
    behind: Behind
    notes: tuple[str, ...] = ()
    exceeds: tuple[Exceeding, ...] = ()


class Asked(Protocol):
    """A cut, or a line of a program, that a planner asks for."""

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def operation(self) -> str:
        """What it is."""

    def ranges(self, tool_diameter_mm: float | None) -> Mapping[str, tuple[float, float]]:
        """Return from where to where what is stated of it goes, by channel."""


@dataclass(frozen=True)
class Wanted:
    """Cuts that a planner asks for of a pair."""

    material: str
    tool: str
    cuts: Sequence[Asked]


@dataclass(frozen=True)
class Known:
    """What a machine knows of a pair: its belief, its tool, the rows that these are from.

    ``row``: the pair's newest parameters, or a related pair's; None: no machine's. ``prior``: what
    other machines know, where the belief is from that.
    """

    belief: Belief
    tool: ToolOf
    behind: Behind
    row: models.CuttingParameters | None
    prior: models.FleetPrior | None = None

    @property
    def own(self) -> bool:
        """Whether the machine has learnt this pair."""
        return self.behind.parameters is not None


def predict_job(store: Store, machine: str, job: Job) -> Predicted:
    """Predict every cut of a job; the prediction is stored with the parameters it used.

    A pair that the machine has not cut is predicted from a related one or from conventional values,
    and the notes say so. Raises UnusableInput for an unknown machine, a program that is broken, or
    where the tool cannot make a cut.
    """
    program = _followed(store, machine, job)
    asked = job.cut if program is None else program.lines
    with store.writing(machine) as session:
        owner = find_machine(session, machine)
        known = known_of(session, owner, job.material, job.tool)
        cuts, states = _cuts(session, known, job, program)
        wanted = Wanted(job.material, job.tool, asked)
        stored = models.Prediction(
            machine_id=owner.id,
            job=_stored(job, program),
            cuts=[asdict(cut) for cut in cuts],
            started_from=None if known.own else known.behind.started_from,
            prior=known.prior,
            parameters=[*([known.row] if known.row is not None else []), *states],
        )
        session.add(stored)
        session.flush()
        return Predicted(
            prediction_id=stored.id,
            job=job,
            cuts=cuts,
            behind=known.behind,
            notes=(
                *notes(session, owner, known, wanted),
                *said_of_states(cuts),
                *said_of_wear(known.belief, known.tool, job.cut, cuts),
                *_of_program(program, job.tool, cuts),
            ),
            exceeds=exceeding(cuts, limits_of(owner)),
        )


def _followed(store: Store, machine: str, job: Job) -> programs.Followed | None:
    """Return a job's program followed through its stock; None where the job lists cuts."""
    if job.program is None:
        return None
    with store.reading() as session:
        file = as_file(find_machine(session, machine))
    return programs.follow(job.program, units=file.units, diameter=file.diameter)


def _cuts(
    session: Session, known: Known, job: Job, program: programs.Followed | None
) -> tuple[tuple[PredictedCut, ...], list[models.CuttingParameters]]:
    """Return the cuts predicted, and the parameters of other process states that were used.

    A program's lines are predicted in the usual state.
    """
    if program is None:
        number = known.behind.parameters
        return in_state.predict(session, number, known.belief, known.tool, job.cut)
    lines = along.predict_lines(known.belief, known.tool, program.lines, source=program.source)
    return lines, []


def _stored(job: Job, program: programs.Followed | None) -> dict[str, Any]:
    """Return a job as it is kept: of a program with the checksum of what was read."""
    if program is None:
        return job.model_dump(mode="json")
    stored = job.model_dump(mode="json", exclude={"cut"})
    stored["program"]["sha256"] = program.sha256
    return stored


def _of_program(
    program: programs.Followed | None, tool: str, cuts: Sequence[PredictedCut]
) -> Iterable[str]:
    """Say how long a program cuts, what of its tools counts, and which line has a high peak."""
    if program is None:
        return
    lines = f"{len(cuts)} lines" if len(cuts) > 1 else "1 line"
    yield f"{lines} cut for {program.cutting_s:.1f} s, of {program.fed_s:.1f} s at a feed"
    if len(program.tools) > 1:
        yield f"cuts with tools {', '.join(program.tools)}: all predicted as {tool}"
    yield from along.peaked(cuts)


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
    behind = Behind(None, None, 0, start.said)
    return Known(start.belief, called, behind, start.row, start.prior)


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


def notes(session: Session, owner: models.Machine, known: Known, wanted: Wanted) -> Iterable[str]:
    """Say what a planner has to know of an answer: from what it is, what is assumed, what is far.

    Far are depths, feeds and operations that the pair's own cuts do not hold.
    """
    if not known.own:
        name, learnt = f"{wanted.material} / {wanted.tool}", learnt_pairs(session, owner.id)
        hint = near(name, learnt) if learnt else ""
        yield (
            f"{owner.name} has not learnt {name}{hint}: predicted from {known.behind.started_from}"
        )
    yield from assumed(known, wanted.cuts)
    if known.behind.parameters is not None:
        made = learnt_from(session, known.behind.parameters)
        yield from _outside(made, wanted.cuts, known.tool)


def said_of_states(cuts: Sequence[PredictedCut]) -> Iterable[str]:
    """Say which cuts are predicted in another process state than the usual one."""
    for number, cut in enumerate(cuts, start=1):
        if cut.state is not None:
            yield (
                f"cut {number} '{cut.name}': in the state '{cut.state}', which its speed or the "
                "wear of its edge implies"
            )


def assumed(known: Known, cuts: Sequence[Asked]) -> Iterable[str]:
    """Say which geometry of the tool is assumed because nobody stated it."""
    kinds = dict.fromkeys(BY_NAME[cut.operation].kind for cut in cuts)
    names = [one.name for kind in kinds for one in tools.assumed_of(kind, known.tool.numbers)]
    if names:
        listed = ", ".join(dict.fromkeys(names))
        yield (
            f"assumed of {known.tool.name}, because nobody stated it: {listed}; a tool file would "
            "narrow the intervals"
        )


def _outside(made: LearntFrom, cuts: Sequence[Asked], tool: ToolOf) -> Iterable[str]:
    """Say which cuts lie outside the depths, feeds and operations that the pair was learnt from."""
    for operation in dict.fromkeys(cut.operation for cut in cuts):
        if operation not in made.operations:
            yield f"operation '{operation}' was never cut: from the law alone, wider"
    for number, asked in enumerate(cuts, start=1):
        stated = asked.ranges(tool.diameter_mm)
        for channel, what, unit in RANGES:
            if channel not in stated or channel not in made.ranges:
                continue
            (least, most), (low, high) = stated[channel], made.ranges[channel]
            if not (low * 0.999 <= least and most <= high * 1.001):
                value = most if most > high * 1.001 else least
                which = f"cut {number} '{asked.name}': " if asked.name or len(cuts) > 1 else ""
                yield (
                    f"{which}{what} {value:.4g} {unit} was never cut ({low:g} to {high:g} {unit})"
                )


def _pair(session: Session, material: str, tool: str) -> models.Pair | None:
    return session.scalar(
        select(models.Pair)
        .join(models.Material)
        .join(models.Tool)
        .where(models.Material.name == material, models.Tool.name == tool)
    )
