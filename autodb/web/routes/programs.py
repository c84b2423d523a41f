"""Jobs whose cuts are an NC program, which is sent with them and read apart."""

import json
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from fastapi import APIRouter, Request, Response
from pydantic import ValidationError
from pydantic_core import from_json
from starlette.concurrency import run_in_threadpool

from autodb.agent.answer.predicting import JobAnswer
from autodb.errors import UnusableInput
from autodb.files.job import Job
from autodb.files.toml import read_toml
from autodb.files.units import typed_number
from autodb.web.http.guard import BODY_MOST
from autodb.web.http.problems import first_of, problems
from autodb.web.http.responses import json_answer
from autodb.web.http.settings import MIB
from autodb.web.receive.apart import ProgramToPredict
from autodb.web.receive.sent import FORM, SentPart, receive_parts, safe
from autodb.web.routes.machines import MachineName
from autodb.web.service import Reads, made_apart, service_of

router = APIRouter()
JOB, PROGRAM = "job", "program"
UNITS = {"_mm": "mm", "_deg": "deg", "stock": "mm", "teeth": "1"}
"""Units of a program's numbers, by the ends of their keys: a page sends them as they were typed."""
_EXAMPLE = {
    "name": "shaft", "material": "C45", "tool": "CNMG 120408",
    "program": {"stock_diameter_mm": 60.0},
}  # fmt: skip
_BODY = {
    "required": True,
    "content": {
        FORM: {
            "schema": {
                "type": "object",
                "required": [JOB, PROGRAM],
                "properties": {
                    JOB: {
                        "type": "string",
                        "contentMediaType": "application/json",
                        "description": "The job as its file says it, in JSON, or the file itself "
                        "(*.toml); what its program is called is said by the program's own name.",
                        "example": json.dumps(_EXAMPLE),
                    },
                    PROGRAM: {
                        "type": "string",
                        "format": "binary",
                        "description": "The program.",
                    },
                },
            }
        }
    },
}


@router.post(
    "/machines/{machine:path}/predict/program",
    summary="Predict a job with a program",
    response_model=JobAnswer,
    responses=problems(401, 404, 408, 413, 422, 429, 503),
    openapi_extra={"requestBody": _BODY},
)
async def predict_program(request: Request, _access: Reads, machine: MachineName) -> Response:
    """Say what each line of a program that cuts will take; nothing is kept.

    The program is read in a process of its own.
    """
    mark = service_of(request).watched.mark()
    return json_answer(JobAnswer, await predicted_program(request, machine), mark)


async def predicted_program(
    request: Request,
    machine: str,
    number: Callable[[str, str, str], float] = lambda key, text, _unit: typed_number(key, text),
) -> JobAnswer:
    """Return what is predicted of the job and the program that a request brings.

    ``number`` reads what was typed of stock and tools: its key, the text, our unit.

    Raises HTTPException where too many are sent or read, UnusableInput where they cannot be used.
    """
    service = service_of(request)
    service.refuse_sending(request)
    await run_in_threadpool(service.needs_machine, machine)
    with tempfile.TemporaryDirectory(prefix="autodb-") as name:
        limits = service.settings.limits
        most = {JOB: BODY_MOST, PROGRAM: limits.program_MiB * MIB}
        parts = await receive_parts(request, Path(name), most, limits.receive_s)
        task = _task(machine, parts, number)
        found: JobAnswer = await made_apart(service, task, JobAnswer, limits.predicting)
    service.metrics.cuts.inc(len(found.cuts))
    return found


def _task(
    machine: str, parts: Mapping[str, SentPart], number: Callable[[str, str, str], float]
) -> ProgramToPredict:
    """Return what is to be predicted of what was sent; raises UnusableInput."""
    lacking = [field for field in (JOB, PROGRAM) if field not in parts]
    if lacking:
        raise UnusableInput(f"{' and '.join(lacking)}: missing; send both as parts")
    called = safe(parts[PROGRAM].called, "program.nc")
    folder = parts[PROGRAM].path.parent / "named"
    folder.mkdir()
    path = parts[PROGRAM].path.rename(folder / called)
    return ProgramToPredict(machine, _job(parts[JOB], called, number), path)


def _job(sent: SentPart, called: str, number: Callable[[str, str, str], float]) -> Job:
    """Return a job of which the program is called so; raises UnusableInput naming the key."""
    if sent.called.lower().endswith(".toml"):
        job = read_toml(sent.path, Job, called=safe(sent.called, JOB))
    else:
        job = _job_in_json(sent.path.read_bytes(), number)
    if job.program is None:
        raise UnusableInput(f"{JOB}: program: missing; send a job with its stock there")
    program = job.program.model_copy(update={"file": called})
    return job.model_copy(update={"program": program})


def _job_in_json(text: bytes, number: Callable[[str, str, str], float]) -> Job:
    try:
        said = from_json(text)
        if isinstance(said, dict) and isinstance(said.get("program"), dict):
            said["program"] = {"file": PROGRAM} | _numbers(said["program"], number)
        return Job.model_validate(said)
    except ValidationError as error:
        raise UnusableInput(f"{JOB}: {first_of(error.errors())}") from None
    except ValueError as error:
        raise UnusableInput(f"{JOB}: is not JSON ({error}); send a job's keys as JSON") from None


def _numbers(said: Any, number: Callable[[str, str, str], float], key: str = "") -> Any:
    """Return what is said of a program, with numbers where they were typed as texts."""
    if isinstance(said, dict):
        return {one: _numbers(value, number, one) for one, value in said.items()}
    if isinstance(said, list):
        return [_numbers(value, number, key) for value in said]
    unit = next((unit for end, unit in UNITS.items() if key.endswith(end)), None)
    return number(key, said, unit) if unit and isinstance(said, str) else said
