"""`python -m benchmarks.hostile [REQUESTS]`: look-ups beside those who mean ill, and memory.

Twenty seconds of look-ups at a steady rate, quiet and beside sixteen connections of another process
that mean ill, in turn: a header line without an end, headers byte by byte, thousands of headers,
tokens that are guessed, what is no HTTP, a body that never comes, blank lines, silence. Each
connects again as soon as it is thrown out. Then REQUESTS (50 000) mixed requests, and the service's
memory after a tenth of them and after all.
"""

import asyncio
import contextlib
import multiprocessing
import sys
import tempfile
from collections.abc import Awaitable, Callable, Sequence
from pathlib import Path

import numpy as np

from benchmarks.fleet_lookups import fill
from benchmarks.serving import API, Asker, asked, memory_mb, request_of, served

VERSIONS, MACHINES, SECONDS = 1, 20, 20.0
HOSTILE, AGAIN_S, SLOW_S = 16, 0.05, 0.2
TIMES, GROWN_MB = 3.0, 8.0
"""Limits: how many times longer look-ups take at p99; what memory may grow by."""
REQUESTS, ASKERS = 50_000, 16
Ill = Callable[[asyncio.StreamReader, asyncio.StreamWriter], Awaitable[None]]


def _repeated(begin: bytes, piece: bytes, pause_s: float = 0.0) -> Ill:
    async def send(_reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.write(begin)
        while not writer.is_closing():
            writer.write(piece)
            await writer.drain()
            await asyncio.sleep(pause_s)

    return send


async def _guessed(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    while not reader.at_eof():
        writer.write(
            f"GET {API}/machines HTTP/1.1\r\nHost: localhost\r\n"
            "Authorization: Bearer autodb_guess\r\n\r\n".encode()
        )
        await writer.drain()
        await reader.read(4096)
        await asyncio.sleep(AGAIN_S)


async def _silent(reader: asyncio.StreamReader, _writer: asyncio.StreamWriter) -> None:
    await reader.read()


BEGUN = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n"
ILL: Sequence[Ill] = (
    _repeated(BEGUN + b"X-Long: ", b"x" * 65536),
    _repeated(BEGUN, b"X: y\r\n", SLOW_S),
    _repeated(BEGUN, b"".join(b"X-%d: y\r\n" % n for n in range(2000))),
    _guessed,
    _repeated(b"", bytes(range(256)) * 64),
    _repeated(b"POST " + API.encode() + b"/machines/lathe-1/lookup/batch HTTP/1.1\r\n"
              b"Host: localhost\r\nContent-Length: 60000000\r\n\r\n", b"{", SLOW_S),
    _repeated(b"", b"\r\n" * 100, AGAIN_S),
    _silent,
)  # fmt: skip


def mean_ill(port: int) -> None:
    """Keep sixteen hostile connections up, for ever."""

    async def one(ill: Ill) -> None:
        while True:
            with contextlib.suppress(OSError):
                reader, writer = await asyncio.open_connection("127.0.0.1", port)
                with contextlib.suppress(OSError):
                    await ill(reader, writer)
                writer.close()
            await asyncio.sleep(AGAIN_S)

    async def every() -> None:
        await asyncio.gather(*(one(ILL[k % len(ILL)]) for k in range(HOSTILE)))

    asyncio.run(every())


def look_ups(port: int, what: str) -> float:
    """Print and return the 99th percentile of look-ups' times, ms."""
    load = asyncio.run(asked(port, SECONDS, np.random.default_rng(4), MACHINES))
    p50, p99 = np.percentile(load.took_ms, [50, 99])
    failed = sum(status != 200 for status in load.statuses)
    print(f"{what}: p50 {p50:.1f} ms, p99 {p99:.1f} ms, {failed} failed", flush=True)
    assert not failed
    return float(p99)


def _mixed(rng: np.random.Generator) -> bytes:
    """Return a request of some kind: most are answered, some are wrong."""
    kinds = (
        request_of(rng, MACHINES),
        request_of(rng, MACHINES).replace(b"depth_mm=", b"depth_mm=-"),
        b"GET /machines/lathe-3 HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"GET /no/such/page HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"GET " + API.encode() + b"/machines HTTP/1.1\r\nHost: localhost\r\n"
        b'If-None-Match: W/"x", *\r\n\r\n',
        b"GET " + API.encode() + b"/machines HTTP/1.1\r\nHost: localhost\r\n"
        b"Authorization: Bearer autodb_wrong\r\n\r\n",
    )
    return kinds[rng.choice(len(kinds), p=[0.6, 0.1, 0.02, 0.1, 0.1, 0.08])]


def mixed(port: int, process: int, count: int) -> float:
    """Send mixed requests; print and return what memory grew by after the first tenth, MB."""
    rng = np.random.default_rng(9)

    async def send(number: int) -> None:
        askers = [Asker(port) for _ in range(ASKERS)]

        async def some(asker: Asker, how_many: int) -> None:
            for _ in range(how_many):
                await asker.ask(_mixed(rng))

        await asyncio.gather(*(some(asker, number // ASKERS) for asker in askers))

    asyncio.run(send(count // 10))
    early = memory_mb(process, "VmRSS")
    asyncio.run(send(count - count // 10))
    late = memory_mb(process, "VmRSS")
    print(f"{count} mixed requests: memory {early:.0f} MB after a tenth, {late:.0f} MB after all")
    return late - early


def main() -> None:
    """Measure, and end with 1 where a limit is missed."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else REQUESTS
    with tempfile.TemporaryDirectory() as folder:
        url = f"sqlite:///{Path(folder) / 'autodb.sqlite3'}"
        fill(url, VERSIONS, Path(folder) / "autodb.sqlite3")
        with served(url) as (at, process):
            port = int(at.rpartition(":")[2])
            asyncio.run(asked(port, 3.0, np.random.default_rng(3), MACHINES))
            quiet_ms = look_ups(port, "quiet")
            ill = multiprocessing.get_context("spawn").Process(target=mean_ill, args=(port,))
            ill.start()
            try:
                beside_ms = look_ups(port, f"beside {HOSTILE} hostile connections")
            finally:
                ill.kill()
                ill.join()
            grown_mb = mixed(port, process, count)
    met = beside_ms <= TIMES * quiet_ms and grown_mb <= GROWN_MB
    print(
        f"p99 {beside_ms / quiet_ms:.2f} × quiet (limit {TIMES:g}), memory grew by {grown_mb:.1f} "
        f"MB (limit {GROWN_MB:g}): {'passed' if met else 'missed'}"
    )
    sys.exit(not met)


if __name__ == "__main__":
    main()
