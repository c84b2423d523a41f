"""Machines that learn while their page says how far it is: one refresh a machine, apart.

Each pass of a refresh is one transaction. Where the service ends, or the process, what was being
done is as if it had not begun, and the next refresh does it.
"""

import threading
import time
from dataclasses import dataclass, replace
from typing import Literal

from fastapi import HTTPException

from autodb.agent.operate.access import Access, note
from autodb.agent.operate.refreshing import UPDATING
from autodb.agent.rows.machines import owner_named
from autodb.errors import UnusableInput
from autodb.files.excuses import excuse
from autodb.store import Store
from autodb.web.http.logs import LOG
from autodb.web.http.settings import ReaderBounds
from autodb.web.receive.apart import MachineToLearn
from autodb.web.receive.children import Children, FailedWords, Unable
from autodb.web.receive.learnt import MachineLearnt
from autodb.wording import Worded, language_of, phrase, stored_msgid
from autodb.wording.kept import stored_sentence

AT_ONCE = 2
"""Machines that learn at the same time. Chosen: each takes a processor."""
STOPS_S = 10.0
"""How long a process that was ended is waited for when the service ends. Chosen."""
LEARNING = FailedWords(
    broke=stored_msgid(
        "{what}: learning broke off ({how}); what was learnt until then is kept. Try again, or run "
        "'autodb refresh' on the service's computer"
    ),
    late=stored_msgid(
        "{what}: learning takes longer than the {most} s that it may take; what was learnt until "
        "then is kept. Learn again: it goes on from there"
    ),
    ended=stored_msgid(
        "the service ended meanwhile; what was learnt until then is kept. Learn again"
    ),
)
_OF_PAIRS = stored_sentence(UPDATING)

State = Literal["running", "done", "refused"]


@dataclass(frozen=True)
class LearningSaid:
    """How far a machine's learning is: its step as it was said, since when, what came of it.

    ``pair_k`` of ``pairs_n``: which pair it is at, None: at none.
    """

    machine: str
    by: str
    began_s: float
    state: State = "running"
    step: str = ""
    pair_k: int | None = None
    pairs_n: int | None = None
    took_s: float = 0.0
    learnt: MachineLearnt | None = None
    refused: Worded | None = None

    @property
    def seconds(self) -> int:
        """How long it has run, or ran; s."""
        return round(self.took_s if self.state != "running" else time.time() - self.began_s)


class Learnings:
    """Machines that learn for one service, or did: of each the last time is remembered."""

    def __init__(self, store: Store, children: Children, bounds: ReaderBounds) -> None:
        self._store, self._children, self._bounds = store, children, bounds
        self._lock = threading.Lock()
        self._known: dict[str, LearningSaid] = {}
        self._threads: list[threading.Thread] = []

    def said(self, machine: str) -> LearningSaid | None:
        """Return how far a machine's learning is; None: none since the service began."""
        with self._lock:
            return self._known.get(machine)

    def begin(self, machine: str, by: Access, *, calibrate: bool = False) -> None:
        """Have a machine learn, calibrated anew before if so asked; note who asked for it.

        Raises NotThere for a machine that is not there, HTTPException where it learns already, or
        too many do.
        """
        with self._store.reading() as session:
            owner = owner_named(session, machine).id
        with self._lock:
            running = [one for one in self._known.values() if one.state == "running"]
            if any(one.machine == machine for one in running):
                said = phrase("{machine} is learning already; wait until it is done",
                              machine=machine)  # fmt: skip
                raise HTTPException(409, said)
            if len(running) >= AT_ONCE:
                raise HTTPException(
                    503, phrase("{count} machines are learning; wait until one is done",
                                count=len(running))
                )  # fmt: skip
            self._known[machine] = LearningSaid(machine, by.who, time.time())
            self._threads = [one for one in self._threads if one.is_alive()]
        try:
            with self._store.writing() as session:
                action = "calibration and learning started" if calibrate else "learning started"
                note(session, by, action, row=("machine", owner))
        except BaseException:
            with self._lock:
                del self._known[machine]
            raise
        task = MachineToLearn(machine, calibrate)
        thread = threading.Thread(target=self._learn, args=(task,), name=f"learns {machine}")
        with self._lock:
            self._threads.append(thread)
        thread.start()

    def _learn(self, task: MachineToLearn) -> None:
        machine = task.machine
        try:
            learnt: MachineLearnt = self._children.do(
                task, MachineLearnt, self._bounds,
                lambda step: self._at(machine, step), failed=LEARNING,
            )  # fmt: skip
            self._end(machine, state="done", learnt=learnt)
        except (UnusableInput, Unable) as error:
            self._end(machine, state="refused", refused=Worded(str(error), language_of(error)))
        except Exception as error:
            LOG.error("learning of %s", machine, exc_info=error)
            said = excuse(error) or "an error of autodb; the service's log has it"
            self._end(machine, state="refused", refused=Worded(said, "en"))

    def _at(self, machine: str, step: str) -> None:
        """Note a step; which pair it is at stays while steps say none."""
        found = _OF_PAIRS.values(step)
        with self._lock:
            one = self._known[machine]
            at = (one.pair_k, one.pairs_n)
            if found is not None:
                at = int(found["k"]), int(found["n"])
            self._known[machine] = replace(one, step=step, pair_k=at[0], pairs_n=at[1])

    def _end(
        self,
        machine: str,
        *,
        state: State,
        learnt: MachineLearnt | None = None,
        refused: Worded | None = None,
    ) -> None:
        with self._lock:
            one = self._known[machine]
            self._known[machine] = replace(
                one, state=state, took_s=time.time() - one.began_s, learnt=learnt, refused=refused
            )

    def close(self) -> None:
        """Wait for processes that have been ended."""
        for one in self._threads:
            one.join(STOPS_S)
