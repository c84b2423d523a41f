"""The JSON Schemas are what the code makes, and agree with the readers on good and bad files."""

import json
import tomllib
from pathlib import Path
from typing import Any

import jsonschema
import pandas as pd
import pytest
from pydantic import ValidationError

from autodb.cli.develop.schemas import FORMATS, texts, unit_of_key
from tests.conftest import ROOT, Cli
from tests.helpers.trapezoids import current, moves

JOBS = ROOT / "sample_jobs"
SAMPLES = [
    ("job", JOBS / "stepped_shaft" / "job.toml"),
    ("job", JOBS / "nc_profile" / "job.toml"),
    ("machine", JOBS / "stepped_shaft" / "machine.toml"),
    ("tool", JOBS / "stepped_shaft" / "tool.toml"),
    ("standard_cuts", ROOT / "calibration" / "turning-aluminium.toml"),
    ("standard_cuts", ROOT / "calibration" / "milling-c45.toml"),
    ("standard_cuts", ROOT / "calibration" / "drilling-c45.toml"),
    *(
        ("conventional", ROOT / "calibration" / "conventional" / f"{name}.toml")
        for name in ("ti6al4v", "c45", "al7075", "s235")
    ),
    ("side_file", JOBS / "stepped_shaft" / "recordings" / "standard-cut-raw.toml"),
    ("side_file", JOBS / "emps" / "columns.toml"),
    ("side_file", JOBS / "vicomtech_turning_wear" / "columns.toml"),
]
MODELS = {name: model for name, _, model, _ in FORMATS}


def _schema(name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((ROOT / "schema" / f"{name}.schema.json").read_text())
    return found


def _accepts(name: str, content: dict[str, Any]) -> bool:
    """Say whether schema and model accept a file; they must agree."""
    by_schema = bool(jsonschema.Draft202012Validator(_schema(name)).is_valid(content))
    try:
        MODELS[name].model_validate(content)
        by_model = True
    except ValidationError:
        by_model = False
    assert by_schema == by_model
    return by_schema


def test_the_schemas_are_what_the_code_makes() -> None:
    stored = {path.name: path.read_text() for path in (ROOT / "schema").glob("*.schema.json")}
    assert stored == texts()


@pytest.mark.parametrize("name", sorted(MODELS))
def test_each_schema_is_a_schema_with_a_name_of_its_own(name: str) -> None:
    schema = _schema(name)
    jsonschema.Draft202012Validator.check_schema(schema)
    assert schema["$id"] == f"urn:autodb:{name}"
    assert schema["title"]
    assert schema["description"]


@pytest.mark.parametrize(("name", "path"), SAMPLES, ids=lambda value: getattr(value, "name", value))
def test_samples_are_accepted_and_misspelt_ones_are_not(name: str, path: Path) -> None:
    content = tomllib.loads(path.read_text())
    assert _accepts(name, content)
    assert not _accepts(name, {**content, "nonsense": 1})


BAD = [
    ("job", {"name": "a", "material": "b", "tool": "c", "cut": []}),
    ("machine", {"axes": {}}),
    ("machine", {"axes": {"z": {"carries": "nothing"}}}),
    ("machine", {"axes": {"z": {"limits": {"force_N": -1}}}}),
    ("machine", {"axes": {"z": {}}, "setup": {"tool": 1, "spindle": "M5"}}),
    ("tool", {"name": "a", "kind": "saw"}),
    ("standard_cuts", {"name": "a", "material": "b", "tool": "c", "cut": []}),
    ("standard_cuts", {"name": "a", "material": "b", "tool": "c", "air_s": 1, "cut": [{}]}),
    ("conventional", {"note": "no name"}),
    ("conventional", {"name": "a", "kienzle": {"k_c11": 1780, "m_c": 0.17}}),
    ("side_file", {"channels": {"t": 3}}),
    ("side_file", {"tool": {"teeth": 0}}),
    ("explanation", {"recording": "a"}),
]


@pytest.mark.parametrize(("name", "content"), BAD)
def test_bad_files_are_refused_by_schema_and_reader(name: str, content: dict[str, Any]) -> None:
    assert not _accepts(name, content)


def test_what_explain_writes_is_an_explanation(cli: Cli) -> None:
    moved = moves(2, seconds=20.0)
    simulation = {"t": moved["t"], "x.current": current(moved, 3, coulomb=0.0)}
    pd.DataFrame({**moved, "x.current": current(moved, 2)}).to_csv("moves.csv", index=False)
    pd.DataFrame(simulation).to_csv("simulation.csv", index=False)
    done = cli("explain", "moves.csv", "--simulation", "simulation.csv", "--json")
    answer = json.loads(done.out)
    assert answer["channels"]["x.current"]["missing"]
    assert _accepts("explanation", answer)


def test_the_docs_quote_the_sample_files() -> None:
    text = (ROOT / "docs" / "formats.md").read_text()
    for name in ("machine.toml", "tool.toml"):
        assert (JOBS / "stepped_shaft" / name).read_text() in text


def test_every_physical_key_says_its_unit() -> None:
    assert unit_of_key("torque_constant_N_m_A") == "N·m/A"
    assert unit_of_key("limits") is None
    for name in MODELS:
        schema = _schema(name)
        for part in (schema, *schema.get("$defs", {}).values()):
            for key, value in part.get("properties", {}).items():
                assert unit_of_key(key) is None or value["description"] == unit_of_key(key)
