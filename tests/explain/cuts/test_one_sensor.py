"""What one component has alone is its sensor's: a plug that was loose for some cuts is a gain."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.answer import Cause
from autodb.records.tables import CutTable
from tests.helpers.truths import cuts as truths

Array = NDArray[np.float64]

CUTS, SCATTER, LOOSE, EDGES = 40, 0.02, (15.0, 20.0), 4
STRENGTH_N_MM2 = {"force.y": 2100.0, "force.z": 1100.0}


def _missing(factors: dict[str, float]) -> dict[str, list[Cause]]:
    """Return what is missing in a table some of whose cuts are off by a factor, by component."""
    made, rng = truths.cuts(CUTS, seed=1), np.random.default_rng(20261129)
    known = {
        "cut": made["cut"] + 1.0, "t": made["t"], "cutting.feed": made["feed"],
        "cutting.depth": made["depth"], "cutting.speed": made["speed"],
    }  # fmt: skip
    simulated = {n: k * made["depth"] * made["feed"] for n, k in STRENGTH_N_MM2.items()}
    loose = (known["cut"] >= LOOSE[0]) & (known["cut"] <= LOOSE[1])
    sensed = {
        name: force * np.where(loose, factors.get(name, 1.0), 1.0)
        * (1.0 + rng.normal(0.0, SCATTER, CUTS))
        for name, force in simulated.items()
    }  # fmt: skip
    table = CutTable(Path("cuts.csv"), known | sensed)
    simulation = CutTable(Path("simulation.csv"), {"cut": known["cut"]} | simulated)
    answer = explain(table, simulation, includes=["shear"]).explanation
    return {name: list(found.missing) for name, found in answer.channels.items()}


@pytest.mark.parametrize("factor", [0.6, 1.4])
def test_a_factor_that_comes_and_goes_in_one_component(factor: float) -> None:
    missing = _missing({"force.y": factor})
    (cause,) = missing["force.y"]
    assert (cause.term, cause.kind) == ("gain", "missing")
    assert cause.parameters["factor"].value == pytest.approx(factor, abs=0.03)
    assert (cause.parameters["first"].value, cause.parameters["last"].value) == LOOSE
    assert missing["force.z"] == []


def test_a_factor_of_both_components_is_the_material() -> None:
    missing = _missing({"force.y": 1.4, "force.z": 1.3})
    assert [cause.term for cause in missing["force.y"]] == ["hard_spot"]
    assert [cause.term for cause in missing["force.z"]] == ["hard_spot"]


@pytest.mark.parametrize(("share", "seed"), [(0.35, 1), (-0.25, 2), (0.5, 3)])
def test_a_factor_that_goes_on_in_a_table_of_one_component_is_a_gain(
    share: float, seed: int
) -> None:
    """A drift adds as much to the lightest cut, and wear begins anew with each edge."""
    made, rng = truths.cuts(CUTS, seed=seed), np.random.default_rng(seed)
    force: Array = np.asarray(STRENGTH_N_MM2["force.y"] * made["depth"] * made["feed"])
    number = np.arange(CUTS, dtype=np.float64)
    place, since = number // (CUTS // EDGES), number % (CUTS // EDGES)
    known: dict[str, Array] = {
        "cut": made["cut"] + 1.0, "t": 60.0 * number, "tool.edge": place + 1.0,
        "tool.cutting_time": 60.0 * since, "cutting.feed": made["feed"],
        "cutting.depth": made["depth"], "cutting.speed": made["speed"],
    }  # fmt: skip
    grown = 1.0 + share * np.linspace(0.0, 1.0, CUTS)
    sensed: Array = np.asarray(force * grown * (1.0 + rng.normal(0.0, SCATTER, CUTS)))
    table = CutTable(Path("cuts.csv"), known | {"force.y": sensed})
    simulation = CutTable(Path("simulation.csv"), {"cut": known["cut"], "force.y": force})
    answer = explain(table, simulation, includes=["shear"]).explanation.channels["force.y"]
    (cause,) = (one for one in answer.missing if one.kind == "missing")
    assert cause.term == "gain"
    assert cause.parameters["factor"].value == pytest.approx(1.0 + share, abs=0.05)
