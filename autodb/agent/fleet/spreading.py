"""Machines spread over a Dask cluster: a task each for what comes in, for parts of what is
sensed, and for what is learnt of it.

A worker that is lost costs the time of the tasks that it had; another does them again, and what
was written is not written twice. BLAS is held to one thread in every task: workers are processes,
and unpinned a pool of them was slower than a plain loop.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeVar

from autodb.agent.fleet import tasks
from autodb.agent.fleet.tasks import MachineTask, RefreshedMachine
from autodb.errors import UnusableInput

if TYPE_CHECKING:
    from distributed import Client, Future

EXTRA = "spreading machines needs the extra 'fleet': run pip install 'autodb[fleet]'"
ANSWER_S = 10
"""How long a scheduler is waited for."""
Done = TypeVar("Done")
Tell = Callable[[RefreshedMachine], None]


def refresh_all(client: "Client", machines: Sequence[MachineTask], tell: Tell) -> None:
    """Refresh machines on a cluster's workers; ``tell`` each as it is done, or why it is not."""
    from distributed import as_completed

    waiting = {
        _submit(client, tasks.take_in_inbox, machine): _Step(machine) for machine in machines
    }
    every = as_completed(list(waiting), loop=client.loop, raise_errors=False)
    for future in every:
        step = waiting.pop(future)
        if future.status == "error":
            tell(RefreshedMachine(step.machine.name, failed=_said(future)))
            continue
        for new, then in step.after(client, future.result(), tell):
            waiting[new] = then
            every.add(new)


@dataclass
class _Step:
    """Where a machine is: taking in (no ``parts``), sensing its parts, or learning."""

    machine: MachineTask
    parts: int | None = None
    notes: list[str] = field(default_factory=list)

    def after(self, client: "Client", result: Any, tell: Tell) -> "list[tuple[Future[Any], _Step]]":
        """Return what follows a task of the machine, with its result."""
        if isinstance(result, RefreshedMachine):
            tell(result)
            return []
        if self.parts is None:
            self.parts = len(result)
            if result:
                return [
                    (_submit(client, tasks.sense_machine, self.machine, cuts), self)
                    for cuts in result
                ]
        else:
            self.parts -= 1
            self.notes += result
        if self.parts:
            return []
        return [(_submit(client, tasks.learn_machine, self.machine, self.notes), self)]


def _submit(client: "Client", task: Callable[..., object], *arguments: object) -> "Future[Any]":
    return client.submit(pinned, task, *arguments, pure=False)


def pinned(task: Callable[..., Done], *arguments: object) -> Done:
    """Do a task with every BLAS that it has loaded held to one thread."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(limits=1):
        return task(*arguments)


def _said(future: "Future[Any]") -> str:
    error = future.exception()
    if isinstance(error, UnusableInput):
        return str(error)
    return f"{type(error).__name__}: {str(error).splitlines()[0] if str(error) else 'no message'}"
