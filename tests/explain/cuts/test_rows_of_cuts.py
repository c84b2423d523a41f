"""Tables as they come: in another order, with gaps, and recordings that are a law to the digit."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.explain import Explained, explain
from autodb.records.tables import CutTable

Array = NDArray[np.float64]

CUTS, STEP_N, SCATTER = 40, 100.0, 0.01
STRENGTH_N_MM2 = {"force.x": 700.0, "force.y": 2000.0, "force.z": 1000.0}
LATE = np.arange(CUTS) >= 18


def _conditions(seed: int) -> dict[str, Array]:
    rng = np.random.default_rng(seed)
    return {
        "cut": np.arange(1.0, CUTS + 1),
        "t": 60.0 * np.arange(CUTS),
        "cutting.feed": rng.choice([0.1, 0.2, 0.3], CUTS),
        "cutting.depth": rng.choice([0.5, 1.0, 2.0], CUTS),
        "cutting.speed": rng.choice([100.0, 200.0], CUTS),
    }


def _simulated(known: dict[str, Array]) -> dict[str, Array]:
    area = known["cutting.depth"] * known["cutting.feed"]
    return {name: strength * area for name, strength in STRENGTH_N_MM2.items()}


def _scattered(simulation: dict[str, Array], seed: int, scatter: float) -> dict[str, Array]:
    rng = np.random.default_rng(seed)
    return {n: f * (1.0 + scatter * rng.standard_normal(CUTS)) for n, f in simulation.items()}


def _explained(known: dict[str, Array], sensed: dict[str, Array]) -> Explained:
    simulation = {"cut": known["cut"], **_simulated(known)}
    return explain(
        CutTable(Path("cuts.csv"), {**known, **sensed}),
        CutTable(Path("simulation.csv"), simulation),
        includes=["shear"],
    )


def _named(found: Explained) -> dict[str, list[tuple[str, str]]]:
    channels = found.explanation.channels
    return {name: [(c.kind, c.term) for c in a.missing] for name, a in channels.items()}


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_zero_point_that_steps_in_one_component_is_its_sensor(seed: int) -> None:
    known = _conditions(seed)
    sensed = _scattered(_simulated(known), seed, SCATTER)
    sensed["force.y"] = sensed["force.y"] + STEP_N * LATE
    found = _explained(known, sensed)
    (drift,) = found.explanation.channels["force.y"].missing
    assert drift.term == "sensor_drift"
    assert drift.parameters["step"].value == pytest.approx(STEP_N, rel=0.1)
    assert drift.parameters["start"].value == pytest.approx(known["t"][18], abs=60.0)
    assert _named(found)["force.x"] == _named(found)["force.z"] == []


def test_one_component_that_grows_by_the_clock_is_no_wear() -> None:
    """A worn flank presses on the work and rubs along it: no component grows alone."""
    known = _conditions(3)
    sensed = _scattered(_simulated(known), 3, SCATTER)
    sensed["force.y"] = sensed["force.y"] * np.linspace(1.0, 1.5, CUTS)
    found = _explained(known, sensed)
    assert _named(found) == {"force.x": [], "force.y": [("missing", "gain")], "force.z": []}
    (gain,) = found.explanation.channels["force.y"].missing
    assert "tool_wear" not in gain.alternatives


def test_a_table_sorted_by_its_settings_is_explained_in_the_order_of_its_clock() -> None:
    known = _conditions(4)
    sensed = _scattered(_simulated(known), 4, SCATTER)
    sensed = {name: force * np.linspace(1.0, 1.3, CUTS) for name, force in sensed.items()}
    order = np.lexsort((known["cutting.feed"], known["cutting.depth"]))
    as_made = _explained(known, sensed)
    as_sorted = _explained(
        {name: values[order] for name, values in known.items()},
        {name: force[order] for name, force in sensed.items()},
    )
    assert as_sorted.explanation.channels == as_made.explanation.channels
    for name, corrected in as_made.rows.items():
        np.testing.assert_array_equal(as_sorted.rows[name], corrected[order])


def test_a_force_and_a_condition_that_one_cut_lacks_are_said() -> None:
    known = _conditions(5)
    sensed = _scattered(_simulated(known), 5, SCATTER)
    sensed["force.y"][3] = np.nan
    gap = {**known, "cutting.speed": known["cutting.speed"].copy()}
    gap["cutting.speed"][[6, 7]] = np.nan
    found = _explained(gap, sensed)
    assert set(found.explanation.channels) == {"force.x", "force.z"}
    assert [note for note in found.notes if "has no value" in note] == [
        "cuts.csv: force.y has no value in 1 of 40 cuts, the first of them cut 4, and is not used; "
        "fill it in, or remove those cuts",
        "cuts.csv: cutting.speed has no value in 2 of 40 cuts, the first of them cut 7, and is not "
        "used; fill it in, or remove those cuts",
    ]


@pytest.mark.parametrize("components", [("force.y",), ("force.x", "force.y", "force.z")])
def test_a_recording_that_is_its_simulation_lacks_nothing(components: tuple[str, ...]) -> None:
    known = _conditions(6)
    sensed = {name: force for name, force in _simulated(known).items() if name in components}
    assert _named(_explained(known, sensed)) == {name: [] for name in components}


@pytest.mark.parametrize("seed", [0, 1, 3])
def test_a_law_to_the_digit_is_named_like_one_with_scatter(seed: int) -> None:
    known = _conditions(seed)
    simulation = _simulated(known)
    harder = _explained(known, {name: 1.2 * force for name, force in simulation.items()})
    assert set(map(tuple, _named(harder).values())) == {(("mistuned", "shear"),)}
    stepped = _explained(known, {**simulation, "force.y": simulation["force.y"] + STEP_N * LATE})
    expected = {"force.x": [], "force.y": [("missing", "sensor_drift")], "force.z": []}
    assert _named(stepped) == expected
