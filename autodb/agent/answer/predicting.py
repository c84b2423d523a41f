"""Predict a job from the posterior of the machine's pair, and keep what was answered."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from autodb.agent.answer.notes import said_of_terms
from autodb.agent.answer.prediction_basis import PredictionBasis, prediction_basis_of
from autodb.agent.learn.known import Behind, known_of
from autodb.agent.rows.catalogue import pair_id, refuse_other_geometry
from autodb.agent.rows.machines import as_file, find_machine, owner_named
from autodb.files.job import Job
from autodb.forward.bending import CutBending, bending_of_job
from autodb.forward.cut_figures import CutFigures, JobTotals, cut_figures, job_totals
from autodb.forward.limits import Exceeding, LimitStanding
from autodb.forward.prediction import PredictedCut
from autodb.store import Also, Store, models, nothing_else

if TYPE_CHECKING:
    from autodb.forward.line_parts import Followed


NOSE = "nose_radius_mm"


@dataclass(frozen=True)
class JobAnswer:
    """The answer for a job: a row per cut, or line of a program that cuts.

    ``exceeds``: limits that a cut may go beyond; ``limits``: how the job stands to all of them;
    ``figures`` of each cut, ``totals`` of all; ``bending`` of work and tool, where they are stated.
    """

    job: Job
    cuts: tuple[PredictedCut, ...]
    behind: Behind
    notes: tuple[str, ...]
    exceeds: tuple[Exceeding, ...]
    limits: tuple[LimitStanding, ...]
    figures: tuple[CutFigures, ...]
    totals: JobTotals
    bending: tuple[CutBending, ...]


@dataclass(frozen=True)
class Predicted(JobAnswer):
    """An answer that is kept, and its number."""

    prediction_id: int


def predict_job(
    store: Store,
    machine: str,
    job: Job,
    *,
    also: Also = nothing_else,
    tool: Mapping[str, float] | None = None,
) -> Predicted:
    """Predict every cut of a job; the prediction is stored with the parameters it used.

    A pair that the machine has not cut is predicted from a related one or from conventional values,
    and the notes say so. ``also``: what else is written in its transaction; ``tool``: what is
    stated of the tool's geometry, which is kept with it. Raises UnusableInput for an unknown
    machine, a program that is broken, or where the tool cannot make a cut or is another one.
    """
    program = followed_program(store, machine, job)
    with store.writing(machine) as session:
        owner = owner_named(session, machine)
        known = known_of(session, owner, job.material, job.tool)
        refuse_other_geometry(job.tool, known.tool.numbers, tool or {})
        stated = {**_stated_of_mill(job, known.tool.numbers), **(tool or {})}
        if tool is not None or stated:
            pair_id(session, job.material, job.tool, stated)
            known = known_of(session, owner, job.material, job.tool)
        basis = prediction_basis_of(session, owner, job.material, known)
        answer, states = _answer(basis, job, program)
        stored = models.Prediction(
            machine_id=owner.id,
            job=_stored(job, program),
            cuts=[asdict(cut) for cut in answer.cuts],
            started_from=None if known.own else known.behind.started_from,
            prior=known.prior,
            width=asdict(basis.width) if basis.width.factor > 1.0 else None,
            parameters=[*([known.row] if known.row is not None else []), *states],
        )
        session.add(stored)
        session.flush()
        also(session, stored.id)
        return Predicted(**vars(answer), prediction_id=stored.id)


def answer_of(basis: PredictionBasis, job: Job) -> JobAnswer:
    """Return the answer for a job of cuts; nothing is kept."""
    return _answer(basis, job, None)[0]


def answer_job(
    store: Store, machine: str, job: Job, *, tool: Mapping[str, float] | None = None
) -> JobAnswer:
    """Return the answer for a job, of cuts or with a program; nothing is kept.

    ``tool``: what is stated of the tool's geometry. Raises UnusableInput as ``predict_job``.
    """
    program = followed_program(store, machine, job)
    with store.reading() as session:
        owner = owner_named(session, machine)
        known = known_of(session, owner, job.material, job.tool)
        stated = {**_stated_of_mill(job, known.tool.numbers), **(tool or {})}
        basis = prediction_basis_of(session, owner, job.material, known).with_tool(stated)
        return _answer(basis, job, program)[0]


def _stated_of_mill(job: Job, known: Mapping[str, float]) -> dict[str, float]:
    """Return what a job states of the one mill or drill of its program, and nobody said before."""
    shapes = [] if job.program is None else list(job.program.tools.values())
    if len(shapes) != 1 or shapes[0].diameter_mm is None:
        return {}
    names = ("diameter_mm", "teeth", "corner_radius_mm", "helix_deg")
    stated = {name: getattr(shapes[0], name) for name in names if name not in known}
    return {name: float(value) for name, value in stated.items() if value is not None}


def followed_program(store: Store, machine: str, job: Job) -> "Followed | None":
    """Return a job's program followed through its stock; None where the job lists cuts.

    Raises UnusableInput for an unknown machine or a program that is broken.
    """
    if job.program is None:
        return None
    from autodb.forward import programs

    with store.reading() as session:
        file = as_file(find_machine(session, machine))
    return programs.follow(
        job.program, units=file.units, diameter=file.diameter,
        highest_rpm=file.spindle.max_speed_rpm,
    )  # fmt: skip


def _answer(
    basis: PredictionBasis, job: Job, program: "Followed | None"
) -> tuple[JobAnswer, list[models.CuttingParameters]]:
    """Return the answer, and the parameters of other process states that were used.

    A program's lines are predicted in the usual state.
    """
    basis = basis.of_lot(job.lot)
    known = basis.known
    if program is None:
        cuts, states = basis.predict(job.cut)
        notes = (*basis.said(job.cut, cuts), *_lasting(basis, job, cuts))
    else:
        from autodb.forward import along

        source, states = program.source, []
        cuts = basis.widened(
            along.predict_lines(known.posterior, known.tool, program.lines, source=source)
        )
        notes = (
            *basis.notes(program.lines),
            *said_of_terms(known.posterior, known.tool, (), cuts),
            *_of_program(program, job.tool, cuts, nose_mm=known.tool.numbers.get(NOSE)),
        )
    figures = tuple(cut_figures(cut) for cut in cuts)
    answer = JobAnswer(
        job=job,
        cuts=cuts,
        behind=known.behind,
        notes=notes,
        exceeds=basis.exceeding(cuts),
        limits=basis.standings(cuts, None if program is None else program.spans_mm),
        figures=figures,
        totals=job_totals(figures),
        bending=bending_of_job(job, cuts),
    )
    return answer, states


def _lasting(basis: PredictionBasis, job: Job, cuts: Sequence[PredictedCut]) -> Iterable[str]:
    """Say how long an edge lasts until the first limit, where wear was learnt and parts can count.

    Nothing is said where the machine states no limit of a load, or an edge passes none.
    """
    from autodb.forward.limits import QUANTITIES

    if basis.known.posterior.wear is None or any(cut.time_s is None for cut in cuts):
        return
    if not any(what.limit(basis.limits, cut) for what in QUANTITIES for cut in cuts):
        return
    from autodb.agent.answer.bounds.lasting import tool_life

    first = tool_life(basis, job).lives[0]
    if first.minutes.low is not None:
        yield first.words


def _stored(job: Job, program: "Followed | None") -> dict[str, Any]:
    """Return a job as it is kept: of a program with the checksum of what was read."""
    if program is None:
        return job.model_dump(mode="json")
    stored = job.model_dump(mode="json", exclude={"cut"})
    stored["program"]["sha256"] = program.sha256
    return stored


def _of_program(
    program: "Followed", tool: str, cuts: Sequence[PredictedCut], *, nose_mm: float | None
) -> Iterable[str]:
    """Say how long a program cuts, what of its tools counts, and which line has a high peak."""
    from autodb.forward.along import nose_leaves, peaked

    lines = f"{len(cuts)} lines" if len(cuts) > 1 else "1 line"
    yield (
        f"{lines} cut for {program.cutting_s:.1f} s, of {program.fed_s:.1f} s at a feed, and take "
        f"{0.001 * program.removed_mm3:.1f} cm³ off"
    )
    if len(program.tools) > 1:
        yield f"cuts with tools {', '.join(program.tools)}: all by what is known of {tool}"
    yield from program.notes
    yield from nose_leaves(program.lines, program.beside, nose_mm)
    yield from peaked(cuts)
