"""The agent of a running machine: it reads it, records each cut, and refreshes.

What is read is in the journal before anything is made of it, recordings lie in the inbox before the
journal forgets, and the refresh takes them from there: the database may be away, the machine too,
and the agent may be killed, at any time. Each connection begins by reading the journal again, so
that a kill and a lost line are one and the same case.
"""

import asyncio
import threading
import time
from collections.abc import Callable
from contextlib import aclosing
from pathlib import Path

from autodb.agent.ingest.entries import inbox_entries
from autodb.agent.ingest.inbox import Inbox
from autodb.agent.operate.health import Health
from autodb.agent.operate.refreshing import Excuse, Opens, refresh
from autodb.agent.rows.machines import find_machine
from autodb.errors import UnusableInput
from autodb.live import recorder
from autodb.live.agentfile import AgentFile
from autodb.live.batch import Batch
from autodb.live.journal import Journal
from autodb.live.opening import source_of
from autodb.live.segmenter import LiveCut, Segmenter
from autodb.live.source import Away

Say = Callable[[str], None]
HEALTH_S = 10.0
LINE_S = 60.0
LOOKS_S = 30.0
"""How often an inbox is read without a new cut: others may put recordings there too."""
RETRIES_S = (1.0, 30.0)
"""How long the first try to connect again waits, and how long the waits grow to."""


def journal_of(path: Path) -> Path:
    """Return the folder that the agent of an agent file keeps its journal and health in."""
    return path.with_name(f"{path.stem}-journal")


def health_of(path: Path) -> Path:
    """Return the health file of the agent of an agent file."""
    return journal_of(path) / "health.json"


class Agent:
    """An agent for as long as it runs.

    ``opens``: the database, each time anew. ``excuse``: has a line for what surroundings are to
    blame for, which is said and tried again. ``goes_on``: asked about once a second.
    """

    def __init__(
        self,
        path: Path,
        plan: AgentFile,
        opens: Opens,
        *,
        say: Say,
        excuse: Excuse,
        goes_on: Callable[[], bool] = lambda: True,
    ) -> None:
        self._path, self._plan, self._opens = path, plan, opens
        self._say, self._excuse, self._goes_on = say, excuse, goes_on
        self._inbox = path.parent / plan.inbox
        self._journal = Journal(journal_of(path))
        self._source = source_of(plan)
        self._connected_once = False
        self._values = 0
        self.health = Health(plan.machine)

    def run(self) -> None:
        """Run while ``goes_on``; raises UnusableInput for what is wrong from the start."""
        from filelock import FileLock, Timeout

        for tool in (self._plan.tool, *self._plan.tools.values()):
            recorder.with_file(tool, self._path.parent)
        folder = journal_of(self._path)
        self._known_machine(begun=self._journal.begun)
        folder.mkdir(exist_ok=True)
        self._inbox.mkdir(parents=True, exist_ok=True)
        lock = FileLock(folder / "lock", timeout=0)
        try:
            lock.acquire()
        except Timeout:
            raise UnusableInput(f"{self._path}: another agent of it is running") from None
        refresher = _Refresher(self)
        refresher.start()
        try:
            asyncio.run(self._run(refresher))
        finally:
            refresher.stop()
            self._journal.close()
            self._tell("stopped")
            lock.release()

    def _known_machine(self, *, begun: bool) -> None:
        """Raise UnusableInput where the database is not there or does not know the machine.

        One that has ``begun`` before records all the same, until the database is back.
        """
        try:
            with self._opens() as store, store.reading() as session:
                find_machine(session, self._plan.machine)
        except Exception as error:
            line = self._excuse(error)
            if line is None or not begun:
                raise
            self._say(line)

    async def _run(self, refresher: "_Refresher") -> None:
        telling = asyncio.create_task(self._telling())
        try:
            await self._reading(refresher)
        finally:
            telling.cancel()

    async def _reading(self, refresher: "_Refresher") -> None:
        """Read the machine, and again whenever it was away."""
        wait_s, said = RETRIES_S[0], ""
        while self._goes_on():
            try:
                await self._session(refresher)
            except Exception as error:
                line = self._excuse(error)
                at_fault = isinstance(error, UnusableInput) and not isinstance(error, Away)
                if line is None or (at_fault and not self._connected_once):
                    raise
                if self.health.state == "connected":
                    wait_s, said = RETRIES_S[0], ""
                self._tell(line)
                if line != said:
                    self._say(f"{line}; trying again")
                said = line
            until = time.monotonic() + wait_s
            while self._goes_on() and time.monotonic() < until:
                await asyncio.sleep(0.2)
            wait_s = min(2.0 * wait_s, RETRIES_S[1])

    async def _session(self, refresher: "_Refresher") -> None:
        """Read the journal again, then the machine for as long as it answers."""
        said = self._journal.read()
        done_s = float("-inf") if said.done_s is None else said.done_s
        segmenter = Segmenter(self._plan, done_s=done_s)
        if said.damaged:
            self._say(f"journal: {said.damaged} lines cannot be read; the others are used")
        for batch in said.replayed():
            self._record(segmenter.take(batch), segmenter, refresher)
        async with aclosing(self._source.batches(said.position)) as batches:
            async for batch in batches:
                if self.health.state != "connected":
                    self._connected_once = True
                    self._tell("connected")
                    self._say(f"{self._plan.source.url}: connected")
                if batch.jump:
                    segmenter = self._after_jump(batch, segmenter, refresher)
                self._take(batch, segmenter, refresher)
                if not self._goes_on():
                    return

    def _take(self, batch: Batch, segmenter: Segmenter, refresher: "_Refresher") -> None:
        """Journal what was said, and record the cuts that are whole by it."""
        if batch.count or batch.gap:
            self._journal.append(batch, segmenter.latest)
            self._values += batch.count
        late = segmenter.late
        self._record(segmenter.take(batch), segmenter, refresher)
        self._journal.forget(segmenter.needs_from_s)
        if batch.why:
            self._say(f"a gap: {batch.why}")
        health = self.health
        health.gaps += batch.gap
        health.lost += batch.lost
        health.late += segmenter.late - late
        health.cutting_since_s = segmenter.cutting_since_s

    def _after_jump(self, batch: Batch, segmenter: Segmenter, refresher: "_Refresher") -> Segmenter:
        """End what is open, as the machine's clock was set; what stands is said again by it."""
        self._say("the machine's clock was set: what it cut then is recorded in two")
        self.health.gaps += 1
        channels = {one.item for one in self._plan.channels.values()}
        begin = min(said[0] for item, (said, _) in batch.values.items() if item in channels)
        stands = {item: ([begin], [value]) for item, (_, value) in segmenter.latest().items()}
        self._record(segmenter.ended(), segmenter, refresher)
        self._journal.clear()
        anew = Segmenter(self._plan)
        anew.take(Batch(stands, begin, batch.position))
        return anew

    def _record(self, cuts: list[LiveCut], segmenter: Segmenter, refresher: "_Refresher") -> None:
        """Write the recordings of cuts, then keep that they are written."""
        for cut in cuts:
            path, notes = recorder.write(
                cut, self._plan, beside=self._path.parent, inbox=self._inbox
            )
            self._journal.done(cut.end_s, segmenter.latest)
            self.health.cuts += 1
            self.health.last_cut = path.name
            seconds = f"{cut.end_s - cut.begin_s:.1f} s"
            self._say("; ".join([f"{path.name}: recorded, {seconds} of cutting", *notes]))
            refresher.new.set()

    def _tell(self, state: str) -> None:
        """Write the health file with another state; what keeps it from that is no trouble."""
        self.health.state = state
        try:
            self.health.waiting = len(inbox_entries(self._inbox).files)
            self.health.write(health_of(self._path))
        except OSError:
            return

    async def _telling(self) -> None:
        """Write the health file every now and then, and say its line less often."""
        began, said = time.monotonic(), time.monotonic()
        while True:
            await asyncio.sleep(HEALTH_S)
            now = time.monotonic()
            self.health.values_per_s = self._values / (now - began)
            self._values, began = 0, now
            self._tell(self.health.state)
            if now - said >= LINE_S:
                self._say(self.health.line())
                said = now

    def refresh(self) -> None:
        """Take the inbox into the database; what keeps it from that is said and tried again."""
        health = self.health
        try:
            with self._opens() as store:
                done = refresh(store, self._plan.machine, inbox=Inbox(self._inbox))
        except Exception as error:
            line = self._excuse(error) or f"{type(error).__name__}: {error}"
            if line != health.refresh:
                self._say(f"refresh: {line}; trying again")
            health.refresh = line
            return
        health.refresh, health.refreshed_at_s = "", time.time()
        for text in done.lines() if done.anything else ():
            self._say(text)

    @property
    def inbox(self) -> Path:
        """The folder that recordings are written into."""
        return self._inbox


class _Refresher(threading.Thread):
    """Refreshes when a cut was recorded, or something else came into the inbox."""

    def __init__(self, agent: Agent) -> None:
        super().__init__(name="refresh", daemon=True)
        self._agent, self._ends = agent, False
        self.new = threading.Event()
        self.new.set()

    def run(self) -> None:
        """Refresh until it is stopped."""
        seen: dict[Path, str] = {}
        while not self._ends:
            if (
                self.new.is_set()
                or self._agent.health.refresh
                or inbox_entries(self._agent.inbox).files != seen
            ):
                self.new.clear()
                self._agent.refresh()
                seen = inbox_entries(self._agent.inbox).files
            self.new.wait(RETRIES_S[0] if self._agent.health.refresh else LOOKS_S)

    def stop(self) -> None:
        """End it once the pass that runs is done; what runs longer is undone, and done again."""
        self._ends = True
        self.new.set()
        self.join(timeout=5.0)
