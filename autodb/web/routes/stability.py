"""To what depth a job's cuts are stable: the tool point's file is sent with the job, read apart."""

import json
import tempfile
from pathlib import Path

from fastapi import APIRouter, Request, Response
from pydantic import ValidationError
from starlette.concurrency import run_in_threadpool

from autodb.agent.answer.bounds.stable import StableCut
from autodb.errors import UnusableInput
from autodb.files.job import Job
from autodb.web.http.guard import BODY_MOST, DYNAMICS_MOST
from autodb.web.http.problems import first_of, problems
from autodb.web.http.responses import json_answer
from autodb.web.receive.apart import JobStability
from autodb.web.receive.sent import FORM, SentPart, receive_parts, safe
from autodb.web.routes.asked import EXAMPLES
from autodb.web.routes.machines import MachineName
from autodb.web.service import Reads, made_apart, service_of

router = APIRouter()
JOB, DYNAMICS = "job", "dynamics"
_EXAMPLE = {"name": "shaft", "material": "C45", "tool": "CNMG 120408", "cut": [EXAMPLES]}
_BODY = {
    "required": True,
    "content": {
        FORM: {
            "schema": {
                "type": "object",
                "required": [JOB, DYNAMICS],
                "properties": {
                    JOB: {
                        "type": "string",
                        "contentMediaType": "application/json",
                        "description": "The job as its file says it, but in JSON.",
                        "example": json.dumps(_EXAMPLE),
                    },
                    DYNAMICS: {
                        "type": "string",
                        "format": "binary",
                        "description": "How the tool point gives way: modes (a file *.toml), or a "
                        "measured receptance (*.csv).",
                    },
                },
            }
        }
    },
}


@router.post(
    "/machines/{machine:path}/stability",
    summary="Stable depth of a job's cuts",
    response_model=list[StableCut],
    responses=problems(401, 404, 408, 413, 422, 429, 503),
    openapi_extra={"requestBody": _BODY},
)
async def stability_route(request: Request, _access: Reads, machine: MachineName) -> Response:
    """Say to what depth each cut is stable, its lobes, and the depth that the limits allow.

    Depths where none limits are null. Nothing is kept.
    """
    service = service_of(request)
    mark = service.watched.mark()
    with tempfile.TemporaryDirectory(prefix="autodb-") as name:
        parts = await received_dynamics(request, machine, Path(name), (JOB, DYNAMICS))
        job = _job(parts[JOB].path.read_bytes())
        found = await stable_apart(request, JobStability(machine, job, named_file(parts[DYNAMICS])))
    return json_answer(tuple[StableCut, ...], found, mark)


async def received_dynamics(
    request: Request, machine: str, folder: Path, fields: tuple[str, ...]
) -> dict[str, SentPart]:
    """Return the parts of a request by their fields, written into a folder.

    Raises HTTPException where too many are sent, UnusableInput where one is missing.
    """
    service = service_of(request)
    service.refuse_sending(request)
    await run_in_threadpool(service.needs_machine, machine)
    most = {JOB: BODY_MOST, DYNAMICS: DYNAMICS_MOST}
    within_s = service.settings.limits.receive_s
    parts = await receive_parts(request, folder, {one: most[one] for one in fields}, within_s)
    lacking = [field for field in fields if field not in parts]
    if lacking:
        raise UnusableInput(f"{' and '.join(lacking)}: missing; send {' and '.join(fields)}")
    return parts


def named_file(sent: SentPart) -> Path:
    """Return a part as a file that is called as its sender calls it: its ending tells its kind."""
    folder = sent.path.parent / "named"
    folder.mkdir()
    return sent.path.rename(folder / safe(sent.called, "tool-point.toml"))


async def stable_apart(request: Request, task: JobStability) -> tuple[StableCut, ...]:
    """Return to what depth a job's cuts are stable, found by a process of its own.

    Raises HTTPException where too many are at work, UnusableInput where it is refused.
    """
    service = service_of(request)
    service.metrics.cuts.inc(len(task.job.cut))
    bounds = service.settings.limits.predicting
    found: tuple[StableCut, ...] = await made_apart(service, task, tuple[StableCut, ...], bounds)
    return found


def _job(text: bytes) -> Job:
    """Return the job that was sent; raises UnusableInput naming the key."""
    try:
        job = Job.model_validate_json(text)
    except ValidationError as error:
        raise UnusableInput(f"{JOB}: {first_of(error.errors())}") from None
    if job.program is not None:
        raise UnusableInput(f"{JOB}: program: no depth of a program is asked for; send its cuts")
    return job
