"""What the pages load, all of it from here: style, scripts, and the library that draws plots."""

import gzip
import hashlib
from collections.abc import Callable
from functools import cache

from fastapi import APIRouter, Request, Response
from plotly.offline import get_plotlyjs

from autodb.reports import figures
from autodb.web.http.problems import problem

router = APIRouter(include_in_schema=False)
SCRIPT, STYLE = "text/javascript", "text/css"
FOR_EVER = "public, max-age=31536000, immutable"
"""Of a file asked for with its digest: another content has another address."""
FILES: dict[str, tuple[str, Callable[[], str]]] = {
    "site.css": (STYLE, lambda: str(figures.style("site/_site.css.j2"))),
    "site.js": (SCRIPT, lambda: str(figures.fragment("site/site.js"))),
    "plots.js": (SCRIPT, lambda: str(figures.fragment("plots.js"))),
    "plotly.js": (SCRIPT, get_plotlyjs),
}
"""Files by name: of what kind, and what makes them."""


@cache
def _made(name: str) -> bytes:
    return FILES[name][1]().encode()


@cache
def _packed(name: str) -> bytes:
    return gzip.compress(_made(name), mtime=0)


@cache
def _digest(name: str) -> str:
    return hashlib.sha256(_made(name)).hexdigest()[:16]


def at(name: str) -> str:
    """Return the address of a file as it is now."""
    return f"/static/{name}?v={_digest(name)}"


@router.get("/static/{name}")
def file(request: Request, name: str) -> Response:
    """Send a file of the pages; they are the same for everybody, and need no token."""
    if name not in FILES:
        return problem(404, f"no file '{name}' here")
    headers = {"Vary": "Accept-Encoding"}
    if request.query_params.get("v") == _digest(name):
        headers["Cache-Control"] = FOR_EVER
    if "gzip" not in request.headers.get("accept-encoding", ""):
        return Response(_made(name), media_type=FILES[name][0], headers=headers)
    headers["Content-Encoding"] = "gzip"
    return Response(_packed(name), media_type=FILES[name][0], headers=headers)
