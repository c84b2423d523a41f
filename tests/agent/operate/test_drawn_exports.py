"""Drawn tables of cuts: imported, exported and restored, every row of every table is the same.

What is stored is what was written, in all digits.
"""

import json
import os
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.conftest import Cli
from tests.helpers.kept import DB, rows_of

pytestmark = pytest.mark.usefixtures("one_law")

TIMES = int(os.environ.get("AUTODB_MUTATIONS", "1"))
WORDS = st.text("abcÄöüß=-+'\",;#|µ°² 019", min_size=1, max_size=9).filter(
    lambda text: text == text.strip() and text not in ("-", "+")
)
CUTS = st.lists(
    st.tuples(
        st.floats(0.01, 1.9), st.floats(0.01, 9.0), st.one_of(st.none(), st.floats(-40.0, 120.0))
    ),
    min_size=3,
    max_size=7,
)


def test_cuts_are_the_same_after_an_export(cli: Cli) -> None:
    @settings(
        max_examples=2 * TIMES,
        deadline=None,
        database=None,
        derandomize=TIMES == 1,
        suppress_health_check=list(HealthCheck),
    )
    @given(CUTS, WORDS, WORDS)
    def check(cuts: list[tuple[float, float, float | None]], material: str, tool: str) -> None:
        for left in (DB, Path("again.sqlite3"), Path("a.csv")):
            left.unlink(missing_ok=True)
        shutil.rmtree("out", ignore_errors=True)
        names = [f'"{name.replace(chr(34), 2 * chr(34))}"' for name in (material, tool)]
        lines = [
            "cut,operation,work.material,tool,cutting.feed,cutting.depth,lubricant.temperature"
        ]
        for number, (feed, depth, warm_degC) in enumerate(cuts, start=1):
            cells = [
                number,
                "turn",
                *names,
                feed,
                depth,
                "" if warm_degC is None else repr(warm_degC),
            ]
            lines.append(",".join(map(str, cells)))
        Path("a.csv").write_text("\n".join([*lines, ""]), "utf-8")
        assert cli("init").code == 0
        assert cli("machine", "add", "lathe").code == 0
        done = cli("import", "a.csv", "--machine", "lathe")
        assert done.code == 0, done.err
        assert cli("export", "out").code == 0
        assert cli("restore", "out", "--db", "sqlite:///again.sqlite3").code == 0
        assert rows_of(Path("again.sqlite3")) == rows_of(DB)
        _compare_stored(cuts, material, tool)

    check()


def _compare_stored(
    cuts: list[tuple[float, float, float | None]], material: str, tool: str
) -> None:
    with closing(sqlite3.connect("again.sqlite3")) as connection:
        kept = connection.execute("SELECT name FROM material").fetchall()
        used = connection.execute("SELECT name FROM tool").fetchall()
        rows = connection.execute("SELECT conditions, measured FROM cut ORDER BY number").fetchall()
    assert (kept, used) == ([(material,)], [(tool,)])
    stored = [{**json.loads(conditions), **json.loads(measured)} for conditions, measured in rows]
    for place, name in enumerate(("cutting.feed", "cutting.depth", "lubricant.temperature")):
        assert [cut.get(name) for cut in stored] == [cut[place] for cut in cuts]
