"""The service as one ASGI application."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from importlib.metadata import version

from anyio import CapacityLimiter
from fastapi import APIRouter, FastAPI, Request, Response
from fastapi.responses import JSONResponse, PlainTextResponse
from starlette.concurrency import run_in_threadpool

from autodb.agent.answer.lookup_cache import Shelves
from autodb.store import open_store
from autodb.store.watched import Watched
from autodb.web import pages
from autodb.web.http import static
from autodb.web.http.guard import Guard
from autodb.web.http.metrics import TEXT, Metrics
from autodb.web.http.problems import problems
from autodb.web.http.rates import Rate
from autodb.web.http.settings import Settings
from autodb.web.receive.children import Children
from autodb.web.receive.imports import Imports
from autodb.web.refusals import handle
from autodb.web.routes import batch, decisions, forces, machines, programs, recordings, tools
from autodb.web.schema import with_units
from autodb.web.service import SENDS_S, Reads, Service, service_of

API = "/api/v1"
ABOUT = """What a machining database knows: forces, torque and power of cuts before they are made,
each with its 95 % interval; what machines can feel; and where every number came from.

Names of quantities end in their unit: `force_x_N`, `feed_mm_rev`, `torque_N_m`. An answer's `ETag`
is the state of the database that it is of: as long as nothing was written, `If-None-Match` gets
304 and no body. Every refusal is one line, `detail`, which says what would work."""

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
    sends = Rate(settings.limits.a_minute, SENDS_S)
    shelves = Shelves(store, watched)
    reading = CapacityLimiter(settings.limits.at_once)
    service = Service(settings, store, watched, shelves, metrics, children, imports, sends, reading)

    @asynccontextmanager
    async def lifespan(_app: FastAPI) -> AsyncIterator[None]:
        service.imports.take_up()
        yield
        await run_in_threadpool(service.close)

    app = FastAPI(
        title="autodb",
        version=version("autodb"),
        description=ABOUT,
        docs_url=None,  # their pages load scripts from elsewhere
        redoc_url=None,
        openapi_url=None,  # its own route asks nobody for a token
        lifespan=lifespan,
    )
    app.state.service = service
    handle(app)
    for router, tag in (
        (batch.router, "Forces"),
        (forces.router, "Forces"),
        (tools.router, "Tools"),
        (decisions.router, "Mismatches"),
        (programs.router, "Forces"),
        (recordings.router, "Recordings"),
        (machines.router, "Machines"),
    ):
        app.include_router(router, prefix=API, tags=[tag])
    app.include_router(operations)
    app.include_router(static.router)
    for shown in pages.PAGES:
        app.include_router(shown.router, include_in_schema=False)
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
