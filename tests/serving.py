"""A service on loopback, in a thread of the test."""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace

import httpx
import uvicorn

from autodb.web import server as serving
from autodb.web.app import make_app
from autodb.web.server import Certificate
from autodb.web.settings import Settings


def listening(
    settings: Settings, certificate: Certificate | None = None
) -> tuple[uvicorn.Server, threading.Thread, str]:
    """Return a service that answers, its thread, and its address."""
    settings = replace(settings, port=0, tls=certificate is not None)
    bound = serving.bound(settings)
    made = serving.server_of(make_app(settings), certificate, settings.proxies)
    thread = threading.Thread(target=made.run, kwargs={"sockets": [bound]})
    thread.start()
    while not made.started:
        time.sleep(0.01)
        assert thread.is_alive()
    scheme = "http" if certificate is None else "https"
    return made, thread, f"{scheme}://localhost:{bound.getsockname()[1]}"


@contextmanager
def served(settings: Settings, certificate: Certificate | None = None) -> Iterator[str]:
    """Have a service answer; give its address."""
    made, thread, at = listening(settings, certificate)
    try:
        yield at
    finally:
        made.should_exit = True
        thread.join(30.0)


def wait_for(at: str) -> None:
    """Wait until a service answers."""
    until = time.monotonic() + 60.0
    while time.monotonic() < until:
        with suppress(httpx.HTTPError):
            if httpx.get(f"{at}/healthz").status_code == 200:
                return
        time.sleep(0.1)
    raise AssertionError("it does not answer")
