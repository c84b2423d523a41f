"""A machine read from an MTConnect agent's sample stream.

The stream is HTTP: parts of one long answer, each an XML document with the observations since the
last, numbered through by the agent. The number up to which we have read is the position that we go
on from; an agent that was started anew says another instance, and begins to count again.

MTConnect standard, parts 1 and 2 (ANSI/MTC1.4-2018; model.mtconnect.org): an observation that does
not change is not said again; a time series carries the instant of its last value.
"""

from collections.abc import AsyncGenerator
from contextlib import aclosing, suppress
from dataclasses import dataclass
from datetime import datetime
from typing import Any
from urllib.parse import urlsplit
from xml.etree import ElementTree

import httpx

from autodb.errors import UnusableInput
from autodb.live.agentfile import AgentFile
from autodb.live.batch import Batch, Position, Said, Value
from autodb.live.source import Away, Offered, SourceClock, unknown_item

HEARTBEAT_S = 1.0
TIMEOUT_S = 10.0
"""How long an agent may say nothing, heartbeats neither, before it counts as away. Chosen."""
OBSERVATIONS = 10_000
"""How many one part of the stream holds at most, where the agent keeps that many."""
PART_BYTES = 64 * 2**20
UNAVAILABLE = "UNAVAILABLE"
FORGOTTEN = "OUT_OF_RANGE"
"""What an agent says of observations that it no longer has (MTConnect, part 1, error codes)."""


@dataclass(frozen=True)
class _DataItem:
    """A data item of a device: ``rate_hz`` of a time series, where it says one."""

    number: str
    name: str
    category: str
    kind: str
    unit: str
    rate_hz: float | None


@dataclass(frozen=True)
class _Document:
    """What a document says: its header, and values by data item."""

    header: dict[str, str]
    values: Said

    @property
    def following(self) -> int:
        """The number of the next observation."""
        return int(self.header.get("nextSequence", "0"))

    @property
    def first(self) -> int:
        """The number of the first observation that the agent still has."""
        return int(self.header.get("firstSequence", "0"))

    @property
    def instance(self) -> str:
        """What an agent says to tell one of its starts from the next."""
        return self.header.get("instanceId", "")


class _Forgotten(Away):
    """What is asked for went out of the agent's buffer before it was read."""


class MtConnect:
    """A source that reads an MTConnect agent."""

    def __init__(self, plan: AgentFile) -> None:
        self._items, self._source = plan.items(), plan.source
        self._channels = [one.item for one in plan.channels.values()]
        device = f"/{plan.source.device}" if plan.source.device else ""
        self._url = plan.source.url.rstrip("/")
        self._base = f"{self._url}{device}"
        self._names: dict[str, str] = {}
        self._rates: dict[str, float | None] = {}

    async def offered(self) -> list[Offered]:
        """Return the data items of the device, with what they say now."""
        async with self._client() as client:
            items = _data_items(await self._get(client, "probe"))
            now = _document(await self._get(client, "current"), {}, {one.number for one in items})
        last = {number: said[1][-1] for number, said in now.values.items()}
        return [
            Offered(
                one.number, one.name, f"{one.category} {one.kind}", one.unit, last.get(one.number)
            )
            for one in items
        ]

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
                except _Forgotten:
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
        begin, gap, state = now.following, False, now
        if after is not None:
            same = after.get("instance") == now.instance
            begin = int(after["next"]) if same else now.first
            gap = not same or begin < now.first
            begin = max(begin, now.first)
            if gap:
                state = self._read(await self._get(client, "current", at=begin))
        if forgot and not gap:
            raise Away(f"{self._url}: says {FORGOTTEN} of observations that it has")
        clock = SourceClock(self._channels, float("-inf") if after is None else after["upto_s"])
        if after is None or gap:
            for batch in _batches(clock, state, begin, begin, gap=gap):
                yield batch
        async with aclosing(self._parts(client, begin, now)) as parts:
            async for part in parts:
                document = self._read(part)
                if document.instance != now.instance:
                    raise Away(f"{self._url}: the agent was started anew")
                for batch in _batches(clock, document, begin, document.following):
                    yield batch
                begin = document.following

    def _client(self) -> httpx.AsyncClient:
        if urlsplit(self._url).scheme not in ("http", "https"):
            raise Away(f"{self._url}: is not an address; use http://HOST:5000")
        return httpx.AsyncClient(timeout=TIMEOUT_S, trust_env=False)

    async def _get(self, client: httpx.AsyncClient, what: str, **query: int) -> bytes:
        try:
            answer = await client.get(f"{self._base}/{what}", params=query)
            if answer.is_error:
                _refuse_forgotten(answer.content)
            answer.raise_for_status()
        except httpx.HTTPError as error:
            raise self._away(error) from None
        return answer.content

    def _away(self, error: Exception) -> Away:
        said = str(error).splitlines()
        return Away(f"{self._url}: {said[0] if said else type(error).__name__}")

    async def _resolve(self, client: httpx.AsyncClient) -> None:
        """Find the data items by number or name; raises UnusableInput where there is none."""
        known = _data_items(await self._get(client, "probe"))
        by_name = {one.name: one for one in known if one.name} | {one.number: one for one in known}
        for item in self._items:
            if item not in by_name:
                raise unknown_item(self._url, item, by_name)
        self._names = {by_name[item].number: item for item in self._items}
        if len(self._names) < len(self._items):
            twice = next(one for one in self._items if one not in self._names.values())
            other = self._names[by_name[twice].number]
            raise UnusableInput(
                f"{self._url}: '{twice}' and '{other}' are one item; use one name for it"
            )
        self._rates = {number: by_name[number].rate_hz for number in self._names}

    def _read(self, text: bytes) -> _Document:
        try:
            found = _document(text, self._rates, set(self._names))
        except (ElementTree.ParseError, ValueError) as error:
            raise Away(f"{self._url}: what it says cannot be read ({error})") from None
        values = {self._names[number]: said for number, said in found.values.items()}
        return _Document(found.header, values)

    async def _parts(
        self, client: httpx.AsyncClient, begin: int, now: _Document
    ) -> AsyncGenerator[bytes, None]:
        """Yield the documents of a stream."""
        most = int(now.header.get("bufferSize", OBSERVATIONS))
        query: dict[str, str | int] = {
            "from": begin,
            "interval": round(self._source.publish_ms),
            "heartbeat": round(1000 * HEARTBEAT_S),
            "count": min(OBSERVATIONS, most),
            "path": " | ".join(f'//DataItem[@id="{number}"]' for number in self._names),
        }
        parts = _Parts()
        try:
            async with client.stream("GET", f"{self._base}/sample", params=query) as answer:
                if answer.is_error:
                    _refuse_forgotten(await answer.aread())
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
    clock: SourceClock, document: _Document, begin: int, following: int, *, gap: bool = False
) -> list[Batch]:
    """Return the batches of a document; after the last it goes on behind it, else from before."""
    parts = clock.heard(document.values)
    found = []
    for number, part in enumerate(parts, start=1):
        behind = following if number == len(parts) else begin
        position = {"instance": document.instance, "next": behind, "upto_s": part.upto_s}
        first = number == 1
        found.append(Batch(part.values, part.upto_s, position, gap=gap and first, jump=part.jump))
    return found


class _Parts:
    """Takes the parts out of a multipart answer (RFC 2046) as its bytes come in."""

    def __init__(self) -> None:
        self._bytes = bytearray()

    def feed(self, some: bytes) -> list[bytes]:
        """Take bytes; return the parts that are whole. Raises ValueError for what is no part."""
        self._bytes += some
        found = []
        while (head := self._bytes.find(b"\r\n\r\n")) >= 0:
            length = _length(bytes(self._bytes[:head]))
            end = head + 4 + length
            if len(self._bytes) < end:
                break
            found.append(bytes(self._bytes[head + 4 : end]))
            del self._bytes[:end]
        if len(self._bytes) > PART_BYTES:
            raise ValueError(f"a part of its stream is over {PART_BYTES} bytes long")
        return found


def _length(head: bytes) -> int:
    for line in head.split(b"\r\n"):
        name, _, value = line.partition(b":")
        if name.strip().lower() == b"content-length" and value.strip().isdigit():
            return int(value)
    raise ValueError("its sample stream has a part without Content-length")


def _local(tag: str) -> str:
    """Return a tag without its namespace, which differs from version to version."""
    return tag.rpartition("}")[2]


def _data_items(text: bytes) -> list[_DataItem]:
    """Return the data items of a probe."""
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise Away(f"what the agent says of its devices cannot be read ({error})") from None
    found = []
    for one in root.iter():
        if _local(one.tag) == "DataItem":
            rate = one.get("sampleRate")
            found.append(
                _DataItem(
                    number=one.get("id", ""),
                    name=one.get("name", ""),
                    category=one.get("category", ""),
                    kind=one.get("type", ""),
                    unit=one.get("nativeUnits") or one.get("units") or "",
                    rate_hz=None if rate is None else float(rate),
                )
            )
    return found


def _document(text: bytes, rates: dict[str, float | None], wanted: set[str]) -> _Document:
    """Read a document of streams; raises ValueError, ParseError for what is none, or _Forgotten."""
    root = ElementTree.fromstring(text)
    if _local(root.tag) == "MTConnectError":
        if any(one.get("errorCode") == FORGOTTEN for one in root.iter()):
            raise _Forgotten(
                "the agent's buffer overflows faster than it is read; make the buffer larger"
            )
        faults = [one.text or "" for one in root.iter() if _local(one.tag) == "Error"]
        raise ValueError("; ".join(faults) or "an error without words")
    header = next((dict(one.attrib) for one in root.iter() if _local(one.tag) == "Header"), {})
    observed = [
        one
        for one in root.iter()
        if one.get("dataItemId") in wanted and one.get("timestamp") is not None
    ]
    values: Said = {}
    for one in sorted(observed, key=lambda one: int(one.get("sequence", "0"))):
        number = str(one.get("dataItemId"))
        instants, said = _observed(one, rates.get(number))
        if instants:
            before = values.setdefault(number, ([], []))
            before[0].extend(instants)
            before[1].extend(said)
    return _Document(header, values)


def _refuse_forgotten(text: bytes) -> None:
    """Raise where the body of a refusal says that what was asked for is forgotten."""
    with suppress(ElementTree.ParseError, ValueError):
        _document(text, {}, set())


def _observed(one: ElementTree.Element, rate_hz: float | None) -> tuple[list[float], list[Value]]:
    """Return the instants and values of an observation: one, or those of a time series."""
    last_s = _instant(str(one.get("timestamp")))
    text = (one.text or "").strip()
    if text == UNAVAILABLE:
        return [last_s], [None]
    if one.get("sampleCount") is None:
        return [last_s], [_value(one, text)]
    rate = float(one.get("sampleRate", rate_hz or 0.0))
    if rate <= 0.0:
        raise ValueError(f"time series '{one.get('dataItemId')}' says no sampleRate")
    series: list[Any] = [float(cell) for cell in text.split()]
    count = len(series)
    return [last_s - (count - 1 - k) / rate for k in range(count)], series


def _value(one: ElementTree.Element, text: str) -> Value:
    """Return a number where it is one, else the text; of a condition, its level."""
    if not text:
        return _local(one.tag)
    try:
        return float(text)
    except ValueError:
        return text


def _instant(stamp: str) -> float:
    """Return seconds since 1970 of a timestamp, which may be followed by '@' and a duration."""
    return datetime.fromisoformat(stamp.partition("@")[0]).timestamp()
