"""The database of the working folder, and all that it holds."""

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

DB = Path("autodb.sqlite3")
URL = "sqlite:///autodb.sqlite3"


def rows_of(path: Path) -> dict[str, list[dict[str, Any]]]:
    """Return the rows of each table, whatever the order of rows and columns."""
    with closing(sqlite3.connect(path)) as connection:
        connection.row_factory = lambda cursor, row: dict(
            sorted(zip([column[0] for column in cursor.description], row, strict=True))
        )
        found = connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")
        names = [row["name"] for row in found]
        return {n: sorted(connection.execute(f"SELECT * FROM {n}"), key=repr) for n in names}
