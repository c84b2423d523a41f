"""Killed at a random moment between first write and commit, a refresh leaves nothing half-written.

Forked children run the same refresh and are killed with SIGKILL until ten were hit before their
commit; each time the database opens, is sound, and holds nothing of the refresh; then the refresh
is run to its end and must give what the undisturbed one gave.
"""

import os
import random
import shutil
import signal
import time
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import event, select

from autodb.agent.refreshing import refresh
from autodb.store import Store, models, open_store
from tests.conftest import Cli

KILLS = 10
MOST_TRIES = 60  # some kills come after the commit: those must leave the finished refresh
DERIVED = (models.SensedForce, models.CuttingParameters)


def _url(path: Path) -> str:
    return f"sqlite:///{path}"


def _content(path: Path) -> dict[str, list[dict[str, Any]]]:
    """Return every derived row but for when it was made, and which forces each version added."""
    store = open_store(_url(path))
    with store.reading() as session:
        content = {
            model.__tablename__: [
                {
                    c.name: getattr(row, c.key)
                    for c in model.__table__.columns
                    if c.name != "created_at"
                }
                for row in session.scalars(select(model).order_by(model.id))
            ]
            for model in DERIVED
        }
        links = session.execute(select(models.cutting_parameters_force)).all()
        content["links"] = [{"pair": tuple(row)} for row in sorted(tuple(r) for r in links)]
    store.close()
    return content


def _sound(path: Path) -> None:
    store = open_store(_url(path))
    with store.engine.connect() as connection:
        assert connection.exec_driver_sql("PRAGMA integrity_check").scalar() == "ok"
        assert connection.exec_driver_sql("PRAGMA foreign_key_check").all() == []
    store.close()


def _watched(store: Store, first_write: Any) -> None:
    """Call ``first_write`` when the first row is about to be written."""

    def before(_c: Any, _k: Any, statement: str, *_: Any) -> None:
        if statement.startswith("INSERT"):
            first_write()

    event.listen(store.engine, "before_cursor_execute", before)


def _time_from_first_write(path: Path) -> float:
    store = open_store(_url(path))
    moments: list[float] = []
    _watched(store, lambda: moments.append(time.perf_counter()))
    refresh(store, "lathe-1")
    took = time.perf_counter() - moments[0]
    store.close()
    return took


def _killed(path: Path, delay_s: float) -> bool:
    """Fork a refresh, kill it ``delay_s`` after its first write; False if it had finished."""
    read_end, write_end = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            store = open_store(_url(path))
            _watched(store, lambda: os.write(write_end, b"w"))
            refresh(store, "lathe-1")
        finally:
            os._exit(0)
    os.close(write_end)
    os.read(read_end, 1)
    time.sleep(delay_s)
    os.kill(child, signal.SIGKILL)
    os.close(read_end)
    _, status = os.waitpid(child, 0)
    return os.WIFSIGNALED(status)


@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
def test_ten_kills_during_refresh(cli: Cli, sample_jobs: Path, tmp_path: Path) -> None:
    recordings = sample_jobs / "stepped_shaft" / "recordings"
    base = tmp_path / "autodb.sqlite3"
    cli("init")
    cli("machine", "add", "lathe-1")
    cli("import", recordings / "standard-cuts.csv", recordings / "shop-week-1.csv",
        "--machine", "lathe-1")  # fmt: skip
    cli("calibrate", "--machine", "lathe-1")
    store = open_store(_url(base))
    with store.engine.connect() as connection:
        connection.exec_driver_sql("PRAGMA wal_checkpoint(TRUNCATE)")
    store.close()

    windows_s = []
    for name in ("first", "second", "whole"):
        shutil.copy(base, tmp_path / name)
        windows_s.append(_time_from_first_write(tmp_path / name))
    expected = _content(tmp_path / "whole")
    assert expected["cutting_parameters"]

    moments, hits = random.Random(20), 0
    for number in range(MOST_TRIES):
        path = tmp_path / f"{number}.sqlite3"
        shutil.copy(base, path)
        killed = _killed(path, moments.uniform(0, min(windows_s)))
        _sound(path)
        after = _content(path)
        if killed and after["sensed_force"] == []:
            hits += 1
            assert after == {name: [] for name in after}
        else:
            assert after == expected
        store = open_store(_url(path))
        refresh(store, "lathe-1")
        store.close()
        assert _content(path) == expected
        if hits == KILLS:
            break
    assert hits == KILLS
