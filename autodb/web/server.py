"""The service as a process: bound, answering, and stopped gracefully."""

import gc
import signal
import socket
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import uvicorn
from fastapi import FastAPI

from autodb.errors import UnusableInput
from autodb.web.http import logs
from autodb.web.http.connections import Connection
from autodb.web.http.settings import Settings

STOP_S = 20
"""How long answers on their way are waited for when it is stopped. Chosen."""
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


def server_of(
    app: FastAPI, certificate: Certificate | None, proxies: Sequence[str] = ()
) -> uvicorn.Server:
    """Return what answers for an app; ``proxies`` are believed for whom they ask, nobody else."""
    config = uvicorn.Config(
        app,
        http=Connection,
        log_config=None,
        server_header=False,
        limit_concurrency=AT_ONCE,
        timeout_keep_alive=IDLE_S,
        timeout_graceful_shutdown=STOP_S,
        proxy_headers=bool(proxies),
        forwarded_allow_ips=list(proxies),
        ssl_certfile=None if certificate is None else certificate.chain,
        ssl_keyfile=None if certificate is None else certificate.key,
    )
    return uvicorn.Server(config)


def run_server(
    app: FastAPI,
    listening: socket.socket,
    certificate: Certificate | None,
    proxies: Sequence[str],
) -> None:
    """Answer until it is stopped (SIGTERM, Ctrl-C): then what is on its way is answered."""
    logs.begin_logging()
    gc.collect()
    gc.freeze()  # what is loaded stays: searched for garbage, it held up answers by 0.1 s
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # the server's own handler ends it, in order
    server_of(app, certificate, proxies).run(sockets=[listening])
