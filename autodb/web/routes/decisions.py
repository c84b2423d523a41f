"""A person's word on a mismatch, given through the service."""

from typing import Annotated

from fastapi import APIRouter, Body, Request, Response

from autodb.agent.answer.overview import mismatch_said
from autodb.agent.operate.access import noting
from autodb.agent.operate.deciding import Decided, confirm, mismatch, reject
from autodb.web.http.problems import problems
from autodb.web.http.responses import json_answer
from autodb.web.http.said import Decision
from autodb.web.routes.machines import Number
from autodb.web.service import Operates, Service, service_of

router = APIRouter()
DECIDES = problems(401, 403, 404, 422, 429, 503)


@router.post(
    "/mismatches/{number}/confirm",
    summary="Confirm a mismatch",
    response_model=Decision,
    responses=DECIDES,
)
def confirm_route(
    request: Request,
    access: Operates,
    number: Number,
    term: Annotated[
        str | None,
        Body(embed=True, description="One of its alternatives, where it is that.", examples=[None]),
    ] = None,
) -> Response:
    """Confirm what was left out: a term that the machine's model can hold enters it."""
    service = service_of(request)
    also = noting(access, "mismatch confirmed", "mismatch", term=term)
    return _said(service, confirm(service.store, number, term=term, by=access.who, also=also))


@router.post(
    "/mismatches/{number}/reject",
    summary="Reject a mismatch",
    response_model=Decision,
    responses=DECIDES,
)
def rejected(request: Request, access: Operates, number: Number) -> Response:
    """Reject a mismatch: cuts that were excluded for it are learnt after all."""
    service = service_of(request)
    also = noting(access, "mismatch rejected", "mismatch")
    return _said(service, reject(service.store, number, by=access.who, also=also))


def _said(service: Service, done: Decided) -> Response:
    kept = [] if done.kept is None else [f"{done.channel} version {done.kept.version}"]
    with service.store.reading() as session:
        row = mismatch_said(session, mismatch(session, done.number))
    said = Decision(row, done.already, (*kept, *done.pairs))
    return json_answer(Decision, said, service.watched.mark())
