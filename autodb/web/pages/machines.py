"""Machines at a glance: what each senses, when it was last heard, and what waits for a person."""

from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from autodb.agent.answer.overview import machines_seen
from autodb.web.html import service_page
from autodb.web.pages.reading import read_state
from autodb.web.service import Reads
from autodb.wording import phrase

MOST = 60
"""Machines of one page. Chosen."""

router = APIRouter()


@router.get("/")
def machines_page(
    request: Request,
    _access: Reads,
    like: Annotated[str, Query(max_length=200)] = "",
    after: Annotated[str, Query(max_length=200)] = "",
) -> Response:
    """Show the machines, by name."""
    found = read_state(
        request, lambda session: machines_seen(session, most=MOST, after=after, like=like)
    )
    return service_page(
        request,
        "machines.html.j2",
        title=phrase("Machines"),
        here="machines",
        machines=found,
        more=found[-1].name if len(found) == MOST else None,
        like=like,
        after=after,
    )
