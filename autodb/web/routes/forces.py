"""Look-ups and predictions: what cuts will take, before they are made."""

from collections.abc import Callable, Coroutine
from functools import partial
from typing import Annotated, Any

from fastapi import APIRouter, Body, Query, Request, Response
from fastapi.routing import APIRoute
from pydantic import StringConstraints
from starlette.concurrency import run_in_threadpool

from autodb.agent.answer.bounds.largest import Largest, Wanted, largest_value
from autodb.agent.answer.bounds.lasting import ToolLife, limit_stated, tool_life
from autodb.agent.answer.bounds.lives import AskedLife, ToolLives, tool_lives
from autodb.agent.answer.predicting import JobAnswer, Predicted, answer_of, predict_job
from autodb.agent.answer.prediction_basis import LookedUp
from autodb.agent.operate.access import Role, noting
from autodb.errors import UnusableInput
from autodb.files.job import Job
from autodb.web.http import responses
from autodb.web.http.problems import problems
from autodb.web.http.responses import json_answer, unchanged
from autodb.web.http.sessions import HEADER
from autodb.web.routes.asked import (
    EXAMPLES,
    LOT,
    cut_of_query,
    pair_of,
    parameters_of_a_cut,
)
from autodb.web.routes.machines import MachineName, documented_answer
from autodb.web.service import Operates, Reads, allowed, service_of


class DirectRoute(APIRoute):
    """A route of a machine that anybody may ask who reads, answered at once.

    The framework's own search for what a route depends on takes a tenth of a look-up's time.
    """

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Return what answers a request: as the route's signature says, without the search."""

        async def answered(request: Request) -> Response:
            access = allowed(request, Role.READ, request.headers.get(HEADER), changes=False)
            made: Response = await self.endpoint(request, access, request.path_params["machine"])
            return made

        return answered


router, direct = APIRouter(), APIRouter(route_class=DirectRoute)
OF_LARGEST = ("what", "share", "sure")
Percent = Annotated[
    float, Query(ge=1.0, le=100.0, description="Of each limit on a load, in per cent.")
]
Surely = Annotated[
    float, Query(ge=50.0, le=99.9, description="How surely it is kept, in per cent.")
]
JOB = {
    "shaft": {
        "summary": "Two cuts of a shaft",
        "value": {
            "name": "shaft",
            "material": "C45",
            "tool": "CNMG 120408",
            "cut": [EXAMPLES, {**EXAMPLES, "name": "finish", "depth_mm": 0.5, "feed_mm_rev": 0.1}],
        },
    }
}


@direct.get(
    "/machines/{machine:path}/lookup",
    summary="Look up one cut",
    openapi_extra={"parameters": parameters_of_a_cut()},
    **documented_answer(LookedUp),
)
async def look_up(request: Request, _access: Reads, machine: MachineName) -> Response:
    """Say which forces, torque and power a cut of a pair will take, with 95 % intervals.

    Nothing is kept. A pair that the machine has not cut is answered from what is nearest to it, and
    ``notes`` say from what.
    """
    service = service_of(request)
    mark = service.watched.mark()
    known = unchanged(request, mark)
    if known is not None:
        return known
    query = dict(request.query_params)
    material, tool = pair_of(query)
    cut = cut_of_query(query)
    found = service.lookup_cache.basis(machine, material, tool, mark=mark)
    service.metrics.cuts.inc()
    answer = found.basis.of_lot(query.get(LOT)).look_up(cut)
    return responses.conditional(request, LookedUp, answer, found.mark)


@router.get(
    "/machines/{machine:path}/largest",
    summary="Largest feed, depth or speed",
    openapi_extra={"parameters": parameters_of_a_cut()},
    **documented_answer(Largest),
)
async def largest_route(
    request: Request,
    _access: Reads,
    machine: MachineName,
    what: Annotated[Wanted, Query(description="What is to be large.", examples=["feed"])],
    share: Percent = 100.0,
    sure: Surely = 95.0,
) -> Response:
    """Say up to which feed, depth or speed a cut keeps a share of the limits of its machine.

    What the cut states of it does not count. Nothing is kept.
    """
    query = {k: text for k, text in request.query_params.items() if k not in OF_LARGEST}
    material, tool = pair_of(query)
    service = service_of(request)
    found = service.lookup_cache.basis(machine, material, tool)
    basis = found.basis.of_lot(query.get(LOT))
    answer = await run_in_threadpool(
        partial(
            largest_value, basis, cut_of_query(query), what, share=share / 100.0, sure=sure / 100.0
        )
    )
    return json_answer(Largest, answer, found.mark)


LIMITED = r"^(force\.[xyz]|torque\.spindle|spindle\.power)=[0-9]{1,9}(\.[0-9]{1,6})?$"
OF_AN_EDGE = rf"^([^=:]{{1,200}}:)?{LIMITED.removeprefix('^')}"
LimitAsked = Annotated[str, StringConstraints(pattern=LIMITED)]
LimitOfEdge = Annotated[str, StringConstraints(pattern=OF_AN_EDGE)]
MOST_JOBS = 20
"""Jobs that may make a part together. Chosen: more than a turret has tools for."""
AJob = Annotated[Job, Body(openapi_examples=JOB)]


@router.post(
    "/machines/{machine:path}/predict",
    summary="Predict a job",
    response_model=JobAnswer,
    responses=problems(401, 404, 413, 422, 429, 503),
)
def predict_route(request: Request, _access: Reads, machine: MachineName, job: AJob) -> Response:
    """Say what each cut of a job will take; nothing is kept."""
    _refuse_a_program(job)
    service = service_of(request)
    found = service.lookup_cache.basis(machine, job.material, job.tool)
    service.metrics.cuts.inc(len(job.cut))
    return json_answer(JobAnswer, answer_of(found.basis, job), found.mark)


@router.post(
    "/machines/{machine:path}/predictions",
    summary="Predict a job and keep the answer",
    status_code=201,
    response_model=Predicted,
    responses=problems(401, 403, 404, 413, 422, 429, 503),
)
def keep_prediction(
    request: Request, access: Operates, machine: MachineName, job: AJob
) -> Response:
    """Say what each cut of a job will take, and keep it: its number leads to what it rests on."""
    _refuse_a_program(job)
    service = service_of(request)

    also = noting(access, "prediction kept", "prediction", machine=machine)
    kept = predict_job(service.store, machine, job, also=also)
    service.metrics.cuts.inc(len(job.cut))
    made = json_answer(Predicted, kept, service.watched.mark())
    made.status_code = 201
    made.headers["Location"] = f"/api/v1/trace/prediction/{kept.prediction_id}"
    return made


@router.post(
    "/machines/{machine:path}/life",
    summary="Life of an edge in a job",
    response_model=ToolLife,
    responses=problems(401, 404, 413, 422, 429, 503),
)
async def life_route(
    request: Request,
    _access: Reads,
    machine: MachineName,
    job: AJob,
    limit: Annotated[
        list[LimitAsked] | None,
        Query(
            description="Limits in place of the machine's, each as CHANNEL=VALUE.",
            examples=[["torque.spindle=40"]],
        ),
    ] = None,
    sure: Surely = 95.0,
) -> Response:
    """Say how many parts an edge lasts until forces, torque or power pass a limit.

    It needs a pair whose wear was learnt; else ``why`` says so. Nothing is kept.
    """
    _refuse_a_program(job)
    found = service_of(request).lookup_cache.basis(machine, job.material, job.tool)
    limits = dict(limit_stated(text, where="limit") for text in limit or ())
    answer = await run_in_threadpool(
        partial(tool_life, found.basis, job, limits=limits, sure=sure / 100.0)
    )
    return json_answer(ToolLife, answer, found.mark)


@router.post(
    "/machines/{machine:path}/lives",
    summary="Lives of the edges that make a part",
    response_model=ToolLives,
    responses=problems(401, 404, 413, 422, 429, 503),
)
async def lives_route(
    request: Request,
    _access: Reads,
    machine: MachineName,
    *,
    jobs: Annotated[
        list[Job],
        Body(embed=True, min_length=1, max_length=MOST_JOBS, description="Each of one tool."),
    ],
    limit: Annotated[
        list[LimitOfEdge] | None,
        Query(
            description="Limits in place of the machine's, each as CHANNEL=VALUE, of all edges, or "
            "as TOOL:CHANNEL=VALUE of one.",
            examples=[["torque.spindle=40"]],
        ),
    ] = None,
    sure: Surely = 95.0,
) -> Response:
    """Say how many parts the edges last that make a part together, and which ends first.

    An edge whose pair has learnt no wear says so in ``why``. Nothing is kept.
    """
    for job in jobs:
        _refuse_a_program(job)
    known = service_of(request).lookup_cache
    found = [known.basis(machine, job.material, job.tool) for job in jobs]
    asked = [AskedLife(one.basis, job) for one, job in zip(found, jobs, strict=True)]
    limits = dict(limit_stated(text, where="limit") for text in limit or ())
    answer = await run_in_threadpool(partial(tool_lives, asked, limits=limits, sure=sure / 100.0))
    return json_answer(ToolLives, answer, found[-1].mark)


def _refuse_a_program(job: Job) -> None:
    """Raise UnusableInput for a job that names a file of this computer."""
    if job.program is not None:
        raise UnusableInput("program: files are not read from here; send a job with cuts")
