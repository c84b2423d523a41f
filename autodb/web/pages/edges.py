"""Edges of a machine's tools, on its page: one button says that one was changed, another undoes."""

from typing import Annotated

from fastapi import APIRouter, Form, Request, Response
from fastapi.responses import RedirectResponse

from autodb.agent.operate.access import Role, noting
from autodb.agent.operate.changed_edges import change_edge, undo_edge_change
from autodb.errors import UnusableInput
from autodb.web.html import path
from autodb.web.pages.machine import show_machine
from autodb.web.routes.edges import CHANGED, UNDONE
from autodb.web.routes.machines import Number
from autodb.web.service import Reads, allowed, service_of

router = APIRouter()
SEE_OTHER = 303
Text = Annotated[str, Form(max_length=1000)]


@router.get("/machines/{machine:path}/edges")
def edges_page(_access: Reads, machine: str) -> Response:
    """Lead to the machine's page, which has them."""
    return _to_edges(machine)


@router.post("/machines/{machine:path}/edges")
def change_edge_page(
    request: Request,
    machine: str,
    *,
    tool: Text = "",
    at: Text = "",
    by: Text = "",
    why: Text = "",
    csrf: Annotated[str, Form()] = "",
) -> Response:
    """Record that a tool has a new edge."""
    access = allowed(request, Role.OPERATE, csrf, changes=True)
    also = noting(access, CHANGED, "edge_change", tool=tool, at=at or None, why=why or None)
    try:
        change_edge(
            service_of(request).store, machine, tool, at=at or None, by=by or access.who,
            why=why or None, also=also,
        )  # fmt: skip
    except UnusableInput as error:
        return show_machine(request, machine, edge_refused=error.line, status=422)
    return _to_edges(machine)


@router.post("/machines/{machine:path}/edges/{number}/undo")
def undo_edge_page(
    request: Request, machine: str, number: Number, csrf: Annotated[str, Form()] = ""
) -> Response:
    """Have a recorded change count no more."""
    access = allowed(request, Role.OPERATE, csrf, changes=True)
    store = service_of(request).store
    undo_edge_change(store, number, also=noting(access, UNDONE, "edge_change"))
    return _to_edges(machine)


def _to_edges(machine: str) -> Response:
    return RedirectResponse(f"{path('machines', machine)}#edges", SEE_OTHER)
