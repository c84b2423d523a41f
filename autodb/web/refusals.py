"""What a request gets whose route raised: data, or a page where it asked for one."""

import sqlite3
from http import HTTPStatus

from fastapi import FastAPI, HTTPException, Request, Response
from fastapi.exceptions import RequestValidationError
from sqlalchemy.exc import DBAPIError
from starlette.exceptions import HTTPException as StarletteHTTPException

from autodb.errors import NotThere, UnusableInput
from autodb.files.excuses import excuse
from autodb.web import html
from autodb.web.http.problems import first_of, problem
from autodb.wording import Worded, language_of, msgid, phrase
from autodb.wording.kept import said_again

NOT_THERE, UNUSABLE, AWAY = 404, 422, 503
UNREAD = "There was an error parsing the body"
"""What FastAPI says of a body that is no JSON at all."""
FAILED = msgid("Internal Server Error")
TITLES = {
    400: msgid("Bad Request"), 401: msgid("Unauthorized"), 403: msgid("Forbidden"),
    404: msgid("Not Found"), 405: msgid("Method Not Allowed"), 408: msgid("Request Timeout"),
    409: msgid("Conflict"), 413: msgid("Content Too Large"), 422: msgid("Unprocessable Content"),
    429: msgid("Too Many Requests"), 503: msgid("Service Unavailable"),
}  # fmt: skip
"""Titles of pages that refuse, by their status; in English those of HTTP (RFC 9110)."""


def answer_refusal(
    request: Request, status: int, detail: str, headers: dict[str, str] | None = None
) -> Response:
    """Return the response for what could not be answered: a page to who asked for one."""
    if not html.is_page(request):
        return problem(status, detail, headers)
    if status == 401:
        return html.service_page(
            request, "sign_in.html.j2", title=phrase("Sign in"), status=status, said=detail,
            then=request.url.path,
        )  # fmt: skip
    title = phrase(TITLES.get(status, FAILED))
    return html.service_page(request, "problem.html.j2", title=title, status=status, said=detail)


def handle(app: FastAPI) -> None:
    """Have an app answer what its routes raise."""
    app.add_exception_handler(UnusableInput, _unusable)
    app.add_exception_handler(RequestValidationError, _invalid)
    app.add_exception_handler(StarletteHTTPException, _refused)
    for kind in (OSError, DBAPIError, sqlite3.Error):
        app.add_exception_handler(kind, _away)
    app.add_exception_handler(Exception, _failed)


async def _unusable(request: Request, error: Exception) -> Response:
    return answer_refusal(
        request, NOT_THERE if isinstance(error, NotThere) else UNUSABLE, _line(error)
    )


async def _invalid(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    return answer_refusal(request, UNUSABLE, first_of(error.errors()))


async def _refused(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException | StarletteHTTPException)
    headers = dict(error.headers) if error.headers else None
    unsaid = error.detail == HTTPStatus(error.status_code).phrase
    said = error.detail
    if unsaid:
        what = phrase(TITLES.get(error.status_code, FAILED))
        said = phrase("{what}: see /api/v1/openapi.json for what it accepts", what=what)
    if error.detail == UNREAD:
        said = phrase("the body is no JSON in UTF-8: see /api/v1/openapi.json for what it accepts")
    return answer_refusal(request, error.status_code, said, headers)


async def _away(request: Request, error: Exception) -> Response:
    said = excuse(error)
    if said is None:
        raise error
    return answer_refusal(request, AWAY, said)


async def _failed(request: Request, _error: Exception) -> Response:
    return answer_refusal(request, 500, phrase("an error of autodb; the service's log has it"))


def _line(error: Exception) -> Worded:
    """Return what an error says, with its language."""
    said = Worded(str(error), language_of(error))
    return said_again(said) if said.language == "en" else said
