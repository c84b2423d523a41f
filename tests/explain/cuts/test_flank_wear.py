"""Wear goes with the measured flank wear of each cut where no cutting time was recorded."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.answer import Cause
from autodb.explain.cuts.stack import table_conditions
from autodb.explain.cuts.trials import plain_trials
from autodb.records.tables import CutTable

Array = NDArray[np.float64]

HOLES, PRESSED_N_MM2 = 48, 400.0
SHARES = {"force.y": 0.5, "force.z": 1.0}
"""Of the chip's force."""


def _drilled(rng: np.random.Generator) -> dict[str, Array]:
    """Holes of three drills in a mixed order, each drill as worn as it happens to be."""
    return {
        "cut": np.arange(1.0, HOLES + 1),
        "t": 60.0 * np.arange(HOLES),
        "cutting.feed": rng.choice([0.13, 0.25, 0.5], HOLES),
        "cutting.depth": rng.choice([2.5, 3.75, 5.0], HOLES),
        "cutting.speed": rng.choice([10.0, 15.0, 20.0], HOLES),
        "tool.flank_wear": rng.uniform(0.02, 0.3, HOLES),
    }


def _worn(conditions: dict[str, Array], rng: np.random.Generator) -> dict[str, list[Cause]]:
    """Return what is missing where the land presses on the work with PRESSED_N_MM2."""
    feed, depth = conditions["cutting.feed"], conditions["cutting.depth"]
    simulation = {name: 900.0 * share * feed * depth for name, share in SHARES.items()}
    land = conditions["tool.flank_wear"]
    recording = {
        name: (force + PRESSED_N_MM2 * depth * land) * (1.0 + 0.03 * rng.standard_normal(HOLES))
        for name, force in simulation.items()
    }
    answer = explain(
        CutTable(Path("holes.csv"), {**conditions, **recording}),
        CutTable(Path("holes.csv"), {"cut": conditions["cut"], **simulation}),
        includes=["shear"],
    ).explanation
    return {name: list(found.missing) for name, found in answer.channels.items()}


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_wear_is_named_by_the_land(seed: int) -> None:
    rng = np.random.default_rng(seed)
    conditions = _drilled(rng)
    mean_depth = float(conditions["cutting.depth"].mean())
    for causes in _worn(conditions, rng).values():
        (wear,) = [one for one in causes if one.kind == "missing"]
        assert (wear.term, wear.variables) == ("tool_wear", ("tool.flank_wear",))
        assert "sensor_drift" not in wear.alternatives
        rate = wear.parameters["rate"]
        assert rate.unit == "N/mm"
        assert rate.value == pytest.approx(PRESSED_N_MM2 * mean_depth, rel=0.2)


def test_a_cutting_time_says_more_than_a_land() -> None:
    """It is recorded at every cut; a land is measured now and then, and filled in."""
    conditions = _drilled(np.random.default_rng(4))
    timed = {**conditions, "tool.cutting_time": conditions["t"]}
    assert table_conditions(CutTable(Path("holes.csv"), conditions)).by_land
    assert not table_conditions(CutTable(Path("holes.csv"), timed)).by_land


def test_a_land_that_is_the_same_in_all_cuts_says_nothing() -> None:
    conditions = _drilled(np.random.default_rng(5))
    conditions["tool.flank_wear"] = np.full(HOLES, 0.1)
    known = table_conditions(CutTable(Path("holes.csv"), conditions))
    assert known.land_mm is not None
    assert not known.by_land


def test_a_trial_with_another_edge_begins_with_the_least_land() -> None:
    conditions = _drilled(np.random.default_rng(6))
    known = table_conditions(CutTable(Path("holes.csv"), conditions))
    least, last = conditions["tool.flank_wear"].min(), conditions["tool.flank_wear"][-1]
    for trial in plain_trials(known):
        assert trial.known.land_mm is not None
        anew = trial.words.startswith("Change the edge")
        np.testing.assert_array_equal(trial.known.land_mm, least if anew else last)
