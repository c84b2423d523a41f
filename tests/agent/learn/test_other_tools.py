"""A tool that is new to a machine starts from what its other tools told of the material."""

from pathlib import Path

import numpy as np
import pandas as pd

from autodb.agent.learn.starting import start_of
from autodb.store import open_store
from tests.conftest import Cli

SIDE = '[recording]\nwork = "C45"\n[tool]\nname = "{tool}"\nkappa_deg = 93\nnose_radius_mm = 0.8\n'


def _table(tool: str, scale: float, seed: int) -> Path:
    """Write twelve cuts of a tool whose forces a dynamometer measured."""
    rng = np.random.default_rng(seed)
    feed, depth = rng.uniform(0.1, 0.4, 12), rng.uniform(1.0, 3.0, 12)
    tangential = scale * 1900.0 * depth * feed**0.75
    pd.DataFrame(
        {
            "cut": range(1, 13), "t": 60 * np.arange(12), "operation": "turn",
            "work.diameter": 50.0, "cutting.depth": depth, "cutting.feed": feed,
            "cutting.speed": 180.0, "force.x": 0.25 * tangential, "force.y": tangential,
            "force.z": 0.5 * tangential * feed**-0.1,
        }
    ).to_csv(f"{tool}.csv", index=False)  # fmt: skip
    Path(f"{tool}.toml").write_text(SIDE.format(tool=tool), encoding="utf-8")
    return Path(f"{tool}.csv")


def test_a_third_tool_starts_from_both_others_and_is_traced_to_them(cli: Cli) -> None:
    cli("init")
    cli("machine", "add", "lathe")
    for number, (tool, scale) in enumerate((("first", 1.0), ("second", 1.1), ("third", 1.05))):
        cli("import", _table(tool, scale, number), "--machine", "lathe")
        done = cli("refresh", "--machine", "lathe")
        assert done.code == 0, done.err
    store = open_store("sqlite:///autodb.sqlite3")
    with store.reading() as session:
        start = start_of(session, 1, "C45", "fourth")
    store.close()
    said = "C45 / first, the same material with another tool (12 cuts), and with "
    assert start.said == said + "second (12 cuts), third (12 cuts)"
    traced = " ".join(cli("trace", "parameters", "3").out.split())
    assert "began as: C45 / first, the same material with another tool" in traced
    assert "parameters 2: C45 / second, version 1" in traced
