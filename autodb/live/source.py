"""What both protocols share: a source of batches, and what a machine offers."""

from collections.abc import AsyncGenerator, Iterable
from dataclasses import dataclass
from importlib import import_module
from typing import Protocol

from autodb.errors import UnusableInput, near
from autodb.live.agentfile import AgentFile
from autodb.live.batch import Batch, Position, Value

QUIET_S = 10.0
"""For how long nothing must be said before time is taken to have gone on. Chosen: while a machine
cuts, its currents are never quiet for that long, and a stalled line is mostly back by then."""
LIBRARIES = ("asyncua", "httpx", "tomli_w", "filelock")


class Away(UnusableInput):
    """A machine that does not answer now; later it may."""


@dataclass(frozen=True)
class Offered:
    """An item that a machine offers: its name in an agent file, what it is called there, its kind
    and unit as far as they are said, and what it says now.
    """

    item: str
    called: str
    kind: str
    unit: str
    value: Value = None


class Source(Protocol):
    """A machine as it is read."""

    def batches(self, after: Position | None) -> AsyncGenerator[Batch, None]:
        """Yield what is said from now on, or from behind ``after``, as far as the machine kept it.

        Raises Away where the machine does not answer any more, UnusableInput for an item that it
        does not have.
        """

    async def offered(self) -> list[Offered]:
        """Return what the machine offers; raises Away."""


def source_of(plan: AgentFile) -> Source:
    """Return the source that an agent file names; raises UnusableInput without the extra."""
    for name in LIBRARIES:
        try:
            import_module(name)
        except ImportError:
            raise UnusableInput(
                f"agent needs {name}; \"pip install 'autodb[live]'\" would work"
            ) from None
    if plan.source.protocol == "opcua":
        from autodb.live.opcua import OpcUa

        return OpcUa(plan)
    from autodb.live.mtconnect import MtConnect

    return MtConnect(plan)


def unknown_item(url: str, item: str, known: Iterable[str]) -> UnusableInput:
    """Return the refusal of an item that a machine does not have."""
    return UnusableInput(f"{url}: has no item '{item}'{near(item, known)}; --list says what it has")
