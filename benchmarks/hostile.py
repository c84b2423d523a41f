"""`python -m benchmarks.hostile [REQUESTS]`: look-ups beside those who mean ill, and memory.

Look-ups at a steady rate: quiet, beside eighteen connections of another process that mean ill, and
beside a process that takes as much of the processors and connects to nothing, so that what the
service lacks is distinguished from what the computer lacks. The three take turns of four seconds,
since others may use the computer too. The connections say a header line without an end, headers
byte by byte, thousands of headers, a body in chunks of one byte that never ends, tokens that are
guessed, what is no HTTP, a body that never comes, blank lines, nothing. Each connects again as soon
as it is thrown out. Then REQUESTS (50 000) mixed requests, and the service's memory meanwhile: it
may grow until every pair that is asked for is kept and every thread has a connection of its own,
which a tenth of them does.
"""

import asyncio
import contextlib
import multiprocessing
import sys
import tempfile
import time
from collections.abc import Awaitable, Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import psutil
from numpy.typing import NDArray

from benchmarks.fleet_lookups import fill
from benchmarks.serving import API, Asker, asked, memory_mb, request_of, served

VERSIONS, MACHINES, RATE = 1, 20, 200
ROUNDS, SECONDS = 6, 4.0
HOSTILE, AGAIN_S, SLOW_S = 18, 0.05, 0.2
TIMES, GROWN_MB = 3.0, 8.0
"""Limits: how many times longer look-ups take at p99; what memory may grow by."""
REQUESTS, ASKERS = 50_000, 16
SEEN_AT = (0.02, 0.1, 0.2, 0.5, 1.0)
"""Shares of the requests after which memory is measured; it may not grow from the second on."""
BUSY_S = 0.01
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
    _repeated(BEGUN + b"Transfer-Encoding: chunked\r\n\r\n", b"1\r\nx\r\n" * 10_000),
    _guessed,
    _repeated(b"", bytes(range(256)) * 64),
    _repeated(b"POST " + API.encode() + b"/machines/lathe-1/lookup/batch HTTP/1.1\r\n"
              b"Host: localhost\r\nContent-Length: 60000000\r\n\r\n", b"{", SLOW_S),
    _repeated(b"", b"\r\n" * 100, AGAIN_S),
    _silent,
)  # fmt: skip


def mean_ill(port: int) -> None:
    """Keep the hostile connections up, for ever."""

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


def keep_busy(share: float) -> None:
    """Use a share of a processor, for ever."""
    while True:
        until = time.process_time() + share * BUSY_S
        while time.process_time() < until:
            pass
        time.sleep((1.0 - share) * BUSY_S)


@contextmanager
def beside(what: Callable[..., None], *args: Any) -> Iterator[psutil.Process]:
    """Have something done in a process of its own."""
    made = multiprocessing.get_context("spawn").Process(target=what, args=args)
    made.start()
    try:
        time.sleep(1.0)  # until it is loaded
        yield psutil.Process(made.pid)
    finally:
        made.kill()
        made.join()


def look_ups(port: int) -> NDArray[np.float64]:
    """Return how long look-ups took, ms, none of which failed."""
    rng = np.random.default_rng(4)
    load = asyncio.run(asked(port, SECONDS, rng, machines=MACHINES, rate=RATE))
    assert all(status == 200 for status in load.statuses)
    return load.took_ms


def used_s(process: psutil.Process) -> float:
    """Return what a process has used of the processors, s."""
    times = process.cpu_times()
    return float(times.user + times.system)


def in_turns(port: int, service: int) -> dict[str, float]:
    """Print and return the 99th percentiles of look-ups' times, ms, by what they are beside."""
    took: dict[str, list[NDArray[np.float64]]] = {"quiet": [], "hostile": [], "busy": []}
    shares = []
    for _ in range(ROUNDS):
        took["quiet"].append(look_ups(port))
        with beside(mean_ill, port) as ill:
            before, begin = (used_s(ill), used_s(psutil.Process(service))), time.monotonic()
            took["hostile"].append(look_ups(port))
            spent = used_s(ill) - before[0], used_s(psutil.Process(service)) - before[1]
            shares.append(np.array(spent) / (time.monotonic() - begin))
        with beside(keep_busy, min(float(shares[-1][0]), 1.0)):
            took["busy"].append(look_ups(port))
    found = {what: float(np.percentile(np.concatenate(some), 99)) for what, some in took.items()}
    of_ill, of_service = np.mean(shares, axis=0)
    print(
        f"look-ups' p99: quiet {found['quiet']:.1f} ms; beside {HOSTILE} hostile connections "
        f"{found['hostile']:.1f} ms, of a process that takes {of_ill:.0%} of a processor, and the "
        f"service {of_service:.0%}; beside one that takes as much and connects to nothing "
        f"{found['busy']:.1f} ms",
        flush=True,
    )
    return found


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
    """Send mixed requests; print memory, and return what it grew by after the first tenth, MB."""
    rng = np.random.default_rng(9)

    async def send(number: int) -> None:
        askers = [Asker(port) for _ in range(ASKERS)]

        async def some(asker: Asker, how_many: int) -> None:
            for _ in range(how_many):
                await asker.ask(_mixed(rng))

        await asyncio.gather(*(some(asker, number // ASKERS) for asker in askers))

    sent, seen = 0, []
    for share in SEEN_AT:
        asyncio.run(send(round(share * count) - sent))
        sent = round(share * count)
        seen.append(memory_mb(process, "VmRSS"))
    curve = ", ".join(f"{mb:.1f} after {at:.0%}" for at, mb in zip(SEEN_AT, seen, strict=True))
    print(f"memory, MB, of {count} mixed requests: {curve}", flush=True)
    return seen[-1] - seen[1]


def main() -> None:
    """Measure; end with 1 where a limit is missed, with 2 where as busy a process misses it too."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else REQUESTS
    with tempfile.TemporaryDirectory() as folder:
        url = f"sqlite:///{Path(folder) / 'autodb.sqlite3'}"
        fill(url, VERSIONS, Path(folder) / "autodb.sqlite3")
        with served(url) as (at, process):
            port = int(at.rpartition(":")[2])
            rng = np.random.default_rng(3)
            asyncio.run(asked(port, 3.0, rng, machines=MACHINES, rate=RATE))
            found = in_turns(port, process)
            grown_mb = mixed(port, process, count)
    times, of_busy = found["hostile"] / found["quiet"], found["busy"] / found["quiet"]
    said = "passed" if times <= TIMES and grown_mb <= GROWN_MB else "missed"
    if times > TIMES and of_busy > TIMES and grown_mb <= GROWN_MB:
        said = "not determined, the computer lacks processors"
    print(
        f"p99 {times:.2f} × quiet (limit {TIMES:g}), beside as busy a process {of_busy:.2f} ×; "
        f"memory grew by {grown_mb:.1f} MB (limit {GROWN_MB:g}): {said}"
    )
    sys.exit({"passed": 0, "missed": 1}.get(said, 2))


if __name__ == "__main__":
    main()
