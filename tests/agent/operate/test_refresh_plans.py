"""How SQLite finds what a refresh of one machine asks: never through the cuts of all of them."""

from pathlib import Path
from typing import Any

import pandas as pd
from sqlalchemy import event

from autodb.agent.ingest.importing import import_file
from autodb.agent.operate.refreshing import refresh
from autodb.store import open_store
from autodb.store.engines import open_sqlite
from tests.conftest import Cli

OF_ALL = "ix_cut_superseded_at"
FEW = 4


def test_a_refresh_goes_by_no_index_of_the_cuts_of_all(
    standard_learnt: Cli, sample_jobs: Path
) -> None:
    assert standard_learnt is not None
    week = pd.read_csv(sample_jobs / "stepped_shaft/recordings/shop-week-1.csv")
    week.head(FEW).to_csv("few.csv", index=False)
    store = open_store("sqlite:///autodb.sqlite3")
    asked: list[tuple[str, Any]] = []
    event.listen(store.engine, "before_cursor_execute", lambda *a: asked.append((a[2], a[3])))
    import_file(store, Path("few.csv"), machine="lathe-1")
    assert refresh(store, "lathe-1").versions
    store.close()
    with open_sqlite(Path("autodb.sqlite3")) as connection:
        plans = {
            (row[3], statement)
            for statement, given in asked
            if statement.lstrip().startswith("SELECT")
            for row in connection.execute(f"EXPLAIN QUERY PLAN {statement}", given)
        }
    connection.close()
    assert len(plans) > 50
    withdrawn = "superseded_at IS NOT NULL"  # those are few indeed
    assert not [plan for plan in plans if OF_ALL in plan[0] and withdrawn not in plan[1]]
