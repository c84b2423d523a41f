"""A virtual machine behind an MTConnect agent: probe, current, and the sample stream, over HTTP.

Made after the standard (ANSI/MTC1.4-2018, parts 1 and 2), as far as a reader of streams notices it:
observations numbered through in a buffer of limited length, parts with Content-length, heartbeats,
a new instance and an empty buffer at each start.
"""

import asyncio
import contextlib
import itertools
import time
from collections import deque
from dataclasses import dataclass
from datetime import UTC, datetime
from urllib.parse import parse_qs, urlsplit

from autodb.proofs.machines.served.shift import STATE, ServedShift

BUFFER = 131_072
BOUNDARY = "part-of-a-stream"
SERIES_S = 0.05
"""Length of one time series."""
NAMESPACE = "urn:mtconnect.org:MTConnectStreams:1.4"


@dataclass(frozen=True)
class _Observation:
    sequence: int
    item: str
    xml: str


class MtConnectServer:
    """An agent on loopback; ``port`` 0 takes one that is free.

    ``buffer``: how many observations it keeps.
    """

    def __init__(self, shift: ServedShift, *, port: int = 0, buffer: int = BUFFER) -> None:
        self._shift, self.port = shift, port
        self._kept: deque[_Observation] = deque(maxlen=buffer)
        self._latest: dict[str, _Observation] = {}
        self._next, self._row, self._sent = 1, 0, 0
        self._instance = time.time_ns() // 1000
        self._server: asyncio.Server | None = None
        self._more = asyncio.Event()
        self._writers: set[asyncio.StreamWriter] = set()

    @property
    def url(self) -> str:
        """Where it is read."""
        return f"http://127.0.0.1:{self.port}"

    async def start(self) -> None:
        """Listen; the observations before are gone."""
        self._instance = max(self._instance + 1, time.time_ns() // 1000)
        self._next, self._sent = 1, 0
        self._kept.clear()
        for item in [*self._shift.columns, *self._shift.states]:
            if item in self._latest:
                self._say(item, self._latest[item].xml)
            else:
                self._say(item, self._element(item, "UNAVAILABLE", self._shift.start_s))
        self._server = await asyncio.start_server(self._serve, "127.0.0.1", self.port)
        self.port = self._server.sockets[0].getsockname()[1]

    async def stop(self) -> None:
        """End every stream and listen no more."""
        if self._server is not None:
            self._server.close()
            for writer in self._writers:
                writer.transport.abort()
            await self._server.wait_closed()
            self._server = None

    @property
    def done(self) -> bool:
        """Whether the shift is over."""
        return self._row >= self._shift.rows

    @property
    def heard(self) -> bool:
        """Whether a stream was sent all that was said."""
        return self._sent >= self._next

    async def play(self, *, speed: float, upto: int | None = None) -> None:
        """Say the shift, from where it was on, ``speed`` times as fast as it was."""
        rows = max(1, round(SERIES_S * self._shift.rate_hz))
        end = self._shift.rows if upto is None else upto
        began, first = time.monotonic(), self._row
        while self._row < end:
            self._play(min(self._row + rows, end))
            due = began + (self._row - first) / self._shift.rate_hz / speed
            await asyncio.sleep(max(0.0, due - time.monotonic()))

    def _play(self, end: int) -> None:
        shift, begin = self._shift, self._row
        for row in range(begin, end):
            for name, value in shift.at(row).items():
                self._say(name, self._element(name, _text(value), shift.instant_s(row)))
        last_s = shift.instant_s(end - 1)
        for name in shift.columns:
            values = " ".join(repr(float(value)) for value in shift.values(name, begin, end))
            series = f'sampleCount="{end - begin}" sampleRate="{shift.rate_hz:g}"'
            self._say(name, self._element(name, values, last_s, series))
        self._row = end
        self._more.set()
        self._more = asyncio.Event()

    def _say(self, item: str, xml: str) -> None:
        self._latest[item] = _Observation(self._next, item, xml)
        self._kept.append(self._latest[item])
        self._next += 1

    def _element(self, item: str, text: str, instant_s: float, more: str = "") -> str:
        stamp = datetime.fromtimestamp(instant_s, UTC).isoformat().replace("+00:00", "Z")
        tag = "LoadTimeSeries" if item in self._shift.columns else "Message"
        return (
            f'<{tag} dataItemId="{_number(item)}" name="{item}" sequence="%d" '
            f'timestamp="{stamp}" {more}>{text}</{tag}>'
        )

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._writers.add(writer)
        with contextlib.suppress(ConnectionError, asyncio.IncompleteReadError):
            while True:
                request = (await reader.readuntil(b"\r\n\r\n")).decode()
                asked = urlsplit(request.split(" ")[1])
                query = {key: values[0] for key, values in parse_qs(asked.query).items()}
                what = asked.path.rpartition("/")[2]
                if what == "sample" and "interval" in query:
                    await self._stream(writer, query)
                    break
                body = self._probe() if what == "probe" else self._current(query)
                head = f"HTTP/1.1 200 OK\r\nContent-Type: text/xml\r\nContent-Length: {len(body)}"
                writer.write(f"{head}\r\n\r\n".encode() + body)
                await writer.drain()
        self._writers.discard(writer)
        writer.close()

    async def _stream(self, writer: asyncio.StreamWriter, query: dict[str, str]) -> None:
        kind = f"multipart/x-mixed-replace;boundary={BOUNDARY}"
        writer.write(f"HTTP/1.1 200 OK\r\nContent-Type: {kind}\r\n\r\n".encode())
        following, count = int(query["from"]), int(query.get("count", "100"))
        pause_s = int(query["interval"]) / 1000.0
        heartbeat_s = int(query.get("heartbeat", "10000")) / 1000.0
        path = query.get("path", "")
        while True:
            if following >= self._next:
                with contextlib.suppress(TimeoutError):
                    async with asyncio.timeout(heartbeat_s):
                        await self._more.wait()
            first = self._kept[0].sequence
            if following < first:
                body = _error(f"'from' must be at least {first}")
            else:
                behind = following - first
                some = list(itertools.islice(self._kept, behind, behind + count))
                following = some[-1].sequence + 1 if some else following
                body = self._streams([one for one in some if _asked(one, path)], following)
            part = f"--{BOUNDARY}\r\nContent-type: text/xml\r\nContent-length: {len(body)}"
            writer.write(f"{part}\r\n\r\n".encode() + body + b"\r\n")
            await writer.drain()
            self._sent = following
            if following >= self._next:
                await asyncio.sleep(pause_s)

    def _current(self, query: dict[str, str]) -> bytes:
        if "at" not in query:
            return self._streams(list(self._latest.values()), self._next)
        latest = {one.item: one for one in self._kept if one.sequence <= int(query["at"])}
        return self._streams(list(latest.values()), self._next)

    def _streams(self, observations: list[_Observation], following: int) -> bytes:
        said = "".join(one.xml.replace("%d", str(one.sequence)) for one in observations)
        header = (
            f'<Header instanceId="{self._instance}" bufferSize="{self._kept.maxlen}" '
            f'firstSequence="{self._kept[0].sequence}" lastSequence="{self._next - 1}" '
            f'nextSequence="{following}"/>'
        )
        device = f'<DeviceStream name="virtual"><ComponentStream>{said}</ComponentStream>'
        return (
            f'<?xml version="1.0"?><MTConnectStreams xmlns="{NAMESPACE}">{header}<Streams>{device}'
            "</DeviceStream></Streams></MTConnectStreams>"
        ).encode()

    def _probe(self) -> bytes:
        rate = f'representation="TIME_SERIES" sampleRate="{self._shift.rate_hz:g}"'
        items = [
            f'<DataItem id="{_number(name)}" name="{name}" category="SAMPLE" type="LOAD" {rate}/>'
            for name in self._shift.columns
        ]
        items += [
            f'<DataItem id="{_number(name)}" name="{name}" category="EVENT" type="MESSAGE"/>'
            for name in self._shift.states
        ]
        device = f'<Device name="virtual"><DataItems>{"".join(items)}</DataItems></Device>'
        return f"<MTConnectDevices><Devices>{device}</Devices></MTConnectDevices>".encode()


def _number(item: str) -> str:
    return "d_" + item.replace(".", "_")


def _asked(one: _Observation, path: str) -> bool:
    return not path or f'@id="{_number(one.item)}"' in path


def _text(value: STATE) -> str:
    return value if isinstance(value, str) else f"{value:g}"


def _error(text: str) -> bytes:
    inner = f'<Errors><Error errorCode="OUT_OF_RANGE">{text}</Error></Errors>'
    return f"<MTConnectError>{inner}</MTConnectError>".encode()
