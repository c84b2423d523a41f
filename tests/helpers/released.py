"""Databases as released versions wrote them: unpacked, read and compared."""

import gzip
import json
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

from sqlalchemy import inspect

from autodb.store.engines import engine_of
from tests.conftest import ROOT

FOLDER = ROOT / "tests" / "agent" / "released"
VERSIONS = sorted(path.name.removesuffix(".sqlite3.gz") for path in FOLDER.glob("*.sqlite3.gz"))

Rows = dict[str, list[dict[str, Any]]]
"""Rows by their table, each by its columns, in the order of the first."""


def unpacked(version: str, path: Path) -> str:
    """Unpack a released version's database as a file; return the number of its schema."""
    path.write_bytes(gzip.decompress((FOLDER / f"{version}.sqlite3.gz").read_bytes()))
    with closing(sqlite3.connect(path)) as file:
        (revision,) = file.execute("SELECT version_num FROM alembic_version").fetchone()
    return str(revision)


def recorded(version: str) -> dict[str, Any]:
    """Return what a released version was seen to hold and to answer."""
    found: dict[str, Any] = json.loads((FOLDER / f"{version}.json").read_text("utf-8"))
    return found


def content(path: Path) -> Rows:
    """Return all that a file holds."""
    with closing(sqlite3.connect(path)) as file:
        file.row_factory = sqlite3.Row
        names = file.execute("SELECT name FROM sqlite_master WHERE type = 'table'").fetchall()
        return {
            name: [dict(row) for row in file.execute(f"SELECT * FROM {name} ORDER BY 1")]
            for (name,) in names
        }


def shape(url: str) -> dict[str, Any]:
    """Return columns, keys, checks and indices of every table, without the names of constraints."""
    engine = engine_of(url)
    look = inspect(engine)
    found = {}
    for name in look.get_table_names():
        found[name] = {
            "columns": [
                (c["name"], str(c["type"]), c["nullable"], c["default"])
                for c in look.get_columns(name)
            ],
            "unique": sorted(sorted(u["column_names"]) for u in look.get_unique_constraints(name)),
            "checks": sorted(
                c["sqltext"].replace('"', "") for c in look.get_check_constraints(name)
            ),
            "keys": sorted(
                (k["constrained_columns"], k["referred_table"], k["options"].get("ondelete", ""))
                for k in look.get_foreign_keys(name)
            ),
            "indices": sorted((i["name"], i["column_names"]) for i in look.get_indexes(name)),
        }
    engine.dispose()
    return found
