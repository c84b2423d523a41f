"""What a machine says before an agent is left alone with it."""

import asyncio
import contextlib
from contextlib import aclosing
from dataclasses import dataclass

from autodb.live.agentfile import AgentFile
from autodb.live.batch import Value
from autodb.live.opening import source_of
from autodb.live.source import Offered

WAIT_S = 5.0
"""How long an item may say nothing before it counts as one that does not. Chosen."""


@dataclass(frozen=True)
class ItemSaid:
    """An item of an agent file, what it is for, and what it says."""

    item: str
    role: str
    said: str


@dataclass(frozen=True)
class Checked:
    """What a machine offers; what the items of a file say; whether it cuts by what they say."""

    offered: list[Offered]
    items: list[ItemSaid]
    cuts: bool

    @property
    def unknown(self) -> list[str]:
        """The items that say nothing."""
        return list(dict.fromkeys(row.item for row in self.items if row.said == "nothing"))


def check_machine(plan: AgentFile, *, listing: bool) -> Checked:
    """Ask a machine what it offers, or what the items of a file say.

    Raises UnusableInput: Away where it does not answer, else for an item that it does not have.
    """
    return asyncio.run(_asked(plan, listing=listing))


async def _asked(plan: AgentFile, *, listing: bool) -> Checked:
    if listing:
        return Checked(await source_of(plan).offered(), [], cuts=False)
    said: dict[str, Value] = {}
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(WAIT_S), aclosing(source_of(plan).batches(None)) as batches:
            async for batch in batches:
                said |= {item: values[-1] for item, (_, values) in batch.values.items()}
                if all(said.get(item) is not None for item in plan.items()):
                    break
    rows = [
        ItemSaid(one.item, name, text_of(said.get(one.item))) for name, one in plan.channels.items()
    ]
    for one in plan.cut.while_:
        holds = "holds" if one.holds(said.get(one.item)) else "does not hold"
        rows.append(ItemSaid(one.item, f"[cut] while: {holds}", text_of(said.get(one.item))))
    rows += [
        ItemSaid(one.item, key.replace("tool.number", "tool_number"), text_of(said.get(one.item)))
        for key, one in plan.said().items()
    ]
    cuts = all(one.holds(said.get(one.item)) for one in plan.cut.while_)
    return Checked([], rows, cuts)


def text_of(value: Value) -> str:
    """Return a value in words."""
    if value is None:
        return "nothing"
    return f"{value:.6g}" if isinstance(value, float) else value
