"""The job planner: what a job's cuts take, which limits they may exceed, what to cut next."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request, Response
from sqlalchemy.orm import Session

from autodb.agent.answer.looking_up import Listed, PairReader
from autodb.agent.answer.planning import ProposedCuts, plan_cuts
from autodb.agent.answer.predicting import JobAnswer, answer_of
from autodb.agent.learn.usual_cut import usual_cut
from autodb.agent.rows.machines import owner_named
from autodb.errors import UnusableInput
from autodb.files.cut_words import cut_in_words
from autodb.files.job import Job
from autodb.files.job_cut import JobCut
from autodb.files.job_words import job_in_words
from autodb.forward.bending import bending_in_words
from autodb.forward.limits import standings_in_words
from autodb.reports.amounts import number
from autodb.reports.figures import force_of
from autodb.reports.planned import predicted
from autodb.web.html import service_page
from autodb.web.pages.cuts import (
    form_of_cuts,
    prediction_spans,
    read_cuts,
    rewritten,
    stated_rows,
)
from autodb.web.pages.program_form import form_of_program
from autodb.web.pages.reading import read_state
from autodb.web.pages.typed import typed_as, written_cut
from autodb.web.service import Reads, service_of
from autodb.wording import phrase

router = APIRouter()
NAME = "planned"


@router.get("/machines/{machine:path}/plan")
def planner(
    request: Request,
    _access: Reads,
    machine: str,
    material: Annotated[str, Query(max_length=200)] = "",
    tool: Annotated[str, Query(max_length=200)] = "",
    *,
    cut_next: Annotated[bool, Query(alias="next")] = False,
    typed: Annotated[str, Query(max_length=20)] = "",
) -> Response:
    """Show the form of a job, and what the job takes once it is stated."""
    known = read_state(request, lambda session: PairReader(session, machine).pairs())
    said: object = ""
    rows: list[Mapping[str, str]] = []
    answered: JobAnswer | None = None
    proposed: ProposedCuts | None = None
    try:
        rows.extend(stated_rows(request.query_params))
        cuts = read_cuts(rows, typed_as(typed))
        rows = rewritten(rows, cuts, typed_as(typed))
        if cuts and material and tool:
            named = tuple(
                cut
                if cut.name
                else cut.model_copy(update={"name": str(phrase("cut {number}", number=k))})
                for k, cut in enumerate(cuts, start=1)
            )
            job = Job(name=NAME, material=material, tool=tool, cut=named)
            service = service_of(request)
            answered = answer_of(service.lookup_cache.basis(machine, material, tool).basis, job)
            proposed = plan_cuts(service.store, machine, job) if cut_next else None
    except UnusableInput as error:
        said = error
    if not rows:
        first = read_state(
            request, lambda session: first_cut(session, machine, known, material, tool)
        )
        rows = [written_cut(first)]
    return service_page(
        request,
        "plan.html.j2",
        title=phrase("{machine}: plan a job", machine=machine),
        machine=machine,
        here="plan",
        materials=sorted({one.material for one in known}),
        tools=sorted({one.tool for one in known}),
        material=material or (known[0].material if known else ""),
        tool=tool or (known[0].tool if known else ""),
        **form_of_cuts(rows),
        **form_of_program(),
        said=said,
        **_answered(request, machine, answered),
        proposed=None if proposed is None else _proposed(proposed),
    )


def _answered(request: Request, machine: str, answered: JobAnswer | None) -> dict[str, Any]:
    """Return what the template shows of an answer."""
    if answered is None:
        return {"answer": None}
    limits = read_state(request, lambda session: owner_named(session, machine).limits)
    return {
        "answer": answered,
        "asked": list(job_in_words(answered.job)),
        "plot": predicted.plot(answered, limits),
        "left_out": 0,
        "cuts": shown_cuts(answered, range(len(answered.cuts))),
        **limits_shown(answered),
    }


def shown_cuts(answered: JobAnswer, which: Iterable[int]) -> list[tuple[Any, ...]]:
    """Return what the template shows of some of an answer's cuts: what they take, and figures."""
    cuts, figures = answered.cuts, answered.figures
    return [
        (cuts[k], prediction_spans(cuts[k], cuts), predicted.figure_rows(figures[k])) for k in which
    ]


def limits_shown(answered: JobAnswer) -> dict[str, Any]:
    """Return what the template shows of an answer's limits and figures."""
    return {
        "exceeds": [(answered.cuts[one.cut - 1].name, one.statement) for one in answered.exceeds],
        "limits": list(standings_in_words(answered.limits)),
        "totals": predicted.total_rows(answered.totals),
        "bending": list(bending_in_words(answered.cuts, answered.bending)),
    }


def first_cut(
    session: Session, machine: str, known: Sequence[Listed], material: str, tool: str
) -> JobCut:
    """Return the cut that the form begins with: a usual one of the pair."""
    owner = owner_named(session, machine)
    if not material and known:
        material, tool = known[0].material, known[0].tool
    return usual_cut(session, owner.id, material, tool)


def _proposed(found: ProposedCuts) -> dict[str, object]:
    """Return what the template shows of what to cut next."""
    return {
        "now": _percent(found.now),
        "cuts": [(cut_in_words(one.cut), _percent(one.left)) for one in found.proposed],
        "targets": [
            (one.cut, force_of(one.component), _percent(one.now), _percent(one.after))
            for one in found.targets
        ],
        "hardly": found.hardly,
        "open": found.open,
        "too_much": found.too_much,
    }


def _percent(share: float) -> str:
    return f"± {number(100.0 * share)} %"
