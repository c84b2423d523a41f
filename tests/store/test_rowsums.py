"""Checksums of rows: kept by whoever writes, and a bit that flips is found."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from sqlalchemy import text, update

from autodb.agent.operate.access import add_to_chain
from autodb.errors import UnusableInput
from autodb.files.checksums import checksum
from autodb.proofs.runs.keeping.flips import Whole
from autodb.store import Store, create_store, head, migrate, models, open_store
from autodb.store.backups import backup
from autodb.store.copies import connect
from autodb.store.restoring import restore
from autodb.store.rowsums import GROUP, altered, row_digest
from tests.conftest import Cli

pytestmark = pytest.mark.usefixtures("one_law")

DB = Path("autodb.sqlite3")
N = 2 * GROUP + 50


@pytest.fixture
def url(tmp_path: Path) -> str:
    return f"sqlite:///{tmp_path / 'a.sqlite3'}"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Return a database whose audit log spans three groups of rows."""
    path = tmp_path_factory.mktemp("made") / "a.sqlite3"
    create_store(f"sqlite:///{path}")
    opened = open_store(f"sqlite:///{path}")
    with opened.writing() as session:
        for n in range(N):
            add_to_chain(
                session, models.AuditEntry(who=f"panel {n}", action="read", detail={"n": n})
            )
    opened.close()
    assert not path.with_name("a.sqlite3-wal").exists()
    return path.read_bytes()


@pytest.fixture
def store(url: str, tmp_path: Path, made: bytes) -> Iterator[Store]:
    (tmp_path / "a.sqlite3").write_bytes(made)
    opened = open_store(url)
    yield opened
    opened.close()


def _altered(store: Store) -> list[str]:
    with closing(connect(Path(str(store.path)))) as file:
        return altered(file)


def _sums(store: Store) -> list[tuple[str, int, int, int]]:
    with closing(connect(Path(str(store.path)))) as file:
        return file.execute("SELECT * FROM row_checksum WHERE rows <> 0 ORDER BY 1, 2").fetchall()


def _behind_its_back(store: Store, statement: str) -> None:
    """Change a value as a flipped bit would: without what keeps the checksums."""
    with closing(connect(Path(str(store.path)))) as file:
        kept = file.execute("SELECT name, sql FROM sqlite_master WHERE type = 'trigger'").fetchall()
        file.execute("BEGIN")
        for name, _sql in kept:
            file.execute(f"DROP TRIGGER {name}")
        file.execute(statement)
        for _name, sql in kept:
            file.execute(sql)
        file.execute("COMMIT")


WRITES = [
    "UPDATE audit_entry SET who = 'all'",
    "DELETE FROM audit_entry WHERE id BETWEEN 200 AND 300",
    "DELETE FROM audit_entry",
    "UPDATE audit_entry SET id = id + 1000",
    "INSERT OR REPLACE INTO audit_entry (id, at, who, action, sha256) VALUES (3, 4, 5, 6.5, 7)",
    "INSERT OR IGNORE INTO audit_entry (id, at, who, action, sha256) VALUES (3, 4, 5, 6, 7)",
    "INSERT INTO tool_property (tool_id, code, value, unit) VALUES (1, 7, '-0.0', 1e300)",
    "INSERT INTO tool_property (tool_id, code, value, unit) VALUES (1, 7, -0.0, x'00ff')",
    "INSERT INTO tool_property (tool_id, code, value, unit) VALUES (1, 'ä', 3, TRUE)",
    "DELETE FROM tool_property",
]


@pytest.mark.parametrize("write", WRITES)
def test_whoever_writes_keeps_the_checksums(store: Store, write: str) -> None:
    """Statements past the models; rows replaced, and given other keys; types changed by columns."""
    with store.writing() as session:
        session.add(models.Tool(name="t", properties=[]))
        session.flush()
        session.add(models.ToolProperty(tool_id=1, code="RE", value=0.8, unit="mm"))
    before = _sums(store)
    with store.engine.connect().execution_options(autodb_writes=True) as connection:
        connection.exec_driver_sql(write)
        connection.commit()
    assert _altered(store) == []
    assert (_sums(store) == before) == ("OR IGNORE" in write)


def test_rows_that_go_with_what_they_belong_to_are_counted_out(store: Store) -> None:
    with store.writing() as session:
        machine = models.Machine(name="m")
        session.add(machine)
        session.flush()
        recording = models.StoredRecording(
            machine_id=machine.id, sha256="a", path="p", kind="cuts", rows=1, units={}, side={}
        )
        session.add(models.Estimator(
            machine_id=machine.id, kind="lstm", component="z", version=1, model={}, scores={},
            recordings=[recording],
        ))  # fmt: skip
    assert ("estimator_recording", 0, 1) in [row[:3] for row in _sums(store)]
    with store.writing() as session:
        session.execute(text("DELETE FROM estimator"))
    assert "estimator_recording" not in [row[0] for row in _sums(store)]
    assert _altered(store) == []


def test_a_change_that_is_taken_back_leaves_its_checksum(store: Store) -> None:
    before = _sums(store)
    with pytest.raises(RuntimeError), store.writing() as session:
        session.execute(update(models.AuditEntry).values(who="nobody"))
        session.execute(text("DELETE FROM audit_entry WHERE id > 5"))
        raise RuntimeError
    assert _sums(store) == before
    assert _altered(store) == []


def test_rows_that_nobody_wrote_are_named(store: Store) -> None:
    _behind_its_back(store, "UPDATE audit_entry SET who = 'panel 8' WHERE id = 300")
    assert _altered(store) == ["audit_entry, rows of id 256 to 511"]
    _behind_its_back(store, "DELETE FROM audit_entry WHERE id > 511")
    assert _altered(store)[1] == "audit_entry, rows of id 512 to 767"


def test_a_later_write_does_not_cover_up_a_value_that_changed_by_itself(store: Store) -> None:
    _behind_its_back(store, "UPDATE audit_entry SET who = 'panel 8' WHERE id = 300")
    with store.writing() as session:
        session.execute(update(models.AuditEntry).values(who="panel 299"))
        session.execute(text("DELETE FROM audit_entry WHERE id > 280"))
    assert _altered(store) == ["audit_entry, rows of id 256 to 511"]


def test_whoever_knows_no_checksums_cannot_write(store: Store) -> None:
    with (
        closing(sqlite3.connect(str(store.path))) as other,
        pytest.raises(sqlite3.OperationalError, match="no such function"),
    ):
        other.execute("UPDATE audit_entry SET who = 'x' WHERE id = 1")


def test_the_digest_of_a_row_is_for_good() -> None:
    """Other versions of Python and of autodb read what this one wrote; types and order count."""
    assert row_digest(1, 0.1, "ä", None, b"\x00") == 4462500393948246844
    assert (
        len({row_digest(*v) for v in ((1, 2), (2, 1), (1.0, 2), ("1", 2), (12,), (1, None))}) == 6
    )
    assert row_digest(-0.0) == row_digest(0.0)


def test_an_earlier_schema_gets_checksums_of_what_it_holds(store: Store, url: str) -> None:
    before = _sums(store)
    migrate(url, "0009")
    assert _altered(store) == []
    migrate(url, head())
    assert _sums(store) == before
    _behind_its_back(store, "UPDATE audit_entry SET who = 'panel 8' WHERE id = 300")
    with pytest.raises(UnusableInput, match="audit_entry, rows of id 256 to 511"):
        migrate(url, "0009")


def test_doctor_backup_and_restore_name_what_changed(store: Store, url: str, cli: Cli) -> None:
    path = Path(str(store.path))
    backup(url, path.with_name("sound.sqlite3"))
    _behind_its_back(store, "UPDATE audit_entry SET who = 'panel 8' WHERE id = 300")
    done = cli("doctor", "--db", url)
    assert done.code == 1
    assert "values that nobody wrote: audit_entry, rows of id 256 to 511" in done.out
    for refused in (
        cli("backup", "copy.sqlite3", "--db", url),
        cli("restore", path, "--db", "sqlite:///new.sqlite3"),
    ):
        assert refused.code == 2
        (line,) = refused.err.strip().splitlines()
        assert "audit_entry, rows of id 256 to 511" in line
        assert "restore an earlier backup with 'autodb restore'" in line
    assert not Path("copy.sqlite3").exists()
    assert not Path("new.sqlite3").exists()
    restore(url, path.with_name("sound.sqlite3"), replace=True)
    assert cli("doctor", "--db", url).code == 0


def test_every_bit_that_flips_in_a_cell_is_found(tmp_path: Path, store: Store, url: str) -> None:
    """Some bits; `autodb prove flips` has two hundred, of a shop's database."""
    with store.writing() as session:
        session.add(models.Machine(name="m", rotary_order=["c"]))
        session.flush()
        recorded = tmp_path / "recorded.csv"
        recorded.write_text("what was recorded")
        session.add(models.StoredRecording(
            machine_id=1, sha256=checksum(recorded), path=str(recorded), kind="cuts", rows=1,
            units={"x": "A"}, side={},
        ))  # fmt: skip
        session.flush()
        session.add_all(
            models.Cut(recording_id=1, number=n, conditions={"a": n}, measured={"z": n / 7})
            for n in range(1, 300)
        )
    backup(url, tmp_path / "whole.sqlite3")
    whole = Whole.of(tmp_path / "whole.sqlite3", tmp_path)
    tried = [whole.flip(tmp_path, seed) for seed in range(40)]
    counting = [flip for flip in tried if flip.counts]
    assert len(counting) > 10
    assert [flip for flip in counting if not (flip.by_doctor and flip.by_backup)] == []
