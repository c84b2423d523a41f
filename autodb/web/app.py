"""The service as one ASGI application.

Units in the service's document: read off the names, which end in them.
"""

from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from typing import Any

from anyio import CapacityLimiter
from fastapi import APIRouter, FastAPI, Request, Response
from fastapi.responses import JSONResponse, PlainTextResponse
from starlette.concurrency import run_in_threadpool

from autodb import __version__
from autodb.store import open_store
from autodb.store.watched import Watched
from autodb.web import pages
from autodb.web.http import static
from autodb.web.http.chosen import Presented
from autodb.web.http.guard import Guard, Rate
from autodb.web.http.logs import TEXT, Metrics
from autodb.web.http.problems import problems
from autodb.web.http.settings import Settings
from autodb.web.lookup_cache import LookupCache
from autodb.web.receive.children import Children
from autodb.web.receive.imports import Imports
from autodb.web.receive.learning import Learnings
from autodb.web.refusals import handle
from autodb.web.routes import (
    batch,
    decisions,
    edges,
    forces,
    kept_recordings,
    machines,
    programs,
    recordings,
    stability,
    tools,
)
from autodb.web.service import SENDS_S, Reads, Service, service_of

UNITS = {
    "_N_m": "N·m", "_mm_rev": "mm/rev", "_mm_tooth": "mm/tooth", "_mm_min": "mm/min",
    "_m_min": "m/min", "_N": "N", "_mm": "mm", "_rpm": "rpm", "_deg": "°", "_s": "s", "_W": "W",
}  # fmt: skip
"""Unit by how a name ends, the longer ends first."""


def unit_of_name(name: str) -> str | None:
    """Return the unit that a name ends in; None where it has none.

    >>> [unit_of_name(one) for one in ("torque_N_m", "feed_mm_rev", "notes")]
    ['N·m', 'mm/rev', None]
    """
    return next((unit for end, unit in UNITS.items() if name.endswith(end)), None)


def with_units(app: FastAPI) -> None:
    """Have an app's document say the unit of every quantity, as ``x-unit``."""
    made = app.openapi

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is None:
            document = made()
            for name, shape in _named(document):
                unit = unit_of_name(name)
                if unit is not None:
                    shape["x-unit"] = unit
        return made()

    app.openapi = openapi  # type: ignore[method-assign]  # FastAPI's way


def _named(document: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Give every property and parameter by its name."""
    for schema in document["components"]["schemas"].values():
        yield from schema.get("properties", {}).items()
    for path in document["paths"].values():
        for operation in path.values():
            for one in operation.get("parameters", ()):
                yield one["name"], one


API = "/api/v1"
ABOUT = """What a machining database holds: forces, torque and power of cuts before they are made,
each with its 95 % interval; what machines can sense; and where every number came from.

Names of quantities end in their unit: `force_x_N`, `feed_mm_rev`, `torque_N_m`. An answer's `ETag`
is the state of the database that it is of: as long as nothing was written, `If-None-Match` gets
304 and no body. Every refusal is one line, `detail`, which ends in the remedy."""

operations = APIRouter(tags=["Operation"])


def make_app(settings: Settings) -> FastAPI:
    """Return the application that serves a database; it is opened at once.

    Raises UnusableInput where there is no database, or its schema is another.
    """
    store = open_store(settings.url)
    watched = Watched(store)
    metrics = Metrics()
    children = Children(settings.url)
    imports = Imports(settings, store, children, metrics)
    learnings = Learnings(store, children, settings.limits.learning)
    sends = Rate(settings.limits.a_minute, SENDS_S)
    lookup_cache = LookupCache(store, watched)
    reading = CapacityLimiter(settings.limits.at_once)
    service = Service(
        settings, store, watched, lookup_cache, metrics, children, imports, learnings, sends,
        reading,
    )  # fmt: skip

    @asynccontextmanager
    async def lifespan(_app: FastAPI) -> AsyncIterator[None]:
        service.imports.take_up()
        yield
        await run_in_threadpool(service.close)

    app = FastAPI(
        title="autodb",
        version=__version__,
        description=ABOUT,
        docs_url=None,  # their pages load scripts from elsewhere
        redoc_url=None,
        openapi_url=None,  # its own route asks nobody for a token
        lifespan=lifespan,
    )
    app.state.service = service
    handle(app)
    for router, tag in (
        (forces.direct, "Forces"),
        (batch.router, "Forces"),
        (forces.router, "Forces"),
        (tools.router, "Tools"),
        (decisions.router, "Mismatches"),
        (edges.router, "Tools"),
        (programs.router, "Forces"),
        (stability.router, "Forces"),
        (recordings.router, "Recordings"),
        (kept_recordings.router, "Recordings"),
        (machines.router, "Machines"),
    ):
        app.include_router(router, prefix=API, tags=[tag])
    app.include_router(operations)
    app.include_router(static.router)
    for shown in pages.PAGES:
        app.include_router(shown.router, include_in_schema=False)
    app.add_middleware(Presented, settings=settings)
    app.add_middleware(Guard, settings=settings, metrics=metrics)
    with_units(app)
    return app


@operations.get("/healthz", summary="Whether it answers", responses=problems(503))
def health(request: Request) -> Response:
    """Say whether the service and its database answer; needs no token."""
    service = service_of(request)
    with service.store.reading() as session:
        session.connection().exec_driver_sql("SELECT version_num FROM alembic_version").one()
    return Response('{"status":"ok"}', media_type="application/json")


@operations.get(f"{API}/openapi.json", include_in_schema=False)
def describe_service(request: Request, _access: Reads) -> Response:
    """Describe the service to programs (OpenAPI)."""
    return JSONResponse(request.app.openapi())


@operations.get(
    "/metrics",
    summary="Counts, for Prometheus",
    response_class=PlainTextResponse,
    responses=problems(401, 429),
)
def request_counts(request: Request, _access: Reads) -> Response:
    """Say how many requests were answered, by route and status, and how fast."""
    return Response(service_of(request).metrics.text(), media_type=TEXT)
