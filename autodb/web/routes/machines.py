"""Machines, what they can sense, what they have learnt: everything that is read by name or
number."""

from collections.abc import Callable
from typing import Annotated, Any

from fastapi import APIRouter, Path, Query, Request, Response
from sqlalchemy.orm import Session

from autodb.agent.answer.looking_up import Listed, PairReader
from autodb.agent.answer.overview import (
    CalibrationSaid,
    MachineSaid,
    MismatchSaid,
    calibrations_said,
    machine_said,
    machines_seen,
    mismatch_said,
)
from autodb.agent.answer.shown.axis_courses import MachineCourse, machine_course
from autodb.agent.answer.traced_forces import Node
from autodb.agent.answer.tracing import trace
from autodb.agent.matching.scoring import PredictionScores, scores_in
from autodb.agent.operate.access import noted
from autodb.agent.operate.deciding import mismatch, mismatches
from autodb.agent.sense.sensors import sensors_of
from autodb.web.http import responses
from autodb.web.http.problems import problems
from autodb.web.http.responses import unchanged
from autodb.web.http.said import AuditLine, Machines, Senses, Step
from autodb.web.service import Administers, Reads, service_of

PAGE = 100
READ = problems(401, 404, 422, 429, 503)
MOST_ID = 2**63 - 1

router = APIRouter()
MachineName = Annotated[str, Path(description="Name of the machine.", examples=["lathe-1"])]
Number = Annotated[int, Path(ge=1, le=MOST_ID, examples=[1])]
Most = Annotated[int, Query(ge=1, le=1000, description="How many at most.")]


def answer_from_state(request: Request, kind: Any, asked: Callable[[Session], object]) -> Response:
    """Answer from one state of the database, or say that it is the one that is known."""
    service = service_of(request)
    mark = service.watched.mark()
    known = unchanged(request, mark)
    if known is not None:
        return known
    with service.store.reading() as session:
        return responses.conditional(request, kind, asked(session), mark)


def documented_answer(kind: Any) -> dict[str, Any]:
    """Return how a route that answers with a type is documented."""
    not_modified = {304: {"description": "As in the answer whose ETag is in If-None-Match."}}
    return {"response_model": kind, "responses": READ | not_modified}


@router.get("/machines", summary="Machines", **documented_answer(Machines))
def machines_route(
    request: Request,
    _access: Reads,
    most: Most = PAGE,
    after: Annotated[str, Query(description="Only those behind this name.")] = "",
) -> Response:
    """List machines with their axes, when they were last heard, and what waits for a person."""

    def some(session: Session) -> Machines:
        found = machines_seen(session, most=most, after=after)
        return Machines(found, found[-1].name if len(found) == most else None)

    return answer_from_state(request, Machines, some)


@router.get(
    "/machines/{machine:path}/sensors", summary="Its force sensors", **documented_answer(Senses)
)
def sensors_route(request: Request, _access: Reads, machine: MachineName) -> Response:
    """List a machine's force sensors, how near they come, and the forces that nothing senses."""
    return answer_from_state(request, Senses, lambda session: Senses(*sensors_of(session, machine)))


@router.get(
    "/machines/{machine:path}/calibrations",
    summary="Calibrations",
    **documented_answer(list[CalibrationSaid]),
)
def calibrations(request: Request, _access: Reads, machine: MachineName) -> Response:
    """List a machine's calibrations that hold now: equations, errors, and why one is refused."""
    return answer_from_state(
        request, list[CalibrationSaid], lambda session: calibrations_said(session, machine)
    )


@router.get(
    "/machines/{machine:path}/pairs",
    summary="Its work-tool pairs",
    **documented_answer(list[Listed]),
)
def pairs_route(
    request: Request,
    _access: Reads,
    machine: MachineName,
    material: Annotated[str | None, Query(examples=["C45"])] = None,
    tool: Annotated[str | None, Query(examples=["CNMG 120408"])] = None,
) -> Response:
    """List the work-tool pairs that a machine has learnt, all or of a material or a tool."""
    return answer_from_state(
        request, list[Listed], lambda session: PairReader(session, machine).pairs(material, tool)
    )


@router.get(
    "/machines/{machine:path}/scores",
    summary="Its predictions and the cuts then made",
    **documented_answer(PredictionScores),
)
def scores_route(request: Request, _access: Reads, machine: MachineName) -> Response:
    """Say how far off a machine's past predictions were, and what that widens."""
    return answer_from_state(request, PredictionScores, lambda s: scores_in(s, machine))


@router.get(
    "/machines/{machine:path}/mismatches",
    summary="Mismatches",
    **documented_answer(list[MismatchSaid]),
)
def machine_mismatches(
    request: Request,
    _access: Reads,
    machine: MachineName,
    decided: Annotated[bool, Query(description="Those decided on, too.")] = False,
) -> Response:
    """List what simulations left out of a machine's recordings, oldest first."""

    def some(session: Session) -> list[MismatchSaid]:
        rows = mismatches(session, machine, decided=decided)
        return [mismatch_said(session, row) for row in rows]

    return answer_from_state(request, list[MismatchSaid], some)


@router.get(
    "/machines/{machine:path}/health",
    summary="How its axes went, and what is due",
    **documented_answer(MachineCourse),
)
def health_route(request: Request, _access: Reads, machine: MachineName) -> Response:
    """Give gain, friction and force of a machine's axes over the weeks, and what is due."""
    return answer_from_state(request, MachineCourse, lambda s: machine_course(s, machine))


@router.get("/machines/{machine:path}", summary="One machine", **documented_answer(MachineSaid))
def machine_route(request: Request, _access: Reads, machine: MachineName) -> Response:
    """Say what a machine is: its axes, their limits, its control."""
    return answer_from_state(request, MachineSaid, lambda session: machine_said(session, machine))


@router.get("/mismatches/{number}", summary="One mismatch", **documented_answer(MismatchSaid))
def one_mismatch(request: Request, _access: Reads, number: Number) -> Response:
    """Say what a simulation left out of a recording, and what it may be otherwise."""
    return answer_from_state(
        request, MismatchSaid, lambda session: mismatch_said(session, mismatch(session, number))
    )


@router.get("/trace/{kind}/{number}", summary="Where a number came from", **documented_answer(Step))
def trace_route(
    request: Request,
    _access: Reads,
    kind: Annotated[
        str,
        Path(
            description="prediction, parameters, force, calibration, model, scale, mismatch or "
            "recording.",
            examples=["parameters"],
        ),
    ],
    number: Number,
) -> Response:
    """Lead from a stored row down to the recordings that it came from."""
    store = service_of(request).store
    return answer_from_state(request, Step, lambda _: _step(trace(store, kind, number)))


def _step(node: Node) -> Step:
    return Step(node.text, [_step(one) for one in node.sources])


@router.get("/audit", summary="Who did what", **documented_answer(list[AuditLine]))
def audit(
    request: Request,
    _access: Administers,
    most: Most = PAGE,
    before: Annotated[int | None, Query(ge=1, le=MOST_ID, description="Older than this.")] = None,
) -> Response:
    """List what was done through the service and with tokens, newest first."""
    return answer_from_state(
        request,
        list[AuditLine],
        lambda session: [AuditLine(*one) for one in noted(session, most=most, before=before)],
    )
