"""Scores of past predictions: the page and the route say what the command says."""

import json
from pathlib import Path

import pandas as pd

from tests.conftest import Cli
from tests.helpers.asked import client_of

MACHINE = ("--machine", "lathe")
JOB = """name = "shaft"
material = "C45"
tool = "insert"
[[cut]]
name = "rough"
diameter_mm = 56
depth_mm = 2.0
feed_mm_rev = 0.3
speed_m_min = 200
"""
SIDE = '[recording]\nwork = "C45"\njob = "shaft"\n[tool]\nname = "insert"\n'


def _served(path: str) -> str:
    with client_of("sqlite:///autodb.sqlite3") as client:
        got = client.get(path)
    assert got.status_code == 200, got.text
    return str(got.text)


def test_a_page_and_a_route_say_what_became_of_predictions(cli: Cli) -> None:
    cli("init")
    cli("machine", "add", "lathe")
    Path("shaft.toml").write_text(JOB, encoding="utf-8")
    assert cli("predict", "shaft.toml", *MACHINE).code == 0
    assert "No cut was made of a prediction yet" in _served("/machines/lathe/scores")
    row = {
        "cut": 1, "t": 0.0, "operation": "turn", "work.diameter": 56, "cutting.depth": 2.0,
        "cutting.feed": 0.3, "cutting.speed": 200.0, "force.x": 300.0, "force.y": 1100.0,
        "force.z": 600.0,
    }  # fmt: skip
    pd.DataFrame([row]).to_csv("made.csv", index=False)
    Path("made.toml").write_text(SIDE, encoding="utf-8")
    assert cli("import", "made.csv", *MACHINE).code == 0
    assert cli("refresh", *MACHINE).code == 0
    page = _served("/machines/lathe/scores")
    assert "1 cuts were predicted and then made" in page
    assert "force.y" in page
    assert 'id="against-force.y"' in page
    assert '/machines/lathe/recordings/1">1</a>' in page
    printed = json.loads(cli("predictions", "score", *MACHINE, "--json").out)
    assert json.loads(_served("/api/v1/machines/lathe/scores")) == printed
