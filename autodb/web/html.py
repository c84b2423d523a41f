"""Pages of the service: a template, who is signed in, and what a browser may load for them."""

from dataclasses import dataclass
from urllib.parse import quote

from fastapi import Request
from fastapi.responses import HTMLResponse

from autodb import __version__
from autodb.agent.operate.access import Access, Role
from autodb.files.units import SYSTEMS, shown_system
from autodb.reports import figures
from autodb.web.http.chosen import NO_PAGES
from autodb.web.http.static import at
from autodb.web.service import service_of
from autodb.wording import presentation
from autodb.wording.catalogues import LANGUAGES

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


@dataclass(frozen=True)
class Site:
    """What every page shows beside its content.

    ``who`` and ``role`` of who is signed in, None: nobody; ``operates``: whether this page may
    change something; ``csrf``: the number that its forms bring; ``machine``: that it is of, and
    ``here``: which of the machine's pages. ``then``: the page itself, with its query;
    ``languages`` and ``systems``: what else its reader may choose, code and words.
    """

    who: str | None
    role: str | None
    operates: bool
    csrf: str
    writes: bool
    machine: str | None
    here: str
    at: str
    then: str
    languages: list[tuple[str, str]]
    systems: list[tuple[str, str]]
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
    return HTMLResponse(content, status, page_headers())


def service_page_piece(
    request: Request, template: str, *, machine: str, **context: object
) -> HTMLResponse:
    """Return a piece of a machine's page that has what its forms need; every text is escaped."""
    return piece(template, site=_site(request, machine, ""), path=path, **context)


def piece(template: str, **context: object) -> HTMLResponse:
    """Return a piece of a page, which the page's script puts in; every text is escaped."""
    content = figures.fragment(f"site/{template}", **context)
    return HTMLResponse(content, headers=page_headers())


def page_headers() -> dict[str, str]:
    """Return what a browser is told of a page, or of a piece of one."""
    return {
        "Content-Security-Policy": POLICY,
        "Content-Language": presentation().language,
        "Vary": "Accept-Language, Cookie",
    }


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
        then=_then(request),
        languages=[one for one in LANGUAGES.items() if one[0] != presentation().language],
        systems=[(one, words) for one, words in SYSTEMS.items() if one != shown_system()],
        version=__version__,
    )


def _then(request: Request) -> str:
    """Return the page that a request is of, with its query where that asks again for the same."""
    query = request.url.query if request.method == "GET" else ""
    return f"{request.url.path}?{query}" if query else request.url.path
