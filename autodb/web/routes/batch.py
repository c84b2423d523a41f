"""Many cuts of a pair at once: a line of JSON each, in and out, in memory a few hundred of them."""

import json
import tempfile
from collections.abc import AsyncIterator, Iterator, Sequence
from itertools import islice
from typing import IO

from fastapi import APIRouter, Request
from fastapi.responses import StreamingResponse
from starlette.concurrency import run_in_threadpool

from autodb.agent.answer.prediction_basis import PredictionBasis
from autodb.errors import UnusableInput
from autodb.files.job_cut import JobCut
from autodb.web.http.problems import problems
from autodb.web.http.responses import adapter, tag_of
from autodb.web.http.said import BatchLine, End
from autodb.web.http.settings import MIB
from autodb.web.routes.asked import EXAMPLES, LOT, pair_of, read_cut
from autodb.web.routes.machines import MachineName
from autodb.web.service import Reads, service_of

router = APIRouter()
NDJSON = "application/x-ndjson"
AT_ONCE = 250
"""Cuts that are predicted together. Chosen: a part of a tenth of a second each."""
IN_MEMORY = MIB
LINE_MOST = 4096
"""Bytes of a line. Chosen: a cut has some two hundred."""


_BODY = {
    "required": True,
    "content": {
        NDJSON: {
            "schema": {"type": "string"},
            "example": f"{json.dumps(EXAMPLES)}\n{json.dumps({**EXAMPLES, 'depth_mm': 1.0})}\n",
        }
    },
}


@router.post(
    "/machines/{machine:path}/lookup/batch",
    summary="Look up many cuts",
    response_class=StreamingResponse,
    responses={
        200: {
            "description": "A line of JSON a cut, `row` counted from 1, in their order: its `cut`, "
            "the limits that it `exceeds` and how it stands to all `limits`, or the `problem` with "
            "it; last, how many were `answered` and `refused`. An answer without that last line "
            "was cut off.",
            "content": {NDJSON: {"schema": {"type": "string"}}},
        },
        **problems(401, 404, 413, 422, 429, 503),
    },
    openapi_extra={
        "requestBody": _BODY,
        "parameters": [
            {"name": name, "in": "query", "required": name != LOT, "schema": {"type": "string"},
             "example": example}
            for name, example in (("material", "C45"), ("tool", "CNMG 120408"), (LOT, "B12"))
        ],
    },
)  # fmt: skip
async def look_up_many(request: Request, _access: Reads, machine: MachineName) -> StreamingResponse:
    """Say what each of many cuts of one pair will take; a line of JSON each, as a job's cut."""
    material, tool = pair_of(dict(request.query_params))
    service = service_of(request)
    found = await run_in_threadpool(service.lookup_cache.basis, machine, material, tool)
    basis = found.basis.of_lot(request.query_params.get(LOT))
    lines = tempfile.SpooledTemporaryFile(IN_MEMORY)  # noqa: SIM115 - closed when answered
    try:
        async for part in request.stream():
            lines.write(part)
    except BaseException:
        lines.close()
        raise
    lines.seek(0)

    async def parts() -> AsyncIterator[bytes]:
        answered = refused = 0
        with lines:
            numbered = enumerate(_lines(lines), start=1)
            while some := list(islice(numbered, AT_ONCE)):
                rows = await run_in_threadpool(_rows, basis, some)
                refused += sum(row.problem is not None for row in rows)
                answered += sum(row.problem is None for row in rows)
                service.metrics.cuts.inc(len(rows))
                yield b"".join(
                    adapter(BatchLine).dump_json(r, exclude_none=True) + b"\n" for r in rows
                )
        yield adapter(End).dump_json(End(answered, refused)) + b"\n"

    return StreamingResponse(parts(), media_type=NDJSON, headers={"ETag": tag_of(found.mark)})


def _lines(file: IO[bytes]) -> Iterator[bytes]:
    """Give the lines that say something; of one that is too long, what is read of it."""
    while line := file.readline(LINE_MOST + 1):
        if len(line) > LINE_MOST:
            while not line.endswith(b"\n") and (rest := file.readline(LINE_MOST)):
                line = line[:LINE_MOST] + rest[-1:]
        if line.strip():
            yield line


def _rows(basis: PredictionBasis, lines: Sequence[tuple[int, bytes]]) -> list[BatchLine]:
    """Return the answers to some lines: together, or each by itself where one cannot be made."""
    asked: list[tuple[int, JobCut]] = []
    rows: dict[int, BatchLine] = {}
    for number, line in lines:
        try:
            asked.append((number, _cut(line)))
        except UnusableInput as error:
            rows[number] = BatchLine(number, problem=str(error))
    rows |= _predicted(basis, asked)
    return [rows[number] for number, _ in lines]


def _predicted(basis: PredictionBasis, asked: Sequence[tuple[int, JobCut]]) -> dict[int, BatchLine]:
    try:
        found, _ = basis.predict([cut for _, cut in asked])
    except UnusableInput as error:
        if len(asked) == 1:
            return {asked[0][0]: BatchLine(asked[0][0], problem=str(error))}
        alone = [_predicted(basis, [one]) for one in asked]
        return {number: row for some in alone for number, row in some.items()}
    return {
        number: BatchLine(number, cut, basis.exceeding([cut]), basis.standings([cut]))
        for (number, _), cut in zip(asked, found, strict=True)
    }


def _cut(line: bytes) -> JobCut:
    """Return the cut that a line of JSON states; raises UnusableInput."""
    if len(line) > LINE_MOST:
        raise UnusableInput(f"longer than {LINE_MOST} bytes; send one cut per line")
    return read_cut(line)
