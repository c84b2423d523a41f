"""`python -m benchmarks.refreshing [CUTS ...]`: a pass that ten new cuts came to, by stored cuts.

The sample lathe learns its standard cuts and a week of the shop from an inbox, as anyone's does;
then the stored rows are multiplied to 10², 10³, 10⁴ and 10⁵ cuts, as if ten had come each time:
recordings, cuts, sensed forces, a version of the pair's parameters every ten cuts, and the last
pass. The ten new ones lie in the inbox; timed is the pass that takes them, with import, ten times:
the median, and the longest of those that explain wear once more. What is multiplied are copies, so
that the pair's numbers do not move; it is the cost that is measured. Beside it the same ten are
imported without a refresh. Set OPENBLAS_NUM_THREADS=1.
"""

import resource
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pandas as pd
from sqlalchemy import Connection, func, insert, select

from autodb.agent.answer.pooled.pooling import ExplainableCuts
from autodb.agent.ingest.importing import import_file
from autodb.agent.ingest.inbox import Inbox
from autodb.agent.operate.refreshing import refresh
from autodb.agent.rows.machines import add_machine
from autodb.agent.sense.calibrating import calibrate_machine
from autodb.assets import kit
from autodb.files.machine import LATHE
from autodb.store import Store, create_store, models, open_store

MACHINE = "lathe-1"
STORED = (100, 1_000, 10_000, 100_000)
TARGET_S = 2.0
"""For ten new cuts among 10⁵."""
AT_A_TIME, PASSES, IMPORTS = 10, 10, 5
RECORDINGS = kit("sample_jobs") / "stepped_shaft" / "recordings"
Row = dict[str, Any]


def main(arguments: list[str]) -> None:
    """Print what a pass costs by the number of stored cuts."""
    print(
        "stored cuts   pass s, processor s   explaining, longest s, processor s   "
        "of it import s   database MB   peak memory MB"
    )
    for stored in [int(one) for one in arguments] or STORED:
        with tempfile.TemporaryDirectory() as name:
            print(_line(Path(name), stored))


def _line(folder: Path, stored: int) -> str:
    url = f"sqlite:///{folder / 'a.sqlite3'}"
    store = _learnt(folder, url, weeks=2 if stored < 250 else 6)
    with store.engine.connect().execution_options(autodb_writes=True) as connection:
        _multiply(connection, stored)
        connection.commit()
    passes = [_pass(store, folder, run) for run in range(PASSES)]
    imports = [_import_s(store, folder, PASSES + run) for run in range(IMPORTS)]
    with store.reading() as session:
        cuts = session.scalar(select(func.count()).select_from(models.Cut))
    store.close()
    size = (folder / "a.sqlite3").stat().st_size / 1e6
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    took, processor = np.median([(one.took_s, one.processor_s) for one in passes], axis=0)
    longest = max(
        (one for one in passes if one.explained), key=lambda one: one.took_s, default=None
    )
    explaining = f"none of {PASSES}"
    if longest is not None:
        count = sum(one.explained > 0 for one in passes)
        times = f"{longest.took_s:.2f}, {longest.processor_s:.2f}"
        explaining = f"{count} of {PASSES}: {times}"
    return (
        f"{cuts:>11}   {took:6.2f}, {processor:11.2f}   {explaining:>34}   "
        f"{np.median(imports):14.2f}   {size:11.0f}   {peak:14.0f}"
    )


def _learnt(folder: Path, url: str, *, weeks: int) -> Store:
    """Return a database whose lathe has learnt standard cuts and weeks of 40.

    Up to 200 cuts are learnt at once, beyond that the new ones alone.
    """
    create_store(url)
    store = open_store(url)
    add_machine(store, MACHINE, LATHE)
    import_file(store, RECORDINGS / "standard-cuts.csv", machine=MACHINE)
    calibrate_machine(store, MACHINE)
    (folder / "in").mkdir()
    for number in range(weeks):
        _deliver(folder, f"week-{number}.csv", 40, number)
    refresh(store, MACHINE, inbox=Inbox(folder / "in", settled_s=0.0))
    return store


def _deliver(folder: Path, name: str, rows: int, seed: int) -> Path:
    """Put cuts of the shop's week into the inbox, their currents other by parts in a thousand."""
    week = pd.read_csv(RECORDINGS / "shop-week-1.csv").iloc[:rows].copy()
    ranges = [str(column) for column in week.columns if str(column).endswith(".range")]
    week[ranges] = week[ranges] * (1.0 + 1e-3 * (1 + seed % 7))
    week["t"] += 1e6 * (seed + 1)
    path = folder / "in" / name
    week.to_csv(path, index=False)
    return path


@dataclass(frozen=True)
class _Pass:
    """What a pass took, of the clock and of the processor, and how often it explained cuts."""

    took_s: float
    processor_s: float
    explained: int


def _pass(store: Store, folder: Path, number: int) -> _Pass:
    _deliver(folder, f"new-{number}.csv", AT_A_TIME, 100 + number)
    with mock.patch.object(
        ExplainableCuts, "explained", autospec=True, side_effect=ExplainableCuts.explained
    ) as explained:
        start, busy = time.perf_counter(), time.process_time()
        done = refresh(store, MACHINE, inbox=Inbox(folder / "in", settled_s=0.0))
        took, processor = time.perf_counter() - start, time.process_time() - busy
    assert [one.cuts for one in done.came_in] == [AT_A_TIME], done
    return _Pass(took, processor, explained.call_count)


def _import_s(store: Store, folder: Path, number: int) -> float:
    path = _deliver(folder, f"new-{number}.csv", AT_A_TIME, 100 + number)
    start = time.perf_counter()
    import_file(store, path, machine=MACHINE)
    took = time.perf_counter() - start
    path.unlink()
    return took


def _multiply(connection: Connection, stored: int) -> None:
    """Add copies of the last recording's rows until ``stored`` cuts are there."""
    last = {table: _newest(connection, table) for table in ("recording", "cut", "sensed_force")}
    version = _newest(connection, "cutting_parameters")[-1]
    source = [row for row in last["cut"] if row["recording_id"] == last["recording"][-1]["id"]]
    cuts = sorted(source, key=lambda row: float(row["number"]))[:AT_A_TIME]
    forces = {
        cut["id"]: [row for row in last["sensed_force"] if row["cut_id"] == cut["id"]]
        for cut in cuts
    }
    made: dict[str, list[Row]] = {name: [] for name in _TABLES}
    ids = {name: _newest(connection, name)[-1]["id"] for name in _TABLES if name != LINK}
    there = len(last["cut"])
    while there < stored:
        there += AT_A_TIME
        ids["recording"] += 1
        recording = {**last["recording"][-1], "id": ids["recording"]}
        recording |= {"sha256": f"{ids['recording']:064d}", "delivered_as": f"{ids['recording']}"}
        made["recording"].append(recording)
        ids["cutting_parameters"] += 1
        version = {**version, "id": ids["cutting_parameters"], "previous_id": version["id"]}
        version |= {"version": version["version"] + 1, "n_cuts": version["n_cuts"] + AT_A_TIME}
        made["cutting_parameters"].append(version)
        for cut in cuts:
            ids["cut"] += 1
            made["cut"].append({**cut, "id": ids["cut"], "recording_id": ids["recording"]})
            for force in forces[cut["id"]]:
                ids["sensed_force"] += 1
                copied = {**force, "id": ids["sensed_force"], "cut_id": ids["cut"]}
                made["sensed_force"].append(copied)
                if force["value_N"] is not None:
                    made[LINK].append(
                        {
                            "cutting_parameters_id": version["id"],
                            "sensed_force_id": ids["sensed_force"],
                        }
                    )
    mark = {**_newest(connection, "refresh_pass")[-1], "last_cut_id": ids["cut"]}
    ids["refresh_pass"] += 1
    mark |= {"id": ids["refresh_pass"], "last_force_id": ids["sensed_force"]}
    made["refresh_pass"].append(mark)
    for name, rows in made.items():
        if rows:
            connection.execute(insert(models.Base.metadata.tables[name]), rows)


LINK = "cutting_parameters_force"
_TABLES = ("recording", "cut", "sensed_force", "cutting_parameters", LINK, "refresh_pass")


def _newest(connection: Connection, name: str) -> list[Row]:
    table = models.Base.metadata.tables[name]
    return [dict(row) for row in connection.execute(select(table).order_by(table.c.id)).mappings()]


if __name__ == "__main__":
    main(sys.argv[1:])
