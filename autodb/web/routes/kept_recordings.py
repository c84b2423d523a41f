"""Recordings that are in the database: which, what was found in them, and taking one back."""

from typing import Annotated

from fastapi import APIRouter, Body, Query, Request, Response

from autodb.agent.answer.shown.recordings import (
    RecordingSaid,
    RecordingSeen,
    recording_said,
    recordings_seen,
)
from autodb.agent.operate.access import noting
from autodb.agent.operate.withdrawing import Withdrawn, take_again, withdraw
from autodb.web.http.problems import problems
from autodb.web.http.responses import json_answer
from autodb.web.routes.machines import (
    MOST_ID,
    PAGE,
    MachineName,
    Most,
    Number,
    answer_from_state,
    documented_answer,
)
from autodb.web.service import Operates, Reads, service_of

router = APIRouter()
WITHDRAWS = problems(401, 403, 404, 422, 429, 503)
NOTED = {"withdraw": "recording withdrawn", "take-again": "recording taken again"}
"""What the audit log says, by the word of what is done."""
Before = Annotated[int | None, Query(ge=1, le=MOST_ID, description="Older than this number.")]


@router.get(
    "/machines/{machine:path}/recordings",
    summary="Its recordings",
    **documented_answer(list[RecordingSeen]),
)
def recordings_route(
    request: Request,
    _access: Reads,
    machine: MachineName,
    most: Most = PAGE,
    before: Before = None,
) -> Response:
    """List a machine's recordings, newest first: lengths, rates, cuts, and what is to know."""
    return answer_from_state(
        request,
        list[RecordingSeen],
        lambda session: recordings_seen(session, machine, most=most, before=before),
    )


@router.get(
    "/machines/{machine:path}/recordings/{number}",
    summary="One recording",
    **documented_answer(RecordingSaid),
)
def recording_route(
    request: Request, _access: Reads, machine: MachineName, number: Number
) -> Response:
    """Say what a recording holds, what was found of its quality, and what rests on it."""
    return answer_from_state(
        request, RecordingSaid, lambda session: recording_said(session, machine, number)
    )


@router.post(
    "/machines/{machine:path}/recordings/{number}/withdraw",
    summary="Withdraw a recording",
    response_model=Withdrawn,
    responses=WITHDRAWS,
)
def withdraw_route(
    request: Request,
    access: Operates,
    machine: MachineName,
    number: Number,
    *,
    why: Annotated[
        str,
        Body(embed=True, min_length=1, max_length=1000, description="Why; a trace says it."),
    ],
) -> Response:
    """Take a recording back, with what rests on it; the next refresh learns without it."""
    service = service_of(request)
    also = noting(access, NOTED["withdraw"], "recording", why=why)
    done = withdraw(service.store, machine, number, why=why, also=also)
    return json_answer(Withdrawn, done, service.watched.mark())


@router.post(
    "/machines/{machine:path}/recordings/{number}/take-again",
    summary="Take a withdrawn recording again",
    response_model=Withdrawn,
    responses=WITHDRAWS,
)
def take_again_route(
    request: Request, access: Operates, machine: MachineName, number: Number
) -> Response:
    """Have a withdrawn recording count again; the next refresh learns from it."""
    service = service_of(request)
    also = noting(access, NOTED["take-again"], "recording")
    done = take_again(service.store, machine, number, also=also)
    return json_answer(Withdrawn, done, service.watched.mark())
