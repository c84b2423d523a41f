"""The Dask cluster that machines are spread over: someone's scheduler, or processes of this one."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from autodb.errors import UnusableInput
from autodb.fleet.spreading import ANSWER_S, EXTRA
from autodb.store import on_server, shown

if TYPE_CHECKING:
    from distributed import Client


@contextmanager
def scheduler_at(address: str, url: str) -> "Iterator[Client]":
    """Give a client of a scheduler elsewhere, whose workers reach the database by its URL.

    Raises UnusableInput where nothing answers there, it has no workers, or the database is a file.
    """
    if not on_server(url):
        raise UnusableInput(
            f"{shown(url)}: is a file, which workers elsewhere do not have; a database on a "
            "server, or --workers in place of --scheduler, would work"
        )
    client = _client(address)
    try:
        if not client.scheduler_info()["workers"]:
            raise UnusableInput(
                f"{address}: its scheduler has no workers; 'dask worker {address}' starts some"
            )
        yield client
    finally:
        client.close()


def _client(address: str) -> "Client":
    try:
        from distributed import Client
    except ImportError:
        raise UnusableInput(EXTRA) from None
    try:
        return Client(address, timeout=ANSWER_S, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise UnusableInput(
            f"{address}: no Dask scheduler answers there ({error}); 'dask scheduler' starts one, "
            "and prints its address"
        ) from None


@contextmanager
def workers_here(count: int) -> "Iterator[Client]":
    """Give a client of as many worker processes on this computer, which end with it.

    They keep no profile of what they do: it grew by half a megabyte a machine.
    """
    try:
        from dask import config
        from distributed import Client, LocalCluster
    except ImportError:
        raise UnusableInput(EXTRA) from None
    with (
        config.set({"distributed.worker.profile.enabled": False}),
        LocalCluster(
            n_workers=count, threads_per_worker=1, processes=True, dashboard_address=":0",
            silence_logs=logging.ERROR,
        ) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):  # fmt: skip
        yield client
