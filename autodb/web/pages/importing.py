"""Importing recordings by dropping their files on a page, which asks what a foreign file is."""

import tempfile
from pathlib import Path

from fastapi import APIRouter, Request, Response
from fastapi.responses import HTMLResponse
from pydantic import ValidationError
from starlette.concurrency import run_in_threadpool

from autodb.agent.rows.machines import owner_named
from autodb.errors import UnusableInput
from autodb.files.channels import channel_names, unit_of
from autodb.records.proposed.choices import SideChoices
from autodb.web.html import page_headers, service_page
from autodb.web.http.problems import first_of
from autodb.web.http.responses import adapter
from autodb.web.http.settings import MIB
from autodb.web.pages.reading import read_state
from autodb.web.receive.looking import FileToLook
from autodb.web.receive.sent import SentPart, receive_parts
from autodb.web.routes.recordings import RECORDING, SIDE, named_as_sent
from autodb.web.service import Operates, Reads, made_apart, service_of
from autodb.wording import phrase

CHOICES = "choices"
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
        channels=[(name, unit_of(name) or "") for name in channel_names()],
    )


@router.post("/machines/{machine:path}/import/look")
async def look(request: Request, _access: Operates, machine: str) -> Response:
    """Answer with the piece of the page that says what a file is; nothing is kept.

    It takes the file, its side file where there is one, and what was chosen beyond that, and reads
    it in a process of its own.
    """
    service = service_of(request)
    service.refuse_sending(request)
    await run_in_threadpool(service.needs_machine, machine)
    limits = service.settings.limits
    most = {RECORDING: limits.recording_MiB, SIDE: limits.side_MiB, CHOICES: limits.side_MiB}
    with tempfile.TemporaryDirectory(prefix="autodb-") as folder:
        sizes = {field: size * MIB for field, size in most.items()}
        parts = await receive_parts(request, Path(folder), sizes, limits.receive_s)
        task = FileToLook(named_as_sent(parts), _choices(parts.get(CHOICES)))
        made = await made_apart(service, task, str, limits.looking)
    return HTMLResponse(made, headers=page_headers())


def _choices(part: SentPart | None) -> SideChoices | None:
    """Return what was chosen; raises UnusableInput."""
    if part is None:
        return None
    try:
        found: SideChoices = adapter(SideChoices).validate_json(part.path.read_bytes())
    except ValidationError as error:
        raise UnusableInput(f"{CHOICES}: {first_of(error.errors())}") from None
    return found
