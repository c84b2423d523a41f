"""Kill import, calibrate, refresh and confirm at chosen moments, and see what is left.

`python -m tests.helpers.kills [NUMBER]` prints where the kills hit, as docs/kills.md shows it. Half
of them are timed from the start of the command, half from its first write, so that the short time
between first write and commit is hit often.
"""

import os
import random
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sqlalchemy import event, select

from autodb import records
from autodb.agent.ingest.importing import import_file
from autodb.agent.operate.deciding import confirm
from autodb.agent.operate.refreshing import refresh
from autodb.agent.rows.machines import add_machine
from autodb.agent.sense.calibrating import calibrate_machine
from autodb.agent.sense.identifying import identify_on_machine
from autodb.assets import kit
from autodb.files.machine import LATHE
from autodb.store import Store, create_store, models, open_store

MACHINE = "lathe-1"
SEED = 20
PHASES = ("before the first write", "between first write and commit", "after the commit")
CLOCKS = {"created_at", "imported_at", "started_at", "finished_at", "decided_at"}

Content = dict[str, list[tuple[Any, ...]]]


def _recording(name: str) -> Path:
    return kit("sample_jobs") / "stepped_shaft" / "recordings" / name


def _import(store: Store) -> None:
    import_file(store, _recording("shop-week-1.csv"), machine=MACHINE)


def _calibrate(store: Store) -> None:
    calibrate_machine(store, MACHINE)


def _refresh(store: Store) -> None:
    refresh(store, MACHINE)


def _confirm(store: Store) -> None:
    confirm(store, 1)


def _axis(store: Store) -> None:
    """Identify an axis, and keep a cause as explain would, to be confirmed."""
    path = _recording("air-moves.csv")
    moves = records.read(path)
    assert isinstance(moves, records.Recording)
    identify_on_machine(store, MACHINE, path, moves)
    with store.writing() as session:
        known = select(models.StoredRecording).where(
            models.StoredRecording.path.endswith(path.name)
        )
        mismatch = models.Mismatch(
            recording_id=session.scalars(known).one().id, channel="z.current", term="asymmetry",
            kind="missing", confidence=0.9, parameters={}, statement="It differs.",
        )  # fmt: skip
        session.add(mismatch)


STEPS: tuple[tuple[str, Callable[[Store], None]], ...] = (
    ("import", _import),
    ("calibrate", _calibrate),
    ("refresh", _refresh),
    ("mismatch confirm", _confirm),
)


@dataclass
class Hits:
    """Kills of one command by phase, and by tenth of its undisturbed time."""

    command: str
    phases: dict[str, int] = field(default_factory=lambda: dict.fromkeys(PHASES, 0))
    tenths: list[int] = field(default_factory=lambda: [0] * 10)
    damaged: list[str] = field(default_factory=list)


def opened(path: Path) -> Store:
    """Open the database in a file."""
    return open_store(f"sqlite:///{path}")


def content(path: Path) -> Content:
    """Return every row of every table, but for the clock's time."""
    store = opened(path)
    with store.reading() as session:
        found = {
            table.name: sorted(
                (
                    tuple(repr(row[c]) for c in table.columns if c.name not in CLOCKS)
                    for row in session.execute(select(table)).mappings()
                ),
            )
            for table in models.Base.metadata.sorted_tables
        }
    store.close()
    return found


def is_sound(path: Path) -> bool:
    """Say whether SQLite finds the file whole and every foreign key leading somewhere."""
    store = opened(path)
    with store.engine.connect() as connection:
        whole = connection.exec_driver_sql("PRAGMA integrity_check").scalar() == "ok"
        led = connection.exec_driver_sql("PRAGMA foreign_key_check").all() == []
    store.close()
    return whole and led


def _settled(path: Path) -> None:
    """Bring the write-ahead log into the file, so that one file is the database."""
    store = opened(path)
    with store.engine.connect() as connection:
        connection.exec_driver_sql("PRAGMA wal_checkpoint(TRUNCATE)")
    store.close()


def bases(folder: Path) -> list[Path]:
    """Return the database before each command, and after the last."""
    first = folder / "0.sqlite3"
    create_store(f"sqlite:///{first}")
    store = opened(first)
    add_machine(store, MACHINE, LATHE)
    import_file(store, _recording("standard-cuts.csv"), machine=MACHINE)
    _axis(store)
    store.close()
    _settled(first)
    made = [first]
    for number, (_, step) in enumerate(STEPS, start=1):
        path = folder / f"{number}.sqlite3"
        shutil.copy(made[-1], path)
        store = opened(path)
        step(store)
        store.close()
        _settled(path)
        made.append(path)
    return made


def _on_first_write(store: Store, call: Callable[[], object]) -> None:
    def before(_c: Any, _k: Any, statement: str, *_: Any) -> None:
        if statement.startswith("INSERT"):
            call()

    event.listen(store.engine, "before_cursor_execute", before)


def _timed(path: Path, step: Callable[[Store], None]) -> tuple[float, float]:
    """Return the seconds to the first write, and in all."""
    store, writes = opened(path), []
    _on_first_write(store, lambda: writes.append(time.perf_counter()))
    start = time.perf_counter()
    step(store)
    took = time.perf_counter() - start
    store.close()
    return writes[0] - start, took


def kill(path: Path, step: Callable[[Store], None], delay_s: float, *, from_write: bool) -> float:
    """Fork the step, kill it after ``delay_s``; return the seconds from its start to the kill."""
    reads, writes = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            store = opened(path)
            os.write(writes, b"s")
            _on_first_write(store, lambda: os.write(writes, b"w"))
            step(store)
        finally:
            os._exit(0)
    os.close(writes)
    os.read(reads, 1)
    start = time.perf_counter()
    if from_write:
        os.read(reads, 1)
    time.sleep(delay_s)
    os.kill(child, signal.SIGKILL)
    lived_s = time.perf_counter() - start
    os.close(reads)
    os.waitpid(child, 0)
    return lived_s


def run(kills: int) -> list[Hits]:
    """Kill each command ``kills`` times; what is left must be the state before or after it, and
    the command run again must end in the state after it. What is not so is in ``damaged``.
    """
    rng = random.Random(SEED)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        states = bases(folder)
        return [_run_step(folder, number, states, rng, kills) for number, _ in enumerate(STEPS)]


def _run_step(
    folder: Path, number: int, states: list[Path], rng: random.Random, kills: int
) -> Hits:
    command, step = STEPS[number]
    before, after = content(states[number]), content(states[number + 1])
    rehearsal = folder / "rehearsal.sqlite3"
    shutil.copy(states[number], rehearsal)
    to_write_s, took_s = _timed(rehearsal, step)
    hits = Hits(command)
    for kill_number in range(kills):
        path = folder / f"{command}-{kill_number}.sqlite3"
        shutil.copy(states[number], path)
        from_write = kill_number % 2 == 0
        delay_s = rng.uniform(0, took_s - to_write_s if from_write else took_s)
        lived_s = kill(path, step, delay_s, from_write=from_write)
        hits.tenths[min(9, int(10 * lived_s / took_s))] += 1
        left = content(path)
        if left == before:
            phase = PHASES[1] if from_write else PHASES[lived_s > to_write_s]
        else:
            phase = PHASES[2]
        hits.phases[phase] += 1
        _judge(hits, path, step, left, (before, after))
    return hits


def _judge(
    hits: Hits,
    path: Path,
    step: Callable[[Store], None],
    left: Content,
    states: tuple[Content, Content],
) -> None:
    if not is_sound(path):
        hits.damaged.append(f"{path.name}: not sound")
    if left not in states:
        hits.damaged.append(f"{path.name}: half of it is there")
    store = opened(path)
    step(store)
    store.close()
    if content(path) != states[1]:
        hits.damaged.append(f"{path.name}: run again, it ends in another state")


def report(found: list[Hits]) -> str:
    """Return the table of where the kills hit."""
    lines = ["| command | " + " | ".join(PHASES) + " | by tenth of its time |", "|---" * 5 + "|"]
    lines += [
        f"| `{h.command}` | "
        + " | ".join(str(h.phases[p]) for p in PHASES)
        + " | "
        + " ".join(str(n) for n in h.tenths)
        + " |"
        for h in found
    ]
    total, damaged = sum(sum(h.tenths) for h in found), [d for h in found for d in h.damaged]
    lines.append(
        f"\n{total} kills; {len(damaged)} left anything but the state before or after the command, "
        "or ended in another state when it was run again."
    )
    return "\n".join([*lines, *damaged])


if __name__ == "__main__":
    print(report(run(int(sys.argv[1]) if len(sys.argv) > 1 else 17)))
