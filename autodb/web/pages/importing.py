"""Importing recordings by dropping their files on a page."""

from fastapi import APIRouter, Request, Response

from autodb.agent.rows.owner import owner_named
from autodb.web.html import service_page
from autodb.web.pages.reading import read_state
from autodb.web.service import Reads, service_of
from autodb.wording import phrase

router = APIRouter()


@router.get("/machines/{machine:path}/import")
def import_page(request: Request, _access: Reads, machine: str) -> Response:
    """Show where files are dropped; the page's script sends them and says how far each is."""
    owner = read_state(request, lambda session: owner_named(session, machine))
    settings = service_of(request).settings
    return service_page(
        request,
        "import.html.j2",
        title=phrase("{machine}: import", machine=machine),
        machine=owner.name,
        here="import",
        keeps=settings.keeps_in is not None,
        most=settings.limits.recording_MiB,
    )
