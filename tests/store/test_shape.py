"""A database consists of what its schema has: what somebody else put into it never runs."""

import gzip
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from autodb.store import head, migrate, revisions
from autodb.store.engines import engine_of
from autodb.store.schemas import expected_shape, objects, schema_faults
from tests.conftest import ROOT, Cli

DB = Path("autodb.sqlite3")
TOKEN = "INSERT INTO access_token (name, sha256, role, created_at) VALUES ('x', 'y', 'admin', 'z')"
FOREIGN = {
    "trigger 'helpful'": f"CREATE TRIGGER helpful AFTER INSERT ON machine BEGIN {TOKEN}; END",
    "view 'all_cuts'": "CREATE VIEW all_cuts AS SELECT * FROM cut",
    "table 'notes'": "CREATE TABLE notes (id INTEGER PRIMARY KEY, text VARCHAR)",
    "table 'search'": "CREATE VIRTUAL TABLE search USING fts5(text)",
    "index 'ix_more'": "CREATE INDEX ix_more ON cut (number)",
    "table 'cut'": "ALTER TABLE cut ADD COLUMN more VARCHAR DEFAULT 'x'",
}
OURS = "row_checksum_machine_insert"


def _do(path: Path, *statements: str) -> None:
    with closing(sqlite3.connect(path, isolation_level=None)) as file:
        for statement in statements:
            file.execute(statement)


def _tokens(path: Path) -> int:
    with closing(sqlite3.connect(path)) as file:
        return int(file.execute("SELECT count(*) FROM access_token").fetchone()[0])


@pytest.mark.parametrize(("names", "statement"), FOREIGN.items())
def test_what_the_schema_has_not_is_neither_restored_nor_backed_up(
    cli: Cli, refused: Callable[..., str], names: str, statement: str
) -> None:
    cli("init")
    cli("machine", "add", "kept")
    cli("backup", "foreign.sqlite3")
    _do(Path("foreign.sqlite3"), statement)
    before = DB.read_bytes()
    assert f"foreign.sqlite3: {names} is n" in refused("restore", "foreign.sqlite3", "--replace")
    assert DB.read_bytes() == before
    assert names in refused("backup", "copy.sqlite3", "--db", "sqlite:///foreign.sqlite3")
    assert not Path("copy.sqlite3").exists()
    done = cli("doctor", "--db", "sqlite:///foreign.sqlite3")
    assert done.code == 1
    assert f"what is no part of the schema: {names}" in done.out
    assert cli("machine", "list").out.count("kept") == 1


@pytest.mark.parametrize(
    ("statements", "says"),
    [
        ((FOREIGN["trigger 'helpful'"],), "trigger 'helpful' is no part of autodb's schema"),
        ((FOREIGN["view 'all_cuts'"],), "view 'all_cuts' is no part of autodb's schema"),
        ((f"DROP TRIGGER {OURS}",), f"trigger '{OURS}' is missing"),
        (
            (
                f"DROP TRIGGER {OURS}",
                f"CREATE TRIGGER {OURS} AFTER INSERT ON machine BEGIN {TOKEN}; END",
            ),
            f"trigger '{OURS}' is not the schema's",
        ),
    ],
)
def test_a_database_that_would_run_something_else_is_not_opened(
    cli: Cli, refused: Callable[..., str], statements: tuple[str, ...], says: str
) -> None:
    cli("init")
    cli("backup", "good.sqlite3")
    _do(DB, *statements)
    assert says in refused("machine", "add", "m")
    assert _tokens(DB) == 0
    assert (
        engine_of(f"sqlite:///{DB}")
        .pool.status()
        .startswith("Pool size: 5  Connections in pool: 0")
    )
    assert says in cli("doctor").out
    assert cli("restore", "good.sqlite3", "--replace").code == 0
    assert cli("machine", "add", "m").code == 0


def test_an_earlier_backup_with_a_trigger_is_not_brought_to_this_schema(
    cli: Cli, refused: Callable[..., str]
) -> None:
    migrate("sqlite:///old.sqlite3", "0008")
    _do(Path("old.sqlite3"), FOREIGN["trigger 'helpful'"])
    assert "trigger 'helpful'" in refused("restore", "old.sqlite3")
    assert "trigger 'helpful'" in refused("init", "--db", "sqlite:///old.sqlite3")
    assert not DB.exists()
    _do(Path("old.sqlite3"), "DROP TRIGGER helpful")
    assert f"schema 0008, upgraded to {head()}" in cli("restore", "old.sqlite3").out


@pytest.mark.parametrize(
    "packed", sorted((ROOT / "tests" / "agent" / "released").glob("*.sqlite3.gz"))
)
def test_databases_of_released_versions_are_what_their_schema_says(
    tmp_path: Path, packed: Path
) -> None:
    path = tmp_path / "released.sqlite3"
    path.write_bytes(gzip.decompress(packed.read_bytes()))
    with closing(sqlite3.connect(path)) as file:
        (revision,) = file.execute("SELECT version_num FROM alembic_version").fetchone()
        assert schema_faults(file, revision) == []


def test_a_database_brought_up_step_by_step_is_a_new_one(tmp_path: Path) -> None:
    path = tmp_path / "stepwise.sqlite3"
    for revision in revisions():
        migrate(f"sqlite:///{path}", revision)
    with closing(sqlite3.connect(path)) as file:
        assert objects(file) == expected_shape(head())


def test_what_analyze_leaves_is_no_fault(cli: Cli) -> None:
    cli("init")
    cli("machine", "add", "lathe-1")
    _do(DB, "ANALYZE")
    assert cli("backup", "copy.sqlite3").code == 0
    assert cli("restore", "copy.sqlite3", "--replace").code == 0
