"""A drill wears fast in the first of its holes and evenly after."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.answer import Cause
from autodb.explain.cuts.candidates.over_time import wear_candidates
from autodb.explain.cuts.cut_search import stack_of
from autodb.records.tables import CutTable

Array = NDArray[np.float64]

HOLES, A_HOLE_S, DEPTH_MM = 60, 4.0, 3.25
FRESH = {"force.y": 1450.0, "force.z": 880.0}
RUN_IN = {"force.y": 190.0, "force.z": 90.0}
EVEN = {"force.y": 40.0, "force.z": 30.0}
RUNS_IN_AFTER = 5.0
"""Holes; no time constant that is searched for."""


def _table(rng: np.random.Generator, *, timed: bool = True, used_s: float = 0.0) -> CutTable:
    holes = np.arange(float(HOLES))
    conditions = {
        "cut": holes + 1.0, "t": 60.0 * holes, "cutting.depth": np.full(HOLES, DEPTH_MM),
        "cutting.feed": np.full(HOLES, 0.1), "cutting.speed": np.full(HOLES, 80.0),
    }  # fmt: skip
    if timed:
        conditions |= {"tool.edge": np.ones(HOLES), "tool.cutting_time": used_s + A_HOLE_S * holes}
    worn = {
        name: RUN_IN[name] * -np.expm1(-holes / RUNS_IN_AFTER) + EVEN[name] * holes / HOLES
        for name in FRESH
    }
    forces = {
        name: fresh + worn[name] + 0.008 * fresh * rng.standard_normal(HOLES)
        for name, fresh in FRESH.items()
    }
    return CutTable(
        Path("holes.csv"), {**conditions, **forces}, texts={"operation": ["drill"] * HOLES}
    )


def _wear(table: CutTable) -> dict[str, Cause]:
    simulation = {name: np.full(HOLES, fresh) for name, fresh in FRESH.items()}
    simulated = CutTable(Path("holes.csv"), {"cut": table.cut, **simulation})
    found = explain(table, simulated, includes=["shear"]).explanation.channels
    return {
        name: cause
        for name, answer in found.items()
        for cause in answer.missing
        if cause.term == "tool_wear"
    }


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_an_edge_that_runs_in_is_named_with_its_size(seed: int) -> None:
    wear = _wear(_table(np.random.default_rng(seed)))
    for name, cause in wear.items():
        size = RUN_IN[name] + EVEN[name]
        assert 0.75 * size < cause.parameters["size"].value < 1.25 * size
        assert cause.confidence > 0.8
    assert set(wear) == set(FRESH)


@pytest.mark.parametrize(
    ("timed", "used_s", "every", "offered"),
    [(True, 0.0, 1, 2), (True, 300.0, 1, 0), (True, 0.0, 3, 0), (False, 0.0, 1, 0)],
)
def test_only_a_fresh_edge_runs_in(timed: bool, used_s: float, every: int, offered: int) -> None:
    """Neither one that has cut before, nor one that may have: the clock does not say. Nor one of
    whose first holes hardly any were recorded.
    """
    whole = _table(np.random.default_rng(4), timed=timed, used_s=used_s)
    seen = {name: values[::every] for name, values in whole.channels.items()}
    simulation = {name: np.full(len(seen["cut"]), fresh) for name, fresh in FRESH.items()}
    stack = stack_of(CutTable(Path("holes.csv"), seen), simulation, ["shear"])
    (wear,) = wear_candidates(stack, frozenset())
    assert sum("run_in" in form.shape for form in wear.forms) == offered
