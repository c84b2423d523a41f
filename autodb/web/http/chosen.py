"""In which language and which units a request is answered: as its browser's cookies say.

Without a cookie the language is what the browser asks for, and units are those of the service.
What programs get is in English and in SI units, whatever they send: only a page's script says by a
header in which language a refusal is shown.
"""

from fastapi import Request, Response
from starlette.datastructures import Headers
from starlette.requests import cookie_parser
from starlette.types import ASGIApp, Receive, Scope, Send

from autodb.files.units import SYSTEMS, presentation_of
from autodb.web.http.settings import Settings
from autodb.wording import Presentation
from autodb.wording.catalogues import LANGUAGES, preferred_language
from autodb.wording.presentation import present_for

LANGUAGE, UNITS = "autodb_language", "autodb_units"
SCRIPT = "x-shown-in"
"""Header by which a page's script says the page's language."""
KEPT_S = 365 * 24 * 3600
"""How long a choice is kept. Chosen."""
NO_PAGES = ("/api/", "/static/", "/healthz", "/metrics")


class Presented:
    """Has each request answered in its language and its units; a plain ASGI middleware."""

    def __init__(self, app: ASGIApp, *, settings: Settings) -> None:
        self._app, self._settings = app, settings

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] == "http":
            present_for(_chosen(Headers(scope=scope), scope["path"], self._settings.units))
        await self._app(scope, receive, send)


def _chosen(headers: Headers, path: str, own: str) -> Presentation:
    """Return in what a request is answered; ``own``: units where its cookies say none."""
    if path.startswith(NO_PAGES):
        asked = headers.get(SCRIPT, "")
        return Presentation(asked if asked in LANGUAGES else "en")
    cookies = cookie_parser(headers.get("cookie", ""))
    language, units = cookies.get(LANGUAGE), cookies.get(UNITS)
    if language not in LANGUAGES:
        language = preferred_language(headers.get("accept-language", ""))
    return presentation_of(str(language), units if units in SYSTEMS else own)


def keep_choice(request: Request, response: Response, language: str, units: str) -> None:
    """Have a browser keep what was chosen; what is nothing to choose from is passed over."""
    tls = request.url.scheme == "https"
    for name, value, known in ((LANGUAGE, language, LANGUAGES), (UNITS, units, SYSTEMS)):
        if value in known:
            response.set_cookie(
                name, value, max_age=KEPT_S, httponly=True, samesite="lax", secure=tls
            )
