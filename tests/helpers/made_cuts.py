"""Jobs that are predicted, and tables of the cuts made of them."""

import json
import sqlite3
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from tests.conftest import Cli

if TYPE_CHECKING:
    pass

MACHINE = ("--machine", "lathe")
JOB = """name = "{name}"
material = "C45"
tool = "insert"
{cuts}"""
CUT = """
[[cut]]
name = "{0}"
diameter_mm = {1}
depth_mm = {2}
feed_mm_rev = {3}
speed_m_min = 200
"""
SHAFT = (("rough 56", 56, 2.0, 0.3), ("rough 48", 48, 2.0, 0.25), ("finish 39", 39, 1.0, 0.12))
GROOVES = (("left", 50, 1.0, 0.1), ("right", 50, 1.0, 0.1))
SIDE = '[recording]\nwork = "C45"\n{said}[tool]\nname = "insert"\n'
FORCES = ("force.x", "force.y", "force.z")
Row = tuple[Any, ...]
Columns = dict[str, Sequence[object]]


def write_job(name: str, cuts: Sequence[Row]) -> Path:
    path = Path(f"{name}.toml")
    text = "".join(CUT.format(*cut) for cut in cuts)
    path.write_text(JOB.format(name=name, cuts=text), encoding="utf-8")
    return path


def predict_job(cli: Cli, name: str, cuts: Sequence[Row]) -> Any:
    ran = cli("predict", write_job(name, cuts), *MACHINE, "--json")
    assert ran.code == 0, ran.err
    return json.loads(ran.out)


def write_cuts(name: str, cuts: Sequence[Row], said: str = "", **columns: Sequence[object]) -> Path:
    """Write cuts as a table, with forces of 1000 N unless ``columns`` say otherwise."""
    _, diameter, depth, feed = zip(*cuts, strict=True)
    forces: Columns = {c: [1000.0 + 7 * k for k in range(len(cuts))] for c in FORCES}
    pd.DataFrame(
        {
            "cut": range(1, len(cuts) + 1), "t": 60 * np.arange(len(cuts)), "operation": "turn",
            "work.diameter": diameter, "cutting.depth": depth, "cutting.feed": feed,
            "cutting.speed": 200.0, **forces, **columns,
        }
    ).to_csv(f"{name}.csv", index=False)  # fmt: skip
    Path(f"{name}.toml").write_text(SIDE.format(said=said), encoding="utf-8")
    return Path(f"{name}.csv")


def import_and_refresh(cli: Cli, table: Path) -> str:
    """Import a table and refresh; return what the refresh said."""
    return _after(cli, table, "refresh")


def import_and_match(cli: Cli, table: Path) -> str:
    """Import a table and match its cuts alone, which is faster; return what that said."""
    return _after(cli, table, "predictions", "match")


def _after(cli: Cli, table: Path, *command: str) -> str:
    ran = cli("import", table, *MACHINE)
    assert ran.code == 0, ran.err
    done = cli(*command, *MACHINE)
    assert done.code == 0, done.err
    return done.out


def queried(query: str) -> list[Row]:
    with closing(sqlite3.connect("autodb.sqlite3")) as file:
        return file.execute(query).fetchall()


def links() -> dict[float, tuple[str, str]]:
    """Return by number of a cut what it is of its job, and by what it is known."""
    found = queried(
        "SELECT cut.number, predicted_cut.name, matched_by FROM predicted_cut JOIN cut "
        "ON cut.id = cut_id WHERE superseded_at IS NULL ORDER BY cut.id"
    )
    return {number: (name, by) for number, name, by in found}


def scores(cli: Cli) -> Any:
    ran = cli("predictions", "score", *MACHINE, "--json")
    assert ran.code == 0, ran.err
    return json.loads(ran.out)
