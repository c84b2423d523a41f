"""A person's word on a mismatch, given through the service."""

from typing import Annotated

from fastapi import APIRouter, Body, Request, Response

from autodb.agent.answer.overview import mismatch_said
from autodb.agent.operate.access import noting
from autodb.agent.operate.deciding import Decided, confirm, mismatch, reject, reopen
from autodb.web.http.problems import problems
from autodb.web.http.responses import json_answer
from autodb.web.http.said import Decision
from autodb.web.routes.machines import Number
from autodb.web.service import Operates, Service, service_of

router = APIRouter()
Reason = Annotated[
    str | None, Body(embed=True, max_length=1000, description="Why; kept with the decision.")
]
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
    *,
    term: Annotated[
        str | None,
        Body(embed=True, description="One of its alternatives, where it is that.", examples=[None]),
    ] = None,
    lot: Annotated[
        str | None,
        Body(embed=True, description="Lot of material of a hard spot, where its cuts say none."),
    ] = None,
    why: Reason = None,
) -> Response:
    """Confirm what was left out: it enters what its term belongs to, as the next version."""
    service = service_of(request)
    also = noting(access, "mismatch confirmed", "mismatch", term=term, why=why)
    done = confirm(service.store, number, term=term, lot=lot, by=access.who, why=why, also=also)
    return _said(service, done)


@router.post(
    "/mismatches/{number}/reject",
    summary="Reject a mismatch",
    response_model=Decision,
    responses=DECIDES,
)
def rejected(request: Request, access: Operates, number: Number, why: Reason = None) -> Response:
    """Reject a mismatch: what confirming it changed is taken back, and cuts that were excluded for
    it are learnt after all.
    """
    service = service_of(request)
    also = noting(access, "mismatch rejected", "mismatch", why=why)
    return _said(service, reject(service.store, number, by=access.who, why=why, also=also))


@router.post(
    "/mismatches/{number}/reopen",
    summary="Take back a decision on a mismatch",
    response_model=Decision,
    responses=DECIDES,
)
def reopened(request: Request, access: Operates, number: Number, why: Reason = None) -> Response:
    """Take back a decision, and what it changed: the next prediction is as it was before."""
    service = service_of(request)
    also = noting(access, "mismatch reopened", "mismatch", why=why)
    return _said(service, reopen(service.store, number, by=access.who, why=why, also=also))


def _said(service: Service, done: Decided) -> Response:
    kept = [] if done.kept is None else [f"{done.channel} version {done.kept.version}"]
    kept += done.changed
    with service.store.reading() as session:
        row = mismatch_said(session, mismatch(session, done.number))
    said = Decision(row, done.already, tuple(kept), done.back)
    return json_answer(Decision, said, service.watched.mark())
