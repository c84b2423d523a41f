"""Learning now: a machine's page begins it, and says how far it is and what was learnt."""

from typing import Annotated

from fastapi import APIRouter, Form, HTTPException, Request, Response
from fastapi.responses import RedirectResponse

from autodb.agent.operate.access import Role
from autodb.web.html import path, service_page_piece
from autodb.web.pages.machine import show_machine
from autodb.web.service import Reads, allowed, service_of

router = APIRouter()
SEE_OTHER, CONFLICT, BUSY = 303, 409, 503


@router.get("/machines/{machine:path}/learning/piece")
def learning_piece(request: Request, _access: Reads, machine: str) -> Response:
    """Answer with the piece of the machine's page that says how far its learning is."""
    service = service_of(request)
    service.needs_machine(machine)
    learning = service.learnings.said(machine)
    return service_page_piece(
        request, "_learning.html.j2", machine=machine, learning=learning, refused=""
    )


@router.get("/machines/{machine:path}/learning")
def learning_page(_access: Reads, machine: str) -> Response:
    """Lead to the machine's page, which has it."""
    return RedirectResponse(f"{path('machines', machine)}#learn", SEE_OTHER)


@router.post("/machines/{machine:path}/learning")
def learn_page(
    request: Request,
    machine: str,
    csrf: Annotated[str, Form()] = "",
    calibrate: Annotated[bool, Form()] = False,
) -> Response:
    """Have a machine learn from what came in; its page then says how far that is."""
    access = allowed(request, Role.OPERATE, csrf, changes=True)
    try:
        service_of(request).learnings.begin(machine, access, calibrate=calibrate)
    except HTTPException as error:
        if error.status_code not in (CONFLICT, BUSY):
            raise
        return show_machine(request, machine, refused=error.detail, status=error.status_code)
    return RedirectResponse(f"{path('machines', machine)}#learn", SEE_OTHER)
