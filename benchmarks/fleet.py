"""`python -m benchmarks.fleet [overhead | days [MACHINES ...]]`: what many machines cost.

`overhead`: tasks that keep a core busy for a second, by a plain loop and by two workers; the limit
is 10 % over half of the loop's time. `days`: of 1, 10, 100 and 1000 virtual machines on one
PostgreSQL server, two days of 20 new cuts each are refreshed by two workers and what they know
together is learnt: time, processor time of clients and server, bytes that the second day adds, and
peak memory of a process. A machine's first day is its first 20 cuts of a pair; forces are sensed
already, because what sensing them costs is a recording's (see benchmarks.refreshing and soak).
"""

import os
import resource
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from autodb.agent.fleet.clusters import workers_here
from autodb.agent.fleet.sharing import learn_fleet
from autodb.agent.fleet.spreading import pinned, refresh_all
from autodb.agent.fleet.tasks import MachineTask, RefreshedMachine
from autodb.proofs.machines.lathe import fleets
from autodb.store import create_store, open_store
from tests.helpers import shops
from tests.helpers.servers import Server

if TYPE_CHECKING:
    from distributed import Client

WORKERS = 2
TASKS, TASK_S = 40, 1.0
OVER = 0.1
MACHINES = (1, 10, 100, 1000)
CUTS = 20
PAIRS_OF_FLEET = 3
"""Materials that the fleet's machines cut, each machine one."""


def busy(seconds: float) -> float:
    """Keep a core busy for a number of its own seconds."""
    end = time.process_time() + seconds
    x = 1.0
    while time.process_time() < end:
        x = (x * 1.0000001) % 7.0
    return x


def overhead() -> None:
    """Print what spreading costs beside a plain loop."""
    start = time.perf_counter()
    for _ in range(TASKS):
        busy(TASK_S)
    loop_s = time.perf_counter() - start
    begun = time.perf_counter()
    with workers_here(WORKERS) as client:
        client.gather([client.submit(pinned, busy, 0.01, pure=False) for _ in range(2 * WORKERS)])
        begun_s = time.perf_counter() - begun
        start = time.perf_counter()
        client.gather([client.submit(pinned, busy, TASK_S, pure=False) for _ in range(TASKS)])
        spread_s = time.perf_counter() - start
    over = spread_s / (loop_s / WORKERS) - 1.0
    print(
        f"{TASKS} tasks of {TASK_S:g} s: loop {loop_s:.1f} s, {WORKERS} workers {spread_s:.1f} s: "
        f"{100.0 * over:.1f} % over half of the loop (limit {100.0 * OVER:.0f} %: "
        f"{'passed' if over <= OVER else 'missed'}); workers are there after {begun_s:.1f} s"
    )


@dataclass(frozen=True)
class Cost:
    """What a day took: wall time, processor time of clients and of the server, s; bytes then."""

    wall_s: float
    clients_s: float
    server_s: float
    bytes: int


def days(counts: Sequence[int]) -> None:
    """Print what a machine's day costs by the number of machines."""
    print("machines   day   wall s   of it learning together s   clients s/machine   "
          "server s/machine   kB added/machine   peak MB of a worker, here")  # fmt: skip
    with tempfile.TemporaryDirectory(prefix="autodb-fleet-") as name:
        Path(name).chmod(0o755)
        server = Server(Path(name) / "server")
        try:
            for count in counts:
                _days(server, count)
        finally:
            server.stop()


def _days(server: Server, count: int) -> None:
    url = server.database()
    create_store(url)
    rng = np.random.default_rng(12)
    fleet = fleets.draw_fleet(rng, materials=PAIRS_OF_FLEET, tools=1)
    names = shops.names(count)
    keys = [(fleet.materials[k % PAIRS_OF_FLEET], fleet.tools[0]) for k in range(count)]
    pairs = [fleets.on_machine(rng, fleet, [key]) for key in keys]
    machines = [MachineTask(url, name, None) for name in names]
    with workers_here(WORKERS) as client:
        client.gather([client.submit(pinned, busy, 0.01, pure=False) for _ in range(2 * WORKERS)])
        for day in (1, 2):
            before = server.bytes(url)
            store = open_store(url)
            for name, pair in zip(names, pairs, strict=True):
                shops.add(store, name, pair, cuts=CUTS, rng=rng)
            store.close()
            together_s, cost = _day(client, machines, url, server)
            peak = max(client.run(_peak_mb).values())
            print(
                f"{count:8d} {day:5d} {cost.wall_s:8.1f} {together_s:27.1f} "
                f"{cost.clients_s / count:19.2f} {cost.server_s / count:18.3f} "
                f"{(cost.bytes - before) / count / 1e3:18.1f} {peak:12.0f}, {_peak_mb():.0f}",
                flush=True,
            )


def _day(
    client: "Client", machines: Sequence[MachineTask], url: str, server: Server
) -> tuple[float, Cost]:
    failed: list[RefreshedMachine] = []

    def tell(one: RefreshedMachine) -> None:
        if one.failed is not None:
            failed.append(one)

    began = _clients_s(client), server.busy_s(), time.perf_counter()
    refresh_all(client, machines, tell)
    assert not failed, failed[:3]
    start = time.perf_counter()
    store = open_store(url)
    learn_fleet(store)
    store.close()
    end = time.perf_counter()
    cost = Cost(
        end - began[2], _clients_s(client) - began[0], server.busy_s() - began[1], server.bytes(url)
    )
    return end - start, cost


def _clients_s(client: "Client") -> float:
    return float(time.process_time() + sum(client.run(time.process_time).values()))


def _peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


PARTS: dict[str, Callable[[list[str]], None]] = {
    "overhead": lambda _: overhead(),
    "days": lambda given: days([int(one) for one in given] or MACHINES),
}

if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    for part in [sys.argv[1]] if len(sys.argv) > 1 else list(PARTS):
        PARTS[part](sys.argv[2:])
