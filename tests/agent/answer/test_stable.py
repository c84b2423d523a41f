"""`autodb stability`: lobes of a job's cuts beside the machine's limits, as text, JSON, picture."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import autodb
from tests.conftest import Cli

MODES = """[[mode]]
axis = "{axis}"
frequency_Hz = 603.0
damping_ratio = 0.03
stiffness_N_m = 8.0e6
"""
JOB = """name = "pocket"
material = "C45"
tool = "mill"
[[cut]]
name = "rough"
operation = "side-down"
depth_mm = 2.0
width_mm = 2.0
feed_mm_tooth = 0.06
speed_rpm = 6000.0
"""
TOOL = """name = "mill"
kind = "end_mill"
[geometry]
diameter_mm = 10.0
teeth = 4
helix_deg = 30.0
rake_deg = 8.0
"""
MACHINE = """[axes.spindle.limits]
torque_N_m = 20.0
speed_rpm = 6200.0
"""
ASKED = ("stability", "job.toml", "--dynamics", "tool-point.toml", "--tool-file", "tool.toml")


@pytest.fixture
def asked(cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Cli:
    monkeypatch.chdir(tmp_path)
    files = {"job.toml": JOB, "tool.toml": TOOL, "machine.toml": MACHINE}
    files["tool-point.toml"] = "".join(MODES.format(axis=axis) for axis in "xy")
    for name, text in files.items():
        Path(name).write_text(text, "utf-8")
    cli("init")
    cli("machine", "add", "m", "--file", "machine.toml")
    return cli


def test_depths_are_said_beside_limits(asked: Cli) -> None:
    said = asked(*ASKED, "--plot", "lobes.html").out
    assert "cut 'rough', 2 mm deep at 6000 rpm: stable up to" in said
    assert "largest depth within 100 % of each limit with 95 % probability" in said
    assert "half the tooth frequency" in said
    (one,) = json.loads(asked(*ASKED, "--json").out)
    stable = one["stable"]
    assert stable["depth_mm"]["low"] < stable["depth_mm"]["value"] < stable["depth_mm"]["high"]
    assert stable["any_speed_mm"]["value"] <= stable["depth_mm"]["value"]
    assert all(better["speed_rpm"] <= 6200.0 for better in stable["better"])
    assert one["loads"]["value"] > 0.0
    page = Path("lobes.html").read_text("utf-8")
    assert "stability lobes of cut 1" in page


def test_what_a_machine_does_not_state_is_said_once(asked: Cli) -> None:
    """Of two cuts, and of a machine without limits."""
    Path("job.toml").write_text(JOB + JOB[JOB.index("[[cut]]") :].replace("rough", "more"), "utf-8")
    asked("machine", "add", "bare")
    said = asked(*ASKED, "--machine", "bare", "--plot", "lobes.html").out
    assert said.count("states no limit") == 1
    assert said.count("deep at 6000 rpm") == 2
    assert Path("lobes.html").read_text("utf-8").count("states no limit") == 1


def test_a_wide_interval_does_not_press_the_lobes_flat(asked: Cli) -> None:
    """With a compliance hardly known the upper end is far above the lobes: a line says where."""
    wide = "".join(MODES.format(axis=axis) + "share = 0.9\n" for axis in "xy")
    Path("tool-point.toml").write_text(wide, "utf-8")
    (one,) = json.loads(asked(*ASKED, "--plot", "lobes.html", "--json").out)
    stable = one["stable"]
    middle = float(np.median([mm for mm in stable["limit_mm"] if mm is not None]))
    page = Path("lobes.html").read_text("utf-8")
    tops = re.findall(r'"yaxis":\{[^}]*"range":\[0\.0,([\d.]+)\]', page)
    assert_allclose([float(one) for one in tops], max(3.0 * middle, 1.2 * 2.0), rtol=1e-6)
    assert max(mm for mm in stable["high_mm"] if mm is not None) > 3.0 * middle
    assert "the upper end of the interval lies above it" in page


def test_the_library_says_what_the_command_says(asked: Cli) -> None:
    theirs = json.loads(asked(*ASKED[:4], "--json", *ASKED[4:]).out)
    assert theirs[0]["stable"]["depth_mm"]
    machine = autodb.open("autodb.sqlite3").machine("m")
    with pytest.raises(autodb.UnusableInput, match="nowhere"):
        machine.stability("job.toml", "nowhere.toml")
    asked("predict", "job.toml", "--tool-file", "tool.toml")  # keeps the tool's geometry
    found = machine.stability("job.toml", "tool-point.toml")
    assert found.to_dict()["cuts"] == theirs
    assert "deep at 6000 rpm: stable up to" in found.lines[0]
    (row,) = found.to_pandas().to_dict("records")
    assert row["depth_mm_low"] < row["depth_mm"] < row["depth_mm_high"]
    assert row["loads_mm"] == theirs[0]["loads"]["value"]
    assert "stability lobes of cut 1" in found.plot().page


def test_a_plan_of_another_material_is_compared_with_the_same_tool_file(asked: Cli) -> None:
    Path("other.toml").write_text(JOB.replace("C45", "S235"), "utf-8")
    found = asked("predict", "job.toml", "--tool-file", "tool.toml", "--beside", "other.toml")
    assert found.code == 0, found.err
    assert "Beside each other" in found.out


def test_what_cannot_be_used_is_said_in_a_line(refused: Callable[..., str], asked: Cli) -> None:
    assert asked is not None
    Path("tool-point.toml").write_text(MODES.format(axis="q"), "utf-8")
    assert "tool-point.toml: mode" in refused(*ASKED)
    Path("tool-point.toml").write_text("[[mode]]\n", "utf-8")
    assert "tool-point.toml" in refused(*ASKED)
    assert "--plot" in refused(*ASKED, "--plot", "lobes.txt")
    assert "nowhere.csv" in refused("stability", "job.toml", "--dynamics", "nowhere.csv")
