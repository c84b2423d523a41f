"""What a browser keeps of its reader: signed in or not, and the language and units of the pages."""

from typing import Annotated

from fastapi import APIRouter, Form, HTTPException, Request, Response
from fastapi.responses import RedirectResponse

from autodb.web.html import service_page
from autodb.web.http.chosen import keep_choice
from autodb.web.service import service_of
from autodb.wording import phrase

router = APIRouter()
SEE_OTHER = 303


@router.get("/sign-in")
def sign_in_page(request: Request, then: str = "/") -> Response:
    """Ask for a token."""
    return service_page(request, "sign_in.html.j2", title=phrase("Sign in"), said="", then=then)


@router.post("/sign-in")
def sign_in(
    request: Request, token: Annotated[str, Form()], then: Annotated[str, Form()] = "/"
) -> Response:
    """Sign in with a token, and go on where it was asked for."""
    service = service_of(request)
    try:
        request.state.who = service.by_token(request, token.strip()).who
    except HTTPException as error:
        said = error.detail
        return service_page(
            request, "sign_in.html.j2", title=phrase("Sign in"), status=error.status_code,
            said=said, then=then,
        )  # fmt: skip
    response = RedirectResponse(_here(then), SEE_OTHER)
    tls = service.settings.tls or request.url.scheme == "https"  # as a proxy that is believed says
    service.sessions.begin(response, token.strip(), tls=tls)
    return response


@router.post("/sign-out")
def sign_out(request: Request, csrf: Annotated[str, Form()] = "") -> Response:
    """Sign out."""
    service = service_of(request)
    session = service.sessions.of(request)
    response = RedirectResponse("/", SEE_OTHER)
    if session is not None and session.brought(csrf):
        service.sessions.end(request, response)
    return response


@router.post("/shown")
def choose_shown(
    request: Request,
    language: Annotated[str, Form(max_length=20)] = "",
    units: Annotated[str, Form(max_length=20)] = "",
    then: Annotated[str, Form(max_length=20_000)] = "/",
) -> Response:
    """Keep a choice, and go on where it was made."""
    response = RedirectResponse(_here(then), SEE_OTHER)
    keep_choice(request, response, language, units)
    return response


def _here(path: str) -> str:
    """Return a path of this service; of any other address, the first page's."""
    return path if path.startswith("/") and not path.startswith(("//", "/\\")) else "/"
