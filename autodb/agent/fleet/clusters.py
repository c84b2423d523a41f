"""The Dask cluster that machines are spread over: someone's scheduler, or processes of this one.

Who may talk to a scheduler or a worker can run whatever they like as its user, and any user of a
computer reaches its loopback. So all of them talk over TLS alone, and each side has to show a
certificate: of the cluster's own authority, or of one that is made for the session.
"""

import logging
import ssl
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from autodb.agent.fleet.spreading import ANSWER_S, EXTRA
from autodb.errors import UnusableInput
from autodb.store import on_server, shown_url

if TYPE_CHECKING:
    from distributed import Client
    from distributed.security import Security

HERE = "127.0.0.1"
TLS = "tls://"
QUIET = {
    "distributed.worker.profile.enabled": False,
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
}
"""Settings of Dask: no profile, which grew by half a megabyte a machine, and nothing over HTTP."""


@dataclass(frozen=True)
class ShownCertificates:
    """What a cluster's members show each other, PEM: its authority, our certificate and its key."""

    ca: Path
    chain: Path
    key: Path


@contextmanager
def scheduler_at(
    address: str, url: str, shown_there: ShownCertificates | None
) -> "Iterator[Client]":
    """Give a client of a scheduler elsewhere, whose workers reach the database by its URL.

    Raises UnusableInput where nothing answers there, it has no workers, the database is a file, or
    others could talk to the workers.
    """
    if not on_server(url):
        raise UnusableInput(
            f"{shown_url(url)}: is a file, which workers elsewhere cannot read; use a database "
            "on a server, or --workers in place of --scheduler"
        )
    client = _client(address, _security(address, shown_there))
    try:
        if not client.scheduler_info()["workers"]:
            raise UnusableInput(
                f"{address}: its scheduler has no workers; start some with 'dask worker {address}'"
            )
        yield client
    finally:
        client.close()


def _security(address: str, shown_there: ShownCertificates | None) -> "Security":
    """Return what a scheduler is talked to with; raises UnusableInput for what is no such thing."""
    if not address.startswith(TLS) or shown_there is None:
        raise UnusableInput(
            f"{address}: whoever reaches a scheduler can run anything on its workers; use "
            f"{TLS}HOST:PORT with --ca, --certificate and --key of the cluster"
        )
    ca, chain, key = shown_there.ca, shown_there.chain, shown_there.key
    try:
        ssl.create_default_context(cafile=ca).load_cert_chain(chain, key)
    except (OSError, ssl.SSLError) as error:
        raise UnusableInput(
            f"{ca}, {chain}, {key}: these are not an authority and a certificate with its key "
            f"({error.strerror or error}); give all three as PEM"
        ) from None
    try:
        from distributed.security import Security
    except ImportError:
        raise UnusableInput(EXTRA) from None
    return Security(
        require_encryption=True,
        tls_ca_file=str(ca),
        tls_client_cert=str(chain),
        tls_client_key=str(key),
    )


def _client(address: str, security: "Security") -> "Client":
    from distributed import Client

    try:
        return Client(address, security=security, timeout=ANSWER_S, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise UnusableInput(
            f"{address}: no Dask scheduler answers there ({error}); start one with 'dask "
            "scheduler', which prints its address"
        ) from None


@contextmanager
def workers_here(count: int) -> "Iterator[Client]":
    """Give a client of as many worker processes on this computer, which end with it.

    Other users of this computer reach none of them: the certificate is made here, for the session,
    and its key goes to the workers through a pipe; what they keep on disk is in a folder of our
    own.
    """
    try:
        from dask import config
        from distributed import Client, LocalCluster
        from distributed.security import Security

        security = Security.temporary()
    except ImportError:
        raise UnusableInput(EXTRA) from None
    with (
        tempfile.TemporaryDirectory(prefix="autodb-") as folder,
        config.set(QUIET | {"temporary-directory": folder}),
        LocalCluster(
            n_workers=count, threads_per_worker=1, processes=True, host=HERE, protocol=TLS,
            security=security, dashboard_address=f"{HERE}:0", scheduler_kwargs={"dashboard": False},
            silence_logs=logging.ERROR,
        ) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):  # fmt: skip
        yield client
