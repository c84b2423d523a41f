"""`python -m benchmarks.fleet_lookups [ROWS]`: look-ups among 10⁶ versions of parameters, while a
refresh writes, on SQLite and on PostgreSQL.

1000 machines have 20 pairs of 50 versions each; posteriors are dense and with all digits, drawn
from seeds, a few of them kept over and over. Each look-up opens the database's state, finds the
newest version of a machine's pair and predicts a turned cut, as a request does. Beside it the same
row is read by its primary key. A forked process adds cuts to other machines and refreshes them the
whole time. 10⁶ rows take about 15 GB in TMPDIR for each database, and minutes to fill.
"""

import json
import os
import signal
import sqlite3
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import select

from autodb.agent.answer.looking_up import PairReader
from autodb.agent.operate.refreshing import refresh
from autodb.agent.operate.scheduling import NICE
from autodb.agent.rows.machines import add_machine
from autodb.agent.rows.posteriors import posterior_columns
from autodb.files.job_cut import JobCut
from autodb.files.machine import LATHE
from autodb.fitting.gaussian import Gaussian
from autodb.pairs.posterior import PairPosterior, Shared, law_error
from autodb.pairs.prior import any_metal
from autodb.proofs.machines.lathe import fleets
from autodb.store import Store, create_store, models, open_store
from autodb.store.rowsums import register
from tests.helpers import shops
from tests.helpers.servers import Server

Array = NDArray[np.float64]

MACHINES, PAIRS, BELIEFS = 1000, 20, 20
LOOK_UPS, WARM_UPS = 2000, 50
CUT = JobCut(operation="turn", diameter_mm=50.0, depth_mm=2.0, feed_mm_rev=0.25, speed_m_min=220.0)
GEOMETRY = {
    "nose_radius_mm": 0.8, "kappa_deg": 95.0, "rake_deg": -6.0, "inclination_deg": -6.0,
    "included_deg": 80.0,
}  # fmt: skip
Row = dict[str, Any]


def drawn(rng: np.random.Generator) -> PairPosterior:
    """Return a posterior as one that has met turning and the calibrations of two axes."""
    sensed = tuple(Shared(f"calibration {k}", 1e-4 * np.eye(2)) for k in range(2))
    known = any_metal().also((law_error("turn"), *sensed, Shared("references y", np.eye(1))))
    sd = 0.1 * np.sqrt(np.diag(known.state.covariance))
    loads = rng.normal(size=(len(sd), len(sd)))
    covariance = loads @ loads.T
    size = np.sqrt(np.diag(covariance))
    covariance *= np.outer(sd / size, sd / size)
    return PairPosterior(Gaussian(known.state.mean, covariance), known.shared, known.scatter, 60)


def tables(versions: int) -> Iterator[tuple[str, Iterable[Row]]]:
    """Return the rows of each table but the machines, in the order of their keys."""
    yield "tool", [{"id": 1, "name": "insert", "kind": "turning_insert", **GEOMETRY}]
    yield "material", ({"id": k + 1, "name": f"material {k}"} for k in range(PAIRS))
    yield "pair", ({"id": k + 1, "material_id": k + 1, "tool_id": 1} for k in range(PAIRS))
    yield "cutting_parameters", _versions(versions)


def _versions(versions: int) -> Iterator[Row]:
    rng = np.random.default_rng(1)
    kept = [
        {k: json.dumps(v) if isinstance(v, list | dict) else v for k, v in columns.items()}
        for columns in (posterior_columns(drawn(rng)) for _ in range(BELIEFS))
    ]
    number = 0
    for version in range(versions):
        for machine in range(MACHINES):
            for pair in range(PAIRS):
                number += 1
                yield {
                    "id": number, "machine_id": machine + 1, "pair_id": pair + 1,
                    "version": version + 1, "created_at": "2026-01-01T00:00:00+00:00",
                    **kept[number % BELIEFS],
                }  # fmt: skip


def fill(url: str, versions: int, file: Path | None) -> None:
    """Make the database, on a server where there is no file."""
    create_store(url)
    store = open_store(url)
    for name in shops.names(MACHINES):
        add_machine(store, name, LATHE)
    if file is not None:
        store.close()
        _fill_file(file, versions)
        return
    with store.writing() as session:
        driver: Any = session.connection().connection.driver_connection
        for table, rows in tables(versions):
            with driver.cursor() as cursor:
                every = iter(rows)
                first = next(every)
                names = ", ".join(f'"{name}"' for name in first)
                with cursor.copy(f"COPY {table} ({names}) FROM STDIN") as copy:
                    copy.write_row(tuple(first.values()))
                    for row in every:
                        copy.write_row(tuple(row.values()))
                sequence = f"SELECT setval(pg_get_serial_sequence('{table}', 'id'), max(id))"
                cursor.execute(f"{sequence} FROM {table}")
    store.close()


def _fill_file(file: Path, versions: int) -> None:
    with closing(sqlite3.connect(file)) as connection, connection:
        register(connection)
        connection.execute("PRAGMA synchronous=OFF")
        connection.execute("PRAGMA journal_mode=OFF")  # nothing is written twice, the log first
        for table, rows in tables(versions):
            every = iter(rows)
            first = next(every)
            names = ", ".join(f'"{name}"' for name in first)
            into = f"INSERT INTO {table} ({names}) VALUES ({', '.join('?' * len(first))})"
            connection.execute(into, tuple(first.values()))
            connection.executemany(into, (tuple(row.values()) for row in every))
        connection.commit()
        connection.execute("PRAGMA journal_mode=WAL")


@contextmanager
def writing(url: str) -> Iterator[None]:
    """Have another process add cuts to other machines and refresh them, meanwhile.

    It gives way as much as a scheduled pass does.
    """
    child = os.fork()
    if child == 0:
        try:
            _write(url)
        finally:
            os._exit(1)
    try:
        yield
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)


def _write(url: str) -> None:
    os.nice(NICE)
    rng = np.random.default_rng(3)
    fleet = fleets.draw_fleet(rng, materials=3, tools=1)
    store = open_store(url)
    number = 0
    while True:
        number += 1
        name = f"busy-{os.getpid()}-{number}"
        shops.add(store, name, fleets.on_machine(rng, fleet, list(fleet.pairs)), cuts=20, rng=rng)
        refresh(store, name)


def measure(store: Store, versions: int, *, what: str) -> None:
    """Look pairs up at random, and read their rows by primary key; print both."""
    rng = np.random.default_rng(2)
    ours, peer = [], []
    for _ in range(LOOK_UPS + WARM_UPS):
        machine, pair = int(rng.integers(MACHINES)), int(rng.integers(PAIRS))
        start = time.perf_counter()
        with store.reading() as session:
            PairReader(session, f"lathe-{machine}").look_up(f"material {pair}", "insert", CUT)
        between = time.perf_counter()
        with store.reading() as session:
            number = ((versions - 1) * MACHINES + machine) * PAIRS + pair + 1
            query = select(models.CuttingParameters.__table__).where(
                models.CuttingParameters.id == number
            )
            session.connection().execute(query).one()
        ours.append(between - start)
        peer.append(time.perf_counter() - between)
    found = [1e3 * np.percentile(some[WARM_UPS:], q) for some in (ours, peer) for q in (50, 99)]
    print(
        f"{what}: look-up p50 {found[0]:.1f} ms, p99 {found[1]:.1f} ms; the row by its key "
        f"{found[2]:.1f}, {found[3]:.1f} ms; {found[0] / found[2]:.1f} x at p50",
        flush=True,
    )


def main(rows: int) -> None:
    """Fill and measure both databases."""
    versions = rows // (MACHINES * PAIRS)
    with tempfile.TemporaryDirectory(prefix="autodb-lookups-") as name:
        folder = Path(name)
        folder.chmod(0o755)
        file = folder / "many.sqlite3"
        _both(f"sqlite:///{file}", versions, "SQLite", lambda _: file.stat().st_size, file)
        file.unlink()
        server = Server(folder / "server")
        try:
            _both(server.database(), versions, "PostgreSQL", server.bytes, None)
        finally:
            server.stop()


def _both(url: str, versions: int, kind: str, size: Any, file: Path | None) -> None:
    start = time.perf_counter()
    fill(url, versions, file)
    filled_s = time.perf_counter() - start
    print(
        f"{kind}: {versions * MACHINES * PAIRS} rows, {size(url) / 1e9:.1f} GB, "
        f"filled in {filled_s:.0f} s",
        flush=True,
    )
    store = open_store(url)
    measure(store, versions, what=f"{kind}, quiet")
    store.close()
    with writing(url):
        store = open_store(url)
        measure(store, versions, what=f"{kind}, while a refresh writes")
        store.close()


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000)
