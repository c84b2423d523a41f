"""A virtual machine that runs beside a test, and an agent that reads it for as long as it takes."""

import asyncio
import sqlite3
import threading
import time
from collections.abc import Callable, Coroutine, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, Protocol

import pyarrow.parquet as pq
from sqlalchemy import select

from autodb.agent.operate.health import read_health
from autodb.agent.operate.running import Agent, health_of
from autodb.agent.rows.machines import add_machine
from autodb.files.excuses import excuse
from autodb.files.machine import LATHE, AxisFile, MachineFile
from autodb.live.agentfile import read_agentfile
from autodb.proofs.machines.served.example import agent_text
from autodb.proofs.machines.served.shift import ServedShift
from autodb.store import Store, create_store, models, open_store

MACHINE = "machine-1"
MILL = MachineFile(axes={name: AxisFile() for name in ("x", "y", "z")})
URL = "sqlite:///autodb.sqlite3"


class Server(Protocol):
    """A virtual machine that can be read."""

    async def start(self) -> None: ...
    async def stop(self) -> None: ...
    async def play(self, *, speed: float, upto: int | None = None) -> None: ...
    @property
    def url(self) -> str: ...


class Running:
    """A server in a thread of its own."""

    def __init__(self, server: Server) -> None:
        self.server = server
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()

    def call(self, what: Coroutine[Any, Any, None], timeout: float = 60.0) -> None:
        """Have it do something, and wait until it is done."""
        asyncio.run_coroutine_threadsafe(what, self._loop).result(timeout)

    def begin(self, what: Coroutine[Any, Any, None]) -> None:
        """Have it do something, without waiting for it."""
        asyncio.run_coroutine_threadsafe(what, self._loop)

    def when_read(self, path: Path, speed: float) -> None:
        """Have it play its shift once the agent of an agent file reads it."""

        async def play() -> None:
            await holds(lambda: connected(path))
            await self.server.play(speed=speed)

        self.begin(play())

    def end(self) -> None:
        """Stop it."""
        self.call(self.server.stop())
        self.call(self._cancelled())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(10.0)
        self._loop.close()

    async def _cancelled(self) -> None:
        others = asyncio.all_tasks() - {asyncio.current_task()}
        for task in others:
            task.cancel()
        await asyncio.gather(*others, return_exceptions=True)


async def holds(what: Callable[[], bool], timeout_s: float = 60.0) -> None:
    """Wait until something holds, which it must in time."""
    end = time.monotonic() + timeout_s
    while not what():
        assert time.monotonic() < end, "it came to hold in no time"
        await asyncio.sleep(0.05)


def connected(path: Path) -> bool:
    """Say whether the agent of an agent file reads its machine."""
    health = health_of(path)
    return health.is_file() and read_health(health).state == "connected"


@contextmanager
def running(server: Server) -> Iterator[Running]:
    """Run a server."""
    one = Running(server)
    one.call(server.start())
    try:
        yield one
    finally:
        one.end()


def write_agentfile(
    server: Server, shift: ServedShift, *, protocol: str, item: Callable[[str], str] = str
) -> Path:
    """Write the agent file of a virtual machine into the working folder."""
    path = Path("agent.toml")
    text = agent_text(shift, machine=MACHINE, protocol=protocol, url=server.url, item=item)
    path.write_text(text, encoding="utf-8")
    return path


def new_database(*, mill: bool) -> None:
    """Make a database with the machine, in the working folder."""
    create_store(URL)
    store = open_store(URL)
    add_machine(store, MACHINE, MILL if mill else LATHE)
    store.close()


@contextmanager
def opened() -> Iterator[Store]:
    """Open the database of the working folder."""
    store = open_store(URL)
    try:
        yield store
    finally:
        store.close()


def count_of_cuts() -> int:
    """Return how many ``cuts_stored`` holds, quickly: it is asked as long as an agent runs."""
    file = "file:autodb.sqlite3?mode=ro"
    with closing(sqlite3.connect(file, uri=True, timeout=10.0)) as database:
        ((count,),) = database.execute(
            "SELECT COUNT(*) FROM cut JOIN recording ON recording.id = cut.recording_id "
            "WHERE delivered_as LIKE '%/inbox/cut-%'"
        )
    return int(count)


def cuts_stored() -> list[models.Cut]:
    """Return the cuts that the database holds of recordings by an agent, as they began."""
    with opened() as store, store.reading() as session:
        query = (
            select(models.Cut)
            .join(models.StoredRecording)
            .where(models.StoredRecording.delivered_as.contains("/inbox/cut-"))
            .order_by(models.StoredRecording.delivered_as)
        )
        found = list(session.scalars(query))
        session.expunge_all()
        return found


def recorded() -> list[Path]:
    """Return the recordings that lie in the inbox or are kept below it, as they were written."""
    return sorted(Path("inbox").rglob("*.parquet"), key=lambda path: path.stat().st_mtime_ns)


def run_agent(
    path: Path, until: Callable[[], bool], *, timeout_s: float = 60.0
) -> tuple[list[str], Agent]:
    """Run an agent until something holds, which it must in time; return what it said, and it."""
    said: list[str] = []
    end = time.monotonic() + timeout_s
    checked = [0.0, False]

    def goes_on() -> bool:
        if time.monotonic() - checked[0] > 0.3:
            checked[:] = [time.monotonic(), until()]
        return not checked[1] and time.monotonic() < end

    agent = Agent(
        path, read_agentfile(path), opened, say=said.append, excuse=excuse, goes_on=goes_on
    )
    agent.run()
    assert checked[1], said
    return said, agent


def same_as_said(shift: ServedShift) -> None:
    """Hold recordings to the rows that the machine said while it cut, bit for bit."""
    paths = recorded()
    assert len(paths) == len(shift.cuts)
    for path, (begin, end) in zip(paths, shift.cuts, strict=True):
        table = pq.read_table(path)
        assert abs(table.num_rows - (end - begin)) <= 1  # the row in which it ends
        for name, column in shift.columns.items():
            said = column[begin : begin + table.num_rows]
            assert table[name].to_numpy().tolist() == said.tolist(), (path, name)
