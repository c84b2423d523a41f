"""Changes of tools' edges that a person records, through the service."""

from typing import Annotated

from fastapi import APIRouter, Body, Query, Request, Response

from autodb.agent.operate.access import noting
from autodb.agent.operate.changed_edges import (
    EdgeChanged,
    EdgesOfMachine,
    change_edge,
    edges_of_machine,
    undo_edge_change,
)
from autodb.web.http.responses import json_answer
from autodb.web.routes.decisions import DECIDES, Reason
from autodb.web.routes.machines import MachineName, Number, answer_from_state, documented_answer
from autodb.web.service import Operates, Reads, service_of

router = APIRouter()
CHANGED, UNDONE = "edge changed", "edge change undone"
"""What the audit log says."""


@router.get(
    "/machines/{machine:path}/edges",
    summary="Its tools' edges",
    **documented_answer(EdgesOfMachine),
)
def edges_route(
    request: Request,
    _access: Reads,
    machine: MachineName,
    every: Annotated[bool, Query(description="Every change, also those undone.")] = False,
) -> Response:
    """List the last recorded change of each tool's edge, and what the edge has cut since."""
    return answer_from_state(
        request, EdgesOfMachine, lambda session: edges_of_machine(session, machine, every=every)
    )


@router.post(
    "/machines/{machine:path}/edges",
    summary="Record an edge change",
    response_model=EdgeChanged,
    responses=DECIDES,
)
def change_edge_route(
    request: Request,
    access: Operates,
    machine: MachineName,
    *,
    tool: Annotated[
        str, Body(embed=True, max_length=1000, description="A tool that it has cuts of.")
    ],
    at: Annotated[
        str | None,
        Body(
            embed=True,
            max_length=100,
            description="When, ISO 8601, without a zone the service's; by default now.",
            examples=[None],
        ),
    ] = None,
    by: Annotated[
        str | None,
        Body(embed=True, max_length=1000, description="Who says so; by default who asks."),
    ] = None,
    why: Reason = None,
) -> Response:
    """Record that a tool has a new edge: what it cuts is counted from then on."""
    service = service_of(request)
    also = noting(access, CHANGED, "edge_change", tool=tool, at=at, why=why)
    done = change_edge(service.store, machine, tool, at=at, by=by or access.who, why=why, also=also)
    return json_answer(EdgeChanged, done, service.watched.mark())


@router.post(
    "/edges/{number}/undo",
    summary="Undo an edge change",
    response_model=EdgeChanged,
    responses=DECIDES,
)
def undo_edge_route(request: Request, access: Operates, number: Number) -> Response:
    """Have a recorded change count no more: its cuts are those of the edge before again."""
    service = service_of(request)
    done = undo_edge_change(service.store, number, also=noting(access, UNDONE, "edge_change"))
    return json_answer(EdgeChanged, done, service.watched.mark())
