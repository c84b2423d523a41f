"""What a database may consist of: the tables, indices and triggers of its schema, and nothing else.

A trigger or view that somebody else put into a file runs with the rights of who writes to it next.
"""

import sqlite3
from collections.abc import Mapping
from contextlib import closing
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from sqlalchemy import create_engine

from autodb.store import models, rowsums
from autodb.store.schemas import head, make_in, migrate

Objects = dict[tuple[str, str], str | tuple[str, ...] | None]
"""What makes each thing of a schema, by kind and name; None: SQLite makes it for a table."""
STATISTICS = (("table", "sqlite_stat1"), ("table", "sqlite_stat4"))
"""What SQLite's ANALYZE leaves: numbers that only its planner reads."""
RUNS = ("trigger", "view")
"""Kinds that do something by themselves, or instead of what they are taken for."""


def objects(file: sqlite3.Connection) -> Objects:
    """Return what a database consists of."""
    found = file.execute("SELECT type, name, sql FROM sqlite_master").fetchall()
    return {
        (kind, name): _plain(kind, sql)
        for kind, name, sql in found
        if (kind, name) not in STATISTICS
    }


def _plain(kind: str, sql: str | None) -> str | tuple[str, ...] | None:
    """Return SQL to compare: of a table, what it lists in any order; migrations add at the end."""
    if kind != "table" or sql is None:
        return sql
    told = " ".join(sql.replace('"', "").split())
    begin, end = told.find("("), told.rfind(")")
    parts = _parted(told[begin + 1 : end])
    return (told[:begin].strip(), told[end:], *sorted(part.strip() for part in parts))


def _parted(text: str) -> list[str]:
    """Split a list at its commas, but for those in brackets."""
    depth, parts = 0, [""]
    for letter in text:
        depth += (letter == "(") - (letter == ")")
        if letter == "," and not depth:
            parts.append("")
        else:
            parts[-1] += letter
    return parts


@cache
def expected_shape(revision: str) -> Objects:
    """Return what a database of a schema that this version knows consists of."""
    if revision == head():
        engine = create_engine("sqlite://")
        with engine.connect() as connection:
            rowsums.register(rowsums.driver_of(connection))
            make_in(connection)
            found = objects(rowsums.driver_of(connection))
        engine.dispose()
        return found
    with TemporaryDirectory() as folder:
        path = Path(folder) / "expected.sqlite3"
        migrate(f"sqlite:///{path}", revision)
        with closing(sqlite3.connect(path)) as file:
            return objects(file)


def strange(file: sqlite3.Connection, revision: str) -> list[str]:
    """Return what a database has beyond its schema, lacks of it or has otherwise, in words."""
    return _differing(objects(file), expected_shape(revision))


def running(file: sqlite3.Connection) -> list[str]:
    """Return what triggers and views a database of this version's schema has or lacks, in words.

    It is asked at each opening: before anything is written that they might run for.
    """
    known: Objects = {
        ("trigger", name): sql
        for name, sql in rowsums.triggers(rowsums.of_metadata(models.Base.metadata)).items()
    }
    found = file.execute(
        f"SELECT type, name, sql FROM sqlite_master WHERE type IN {RUNS}"
    ).fetchall()
    return _differing({(kind, name): sql for kind, name, sql in found}, known)


def _differing(found: Mapping[tuple[str, str], object], known: Objects) -> list[str]:
    both = found.keys() & known.keys()
    different = (found.keys() ^ known.keys()) | {one for one in both if found[one] != known[one]}
    return [_said(one, one in found, one in known) for one in sorted(different, key=_order)]


def _order(thing: tuple[str, str]) -> tuple[bool, str]:
    """Return by what things are listed: what runs by itself first."""
    return thing[0] not in RUNS, thing[1]


def _said(thing: tuple[str, str], found: bool, known: bool) -> str:
    how = "is not the schema's" if known and found else "is no part of autodb's schema"
    return f"{thing[0]} '{thing[1]}' {how if found else 'is missing'}"
