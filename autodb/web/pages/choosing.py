"""The language and the units of the pages, chosen by who reads them."""

from typing import Annotated

from fastapi import APIRouter, Form, Request, Response
from fastapi.responses import RedirectResponse

from autodb.web.http.chosen import keep_choice
from autodb.web.pages.reading import here

router = APIRouter()
SEE_OTHER = 303


@router.post("/shown")
def choose_shown(
    request: Request,
    language: Annotated[str, Form(max_length=20)] = "",
    units: Annotated[str, Form(max_length=20)] = "",
    then: Annotated[str, Form(max_length=20_000)] = "/",
) -> Response:
    """Keep a choice, and go on where it was made."""
    response = RedirectResponse(here(then), SEE_OTHER)
    keep_choice(request, response, language, units)
    return response
