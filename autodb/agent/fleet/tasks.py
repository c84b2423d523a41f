"""What a worker does for one machine. Each task may be done again: what is done already is not.

A task opens the database itself, and gives it back; only names, numbers and lines travel.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from autodb.agent.ingest.inbox import Inbox
from autodb.agent.operate.refreshing import refresh
from autodb.agent.sense.over_time import cuts_to_feel, feel_over_time
from autodb.errors import UnusableInput
from autodb.store import Store, open_store, retried

CUTS_A_TASK = 8
"""Recorded cuts that one task senses: some seconds' work each. Chosen."""


@dataclass(frozen=True)
class MachineTask:
    """A machine to refresh: the database that it is in, its name, its inbox if it has one."""

    url: str
    name: str
    inbox: str | None


@dataclass(frozen=True)
class RefreshedMachine:
    """What became of a machine: lines to say; ``failed``: why it was not refreshed."""

    machine: str
    lines: list[str] = field(default_factory=list)
    failed: str | None = None


@contextmanager
def _opened(machine: MachineTask) -> Iterator[Store]:
    store = open_store(machine.url)
    try:
        yield store
    finally:
        store.close()


def take_in_inbox(machine: MachineTask) -> list[list[int]]:
    """Import what is in a machine's inbox; return the recorded cuts to sense, by id, in parts."""
    with _opened(machine) as store:
        if machine.inbox is not None:
            inbox = Inbox(Path(machine.inbox))
            retried(lambda: inbox.take_in(store, machine.name, _silently))
        cuts = retried(lambda: cuts_to_feel(store, machine.name))
    return [cuts[begin : begin + CUTS_A_TASK] for begin in range(0, len(cuts), CUTS_A_TASK)]


def sense_machine(machine: MachineTask, cuts: list[int]) -> list[str]:
    """Sense some recorded cuts of a machine; return what is to be said of them."""
    with _opened(machine) as store:
        sensed = retried(lambda: feel_over_time(store, machine.name, only=set(cuts)))
    return sensed.notes


def learn_machine(machine: MachineTask, notes: list[str]) -> RefreshedMachine:
    """Refresh a machine whose recordings are taken in and sensed."""
    with _opened(machine) as store:
        done = refresh(store, machine.name)
    done.set_aside[:0] = notes
    return RefreshedMachine(machine.name, done.lines())


def whole_task(machine: MachineTask) -> RefreshedMachine:
    """Do all of it for one machine; where its input is to blame, say that it was not refreshed."""
    inbox = None if machine.inbox is None else Inbox(Path(machine.inbox))
    try:
        with _opened(machine) as store:
            return RefreshedMachine(machine.name, refresh(store, machine.name, inbox=inbox).lines())
    except UnusableInput as error:
        return RefreshedMachine(machine.name, failed=error.line)


def _silently(_step: str) -> None:
    return
