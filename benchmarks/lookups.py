"""`python -m benchmarks.lookups`: a look-up in a database of 100 000 pairs, on one core.

Every pair has a posterior of coordinates and shared errors, dense and with all digits, drawn from
seeds; a few of them are kept over and over, as text, because drawing them is not what is timed. The
database takes about 4 GB in a temporary folder (TMPDIR), and some minutes to fill. Beside each
look-up the same row is read by its primary key and nothing done with it. Timed are an insert whose
geometry is stated, one of which nothing is, an end mill, whose peaks within a turn come with it,
and a drill. Set OPENBLAS_NUM_THREADS=1 and OMP_NUM_THREADS=1.
"""

import json
import sqlite3
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autodb.agent.answer.looking_up import PairReader
from autodb.agent.rows.machines import add_machine
from autodb.agent.rows.posteriors import posterior_columns
from autodb.files.job_cut import JobCut
from autodb.files.machine import AxisFile, MachineFile
from autodb.fitting.gaussian import Gaussian
from autodb.pairs.posterior import PairPosterior, Shared, law_error
from autodb.pairs.prior import any_metal
from autodb.store import create_store, open_store
from autodb.store.rowsums import register

Array = NDArray[np.float64]

PAIRS, TOOLS, BELIEFS = 100_000, 100, 50
LOOK_UPS, WARM_UPS = 2000, 50
P50_MS = 2.0
"""Target of a look-up of a cut with an insert whose geometry is stated."""
MACHINE = "m"


@dataclass(frozen=True)
class Kind:
    """A kind of tool, as rows state it, and a cut that it makes."""

    name: str
    kind: str
    geometry: dict[str, float]
    cut: JobCut


TURN = JobCut(operation="turn", diameter_mm=50.0, depth_mm=2.0, feed_mm_rev=0.25, speed_m_min=220.0)
SLOT = JobCut(operation="slot", depth_mm=2.0, feed_mm_tooth=0.05, speed_m_min=120.0)
HOLE = JobCut(operation="drill", feed_mm_rev=0.15, speed_m_min=80.0)
STATED = {
    "nose_radius_mm": 0.8, "kappa_deg": 95.0, "rake_deg": -6.0, "inclination_deg": -6.0,
    "included_deg": 80.0,
}  # fmt: skip
MILL = {"diameter_mm": 10.0, "teeth": 4, "helix_deg": 30.0, "corner_radius_mm": 0.2}
KINDS = (
    Kind("turn, insert stated", "turning_insert", STATED, TURN),
    Kind("turn, nothing stated", "turning_insert", {}, TURN),
    Kind("slot, mean and peaks", "end_mill", {**MILL, "rake_deg": 8.0}, SLOT),
    Kind("drill", "drill", {"diameter_mm": 8.0, "point_angle_deg": 140.0}, HOLE),
)


def drawn(rng: np.random.Generator) -> PairPosterior:
    """Return a posterior as one that has met three operations and three calibrations."""
    met = tuple(law_error(name) for name in ("turn", "face", "drill"))
    sensed = tuple(Shared(f"calibration {k}", 1e-4 * np.eye(4)) for k in range(3))
    known = any_metal().also((*met, *sensed, Shared("references", np.eye(2))))
    size = len(known.state.mean)
    sd = 0.1 * np.sqrt(np.diag(known.state.covariance))
    loads = rng.normal(size=(size, size))
    covariance = loads @ loads.T
    drawn_sd = np.sqrt(np.diag(covariance))
    covariance *= np.outer(sd / drawn_sd, sd / drawn_sd)
    mean = known.state.mean + sd * rng.normal(size=size)
    return PairPosterior(Gaussian(mean, covariance), known.shared, known.scatter, 60)


def fill(path: Path) -> None:
    """Make the database."""
    url = f"sqlite:///{path}"
    create_store(url)
    store = open_store(url)
    axes = {name: AxisFile() for name in ("x", "z", "spindle")}
    add_machine(store, MACHINE, MachineFile(axes=axes))
    store.close()
    kinds = [KINDS[k % len(KINDS)] for k in range(TOOLS)]
    tools = ({"id": k + 1, "name": _tool(k), "kind": of.kind, **of.geometry}
             for k, of in enumerate(kinds))  # fmt: skip
    materials = range(PAIRS // TOOLS)
    with closing(sqlite3.connect(path)) as connection, connection:
        register(connection)
        connection.execute("PRAGMA synchronous=OFF")
        for row in tools:
            _insert(connection, "tool", iter([row]))
        _insert(connection, "material", ({"id": k + 1, "name": _material(k)} for k in materials))
        pairs = ({"id": k + 1, "material_id": k // TOOLS + 1, "tool_id": k % TOOLS + 1}
                 for k in range(PAIRS))  # fmt: skip
        _insert(connection, "pair", pairs)
        _insert(connection, "cutting_parameters", _versions())


def _versions() -> Iterator[dict[str, Any]]:
    rng = np.random.default_rng(1)
    kept = [
        {k: json.dumps(v) if isinstance(v, (list, dict)) else v for k, v in columns.items()}
        for columns in (posterior_columns(drawn(rng)) for _ in range(BELIEFS))
    ]
    for k in range(PAIRS):
        own = {"id": k + 1, "machine_id": 1, "pair_id": k + 1, "version": 1}
        yield {**own, "created_at": "2026-01-01T00:00:00+00:00", **kept[k % BELIEFS]}


def _insert(connection: sqlite3.Connection, table: str, rows: Iterator[dict[str, Any]]) -> None:
    first = next(rows)
    columns = ", ".join(f'"{name}"' for name in first)
    statement = f'INSERT INTO "{table}" ({columns}) VALUES ({", ".join("?" * len(first))})'
    connection.execute(statement, tuple(first.values()))
    connection.executemany(statement, (tuple(row.values()) for row in rows))


def _tool(k: int) -> str:
    return f"tool {k:03d}"


def _material(k: int) -> str:
    return f"material {k:04d}"


def times_s(calls: list[Callable[[], object]]) -> tuple[Array, Array]:
    """Return the wall time of each call after some to warm up, and its time on the processor."""
    for call in calls[:WARM_UPS]:
        call()
    wall, busy = [], []
    for call in calls[WARM_UPS:]:
        start, began = time.perf_counter(), time.thread_time()
        call()
        busy.append(time.thread_time() - began)
        wall.append(time.perf_counter() - start)
    return np.array(wall), np.array(busy)


def measure(path: Path) -> None:
    """Look pairs up at random, and read their rows by primary key."""
    store = open_store(f"sqlite:///{path}")
    rng = np.random.default_rng(2)
    of_kind = np.arange(PAIRS) % len(KINDS)
    with store.reading() as session, closing(sqlite3.connect(path)) as plain:
        pair_reader = PairReader(session, MACHINE)
        for number, kind in enumerate(KINDS):
            rows = rng.choice(np.flatnonzero(of_kind == number), LOOK_UPS + WARM_UPS)
            ours, busy = times_s([_look_up(pair_reader, int(row), kind.cut) for row in rows])
            peer, _ = times_s([_select(plain, int(row) + 1) for row in rows])
            _say(kind.name, ours, busy, peer, target_ms=P50_MS if number == 0 else None)
    store.close()


def _look_up(pair_reader: PairReader, pair: int, cut: JobCut) -> Callable[[], object]:
    material, tool = _material(pair // TOOLS), _tool(pair % TOOLS)
    return lambda: pair_reader.look_up(material, tool, cut)


def _select(connection: sqlite3.Connection, number: int) -> Callable[[], object]:
    statement = "SELECT * FROM cutting_parameters WHERE id = ?"
    return lambda: connection.execute(statement, (number,)).fetchone()


def _say(name: str, ours: Array, busy: Array, peer: Array, *, target_ms: float | None) -> None:
    p50, p99 = (1e3 * float(np.percentile(ours, q)) for q in (50, 99))
    row50, row99 = (1e3 * float(np.percentile(peer, q)) for q in (50, 99))
    verdict = "passed" if target_ms is not None and p50 < target_ms else "missed"
    target = "" if target_ms is None else f"; target p50 < {target_ms:g} ms: {verdict}"
    print(
        f"{name}: p50 {p50:.2f} ms ({1e3 * float(np.percentile(busy, 50)):.2f} on the processor), "
        f"p99 {p99:.2f} ms; the row by its key {row50:.3f} ms, "
        f"{row99:.3f} ms; {p50 / row50:.0f} x at p50{target}"
    )


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        database = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(folder) / "many.sqlite3"
        if not database.exists():
            fill(database)
        numbers = len(drawn(np.random.default_rng(1)).state.mean)
        print(f"{PAIRS} pairs of {numbers} numbers, {database.stat().st_size / 1e9:.1f} GB")
        measure(database)
