"""Recordings that were sent: received, and imported one after another while their senders ask.

What was accepted is imported also where the service ends before: by the one that begins next.
"""

import itertools
import queue
import threading
import time
from collections import OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from fastapi import HTTPException

from autodb.agent.ingest.importing import Imported
from autodb.agent.operate.access import Access
from autodb.agent.operate.receiving import Sent, recording_came_in
from autodb.errors import NotThere, UnusableInput
from autodb.files.excuses import excuse
from autodb.store import Store
from autodb.web.http.logs import LOG, Metrics
from autodb.web.http.said import Importing
from autodb.web.http.settings import Settings
from autodb.web.receive import landing
from autodb.web.receive.accepted import Accepted, Claim, accept, left
from autodb.web.receive.apart import Import
from autodb.web.receive.children import Children, Unable
from autodb.wording import msgid, phrase

REMEMBERED = 1000
"""Imports that can be asked for; beyond, the oldest is forgotten. Chosen: some 1 kB each."""
WAIT_S = 30
"""When to try again where too many wait. Chosen: some imports take so long."""
STOPS_S = 30.0
"""How long what is decided of the last import is waited for when the service ends. Chosen."""
NO_FOLDER = msgid("the database is on a server; run 'autodb serve --recordings FOLDER'")


@dataclass(frozen=True)
class Place:
    """Where one recording is received: below the folder of all, by its machine."""

    folder: Path
    made: Path
    machine: str


@dataclass(frozen=True)
class WaitingImport:
    """A recording that was accepted: its import's number, where it lies, and the claim to it."""

    number: int
    place: Place
    sent: Sent
    claim: Claim


class Imports:
    """Recordings that were sent to one service, by the numbers of their imports.

    Numbers go on from the clock's seconds: a service that begins again gives none a second time.
    """

    def __init__(
        self, settings: Settings, store: Store, children: Children, metrics: Metrics
    ) -> None:
        self._settings, self._store = settings, store
        self._children, self._metrics = children, metrics
        self._lock = threading.Lock()
        self._numbers = itertools.count(int(time.time()))
        self._known: OrderedDict[int, Importing] = OrderedDict()
        self._queue: queue.SimpleQueue[WaitingImport | None] = queue.SimpleQueue()
        self._worker: threading.Thread | None = None
        self._held = 0

    def said(self, number: int) -> Importing:
        """Return how far an import is; raises NotThere."""
        with self._lock:
            found = self._known.get(number)
        if found is None:
            raise NotThere(
                phrase("no import {number}; use the number that sending a recording gave",
                    number=number)
            )  # fmt: skip
        return found

    @contextmanager
    def place(self, machine: str) -> Iterator[Place]:
        """Give a place to receive a recording at, which is taken away where it is not added.

        Raises HTTPException where there is no folder, or too many are received or wait.
        """
        folder = self._settings.keeps_in
        if folder is None:
            raise HTTPException(403, phrase(NO_FOLDER))
        self._hold()
        made: Place | None = None
        try:
            made = Place(folder, landing.place(folder, machine), machine)
            yield made
        except BaseException:
            if made is not None:
                landing.give_up(folder, made.made)
            self._let_go()
            raise

    def add(self, place: Place, path: Path, by: Access) -> Importing:
        """Have what was received at a place imported; return how far it is.

        It is on the disk by then, so that it outlasts the service.
        """
        file = str(path.relative_to(place.folder))
        one = Accepted(next(self._numbers), place.machine, file, by)
        return self._queued(one, place, accept(place.folder, place.made, one))

    def _queued(self, one: Accepted, place: Place, claim: Claim) -> Importing:
        path = place.folder / one.file
        came_as = landing.came_as(place.folder, one.machine, path.name)
        said = Importing(one.number, one.machine, path.name)
        with self._lock:
            self._known[said.number] = said
            if len(self._known) > REMEMBERED:
                self._known.popitem(last=False)
            if self._worker is None:
                self._worker = threading.Thread(target=self._work, name="imports")
                self._worker.start()
        sent = Sent(path, one.machine, came_as, one.by)
        self._queue.put(WaitingImport(one.number, place, sent, claim))
        return said

    def take_up(self) -> None:
        """Have imported what a service accepted that ended, and decide what else it left."""
        folder = self._settings.keeps_in
        if not self._settings.writes or folder is None:
            return
        for one, claim in left(folder):
            self._numbers = itertools.count(max(one.number + 1, int(time.time())))
            with self._lock:
                self._held += 1
            self._metrics.importing.inc()
            self._queued(one, Place(folder, (folder / one.file).parent, one.machine), claim)
        landing.decide_left(folder, self._store)

    def close(self) -> None:
        """Leave those that wait to the service that begins next; the process at work has ended."""
        self._queue.put(None)
        if self._worker is not None:
            self._worker.join(STOPS_S)

    def _hold(self) -> None:
        with self._lock:
            most = self._settings.limits.waiting
            if self._held >= most:
                said = phrase(
                    "{count} recordings wait already; try again in {wait} s",
                    count=most, wait=WAIT_S,
                )  # fmt: skip
                raise HTTPException(503, said, {"Retry-After": str(WAIT_S)})
            self._held += 1
        self._metrics.importing.inc()

    def _let_go(self) -> None:
        with self._lock:
            self._held -= 1
        self._metrics.importing.dec()

    def _say(self, number: int, **change: Any) -> None:
        with self._lock:
            if number in self._known:
                self._known[number] = replace(self._known[number], **change)

    def _work(self) -> None:
        while (one := self._queue.get()) is not None:
            self._say(one.number, state="reading")
            outcome = self._outcome(one.number, one.sent)
            if outcome is None:
                one.claim.let_go()
                self._let_go()
                self._say(one.number, progress="", state="waiting")
                continue
            self._settle(one)
            state = "refused" if isinstance(outcome, str) else "done"
            key = "refused" if isinstance(outcome, str) else "came_in"
            self._metrics.imports.labels(state).inc()
            self._say(one.number, progress="", state=state, **{key: outcome})

    def _outcome(self, number: int, sent: Sent) -> Imported | str | None:
        """Have a recording imported in a process of its own; return what came in, or why not.

        None: the service ended before.
        """
        bounds = self._settings.limits.importing
        try:
            there = recording_came_in(self._store, sent.path)
            if there is not None:  # of a service that was killed as it had written all
                return there
            try:
                done: Imported = self._children.do(
                    Import(sent), Imported, bounds, lambda step: self._say(number, progress=step)
                )
                return done
            except (UnusableInput, Unable) as error:
                # killed after all was written, it came in
                ends = isinstance(error, Unable) and self._children.closed
                return recording_came_in(self._store, sent.path) or (None if ends else str(error))
        except Exception as error:
            LOG.error("import of %s", sent.path, exc_info=error)
            return excuse(error) or "an error of autodb; the service's log has it"

    def _settle(self, one: WaitingImport) -> None:
        """Keep what came in, and take away what did not."""
        try:
            landing.keep_place(one.place.folder, one.place.made, self._store)
        except Exception as error:  # then it is decided when a service begins
            LOG.error("what was sent to %s", one.place.made, exc_info=error)
        finally:
            one.claim.finish()
            self._let_go()
