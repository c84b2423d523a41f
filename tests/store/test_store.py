"""The database: migrations, constraints, one transaction a change."""

import sqlite3
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import alembic.op
import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import Engine, MetaData, Table, create_engine, inspect, select
from sqlalchemy.exc import IntegrityError

from autodb.errors import UnusableInput
from autodb.store import Store, create_store, head, migrate, models, open_store
from autodb.store.engines import engine_of
from autodb.store.rowsums import SUMS, driver_of
from autodb.store.schemas import objects


@pytest.fixture
def url(tmp_path: Path) -> str:
    return f"sqlite:///{tmp_path / 'a.sqlite3'}"


@pytest.fixture
def store(url: str) -> Iterator[Store]:
    create_store(url)
    opened = open_store(url)
    yield opened
    opened.close()


def test_creating_twice_changes_nothing(url: str) -> None:
    assert create_store(url).was is None
    assert not create_store(url).changed


@pytest.fixture
def migrated(tmp_path: Path) -> Iterator[Engine]:
    at = f"sqlite:///{tmp_path / 'migrated.sqlite3'}"
    migrate(at, head())
    engine = create_engine(at)
    yield engine
    engine.dispose()


def test_the_migrations_make_the_tables_of_the_models(migrated: Engine) -> None:
    both = MetaData()
    for table in (*models.Base.metadata.sorted_tables, SUMS):
        table.to_metadata(both)
    with migrated.connect() as connection:
        context = MigrationContext.configure(connection)
        assert compare_metadata(context, both) == []


def test_a_new_database_is_what_the_migrations_make(store: Store, migrated: Engine) -> None:
    """Column by column, with checks, keys and indexes, and at the same revision."""
    new, old = inspect(store.engine), inspect(migrated)
    assert sorted(new.get_table_names()) == sorted(old.get_table_names())
    for table in new.get_table_names():
        for look in (
            "get_check_constraints",
            "get_columns",
            "get_foreign_keys",
            "get_indexes",
            "get_unique_constraints",
        ):
            ours, theirs = getattr(new, look)(table), getattr(old, look)(table)
            assert sorted(map(_without_order, ours)) == sorted(map(_without_order, theirs)), table
    with store.engine.connect() as one, migrated.connect() as other:
        asked = "SELECT version_num FROM alembic_version"
        assert one.exec_driver_sql(asked).all() == other.exec_driver_sql(asked).all()
        assert objects(driver_of(one)) == objects(driver_of(other))  # triggers to the letter


def _without_order(found: dict[str, Any]) -> str:
    def said(value: Any) -> str:
        return str({k: str(v) for k, v in value.items()} if isinstance(value, dict) else value)

    return str(sorted((key, said(value)) for key, value in found.items() if key != "primary_key"))


def test_the_migrations_go_down_and_up_again(store: Store, url: str) -> None:
    migrate(url, "0001")
    migrate(url, "base")
    assert inspect(store.engine).get_table_names() == ["alembic_version"]
    migrate(url, head())
    assert "machine" in inspect(store.engine).get_table_names()


def test_a_migration_that_fails_halfway_leaves_nothing(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[str] = []

    def create(name: str, *columns: Any, **options: Any) -> None:
        made.append(name)
        if len(made) == 5:
            raise RuntimeError
        real(name, *columns, **options)

    real = alembic.op.create_table
    monkeypatch.setattr(alembic.op, "create_table", create)
    with pytest.raises(RuntimeError):
        migrate(url, head())
    assert _tables(url) == []


def test_a_creation_that_fails_halfway_leaves_nothing(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise RuntimeError

    monkeypatch.setattr(Table, "create", fail)  # the last of them, alembic's own
    with pytest.raises(RuntimeError):
        create_store(url)
    assert _tables(url) == []


def _tables(url: str) -> list[str]:
    engine = engine_of(url)
    found = inspect(engine).get_table_names()
    engine.dispose()
    return found


def test_foreign_keys_and_write_ahead_log_are_on(store: Store) -> None:
    with store.engine.connect() as connection:
        assert connection.exec_driver_sql("PRAGMA foreign_keys").scalar() == 1
        assert connection.exec_driver_sql("PRAGMA journal_mode").scalar() == "wal"
    with pytest.raises(IntegrityError), store.writing() as session:
        session.add(models.Axis(machine_id=99, name="x", carries="tool", current_sign=1))


BAD_ROWS = [
    lambda: models.Axis(machine_id=1, name="x", carries="nothing", current_sign=1),
    lambda: models.Axis(machine_id=1, name="x", carries="tool", current_sign=0),
    lambda: models.SensedForce(cut_id=1, component="z", estimator="range", value_N=1.0, sd_N=None),
    lambda: models.SensedForce(cut_id=1, component="z", estimator="none", reason=None),
    lambda: models.SensedForce(cut_id=1, component="q", estimator="none", reason="no"),
]


@pytest.mark.parametrize("make", BAD_ROWS)
def test_constraints_refuse_what_makes_no_sense(
    store: Store, make: Callable[[], models.Base]
) -> None:
    with store.writing() as session:
        machine = models.Machine(name="m")
        recording = models.StoredRecording(
            machine_id=1, sha256="a", path="a", kind="cuts", rows=1, units={}, side={}
        )
        session.add(machine)
        session.flush()
        session.add(recording)
        session.flush()
        session.add(models.Cut(recording_id=1, number=1, conditions={}, measured={}))
    with pytest.raises(IntegrityError), store.writing() as session:
        session.add(make())


def test_a_failed_change_leaves_nothing(store: Store) -> None:
    with pytest.raises(RuntimeError), store.writing() as session:
        session.add(models.Machine(name="half"))
        session.flush()
        raise RuntimeError
    with store.reading() as session:
        assert session.scalars(select(models.Machine)).all() == []


def test_a_reader_sees_one_state(store: Store) -> None:
    with store.reading() as reader:
        before = len(reader.scalars(select(models.Machine)).all())
        with store.writing() as writer:
            writer.add(models.Machine(name="new"))
        assert len(reader.scalars(select(models.Machine)).all()) == before


def test_what_is_no_database_says_so(tmp_path: Path) -> None:
    missing = f"sqlite:///{tmp_path / 'none.sqlite3'}"
    with pytest.raises(UnusableInput, match="make one with 'autodb init'"):
        open_store(missing)
    other = tmp_path / "other.sqlite3"
    sqlite3.connect(other).execute("CREATE TABLE a (b)")
    with pytest.raises(UnusableInput, match="no autodb database"):
        open_store(f"sqlite:///{other}")
    with pytest.raises(UnusableInput, match="another program's tables"):
        create_store(f"sqlite:///{other}")
    text = tmp_path / "text.sqlite3"
    text.write_text("not a database at all, but long enough to be read as one" * 20)
    with pytest.raises(UnusableInput, match="cannot be opened as a database"):
        open_store(f"sqlite:///{text}")
    with pytest.raises(UnusableInput, match="no database URL"):
        open_store("nonsense")
    with pytest.raises(UnusableInput, match="only SQLite and"):
        open_store("mysql://localhost/a")


def test_another_schema_is_not_opened(store: Store, url: str) -> None:
    with store.engine.connect().execution_options(autodb_writes=True) as connection:
        connection.exec_driver_sql("UPDATE alembic_version SET version_num = '9999'")
        connection.commit()
    with pytest.raises(UnusableInput, match="schema 9999"):
        open_store(url)
