"""The service as a process: bound, answering, and stopped gracefully."""

import asyncio
import gc
import signal
import socket
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import uvicorn
from fastapi import FastAPI

from autodb.errors import UnusableInput
from autodb.web.http import logs
from autodb.web.http.connections import Connection
from autodb.web.http.settings import Settings
from autodb.web.warming import warm_up

STOP_S = 20
"""How long answers on their way are waited for when it is stopped. Chosen."""
CUT_OFF_S = 1.0
"""How long answers that are cut off are waited for. Chosen."""
HANG_UPS = 100
"""How often, in that time, it is looked whether connections have ended. Chosen."""
ENDS = (signal.SIGINT, signal.SIGTERM)
IDLE_S = 30
"""How long a connection that asks nothing is kept. Chosen."""
AT_ONCE = 256
"""Requests answered at once; more get 503. Chosen."""


@dataclass(frozen=True)
class Certificate:
    """A certificate and its key, PEM."""

    chain: Path
    key: Path


def bound(settings: Settings) -> socket.socket:
    """Return a socket that listens where it is said; raises UnusableInput."""
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    made = socket.socket(family)
    made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        made.bind((settings.host, settings.port))
    except OSError as error:
        made.close()
        raise UnusableInput(
            f"{settings.host}:{settings.port}: the service cannot listen there "
            f"({error.strerror or error}); use another --port or --host"
        ) from None
    return made


class StoppableServer(uvicorn.Server):
    """A server that ends in order however often it is told to: what it stands on is closed too.

    The library's own raises its signals again inside its loop, which ends whatever still runs
    there with a traceback, and a second one leaves the application open.
    """

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Take the signals that end it for as long as it answers; only the main thread can."""
        taken = ENDS if threading.current_thread() is threading.main_thread() else ()
        before = {number: signal.signal(number, self.handle_exit) for number in taken}
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended it."""
        return signal.SIGINT in self._captured_signals

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Answer what is on its way, at most ``STOP_S``, or until told again; then close."""
        late = asyncio.get_running_loop().call_later(STOP_S, self._give_up)
        await super().shutdown(sockets)
        late.cancel()
        cut_off = list(self.server_state.tasks)
        for task in cut_off:
            task.cancel()
        if cut_off:
            await asyncio.wait(cut_off, timeout=CUT_OFF_S)
            logs.LOG.warning("%d answers on their way were cut off", len(cut_off))
        await self._hang_up()
        if self.force_exit:
            await self.lifespan.shutdown()

    async def _hang_up(self) -> None:
        """End connections that are still open: what nobody reads would hold up the loop's end."""
        for connection in list(self.server_state.connections):
            connection.transport.abort()
        for _ in range(HANG_UPS):
            if not self.server_state.connections:
                break
            await asyncio.sleep(CUT_OFF_S / HANG_UPS)

    def _give_up(self) -> None:
        self.force_exit = True


def server_of(
    app: FastAPI, certificate: Certificate | None, proxies: Sequence[str] = ()
) -> StoppableServer:
    """Return what answers for an app; ``proxies`` are believed for whom they ask, nobody else."""
    config = uvicorn.Config(
        app,
        http=Connection,
        log_config=None,
        server_header=False,
        limit_concurrency=AT_ONCE,
        timeout_keep_alive=IDLE_S,
        proxy_headers=bool(proxies),
        forwarded_allow_ips=list(proxies),
        ssl_certfile=None if certificate is None else certificate.chain,
        ssl_keyfile=None if certificate is None else certificate.key,
    )
    return StoppableServer(config)


def run_server(
    app: FastAPI,
    listening: socket.socket,
    certificate: Certificate | None,
    proxies: Sequence[str],
) -> None:
    """Answer until it is stopped (SIGTERM, Ctrl-C): then what is on its way is answered.

    Raises KeyboardInterrupt where Ctrl-C stopped it.
    """
    logs.begin_logging()
    gc.collect()
    gc.freeze()  # what is loaded stays: searched for garbage, it held up answers by 0.1 s
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # the server's own handler ends it, in order
    server = server_of(app, certificate, proxies)
    warm_up(app.state.service.store)
    server.run(sockets=[listening])
    if server.interrupted:
        raise KeyboardInterrupt
