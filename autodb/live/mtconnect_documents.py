"""Documents of an MTConnect agent: what it offers, what it says, and the parts of its stream."""

import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from typing import Any
from xml.etree import ElementTree

from autodb.live.batch import Said, Value
from autodb.live.source import Away

PART_BYTES = 64 * 2**20
UNAVAILABLE = "UNAVAILABLE"
CONDITIONS = frozenset({"Normal", "Warning", "Fault", "Unavailable"})
FORGOTTEN = "OUT_OF_RANGE"
"""What an agent says of observations that it no longer has (MTConnect, part 1, error codes)."""
Wanted = dict[str, set[str | None]]
"""Of each data item, by number, the parts that are read: None is the whole."""
IN_SPACE = ({"x": 0, "y": 1, "z": 2}, {"a": 0, "b": 1, "c": 2})
"""Places of the parts of three numbers, of positions and of orientations."""
PART_OF = re.compile(r"(?P<item>.+)\[(?P<part>[^\[\]]+)\]")


@dataclass(frozen=True)
class MtDataItem:
    """A data item of a device: ``rate_hz`` of a time series, where it says one; ``parts`` of one
    that is several numbers."""

    number: str
    name: str
    category: str
    kind: str
    unit: str
    rate_hz: float | None
    parts: tuple[str, ...] = ()


Mark = tuple[int, str, str]
"""An observation by which a stream is known again: its number, data item and timestamp."""


@dataclass(frozen=True)
class MtDocument:
    """What a document says: its header, and values by data item.

    ``mark``: the newest observation in it that is no condition, of which several hold at a time.
    """

    header: dict[str, str]
    values: Said
    mark: Mark | None = None

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


class Forgotten(Away):
    """What is asked for went out of the agent's buffer before it was read."""


_HEAD_ENDS = re.compile(rb"(?<=[^\r\n])(\r\n\r\n|\n\n)")
"""An empty line behind a header; some agents write bare line feeds."""


class StreamParts:
    """Takes the parts out of a multipart answer (RFC 2046) as its bytes come in."""

    def __init__(self) -> None:
        self._bytes = bytearray()

    def feed(self, some: bytes) -> list[bytes]:
        """Take bytes; return the parts that are whole. Raises ValueError for what is no part."""
        self._bytes += some
        found = []
        while (head := _HEAD_ENDS.search(self._bytes)) is not None:
            end = head.end() + _length(bytes(self._bytes[: head.start()]))
            if len(self._bytes) < end:
                break
            found.append(bytes(self._bytes[head.end() : end]))
            del self._bytes[:end]
        if len(self._bytes) > PART_BYTES:
            raise ValueError(f"a part of its stream is over {PART_BYTES} bytes long")
        return found


def _length(head: bytes) -> int:
    for line in head.splitlines():
        name, _, value = line.partition(b":")
        if name.strip().lower() == b"content-length" and value.strip().isdigit():
            return int(value)
    raise ValueError("its sample stream has a part without Content-length")


def _local(tag: str) -> str:
    """Return a tag without its namespace, which differs from version to version."""
    return tag.rpartition("}")[2]


def data_items(text: bytes) -> list[MtDataItem]:
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
                MtDataItem(
                    number=one.get("id", ""),
                    name=one.get("name", ""),
                    category=one.get("category", ""),
                    kind=one.get("type", ""),
                    unit=(one.get("units") or one.get("nativeUnits") or "").removesuffix(IN_3D),
                    rate_hz=None if rate is None else float(rate),
                    parts=_parts_in_space(one),
                )
            )
    return found


IN_3D = "_3D"


def _parts_in_space(one: ElementTree.Element) -> tuple[str, ...]:
    """Return the parts of a data item of three numbers, else none."""
    if not (one.get("units") or "").endswith(IN_3D):
        return ()
    turns = (one.get("units") or "").startswith("DEGREE")
    return tuple(IN_SPACE[turns])


def keys_said(text: bytes) -> dict[str, tuple[str, ...]]:
    """Return the keys of each set of data in a document of streams, by data item."""
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise Away(f"what the agent says cannot be read ({error})") from None
    found: dict[str, tuple[str, ...]] = {}
    for one in root.iter():
        keys = tuple(entry.get("key", "") for entry in one if _local(entry.tag) == "Entry")
        if keys:
            number = one.get("dataItemId", "")
            found[number] = tuple(dict.fromkeys((*found.get(number, ()), *keys)))
    return found


def part_key(number: str, part: str | None) -> str:
    """Return how a data item, or a part of it, is called."""
    return number if part is None else f"{number}[{part}]"


def name_and_part(item: str, known: Mapping[str, object]) -> tuple[str, str | None]:
    """Return the data item that an item names, and the part of it; a name itself may have [ ]."""
    found = None if item in known else PART_OF.fullmatch(item)
    return (item, None) if found is None else (found["item"], found["part"])


def read_streams(text: bytes, rates: dict[str, float | None], wanted: Wanted) -> MtDocument:
    """Read a document of streams; raises ValueError, ParseError for what is none, or Forgotten."""
    root = ElementTree.fromstring(text)
    if _local(root.tag) == "MTConnectError":
        if any(one.get("errorCode") == FORGOTTEN for one in root.iter()):
            raise Forgotten(
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
        for part in wanted[number]:
            instants, said = _observed(one, rates.get(number), part)
            if instants:
                before = values.setdefault(part_key(number, part), ([], []))
                before[0].extend(instants)
                before[1].extend(said)
    return MtDocument(header, values, newest_mark(observed))


def newest_mark(observed: list[ElementTree.Element]) -> Mark | None:
    """Return the newest of some observations that is no condition; None where there is none."""
    marks = [
        (int(one.get("sequence", "0")), str(one.get("dataItemId")), str(one.get("timestamp")))
        for one in observed
        if _local(one.tag) not in CONDITIONS
    ]
    return max(marks, default=None)


def mark_of(text: bytes, item: str) -> Mark | None:
    """Return the newest observation of a data item in a document; None where it has none."""
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise Away(f"what the agent says cannot be read ({error})") from None
    return newest_mark([one for one in root.iter() if one.get("dataItemId") == item])


def refuse_forgotten(text: bytes) -> None:
    """Raise where the body of a refusal says that what was asked for is forgotten."""
    with suppress(ElementTree.ParseError, ValueError):
        read_streams(text, {}, {})


def _observed(
    one: ElementTree.Element, rate_hz: float | None, part: str | None
) -> tuple[list[float], list[Value]]:
    """Return the instants and values of an observation: one, or those of a time series.

    Of a part: none where a set of data does not say it anew.
    """
    last_s = _instant(str(one.get("timestamp")))
    text = (one.text or "").strip()
    if text == UNAVAILABLE:
        return [last_s], [None]
    if part is not None:
        entries = [entry for entry in one if _local(entry.tag) == "Entry"]
        if entries:
            own = [entry for entry in entries if entry.get("key") == part]
            return [last_s] * len(own), [_entry(entry) for entry in own]
        return [last_s], [_in_space(text, part)]
    if one.get("sampleCount") is None:
        return [last_s], [_value(one, text)]
    rate = float(one.get("sampleRate", rate_hz or 0.0))
    if rate <= 0.0:
        raise ValueError(f"time series '{one.get('dataItemId')}' says no sampleRate")
    series: list[Any] = [float(cell) for cell in text.split()]
    count = len(series)
    return [last_s - (count - 1 - k) / rate for k in range(count)], series


def _entry(entry: ElementTree.Element) -> Value:
    """Return what an entry of a set of data says; None where it was taken out."""
    text = (entry.text or "").strip()
    return None if entry.get("removed") == "true" or not text else _value(entry, text)


def _in_space(text: str, part: str) -> Value:
    """Return one of three numbers; None where there is none such."""
    cells = text.split()
    place = next((own[part] for own in IN_SPACE if part in own), None)
    if place is None or place >= len(cells):
        return None
    return float(cells[place])


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
