"""What a machine says before an agent is left alone with it."""

import asyncio
import contextlib
from contextlib import aclosing
from dataclasses import dataclass

from autodb.errors import UnusableInput
from autodb.files.channels import unit_of
from autodb.files.units import conversion, is_any_unit
from autodb.live.agentfile import AgentFile, ChannelItem
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
    """What a machine offers; what the items of a file say; whether it cuts by what they say.

    ``never``: sentences on items that cannot become the channels that they are for.
    """

    offered: list[Offered]
    items: list[ItemSaid]
    cuts: bool
    never: tuple[str, ...] = ()

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
    source = source_of(plan)
    if listing:
        return Checked(await source.offered(), [], cuts=False)
    units = await source.units()
    said: dict[str, Value] = {}
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(WAIT_S), aclosing(source.batches(None)) as batches:
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
    return Checked([], rows, cuts, _never(plan, said, units))


def _never(plan: AgentFile, said: dict[str, Value], units: dict[str, str]) -> tuple[str, ...]:
    """Return why items cannot become their channels: a text, or a unit that is not the stated."""
    found = []
    for name, one in plan.channels.items():
        value = said.get(one.item)
        if isinstance(value, str):
            found.append(f"{one.item} says '{value}', which is no number; it cannot be {name}")
        elif one.item in units:
            wrong = _wrong_unit(name, one, units[one.item])
            found += [] if wrong is None else [wrong]
    return tuple(found)


def _wrong_unit(name: str, one: ChannelItem, sent: str) -> str | None:
    """Say where an item is sent in another unit than its channel is read in.

    Of a `scale` the file says itself what it makes; a unit that is none of ours says nothing.
    """
    ours, unit = unit_of(name), _ours(sent)
    if ours is None or one.scale != 1.0 or one.kind == "percent" or not is_any_unit(unit):
        return None
    stated = one.unit or ours
    try:
        found = conversion(unit, to=ours, where=one.item)
    except UnusableInput:
        return f"{one.item} is sent in {sent}, which is no unit of {name}"
    if found == conversion(stated, to=ours, where=one.item):
        return None
    remedy = "leave out its unit" if found == (1.0, 0.0) else f'state unit = "{unit}"'
    return f"{one.item} is sent in {sent}, and {name} is read in {stated}; {remedy}"


def _ours(sent: str) -> str:
    """Return a unit as MTConnect names it (part 2, units) in the words that side files have."""
    words = {"newton_meter": "N*m", "celsius": "degC", "revolution/minute": "rev/min"}
    lower = sent.lower()
    return words.get(lower, lower if sent.isupper() and len(sent) > 3 else sent)


def text_of(value: Value) -> str:
    """Return a value in words."""
    if value is None:
        return "nothing"
    return f"{value:.6g}" if isinstance(value, float) else value
