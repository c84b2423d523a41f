"""A machine read over OPC UA: its server says every change of the nodes that we subscribed to.

Where the server keeps a history of the nodes (HistoryRead, OPC 10000-11) what was said while nobody
listened is read from there; where it does not, that is a gap.

The number of a namespace is the server's of today, its URI is the maker's (OPC 10000-3, 8.2.2):
`nsu=URI;s=X.Current` is the same node whatever order they are registered in. Of `ns=2;s=X.Current`
the URI is kept with the position, and another one behind the same number is refused.
"""

import asyncio
import contextlib
import logging
import math
import re
from collections.abc import AsyncGenerator
from datetime import UTC, datetime

from asyncua import ua
from asyncua.client.client import Client
from asyncua.common.node import Node
from asyncua.common.subscription import (
    DataChangeEvent,
    OverflowPolicy,
    StatusChangeEvent,
    Subscription,
)
from asyncua.ua.status_codes import StatusCodes
from asyncua.ua.uaerrors import UaError, UaStringParsingError

from autodb.errors import UnusableInput, near
from autodb.live.agentfile import AgentFile
from autodb.live.batch import Batch, Position, Said, Value
from autodb.live.opcua_session import OpcUaSession, away
from autodb.live.source import Away, HeardValues, Offered, SourceClock, unknown_item

LISTEN_S = 1.0
TOGETHER_S = 0.02
"""How long what is sent together may take to come in."""
WAITING = 200_000
"""How many values may wait here before the connection is given up: a minute of a fast machine."""
QUEUED = 5_000
"""How many values of a node the server is asked to keep until it sends them."""
DEEP = 12
"""How deep folders of a server are looked into."""
OVERFLOW = 0x480
"""Bits of a status code: of a data value, and its queue has lost some (OPC 10000-4, 7.39)."""


class OpcUa:
    """A source that reads an OPC UA server."""

    def __init__(self, plan: AgentFile) -> None:
        logging.getLogger("asyncua").setLevel(logging.CRITICAL)  # what it has to say, we say
        self._source, self._items = plan.source, plan.items()
        self._channels = [one.item for one in plan.channels.values()]
        self._url = plan.source.url

    async def offered(self) -> list[Offered]:
        """Return the variables of the server that are no part of OPC UA itself."""
        async with OpcUaSession(self._source) as client:
            found: list[Offered] = []
            try:
                spaces = await client.get_namespace_array()
                await _browse(client.nodes.objects, "", found, set(), spaces=spaces, deep=DEEP)
            except (UaError, OSError, TimeoutError) as error:
                raise away(self._url, error) from None
            return found

    async def batches(self, after: Position | None) -> AsyncGenerator[Batch, None]:
        """Yield what the server says, from behind ``after`` where it keeps a history."""
        async with OpcUaSession(self._source) as client:
            try:
                spaces = await client.get_namespace_array()
                self._refuse_moved(spaces, after)
                nodes = await self._nodes(client, spaces)
                listening = await self._listen(client, nodes)
                try:
                    stream = _Stream(nodes, self._channels, after, self._numbered(spaces))
                    if after is not None:
                        for batch in await stream.caught_up():
                            yield batch
                    while True:
                        for batch in stream.batches(await listening.heard()):
                            yield batch
                finally:
                    listening.end()
            except (UaError, OSError, TimeoutError) as error:
                raise away(self._url, error) from None

    async def units(self) -> dict[str, str]:
        """Return the engineering units (OPC 10000-8, 5.6.3) of nodes that say them."""
        found = {}
        async with OpcUaSession(self._source) as client:
            try:
                nodes = await self._nodes(client, await client.get_namespace_array())
                for item, node in nodes.items():
                    with contextlib.suppress(UaError):
                        said = await (await node.get_child("0:EngineeringUnits")).read_value()
                        found[item] = str(said.DisplayName.Text or "")
            except (UaError, OSError, TimeoutError) as error:
                raise away(self._url, error) from None
        return {item: unit for item, unit in found.items() if unit}

    def _numbered(self, spaces: list[str]) -> dict[str, str]:
        """Return the URI of each namespace that items name by its number."""
        numbers = (NUMBERED.match(item) for item in self._items)
        named = {int(found["number"]) for found in numbers if found is not None}
        return {str(k): spaces[k] for k in sorted(named) if 0 < k < len(spaces)}

    def _refuse_moved(self, spaces: list[str], after: Position | None) -> None:
        """Raise UnusableInput where a number means another namespace than when it was read last."""
        before = {} if after is None else after.get("namespaces", {})
        for number, uri in self._numbered(spaces).items():
            was = before.get(number, uri)
            if was != uri:
                raise UnusableInput(
                    f"{self._url}: namespace {number} was {was} and is {uri} now; name "
                    f"the items by it, like nsu={was};s=X.Current, and move the journal away"
                )

    async def _nodes(self, client: Client, spaces: list[str]) -> dict[str, Node]:
        """Return the nodes by item; raises UnusableInput for one that is not there."""
        found = {}
        for item in self._items:
            try:
                found[item] = client.get_node(self._numbered_id(item, spaces))
            except (UaStringParsingError, ValueError):
                raise UnusableInput(
                    f"{self._url}: '{item}' is not a node id; use one like nsu=URI;s=X.Current"
                ) from None
            value = await found[item].read_data_value(raise_on_bad_status=False)
            if value.StatusCode is not None and value.StatusCode.value in UNKNOWN:
                raise unknown_item(self._url, item, [one.item for one in await self.offered()])
        return found

    def _numbered_id(self, item: str, spaces: list[str]) -> str:
        """Return an id with the number that the server has for its namespace's URI."""
        found = BY_URI.match(item)
        if found is None:
            return item
        if found["uri"] not in spaces:
            raise UnusableInput(
                f"{self._url}: has no namespace {found['uri']}{near(found['uri'], spaces)}; is it "
                "another machine?"
            )
        return f"ns={spaces.index(found['uri'])};{found['id']}"

    async def _listen(self, client: Client, nodes: dict[str, Node]) -> "_Listening":
        subscription = await client.create_subscription(
            self._source.publish_ms, queue_maxsize=WAITING, overflow=OverflowPolicy.DISCONNECT
        )
        handles = await subscription.subscribe_data_change(
            list(nodes.values()),
            queuesize=QUEUED,
            sampling_interval=ua.Duration(self._source.sample_ms),
        )
        for item, handle in zip(nodes, handles, strict=True):
            if isinstance(handle, ua.StatusCode):
                raise UnusableInput(f"{self._url}: '{item}' cannot be listened to ({handle.name})")
        return _Listening(self._url, client, subscription)


NUMBERED = re.compile(r"ns=(?P<number>\d+);")
BY_URI = re.compile(r"nsu=(?P<uri>.+?);(?P<id>[isgb]=.*)", re.DOTALL)
UNKNOWN = (StatusCodes.BadNodeIdUnknown, StatusCodes.BadNodeIdInvalid)


class _Listening:
    """A subscription, and what it has said since the last time."""

    def __init__(self, url: str, client: Client, subscription: Subscription) -> None:
        self._url, self._client, self._subscription = url, client, subscription
        self._number = subscription.subscription_id
        self._said: list[DataChangeEvent] = []
        self._more, self._ended = asyncio.Event(), False
        self._taking = asyncio.create_task(self._take())

    async def _take(self) -> None:
        """Take events as they come in."""
        async for event in self._subscription:
            self._ended = self._ended or isinstance(event, StatusChangeEvent)
            if isinstance(event, DataChangeEvent):
                self._said.append(event)
            self._more.set()

    async def heard(self) -> list[DataChangeEvent]:
        """Return what was said since the last time; nothing after a while of quiet.

        Raises Away where the connection is gone, or was made anew and something missed.
        """
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(self._more.wait(), LISTEN_S)
            await asyncio.sleep(TOGETHER_S)
        self._more.clear()
        said, self._said = self._said, []
        ended = self._ended or self._taking.done()
        if ended or self._subscription.subscription_id != self._number:
            raise Away(f"{self._url}: the subscription was ended")
        if self._client.uaclient.state.name != "CONNECTED":
            raise Away(f"{self._url}: the connection was lost")
        return said

    def end(self) -> None:
        """Take no more."""
        self._taking.cancel()


class _Stream:
    """Puts what is said in turn, item by item, and knows how far each has come."""

    def __init__(
        self,
        nodes: dict[str, Node],
        channels: list[str],
        after: Position | None,
        namespaces: dict[str, str],
    ) -> None:
        self._nodes, self._namespaces = nodes, namespaces
        self._items = {node.nodeid: item for item, node in nodes.items()}
        self._last: dict[str, float] = dict(after["last"]) if after is not None else {}
        sampled = [self._last[item] for item in channels if item in self._last]
        self._clock = SourceClock(channels, max(sampled, default=-math.inf))

    async def caught_up(self) -> list[Batch]:
        """Return what was said while nobody listened; a gap where not all of it is known."""
        values: Said = {}
        whole = True
        for item, node in self._nodes.items():
            last = self._last.get(item)
            said = None if last is None else await _history(node, last)
            if said is None:
                whole = False
            elif said[0]:
                values[item] = said
        if whole:
            return self._batches(values)
        self._last = {}
        why = "the server's history does not have all that it said meanwhile"
        return [Batch({}, self._clock.upto_s, self._position(), gap=True, why=why)]

    def batches(self, events: list[DataChangeEvent]) -> list[Batch]:
        """Return what events say."""
        values: Said = {}
        lost = 0
        for event in events:
            said = event.data.monitored_item.Value
            lost += said.StatusCode is not None and said.StatusCode.value & OVERFLOW == OVERFLOW
            instants, heard = values.setdefault(self._items[event.node.nodeid], ([], []))
            instants.append(_instant(said))
            heard.append(_value(said))
        return self._batches(values, lost)

    def _batches(self, values: Said, lost: int = 0) -> list[Batch]:
        """Return batches of what history had not said already, one for each setting of a clock."""
        found = []
        for part in self._clock.heard(values):
            new = self._new(part)
            found.append(Batch(new, part.upto_s, self._position(), lost=lost, jump=part.jump))
            lost = 0
        return found

    def _new(self, part: HeardValues) -> Said:
        """Return what was not said before; how far each item has come is kept."""
        if part.jump:
            self._last = {}
        new: Said = {}
        for item, (instants, heard) in part.values.items():
            last = self._last.get(item, -math.inf)
            rows = [row for row in zip(instants, heard, strict=True) if row[0] >= last]
            if rows:
                new[item] = ([at for at, _ in rows], [value for _, value in rows])
                self._last[item] = rows[-1][0]
        return new

    def _position(self) -> Position:
        return {"last": dict(self._last), "namespaces": self._namespaces}


async def _history(node: Node, last_s: float) -> tuple[list[float], list[Value]] | None:
    """Return what a node said behind an instant; None: its server does not know all of that.

    The value at the instant itself must be there, or what followed it may be gone too.
    """
    try:
        kept = await node.read_raw_history(datetime.fromtimestamp(last_s, UTC), return_bounds=False)
    except UaError:
        return None
    instants = [_instant(one) for one in kept]
    if not instants or abs(instants[0] - last_s) > 1e-5:
        return None
    found: tuple[list[float], list[Value]] = ([], [])
    for instant, one in zip(instants, kept, strict=True):
        if instant > max([last_s, *found[0][-1:]]):
            found[0].append(instant)
            found[1].append(_value(one))
    return found


def _instant(said: ua.DataValue) -> float:
    """Return when something was said, s since 1970: by the machine, else by its server."""
    stamp = said.SourceTimestamp or said.ServerTimestamp
    if stamp is None:
        raise Away("a value without any timestamp; use a server that sends SourceTimestamp")
    return (stamp if stamp.tzinfo else stamp.replace(tzinfo=UTC)).timestamp()


def _value(said: ua.DataValue) -> Value:
    """Return a number or a text; None where the status is not good or it is neither."""
    if said.StatusCode is not None and not said.StatusCode.is_good():
        return None
    value = said.Value.Value if said.Value is not None else None
    if isinstance(value, bool | int | float):
        return float(value) if math.isfinite(value) else None
    return value if isinstance(value, str) else None


async def _browse(
    node: Node,
    above: str,
    found: list[Offered],
    seen: set[ua.NodeId],
    *,
    spaces: list[str],
    deep: int,
) -> None:
    """Collect the variables below a node that are no part of OPC UA itself."""
    for child in await node.get_children():
        if child.nodeid in seen or deep == 0:
            continue
        seen.add(child.nodeid)
        name = (await child.read_browse_name()).Name
        called = f"{above}/{name}" if above else str(name)
        kind = await child.read_node_class()
        if kind == ua.NodeClass.Variable and child.nodeid.NamespaceIndex > 0:
            said = await child.read_data_value(raise_on_bad_status=False)
            type_name = said.Value.VariantType.name if said.Value is not None else ""
            item = _by_uri(child.nodeid, spaces)
            found.append(Offered(item, called, type_name, "", _value(said)))
        if child.nodeid.NamespaceIndex > 0:
            await _browse(child, called, found, seen, spaces=spaces, deep=deep - 1)


def _by_uri(node: ua.NodeId, spaces: list[str]) -> str:
    """Return a node's id with its namespace's URI."""
    number, _, name = node.to_string().partition(";")
    space = int(number.removeprefix("ns="))
    return f"nsu={spaces[space]};{name}" if space < len(spaces) else node.to_string()
