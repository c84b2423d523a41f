"""Tool bits of FreeCAD are tools, and look-ups and predictions take a tool's file."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from numpy.testing import assert_allclose

from autodb.files.tool import geometry_of, read_tool
from tests.conftest import Cli

MILL = {"Diameter": "10.0000 mm", "CuttingEdgeHeight": "30.0000 mm", "Flutes": "3"}
JOB = """name = "slot"
material = "C45"
tool = "10 mm mill"
[[cut]]
operation = "slot"
depth_mm = 2
feed_mm_tooth = 0.05
speed_rpm = 3000
"""


def _bit(folder: Path, **changed: Any) -> Path:
    said = {"version": 2, "name": "10 mm mill", "shape": "endmill.fcstd", "parameter": MILL}
    path = folder / "mill.fctb"
    path.write_text(json.dumps({**said, **changed}), "utf-8")
    return path


@pytest.mark.parametrize(
    ("changed", "kind", "expected"),
    [
        ({}, "end_mill", {"diameter_mm": 10.0, "teeth": 3, "corner_radius_mm": 0.0}),
        (
            {"shape-type": "Ballend", "parameter": {"Diameter": "0.25 in", "Flutes": 0}},
            "end_mill",
            {"diameter_mm": 6.35, "corner_radius_mm": 3.175},
        ),
        (
            {"shape-type": "Bullnose", "parameter": {**MILL, "CornerRadius": "1,5 mm"}},
            "end_mill",
            {"diameter_mm": 10.0, "teeth": 3, "corner_radius_mm": 1.5},
        ),
        (
            {"shape": "drill.fcstd", "parameter": {"Diameter": 5, "TipAngle": "119.0000 °"}},
            "drill",
            {"diameter_mm": 5.0, "point_angle_deg": 119.0},
        ),
        (
            {"shape": "Iso_shape_C.fcstd", "parameter": {"TipRadius": "0.40 mm"}},
            "turning_insert",
            {"nose_radius_mm": 0.4, "included_deg": 80.0},
        ),
        (
            {"shape-type": "isoshape", "parameter": {"TipRadius": "0.4 mm", "TipAngle": "35 °"}},
            "turning_insert",
            {"nose_radius_mm": 0.4, "included_deg": 35.0},
        ),
        (
            {"shape": "torus.fcstd", "parameter": {"Diameter": "1/4 in", "TorusRadius": "1,0 mm"}},
            "end_mill",
            {"diameter_mm": 6.35, "corner_radius_mm": 1.0},
        ),
    ],
)
def test_a_bit_says_what_a_tool_file_would(
    tmp_path: Path, changed: dict[str, Any], kind: str, expected: dict[str, float]
) -> None:
    found = read_tool(_bit(tmp_path, **changed))
    assert (found.kind, found.name) == (kind, "10 mm mill")
    geometry = geometry_of(found).model_dump(exclude_none=True)
    assert set(geometry) == set(expected)
    assert_allclose([geometry[name] for name in expected], list(expected.values()))


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"shape": "chamfer.fcstd"}, "shape 'chamfer' is no tool whose forces are known"),
        ({"parameter": {"Diameter": "wide"}}, "parameter.Diameter: 'wide' is no quantity"),
        ({"parameter": {"Diameter": "-5 mm"}}, "geometry.diameter_mm"),
        ({"parameter": None}, "parameter: missing"),
    ],
)
def test_a_bit_that_is_none_is_refused(
    tmp_path: Path, refused: Callable[..., str], changed: dict[str, Any], said: str
) -> None:
    path = _bit(tmp_path, **changed)
    line = refused("lookup", "--machine", "m", "--tool-file", path)
    assert said in line
    assert str(path) in line


def test_a_tool_s_file_is_taken_by_look_ups_and_kept_by_predictions(
    tmp_path: Path, cli: Cli, refused: Callable[..., str]
) -> None:
    bit = _bit(tmp_path)
    for asked in (("init",), ("machine", "add", "m")):
        assert cli(*asked).code == 0
    slot = ("--operation", "slot", "--depth", 2, "--feed", 0.05, "--rpm", 3000)
    named = ("lookup", "--machine", "m", "--material", "C45", *slot)
    assert "not known" in refused(*named, "--tool", "10 mm mill")
    found = json.loads(cli(*named, "--tool-file", bit, "--json").out)
    assert found["tool"] == "10 mm mill"
    assert "not known" in refused(*named, "--tool", "10 mm mill")

    Path("job.toml").write_text(JOB, "utf-8")
    done = cli("predict", "job.toml", "--machine", "m", "--tool-file", bit, "--json")
    assert json.loads(done.out)["cuts"][0]["torque_N_m"] == found["cut"]["torque_N_m"]
    assert cli(*named, "--tool", "10 mm mill").code == 0
    other = _bit(tmp_path, parameter={**MILL, "Diameter": "12 mm"})
    line = "diameter_mm is 10 here and 12 in the file"
    assert line in refused("predict", "job.toml", "--machine", "m", "--tool-file", other)
    assert line in refused(*named, "--tool-file", other)
    assert "one name" in refused(*named, "--tool", "mill", "--tool-file", bit)
    drilled = ("lookup", "--machine", "m", "--material", "C45", "--tool-file", bit)
    line = refused(*drilled, "--operation", "drill", "--feed", 0.1, "--rpm", 2000)
    assert "is of an end mill, which makes no 'drill'; name a file of a drill" in line
