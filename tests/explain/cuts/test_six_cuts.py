"""Six cuts are enough where they tell, and invent nothing where they do not."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.explain import explain
from autodb.explain.answer import Cause
from autodb.records.tables import CutTable
from tests.helpers.campaigns import first

Array = NDArray[np.float64]
DEPTH_MM = np.array([0.5, 2.0, 3.0, 1.0, 2.0, 0.5])
FEED_MM = np.array([0.08, 0.3, 0.1, 0.3, 0.12, 0.2])
SPEED_M_MIN = np.array([100.0, 240.0, 160.0, 240.0, 100.0, 160.0])
THIN_MM = np.array([0.02, 0.3, 0.1, 0.4, 0.05, 0.2])
SCATTER = 0.02


def _missing(
    seed: int, cuts: int, *, softer: float, edge_N_mm: float, feed_mm: Array = FEED_MM
) -> list[Cause]:
    """Return what one component lacks that is softer by speed, and has an edge."""
    rng = np.random.default_rng(seed)
    depth, feed, speed = (values[:cuts] for values in (DEPTH_MM, feed_mm, SPEED_M_MIN))
    simulated = 1900.0 * depth * feed
    force = simulated * (speed / 150.0) ** -softer + edge_N_mm * depth
    number = np.arange(1, cuts + 1).astype(np.float64)
    conditions: dict[str, Array] = {
        "cut": number,
        "t": 60.0 * number,
        "cutting.feed": feed,
        "cutting.depth": depth,
        "cutting.speed": speed,
    }
    measured = force * (1.0 + SCATTER * rng.standard_normal(cuts))
    path = Path("cuts.csv")
    found = explain(
        CutTable(path, {**conditions, "force.y": measured}),
        CutTable(path, {"cut": conditions["cut"], "force.y": simulated}),
        includes=["shear"],
    )
    missing = found.explanation.channels["force.y"].missing
    return [cause for cause in missing if cause.kind == "missing"]


def _sure(seed: int, cuts: int, *, softer: float, edge_N_mm: float) -> set[str]:
    """Return what of it is named with 90 %."""
    missing = _missing(seed, cuts, softer=softer, edge_N_mm=edge_N_mm)
    return {cause.term for cause in missing if cause.confidence >= 0.9}


def test_six_cuts_name_what_they_plainly_show() -> None:
    assert _sure(1, 6, softer=0.4, edge_N_mm=0.0) == {"speed_softening"}
    (cause,) = _missing(1, 6, softer=0.0, edge_N_mm=90.0, feed_mm=THIN_MM)
    assert (cause.term, cause.alternatives) == ("edge_force", ())
    assert cause.confidence >= 0.9


@pytest.mark.parametrize("seed", [1, 3, 10])
def test_without_thin_chips_an_edge_may_be_a_size_effect(seed: int) -> None:
    """Either leaves a sum of squares of three scatters, beside a chip's own force that is free."""
    (cause,) = _missing(seed, 6, softer=0.0, edge_N_mm=90.0)
    assert {cause.term, *cause.alternatives} == {"edge_force", "size_effect"}
    assert cause.confidence < 0.9


@pytest.mark.parametrize(("draws", "most"), first(1, [(20, 3), (40, 5)]))
def test_six_cuts_with_nothing_missing_name_hardly_anything(draws: int, most: int) -> None:
    """With one in fifty by chance, more have a name once in 1700 times, and in 7000."""
    named = sum(bool(_sure(100 + k, 6, softer=0.0, edge_N_mm=0.0)) for k in range(draws))
    assert named <= most


def test_five_cuts_are_refused() -> None:
    with pytest.raises(UnusableInput, match="5 cuts are too few to explain; use at least 6"):
        _sure(1, 5, softer=0.0, edge_N_mm=0.0)
