"""Pages of the service: a template, who is signed in, and what a browser may load for them."""

from dataclasses import dataclass
from urllib.parse import quote

from fastapi import Request
from fastapi.responses import HTMLResponse

from autodb import __version__
from autodb.agent.operate.access import Access, Role
from autodb.reports import figures
from autodb.web.http.static import at
from autodb.web.service import service_of

POLICY = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self' 'unsafe-inline'",  # plots place their parts by style attributes
        "img-src 'self' data: blob:",
        "connect-src 'self'",
        "form-action 'self'",
        "base-uri 'none'",
        "frame-ancestors 'none'",
    )
)
NO_PAGES = ("/api/", "/static/", "/healthz", "/metrics")


@dataclass(frozen=True)
class Site:
    """What every page shows beside its content.

    ``who`` and ``role`` of who is signed in, None: nobody; ``operates``: whether this page may
    change something; ``csrf``: the number that its forms bring; ``machine``: that it is of, and
    ``here``: which of the machine's pages.
    """

    who: str | None
    role: str | None
    operates: bool
    csrf: str
    writes: bool
    machine: str | None
    here: str
    at: str
    version: str


def service_page(
    request: Request,
    template: str,
    *,
    title: str,
    machine: str | None = None,
    here: str = "",
    status: int = 200,
    **context: object,
) -> HTMLResponse:
    """Return a page of the service; every text in ``context`` is escaped."""
    site = _site(request, machine, here)
    content = figures.fragment(
        f"site/{template}", title=title, site=site, path=path, static=at, **context
    )
    return HTMLResponse(content, status, {"Content-Security-Policy": POLICY})


def piece(template: str, **context: object) -> HTMLResponse:
    """Return a piece of a page, which the page's script puts in; every text is escaped."""
    content = figures.fragment(f"site/{template}", **context)
    return HTMLResponse(content, headers={"Content-Security-Policy": POLICY})


def is_page(request: Request) -> bool:
    """Return whether a request asks for a page, not for data."""
    return not request.url.path.startswith(NO_PAGES)


def path(*names: str) -> str:
    """Return the path of a page whose parts are names, whatever is in them."""
    return "".join(f"/{quote(name, safe='')}" for name in names)


def _site(request: Request, machine: str | None, here: str) -> Site:
    service = service_of(request)
    access: Access | None = getattr(request.state, "access", None)
    session = service.sessions.of(request)
    signed_in = access is not None and access.token_id is not None and session is not None
    writes = service.settings.writes
    return Site(
        who=access.who if access is not None and signed_in else None,
        role=access.role.word if access is not None and signed_in else None,
        operates=bool(signed_in and writes and access and access.role >= Role.OPERATE),
        csrf=session.csrf if session is not None and signed_in else "",
        writes=writes,
        machine=machine,
        here=here,
        at=request.url.path,
        version=__version__,
    )
