"""Recordings that are sent: received, read apart, and asked for until they are in the database."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from fastapi import APIRouter, Request, Response
from starlette.concurrency import run_in_threadpool

from autodb.errors import UnusableInput
from autodb.readers import EMPTY, READERS, UNKNOWN_KIND
from autodb.web.http.problems import problems
from autodb.web.http.responses import adapter
from autodb.web.http.said import Importing
from autodb.web.http.settings import MIB
from autodb.web.receive.sent import FORM, SentPart, receive_parts, safe
from autodb.web.routes.machines import MachineName, Number
from autodb.web.service import Operates, Reads, service_of
from autodb.wording import language_of
from autodb.wording.kept import said_again

router = APIRouter()
RECORDING, SIDE = "recording", "side"
_FILE = {"type": "string", "format": "binary"}
_BODY = {
    "required": True,
    "content": {
        FORM: {
            "schema": {
                "type": "object",
                "required": [RECORDING],
                "properties": {
                    RECORDING: _FILE | {"description": "Its name's ending says how it is read."},
                    SIDE: _FILE | {"description": "Its side file (TOML)."},
                },
            }
        }
    },
}


@router.post(
    "/machines/{machine:path}/recordings",
    summary="Send a recording",
    status_code=202,
    response_model=Importing,
    responses={
        202: {
            "description": "It is here, and will be read; `Location` says how far that is.",
            "headers": {"Location": {"schema": {"type": "string"}}},
        },
        **problems(401, 403, 404, 408, 413, 422, 429, 503),
    },
    openapi_extra={"requestBody": _BODY},
)
async def send(request: Request, access: Operates, machine: MachineName) -> Response:
    """Import a recording or a table of cuts, with its side file; a file that is there counts once.

    It is read in a process of its own, after those that wait. What is wrong with it, its import
    says: in one line, and nothing of it is kept.
    """
    service = service_of(request)
    service.refuse_sending(request)
    await run_in_threadpool(service.needs_machine, machine)
    limits = service.settings.limits
    most = {RECORDING: limits.recording_MiB * MIB, SIDE: limits.side_MiB * MIB}
    with service.imports.place(machine) as place:
        path = named_as_sent(await receive_parts(request, place.made, most, limits.receive_s))
        said = await run_in_threadpool(service.imports.add, place, path, access)
    return _answer(said, 202, {"Location": f"/api/v1/imports/{said.number}"})


@router.get(
    "/imports/{number}",
    summary="How far an import is",
    response_model=Importing,
    responses=problems(401, 404, 422, 429, 503),
)
def importing(request: Request, _access: Reads, number: Number) -> Response:
    """Say how far the import of a recording is, and what came in or why it was refused.

    To a page of the service, in its language as far as what was said is known there.

    Remembered are the last thousand since the service began.
    """
    said = service_of(request).imports.said(number)
    if said.refused is None:
        return _answer(said, 200)
    refused = said_again(said.refused)
    language = {"Content-Language": language_of(refused)}
    return _answer(replace(said, refused=str(refused)), 200, language)


def _answer(said: Importing, status: int, headers: dict[str, str] | None = None) -> Response:
    body = adapter(Importing).dump_json(said)
    return Response(body, status, headers, media_type="application/json")


def named_as_sent(parts: Mapping[str, SentPart]) -> Path:
    """Give a recording its name, which says how it is read, and its side file the same.

    Return where it lies; raises UnusableInput.
    """
    if RECORDING not in parts:
        raise UnusableInput(f"{RECORDING}: missing; send it with -F {RECORDING}=@FILE")
    part = parts[RECORDING]
    path = part.path.with_name(safe(part.called, RECORDING))
    if path.suffix.lower() not in READERS:
        raise UnusableInput(UNKNOWN_KIND.format(file=path.name, kinds=", ".join(READERS)))
    if not part.path.stat().st_size:
        raise UnusableInput(EMPTY.format(file=path.name))
    if SIDE in parts:
        parts[SIDE].path.rename(path.with_suffix(".toml"))
    return part.path.rename(path)
