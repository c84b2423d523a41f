"""An edge wears in a table that does not say how long it has cut: by the clock, that is."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.answer import Cause
from autodb.explain.cuts.candidates.cutting import nose_candidates
from autodb.explain.cuts.cut_search import stack_of
from autodb.records.tables import CutTable

Array = NDArray[np.float64]

CUTS, WORN_N_MM = 40, 60.0
SHARES = {"force.x": 0.4, "force.y": 1.0, "force.z": 0.6}
"""Of the chip's force; wear adds in other shares, which a gain does not."""


def _conditions(rng: np.random.Generator) -> dict[str, Array]:
    return {
        "cut": np.arange(1.0, CUTS + 1),
        "t": 60.0 * np.arange(CUTS),
        "cutting.feed": rng.choice([0.1, 0.2, 0.3], CUTS),
        "cutting.depth": rng.choice([0.5, 1.0, 2.0], CUTS),
    }


def _wear(conditions: dict[str, Array], worn: Array, rng: np.random.Generator) -> list[Cause]:
    """Return the causes of each component where wear grows to WORN_N_MM as ``worn`` (n,) does."""
    feed, depth = conditions["cutting.feed"], conditions["cutting.depth"]
    simulation = {name: share * 2000.0 * feed * depth for name, share in SHARES.items()}
    recording = {
        name: simulation[name]
        + (0.5 + share) * WORN_N_MM * depth * worn
        + 4.0 * rng.standard_normal(CUTS)
        for name, share in SHARES.items()
    }
    path = Path("cuts.csv")
    found = explain(
        CutTable(path, {**conditions, **recording}),
        CutTable(path, {"cut": conditions["cut"], **simulation}),
        includes=["shear"],
    )
    answers = found.explanation.channels.values()
    return [c for a in answers for c in a.missing if c.term == "tool_wear" and c.confidence > 0.8]


def test_an_edge_that_wears_shows_without_its_cutting_time() -> None:
    rng = np.random.default_rng(3)
    causes = _wear(_conditions(rng), np.linspace(0.0, 1.0, CUTS), rng)
    assert [c.variables for c in causes] == [("t",)] * 3


def test_a_recorded_edge_begins_anew() -> None:
    """Two edges, one after the other, each worn from its own first cut on."""
    rng = np.random.default_rng(4)
    conditions = _conditions(rng)
    conditions["tool.edge"] = np.repeat([1.0, 2.0], CUTS // 2)
    causes = _wear(conditions, np.tile(np.linspace(0.0, 1.0, CUTS // 2), 2), rng)
    assert len(causes) == 3


@pytest.mark.parametrize(("operation", "offered"), [("turn", 1), ("drill", 0)])
def test_only_what_is_turned_has_a_nose(operation: str, offered: int) -> None:
    rng = np.random.default_rng(5)
    conditions = _conditions(rng)
    forces = {name: rng.uniform(100.0, 200.0, CUTS) for name in ("force.y", "force.z")}
    table = CutTable(
        Path("cuts.csv"), {**conditions, **forces}, texts={"operation": [operation] * CUTS}
    )
    stack = stack_of(table, {name: values - 5.0 for name, values in forces.items()}, ["shear"])
    assert len(nose_candidates(stack)) == offered
