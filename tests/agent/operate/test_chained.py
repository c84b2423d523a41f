"""The audit log is a chain: what is changed in it afterwards is found, and named by its number."""

import sqlite3
import threading
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import select, text

from autodb.agent.operate.access import Access, Role, add_token, first_broken, note, noted
from autodb.agent.rows.machines import add_machine
from autodb.files.machine import LATHE
from autodb.store import Store, create_store, head, migrate, models, open_store
from autodb.store.rowsums import register
from tests.conftest import Cli
from tests.helpers.servers import Server

FILE = "autodb.sqlite3"
URL = f"sqlite:///{FILE}"
SHOP = Access("shop", Role.OPERATE, None)


@pytest.fixture
def log(cli: Cli) -> Iterator[Store]:
    """Return a database whose audit log has six entries."""
    cli("init")
    store = open_store(URL)
    with store.writing() as session:
        for k in range(6):
            detail: dict[str, Any] = {"β": [k, 0.1, None], "a": {"y": 1, "x": "é"}} if k else {}
            note(session, SHOP, f"done {k}", row=("recording", k), **detail)
    yield store
    store.close()


def _broken(store: Store) -> int | None:
    with store.reading() as session:
        return first_broken(session)


def test_a_log_as_it_was_written_is_whole(log: Store, cli: Cli) -> None:
    add_token(log, "planner", "read", days=1)
    assert _broken(log) is None
    with log.reading() as session:
        hashes = [one.sha256 for _, one in noted(session, most=9)]
    assert len(set(hashes)) == 7
    done = cli("doctor")
    assert (done.code, "audit log altered" in done.out) == (0, True)


@pytest.mark.parametrize(
    ("change", "broken"),
    [
        ("UPDATE audit_entry SET who = 'another' WHERE id = 3", 3),
        ("UPDATE audit_entry SET at = '2026-01-01T00:00:00+00:00' WHERE id = 2", 2),
        ("UPDATE audit_entry SET detail = '{}' WHERE id = 4", 4),
        ("UPDATE audit_entry SET row_id = 1 WHERE id = 6", 6),
        ("UPDATE audit_entry SET sha256 = '' WHERE id = 5", 5),
        ("DELETE FROM audit_entry WHERE id = 1", 2),
        ("DELETE FROM audit_entry WHERE id = 3", 4),
        ("UPDATE audit_entry SET id = 9 WHERE id = 3", 4),
        (
            "INSERT INTO audit_entry (at, who, action, sha256) "
            "SELECT at, who, action, sha256 FROM audit_entry WHERE id = 6",
            7,
        ),
    ],
)
def test_the_first_entry_that_does_not_fit_is_named(
    log: Store, cli: Cli, change: str, broken: int
) -> None:
    with closing(register(sqlite3.connect(FILE, isolation_level=None))) as file:
        file.execute(change)
    assert _broken(log) == broken
    done = cli("doctor")
    assert done.code == 1
    assert f"audit log altered: audit_entry {broken}:" in done.out


def test_what_goes_on_behind_a_broken_entry_does_not_mend_it(log: Store) -> None:
    with log.writing() as session:
        session.get_one(models.AuditEntry, 3).who = "another"
    add_token(log, "planner", "read", days=1)
    assert _broken(log) == 3


def test_entries_of_earlier_versions_are_chained_as_they_are(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'old.sqlite3'}"
    migrate(url, "0009")
    with closing(sqlite3.connect(tmp_path / "old.sqlite3", isolation_level=None)) as file:
        file.executemany(
            "INSERT INTO audit_entry (id, at, who, action, row_kind, row_id, detail) "
            "VALUES (?, '2026-01-01T00:00:00+00:00', 'shop', 'imported', 'recording', 1, ?)",
            [(2, None), (5, '{"β": 0.1, "a": [1, null]}'), (9, "null")],
        )
    migrate(url, head())
    store = open_store(url)
    assert _broken(store) is None
    with store.writing() as session:
        note(session, SHOP, "done")
    assert _broken(store) is None
    with store.writing() as session:
        session.execute(text("DELETE FROM audit_entry WHERE id = 2"))
    assert _broken(store) == 5
    store.close()


def test_machines_of_a_server_that_write_at_once_make_one_chain(server: Server) -> None:
    url = server.database()
    create_store(url)
    store = open_store(url)
    names = [f"lathe-{k}" for k in range(4)]
    for name in names:
        add_machine(store, name, LATHE)

    def work(name: str) -> None:
        for k in range(10):
            with store.writing(name) as session:
                note(session, SHOP, f"done {k}", row=("machine", k), by=name)

    threads = [threading.Thread(target=work, args=(name,)) for name in names]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert _broken(store) is None
    with store.reading() as session:
        assert len(session.scalars(select(models.AuditEntry)).all()) == 40
    store.close()
