"""What stands before every route: whom it is asked as, how much is sent, and what browsers may do.

A plain ASGI middleware: each request passes it once, is counted, timed and logged with a number
that its answer carries.

How often each address did something lately.
"""

import logging
import secrets
import threading
import time
from collections import deque

from fastapi import HTTPException
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from autodb.web.http.logs import LOG, Metrics
from autodb.web.http.problems import problem
from autodb.web.http.sessions import SAFE
from autodb.web.http.settings import MIB, Settings
from autodb.wording import phrase

BODY_MOST = MIB
"""Bytes of a request's body, but where a route takes more."""
DYNAMICS_MOST = 8 * MIB
"""Bytes of a file of a tool point's receptance. Chosen: 100 000 lines of a CSV."""
BODY_MOST_OF = {"/batch": 64 * MIB, "/stability": DYNAMICS_MOST + 2 * BODY_MOST}
"""Bytes by how a path ends, beside what the settings' limits say."""
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=()",
    "Cache-Control": "no-cache",
}
OURS = ("same-origin", "none")
"""What browsers say of requests by a page of ours, or by hand (W3C Fetch Metadata)."""
HSTS = "max-age=31536000"


class Guard:
    """Lets a request through to the routes, or refuses it."""

    def __init__(self, app: ASGIApp, *, settings: Settings, metrics: Metrics) -> None:
        self._app, self._settings, self._metrics = app, settings, metrics
        self._headers = HEADERS | ({"Strict-Transport-Security": HSTS} if settings.tls else {})
        limits = settings.limits
        self._most = BODY_MOST_OF | {
            "/recordings": (limits.recording_MiB + limits.side_MiB) * MIB + BODY_MOST,
            "/look": (limits.recording_MiB + 2 * limits.side_MiB) * MIB + BODY_MOST,
            "/program": limits.program_MiB * MIB + 2 * BODY_MOST,
        }

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        request = _Request(scope, self._headers, send)
        self._metrics.running.inc()
        try:
            refused = self._refusal(Headers(scope=scope), scope["method"], scope["path"])
            if refused is not None:
                await problem(*refused)(scope, receive, request.send)
            else:
                most = self._most_of(scope["path"])
                await self._app(scope, _bounded(receive, most), request.send)
        finally:
            self._metrics.running.dec()
            self._tell(scope, request)

    def _refusal(self, headers: Headers, method: str, path: str) -> tuple[int, str] | None:
        if method not in SAFE and headers.get("sec-fetch-site", "none") not in OURS:
            return 403, "sent by a page of another site; send it from a page of this service"
        names, asked = self._settings.answers_to, headers.get("host", "")
        if names is not None and _name(asked) not in names:
            return 400, f"asked by the name '{_name(asked)}'; allow it with 'autodb serve --name'"
        length = headers.get("content-length", "0")
        if not length.isdecimal():
            return 400, "Content-Length: not a number"
        if int(length) > self._most_of(path):
            return 413, _too_large(self._most_of(path))
        return None

    def _most_of(self, path: str) -> int:
        """Return how many bytes a body may have that is sent to a path."""
        return next((most for end, most in self._most.items() if path.endswith(end)), BODY_MOST)

    def _tell(self, scope: Scope, request: "_Request") -> None:
        route = getattr(scope.get("route"), "path", "none")
        took_s = time.perf_counter() - request.begun
        self._metrics.requests.labels(route, scope["method"], str(request.status)).inc()
        self._metrics.seconds.labels(route).observe(took_s)
        client = scope.get("client")
        LOG.log(
            logging.ERROR if request.status >= 500 else logging.INFO,
            "answered",
            extra={
                "request": request.number,
                "method": scope["method"],
                "path": scope["path"],
                "route": route,
                "status": request.status,
                "ms": round(1000.0 * took_s, 2),
                "who": scope.get("state", {}).get("who"),
                "client": client[0] if client else None,
            },
        )


class _Request:
    """One request on its way: its number, when it began, and the status it got."""

    def __init__(self, scope: Scope, headers: dict[str, str], send: Send) -> None:
        self.number, self.begun, self.status = secrets.token_hex(6), time.perf_counter(), 500
        self._headers, self._send = headers, send
        scope.setdefault("state", {})["request"] = self.number

    async def send(self, message: Message) -> None:
        """Send a part of the answer, its head with the headers that all have."""
        if message["type"] == "http.response.start":
            self.status = message["status"]
            headers = MutableHeaders(scope=message)
            for name, value in self._headers.items():
                headers.setdefault(name, value)
            headers["X-Request-ID"] = self.number
        await self._send(message)


def _bounded(receive: Receive, most: int) -> Receive:
    """Return what receives a body that says no length, and stops where it is too large."""
    taken = 0

    async def bounded() -> Message:
        nonlocal taken
        message = await receive()
        taken += len(message.get("body", b""))
        if taken > most:
            raise HTTPException(413, _too_large(most))
        return message

    return bounded


def _too_large(most: int) -> str:
    return phrase("larger than {most} MiB; send it in parts", most=f"{most / MIB:g}")


def _name(host: str) -> str:
    """Return the name of a Host header, without its port."""
    name, _, port = host.lower().rpartition(":")
    return name if name and port.isdecimal() else host.lower()


CLIENTS = 10_000
"""Addresses that are remembered; beyond, the oldest is forgotten. Chosen: some megabytes."""


class Rate:
    """Of each address when it did something, so that it may do so ``most`` times in a while."""

    def __init__(self, most: int, within_s: float) -> None:
        self._most, self._within_s = most, within_s
        self._lock = threading.Lock()
        self._when: dict[str, deque[float]] = {}

    def note(self, client: str) -> None:
        """Remember that an address did it now."""
        with self._lock:
            some = self._when.setdefault(client, deque(maxlen=self._most))
            some.append(time.monotonic())
            if len(self._when) > CLIENTS:
                del self._when[next(iter(self._when))]

    def wait_s(self, client: str) -> int:
        """Return how long an address has to wait until it may do it again; 0: it may now."""
        with self._lock:
            some = self._when.get(client)
            if some is None:
                return 0
            now = time.monotonic()
            while some and now - some[0] > self._within_s:
                some.popleft()
            if not some:
                del self._when[client]
            return int(self._within_s - (now - some[0])) + 1 if len(some) == self._most else 0
