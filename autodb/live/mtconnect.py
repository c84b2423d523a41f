"""A machine read from an MTConnect agent's sample stream.

The stream is HTTP: parts of one long answer, each an XML document with the observations since the
last, numbered through by the agent. The number up to which we have read is the position that we go
on from; an agent that was started anew says another instance, and begins to count again.

MTConnect standard, parts 1 and 2 (ANSI/MTC1.4-2018; model.mtconnect.org): an observation that does
not change is not said again; a time series carries the instant of its last value. Of three numbers
in space, and of a set of data, an item is one: `position[x]`, `variables[R10]`. A value is in the
`units` of its data item, whatever units the device has by itself (`nativeUnits`).
"""

from collections.abc import AsyncGenerator
from contextlib import aclosing
from urllib.parse import urlsplit
from xml.etree import ElementTree

import httpx

from autodb.errors import UnusableInput
from autodb.live.agentfile import AgentFile
from autodb.live.batch import Batch, Position
from autodb.live.mtconnect_documents import (
    FORGOTTEN,
    Forgotten,
    Mark,
    MtDocument,
    StreamParts,
    Wanted,
    data_items,
    keys_said,
    mark_of,
    name_and_part,
    part_key,
    read_streams,
    refuse_forgotten,
)
from autodb.live.source import Away, Offered, SourceClock, unknown_item

HEARTBEAT_S = 1.0
TIMEOUT_S = 10.0
"""How long an agent may say nothing, heartbeats neither, before it counts as away. Chosen."""
OBSERVATIONS = 10_000
"""How many one part of the stream holds at most, where the agent keeps that many."""


class MtConnect:
    """A source that reads an MTConnect agent."""

    def __init__(self, plan: AgentFile) -> None:
        self._items, self._source = plan.items(), plan.source
        self._channels = [one.item for one in plan.channels.values()]
        device = f"/{plan.source.device}" if plan.source.device else ""
        self._url = plan.source.url.rstrip("/")
        self._base = f"{self._url}{device}"
        self._names: dict[tuple[str, str | None], str] = {}
        self._units: dict[str, str] = {}
        self._rates: dict[str, float | None] = {}

    async def offered(self) -> list[Offered]:
        """Return the data items of the device, with what they say now."""
        async with self._client() as client:
            items = data_items(await self._get(client, "probe"))
            text = await self._get(client, "current")
        keys = keys_said(text)
        parts = {one.number: one.parts or keys.get(one.number, ()) for one in items}
        wanted: Wanted = {number: set(own) or {None} for number, own in parts.items()}
        now = read_streams(text, {}, wanted)
        last = {number: said[1][-1] for number, said in now.values.items()}
        return [
            Offered(item, one.name, f"{one.category} {one.kind}".strip(), one.unit, last.get(item))
            for one in items
            for item in [part_key(one.number, part) for part in parts[one.number] or (None,)]
        ]

    async def units(self) -> dict[str, str]:
        """Return the units that items are sent in, where they are said; raises Away."""
        async with self._client() as client:
            await self._resolve(client)
        return {
            item: self._units[number] for (number, _), item in self._names.items()
            if self._units[number]
        }  # fmt: skip

    async def batches(self, after: Position | None) -> AsyncGenerator[Batch, None]:
        """Yield what the agent says, from behind ``after`` as far as it still has it.

        What went out of its buffer before it was read is a gap, now as after a pause.
        """
        async with self._client() as client:
            await self._resolve(client)
            forgot = False
            while True:
                try:
                    async with aclosing(self._behind(client, after, forgot=forgot)) as batches:
                        async for batch in batches:
                            after, forgot = batch.position, False
                            yield batch
                except Forgotten:
                    if forgot:
                        raise
                    forgot = True

    async def _behind(
        self, client: httpx.AsyncClient, after: Position | None, *, forgot: bool
    ) -> AsyncGenerator[Batch, None]:
        """Yield what is said behind a position, until the agent is away or has forgotten it.

        ``forgot``: it said so of this position, and must have a later beginning.
        """
        now = self._read(await self._get(client, "current"))
        begin, why, state = now.following, "", now
        if after is not None:
            begin, why = await self._begin(client, after, now)
            if why:
                state = self._read(await self._get(client, "current", at=begin))
        if forgot and not why:
            raise Away(f"{self._url}: says {FORGOTTEN} of observations that it has")
        clock = SourceClock(self._channels, float("-inf") if after is None else after["upto_s"])
        heard = None if after is None or why else after.get("heard")
        if after is None or why:
            for batch in _batches(clock, state, begin, begin, heard, why=why):
                yield batch
            heard = state.mark
        async with aclosing(self._parts(client, begin, now)) as parts:
            async for part in parts:
                document = self._read(part)
                if document.instance != now.instance:
                    raise Away(f"{self._url}: the agent was started anew")
                for batch in _batches(clock, document, begin, document.following, heard):
                    yield batch
                begin, heard = document.following, document.mark or heard

    async def _begin(
        self, client: httpx.AsyncClient, after: Position, now: MtDocument
    ) -> tuple[int, str]:
        """Return the number to go on from behind a position, and why there is a gap before it.

        An agent that was started anew says so by its instance. One that kept that counts from the
        beginning: it has not come as far as we were, or what it has in the place of what we heard
        last is another observation.
        """
        begin = int(after["next"])
        if after.get("instance") != now.instance or begin > now.following:
            return now.first, "the agent was started anew"
        if begin < now.first:
            return now.first, "the agent's buffer has no more all that was said meanwhile"
        if await self._is_another(client, after, now):
            return now.first, "the agent was started anew, and says its old instance"
        return begin, ""

    async def _is_another(
        self, client: httpx.AsyncClient, after: Position, now: MtDocument
    ) -> bool:
        """Say whether an agent has something else where we heard the last observation.

        It cannot be known where that went out of its buffer.
        """
        heard = after.get("heard")
        if heard is None:
            return False
        at = max(int(after["next"]) - 1, int(heard[0]))
        if at < now.first or at >= now.following:
            return at >= now.following
        there = mark_of(await self._get(client, "current", at=at), heard[1])
        return there is not None and there != tuple(heard)

    def _client(self) -> httpx.AsyncClient:
        if urlsplit(self._url).scheme not in ("http", "https"):
            raise Away(f"{self._url}: is not an address; use http://HOST:5000")
        return httpx.AsyncClient(timeout=TIMEOUT_S, trust_env=False)

    async def _get(self, client: httpx.AsyncClient, what: str, **query: int) -> bytes:
        try:
            answer = await client.get(f"{self._base}/{what}", params=query)
            if answer.is_error:
                refuse_forgotten(answer.content)
            answer.raise_for_status()
        except httpx.HTTPError as error:
            raise self._away(error) from None
        return answer.content

    def _away(self, error: Exception) -> Away:
        said = str(error).splitlines()
        return Away(f"{self._url}: {said[0] if said else type(error).__name__}")

    async def _resolve(self, client: httpx.AsyncClient) -> None:
        """Find the data items by number or name; raises UnusableInput where there is none."""
        known = data_items(await self._get(client, "probe"))
        by_name = {one.name: one for one in known if one.name} | {one.number: one for one in known}
        names: dict[tuple[str, str | None], str] = {}
        for item in self._items:
            name, part = name_and_part(item, by_name)
            if name not in by_name:
                raise unknown_item(self._url, item, by_name)
            own = by_name[name]
            if part is None and own.parts:
                raise UnusableInput(
                    f"{self._url}: '{item}' is {len(own.parts)} numbers; use one of them, like "
                    f"{item}[{own.parts[0]}]"
                )
            other = names.setdefault((own.number, part), item)
            if other != item:
                raise UnusableInput(
                    f"{self._url}: '{item}' and '{other}' are one item; use one name for it"
                )
        self._names = names
        self._rates = {number: by_name[number].rate_hz for number, _ in names}
        self._units = {number: by_name[number].unit for number, _ in names}

    def _read(self, text: bytes) -> MtDocument:
        try:
            found = read_streams(text, self._rates, self._wanted)
        except (ElementTree.ParseError, ValueError) as error:
            raise Away(f"{self._url}: what it says cannot be read ({error})") from None
        called = {part_key(*own): item for own, item in self._names.items()}
        values = {called[key]: said for key, said in found.values.items()}
        return MtDocument(found.header, values, found.mark)

    @property
    def _wanted(self) -> Wanted:
        """What is read of each data item."""
        found: Wanted = {}
        for number, part in self._names:
            found.setdefault(number, set()).add(part)
        return found

    async def _parts(
        self, client: httpx.AsyncClient, begin: int, now: MtDocument
    ) -> AsyncGenerator[bytes, None]:
        """Yield the documents of a stream."""
        most = int(now.header.get("bufferSize", OBSERVATIONS))
        query: dict[str, str | int] = {
            "from": begin,
            "interval": round(self._source.publish_ms),
            "heartbeat": round(1000 * HEARTBEAT_S),
            "count": min(OBSERVATIONS, most),
            "path": " | ".join(f'//DataItem[@id="{number}"]' for number in self._wanted),
        }
        parts = StreamParts()
        try:
            async with client.stream("GET", f"{self._base}/sample", params=query) as answer:
                if answer.is_error:
                    refuse_forgotten(await answer.aread())
                    raise Away(f"{self._url}: answers {answer.status_code} to its sample stream")
                async for some in answer.aiter_bytes():
                    for part in parts.feed(some):
                        yield part
        except httpx.HTTPError as error:
            raise self._away(error) from None
        except ValueError as error:
            raise Away(f"{self._url}: {error}") from None
        raise Away(f"{self._url}: ended its stream")


def _batches(
    clock: SourceClock,
    document: MtDocument,
    begin: int,
    following: int,
    heard: Mark | None,
    *,
    why: str = "",
) -> list[Batch]:
    """Return the batches of a document; after the last it goes on behind it, else from before.

    ``heard``: what was heard last before it; ``why`` there is a gap before it, empty: there is
    none.
    """
    parts = clock.heard(document.values)
    found = []
    for number, part in enumerate(parts, start=1):
        last = number == len(parts)
        position = {
            "instance": document.instance,
            "next": following if last else begin,
            "upto_s": part.upto_s,
            "heard": document.mark or heard if last else heard,
        }
        reason = why if number == 1 else ""
        found.append(
            Batch(part.values, part.upto_s, position, bool(reason), jump=part.jump, why=reason)
        )
    return found
