"""Shifts of a lathe and a mill that are served while a test reads them."""

import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from autodb.proofs.machines.served.opcua import OpcUaServer
from autodb.proofs.machines.served.shift import lathe_shift, mill_shift
from tests.helpers.running_machine import (
    Running,
    count_of_cuts,
    new_database,
    recorded,
    running,
    write_agentfile,
)

LATHE = lathe_shift(3, 5)
MILL = mill_shift(2, 5, longest_s=1.5, pause_s=1.7)
"""Its pauses are longer than what ends a cut, so that nothing waits until the machine counts as
quiet."""
SPEED, MILL_SPEED = 6.0, 2.0
"""Times as fast as it was: over MTConnect, and over OPC UA, where each value is a message."""
CHANNELS = [OpcUaServer(MILL, port=0).item(name) for name in MILL.columns]


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


@contextmanager
def served_mill(*, history: bool) -> Iterator[Running]:
    server = OpcUaServer(MILL, port=free_port(), history=history)
    with running(server) as one:
        new_database(mill=True)
        write_agentfile(server, MILL, protocol="opcua", item=server.item)
        yield one


def all_in(count: int) -> Callable[[], bool]:
    return lambda: count_of_cuts() >= count


def rows_recorded() -> list[Any]:
    import pyarrow.parquet as pq

    return [pq.read_table(path)["t"] for path in recorded()]
