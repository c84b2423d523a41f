"""What has no name is only what the simulation's own terms leave of it."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.answer import ChannelAnswer
from autodb.explain.cuts.candidates.library import families, own_columns_of_cuts
from autodb.explain.cuts.cut_search import stack_of
from autodb.explain.cuts.fit import beside_own, fit_cuts
from autodb.explain.engine.candidates import Choice
from autodb.records.tables import CutTable

Array = NDArray[np.float64]

EDGES, CUTS = 4, 14
LIFE_S = 2400.0
INCLUDES = ["shear", "tool_wear"]


def _made(seed: int) -> tuple[CutTable, Array]:
    """Return cuts whose wear bends, and the fit to them of a chip's force and of even wear.

    Fast at first, then slow, then fast again: what an edge does, and no power of its time.
    """
    rng = np.random.default_rng(seed)
    count = EDGES * CUTS
    depth = np.repeat(np.tile([0.75, 1.5], EDGES // 2), CUTS)
    feed = np.repeat([0.25, 0.25, 0.5, 0.5], CUTS)
    worn = np.tile(np.linspace(0.0, 1.0, CUTS), EDGES)
    course = 60.0 * worn + 25.0 * np.sin(2.0 * np.pi * worn)
    force = 400.0 * feed * depth + depth * course + 2.0 * rng.standard_normal(count)
    own = np.column_stack([feed * depth, depth * worn])
    simulation = own @ np.linalg.lstsq(own, force, rcond=None)[0]
    table = {
        "cut": np.arange(1.0, count + 1), "t": 600.0 * np.arange(count),
        "tool.edge": np.repeat(np.arange(1.0, EDGES + 1), CUTS),
        "tool.cutting_time": LIFE_S * worn, "cutting.feed": feed, "cutting.depth": depth,
        "force.y": force,
    }  # fmt: skip
    return CutTable(Path("cuts.csv"), table), simulation


def _answer(seed: int) -> ChannelAnswer:
    table, simulation = _made(seed)
    simulated = CutTable(Path("cuts.csv"), {"cut": table.cut, "force.y": simulation})
    return explain(table, simulated, includes=INCLUDES).explanation.channels["force.y"]


@pytest.mark.parametrize("seed", [1, 2])
def test_a_curve_takes_nothing_from_a_wear_that_is_right(seed: int) -> None:
    """The simulated wear is the fit to the recording: no other rate predicts it better."""
    found = {cause.kind: cause for cause in _answer(seed).missing}
    assert set(found) == {"missing"}
    assert found["missing"].parameters["size"].value < 45.0


def test_the_sum_stays_and_own_terms_are_as_alone() -> None:
    table, simulation = _made(4)
    stack = stack_of(table, {"force.y": simulation}, INCLUDES)
    own = own_columns_of_cuts(stack, INCLUDES)
    curve = next(c for c in families(stack) if c.variables == ("tool.cutting_time",))
    choices = (Choice(curve, 0),)
    joint = fit_cuts(stack, own, choices)
    told = beside_own(stack, own, choices, joint)
    assert_allclose(np.sum(told.parts, axis=0), np.sum(joint.parts, axis=0), atol=1e-6)
    alone = fit_cuts(stack, own, ())
    assert_allclose(told.coefficients[:2], alone.coefficients, atol=1e-3)
    assert np.abs(told.parts[-1]).max() < 45.0
