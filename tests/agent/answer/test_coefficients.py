"""Fitted coefficients as a file: what a tool is by its codes, what was learnt beside it."""

import json
from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from numpy.testing import assert_allclose

from autodb.agent.answer.coefficients import tool_of
from autodb.agent.rows.posteriors import as_posterior, latest
from autodb.assets import kit
from autodb.cutting.kienzle import ViewRange, linear_edge
from autodb.cutting.shear import NAMES, PARAMETERS
from autodb.errors import UnusableInput
from autodb.files.coefficients import read_coefficients
from autodb.files.tool import ISO_13399
from autodb.fitting.gaussian import Gaussian
from autodb.store import models, open_store
from tests.conftest import Cli

FILE = "coefficients.json"


def test_another_program_gets_the_numbers_that_the_machine_believes(standard_learnt: Cli) -> None:
    done = standard_learnt("export", "--coefficients", FILE, "--machine", "lathe-1")
    assert done.code == 0, done.err
    assert f"{FILE}: 1 pairs" in done.out
    written = json.loads(Path(FILE).read_text(encoding="utf-8"))
    schema = json.loads((kit("schema") / "coefficients.schema.json").read_text(encoding="utf-8"))
    Draft202012Validator(schema).validate(written)
    (pair,) = read_coefficients(Path(FILE)).pairs
    store = open_store("sqlite:///autodb.sqlite3")
    with store.reading() as session:
        row = latest(session, 1, 1)
        assert row is not None
        posterior = as_posterior(row)
    store.close()
    assert pair.law.numbers == list(NAMES)
    law = Gaussian(np.array(pair.law.mean), np.array(pair.law.covariance))
    assert_allclose(law.mean, posterior.law.mean, rtol=0, atol=0)
    assert_allclose(law.covariance, posterior.law.covariance, rtol=0, atol=0)
    edge = pair.orthogonal_edge
    at = ViewRange(edge.thinnest_mm, edge.thickest_mm, edge.speed_m_min, np.radians(edge.rake_deg))
    view = linear_edge(law, at)
    assert_allclose(
        [edge.linear[name].value for name in view.names], view.posterior.mean, rtol=1e-9
    )
    assert all(one.lower <= one.value <= one.upper for one in edge.linear.values())
    assert (pair.learnt_from.cuts, pair.learnt_from.operations) == (32, ["face", "turn"])


def test_coordinates_are_what_the_file_says_they_are() -> None:
    of = {"plain": 0.7, "ln": np.log(0.7), "ln tan": np.log(np.tan(np.radians(0.7)))}
    for one in PARAMETERS:
        assert_allclose(one.inside(0.7), of[one.coordinate], rtol=1e-12, err_msg=one.name)


@pytest.mark.parametrize("kind", ["turning_insert", "end_mill", "drill"])
def test_a_tool_has_each_known_number_once(kind: str) -> None:
    numbers = {
        "diameter_mm": 10.0, "teeth": 4, "helix_deg": 30.0, "corner_radius_mm": 0.5,
        "point_angle_deg": 118.0, "nose_radius_mm": 0.8, "kappa_deg": 93.0, "rake_deg": -6.0,
        "inclination_deg": -7.0, "included_deg": 80.0,
    }  # fmt: skip
    made = tool_of(models.Tool(name="t", kind=kind, **numbers))
    ours = {code.symbol: code.ours[kind] for code in ISO_13399 if kind in code.ours}
    by_code = {ours[symbol]: value for symbol, value in made.iso13399.items()}
    rest = made.geometry.model_dump(exclude_none=True)
    assert by_code | rest == numbers
    assert not by_code.keys() & rest.keys()
    assert set(by_code) == set(ours.values())


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (("--coefficients", FILE), "--coefficients needs --machine NAME"),
        (("--coefficients", "c.txt", "--machine", "lathe-1"), "does not end in .json"),
        (("--coefficients", FILE, "--machine", "lathe-2"), "no machine 'lathe-2'"),
        (("--coefficients", FILE, "--cards", "c.csv", "--machine", "lathe-1"), "give one of"),
    ],
)
def test_what_does_not_go_together_is_said(
    standard_learnt: Cli, options: tuple[str, ...], line: str
) -> None:
    done = standard_learnt("export", *options)
    assert done.code == 2
    assert line in done.err
    assert not Path(FILE).exists()


def test_a_machine_that_has_learnt_nothing_says_so(cli: Cli) -> None:
    cli("init")
    cli("machine", "add", "lathe-1")
    done = cli("export", "--coefficients", FILE, "--machine", "lathe-1")
    assert done.code == 2
    assert "has no fitted work-tool pair" in done.err


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("{", "is no JSON"),
        ('{"format": 2, "autodb": "1", "written_at": "", "machine": "", "pairs": []}', "format: "),
    ],
)
def test_a_file_that_is_none_is_refused(tmp_path: Path, text: str, line: str) -> None:
    path = tmp_path / FILE
    path.write_text(text, encoding="utf-8")
    with pytest.raises(UnusableInput, match=line):
        read_coefficients(path)
