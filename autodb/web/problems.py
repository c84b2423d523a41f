"""What a request gets in place of an answer: one line that says what would work."""

import sqlite3
from collections.abc import Sequence
from http import HTTPStatus
from typing import Any

from fastapi import FastAPI, HTTPException, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import BaseModel
from sqlalchemy.exc import DBAPIError
from starlette.exceptions import HTTPException as StarletteHTTPException

from autodb.errors import NotThere, UnusableInput
from autodb.excuses import excuse

NOT_THERE, UNUSABLE, AWAY = 404, 422, 503
ELSEWHERE = "/api/v1/openapi.json lists what would work"


class Problem(BaseModel):
    """Why there is no answer; ``detail`` is one line, which says what would work."""

    detail: str


WORDS = {
    400: "Not a request that can be read.",
    401: "No token, or one that is not valid.",
    403: "The token's role does not allow it, or the service is read-only.",
    404: "There is none of that name or number.",
    409: "Something else was decided meanwhile.",
    413: "Larger than is taken.",
    422: "Unusable input: which key, and what would work.",
    429: "Too often; Retry-After says when it would work.",
    503: "The database is away, locked or damaged.",
}


def problems(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Return how a route's document names the statuses that are no answer."""
    return {one: {"model": Problem, "description": WORDS[one]} for one in sorted(statuses)}


def problem(status: int, detail: str, headers: dict[str, str] | None = None) -> JSONResponse:
    """Return the response for what could not be answered."""
    return JSONResponse(Problem(detail=detail).model_dump(), status, headers)


def handle(app: FastAPI) -> None:
    """Have an app answer what its routes raise."""
    app.add_exception_handler(UnusableInput, _unusable)
    app.add_exception_handler(RequestValidationError, _invalid)
    app.add_exception_handler(StarletteHTTPException, _refused)
    for kind in (OSError, DBAPIError, sqlite3.Error):
        app.add_exception_handler(kind, _away)
    app.add_exception_handler(Exception, _failed)


async def _unusable(_request: Request, error: Exception) -> JSONResponse:
    return problem(NOT_THERE if isinstance(error, NotThere) else UNUSABLE, str(error))


async def _invalid(_request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, RequestValidationError)
    return problem(UNUSABLE, first_of(error.errors()))


def first_of(errors: Sequence[Any]) -> str:
    """Return the first error of a model in one line: where, and why."""
    first = errors[0]
    where = ".".join(str(part) for part in first["loc"] if part != "body")
    message = first["msg"].removeprefix("Value error, ")
    return f"{where}: {message}" if where else str(message)


async def _refused(_request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, HTTPException | StarletteHTTPException)
    headers = dict(error.headers) if error.headers else None
    unsaid = error.detail == HTTPStatus(error.status_code).phrase
    said = f"{error.detail}: {ELSEWHERE}" if unsaid else str(error.detail)
    return problem(error.status_code, said, headers)


async def _away(_request: Request, error: Exception) -> JSONResponse:
    said = excuse(error)
    if said is None:
        raise error
    return problem(AWAY, said)


async def _failed(_request: Request, _error: Exception) -> JSONResponse:
    return problem(500, "an error of autodb; the service's log has it")
