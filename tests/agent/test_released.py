"""Databases written by released versions open, keep what they hold, and go down again unchanged."""

import json
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import alembic.op
import numpy as np
import pytest
from numpy.testing import assert_array_equal

from autodb.store import create_store, head, migrate
from autodb.store.schemas import expected_shape
from tests.conftest import Cli
from tests.helpers.released import VERSIONS, content, recorded, shape, unpacked

DB = Path("autodb.sqlite3")
URL = f"sqlite:///{DB}"
WRITTEN_BY_UPGRADES = {"alembic_version", "row_checksum"}


@pytest.fixture(params=VERSIONS)
def version(request: pytest.FixtureRequest) -> str:
    """Return each released version."""
    return str(request.param)


@pytest.fixture
def schema(version: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Have the version's database as the one in the working folder; return its schema's number."""
    monkeypatch.chdir(tmp_path)
    return unpacked(version, DB)


def test_a_released_database_is_upgraded_and_says_from_where(schema: str, cli: Cli) -> None:
    before = content(DB)
    assert f"schema {schema}, this version needs" in cli("machine", "list").err
    assert f"upgraded from schema {schema} to {head()}" in cli("init").out
    after = content(DB)
    for table in before.keys() - WRITTEN_BY_UPGRADES:
        pairs = zip(after[table], before[table], strict=True)
        assert [{name: now[name] for name in was} for now, was in pairs] == before[table], table
    assert "z" in cli("machine", "show", "lathe-1").out
    failed = [line.strip() for line in cli("doctor").out.splitlines() if "FAILED" in line]
    assert len(failed) == 1
    assert failed[0].startswith("recordings not on the disk")


def test_it_goes_down_again_unchanged(schema: str) -> None:
    before, made = content(DB), shape(URL)
    create_store(URL)
    assert content(DB) != before
    migrate(URL, schema)
    assert content(DB) == before
    assert shape(URL) == made


def test_an_upgrade_that_fails_halfway_leaves_the_released_database(
    schema: str, version: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It fails where half of the tables that are made anew are, and at the last of them."""
    expected_shape(schema)  # which makes tables too, of another file
    before, made = content(DB), shape(URL)
    real, changed, fails_at = alembic.op.batch_alter_table, list[str](), 0

    def alter(name: str, **options: Any) -> Any:
        changed.append(name)
        if len(changed) == fails_at:
            raise RuntimeError
        return real(name, **options)

    monkeypatch.setattr(alembic.op, "batch_alter_table", alter)
    unpacked(version, Path("copy.sqlite3"))
    create_store("sqlite:///copy.sqlite3")
    for number in ((len(changed) + 1) // 2, len(changed)):
        fails_at = number
        changed.clear()
        with pytest.raises(RuntimeError):
            create_store(URL)
        assert content(DB) == before
        assert shape(URL) == made


def test_a_database_with_rows_that_lead_nowhere_is_not_upgraded(
    schema: str, refused: Callable[..., str]
) -> None:
    assert schema
    with closing(sqlite3.connect(DB)) as file:
        file.execute("DELETE FROM recording WHERE id = 1")
        file.commit()
    before = content(DB)
    assert "points to no recording; restore a backup" in refused("init")
    assert content(DB) == before


def test_it_holds_the_parameters_that_were_recorded(version: str, schema: str, cli: Cli) -> None:
    assert schema < head()
    assert cli("init").code == 0
    kept = content(DB)["cutting_parameters"]
    for row, was in zip(kept, recorded(version)["parameters"], strict=True):
        assert {name: row[name] for name in ("component", "version")} == {
            name: was[name] for name in ("component", "version")
        }
        assert json.loads(row["mean"]) == was["mean"]
        covariance = np.array(json.loads(row["covariance"]))
        assert_array_equal(np.diag(covariance), _variances(was))


def _variances(was: dict[str, Any]) -> list[float]:
    if "variances" in was:
        return list(was["variances"])
    return [row[number] for number, row in enumerate(was["covariance"])]
