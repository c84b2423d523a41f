"""`python -m benchmarks.soak [mtconnect|opcua] [MINUTES]`: an agent for ten minutes, its memory.

A virtual mill (14 channels at 250 Hz, a cut of 4 s every 6 s) is served by a process of its own, in
real time; the agent of this process journals, records, imports and refreshes. Its memory is read
each minute; what counts is the slope from the second minute on, when everything has been loaded
once. Set OPENBLAS_NUM_THREADS=1.
"""

import asyncio
import multiprocessing
import os
import resource
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np

from autodb.agent.operate.health import memory_MB
from autodb.agent.operate.running import Agent
from autodb.agent.rows.machines import add_machine
from autodb.files.excuses import excuse
from autodb.files.machine import AxisFile, MachineFile
from autodb.live.agentfile import read_agentfile
from autodb.proofs.machines.served.example import agent_text
from autodb.proofs.machines.served.mtconnect import MtConnectServer
from autodb.proofs.machines.served.opcua import OpcUaServer
from autodb.proofs.machines.served.shift import ServedShift, mill_shift
from autodb.store import Store, create_store, open_store

MINUTES, LOADED_MIN = 10.0, 2.0
PORT = 48_555
MACHINE = "mill-1"
URL = "sqlite:///autodb.sqlite3"


def _server(protocol: str, shift: ServedShift) -> MtConnectServer | OpcUaServer:
    if protocol == "mtconnect":
        return MtConnectServer(shift, port=PORT)
    return OpcUaServer(shift, port=PORT)


def _serve(protocol: str, shift: ServedShift) -> None:
    async def served() -> None:
        server = _server(protocol, shift)
        await server.start()
        await server.play(speed=1.0)
        await asyncio.sleep(3600.0)

    asyncio.run(served())


@contextmanager
def _opened() -> Iterator[Store]:
    store = open_store(URL)
    try:
        yield store
    finally:
        store.close()


def main(arguments: list[str]) -> None:
    """Print the agent's memory by the minute, and how it grew."""
    protocol = (arguments or ["mtconnect"])[0]
    minutes = float((arguments[1:] or [str(MINUTES)])[0])
    if minutes < LOADED_MIN + 2.0:
        sys.exit(f"at least {LOADED_MIN + 2.0:g} minutes would tell something")
    shift = replace(mill_shift(3, 1), times=int(minutes * 60.0 / 18.0) + 10)
    serving = multiprocessing.get_context("fork").Process(
        target=_serve, args=(protocol, shift), daemon=True
    )
    serving.start()
    time.sleep(5.0)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        _soak(protocol, shift, minutes)
        os.chdir("/")
    serving.kill()


def _soak(protocol: str, shift: ServedShift, minutes: float) -> None:
    create_store(URL)
    with _opened() as store:
        add_machine(store, MACHINE, MachineFile(axes={name: AxisFile() for name in "xyz"}))
    server = _server(protocol, shift)
    item = server.item if isinstance(server, OpcUaServer) else str
    url = f"http://127.0.0.1:{PORT}" if protocol == "mtconnect" else server.url
    path = Path("agent.toml")
    text = agent_text(shift, machine=MACHINE, protocol=protocol, url=url, item=item)
    path.write_text(text, encoding="utf-8")
    began, used = time.monotonic(), time.process_time()
    seen: list[tuple[float, float]] = []

    def goes_on() -> bool:
        passed_min = (time.monotonic() - began) / 60.0
        if passed_min >= len(seen):
            seen.append((passed_min, memory_MB()))
            print(f"{passed_min:5.1f} min   {seen[-1][1]:6.1f} MB   {agent.health.line()}")
        return passed_min < minutes

    agent = Agent(path, read_agentfile(path), _opened, say=_silent, excuse=excuse, goes_on=goes_on)
    agent.run()
    share = (time.process_time() - used) / (time.monotonic() - began)
    late = np.array([one for one in seen if one[0] >= LOADED_MIN])
    slope = float(np.polyfit(late[:, 0], late[:, 1], 1)[0])
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000.0
    print(f"{protocol}: {agent.health.cuts} cuts; {slope:+.2f} MB a minute from minute 2 on; "
          f"peak {peak:.0f} MB; {share:.2f} of a core")  # fmt: skip


def _silent(_line: str) -> None:
    """Say nothing."""


if __name__ == "__main__":
    main(sys.argv[1:])
