"""A simulation's own wear is read off it, whatever its course, and re-tuned by a share."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.answer import Cause
from autodb.explain.cuts.carried import elsewhere
from autodb.explain.cuts.cut_search import look_in_cuts, stack_of
from autodb.explain.cuts.simulated_wear import wear_read_off
from autodb.explain.cuts.stack import table_conditions
from autodb.records.tables import CutTable

Array = NDArray[np.float64]
Course = Callable[[Array], Array]

EDGES, CUTS, LIFE_S = 4, 15, 2400.0
N_MM = np.array([60.0, 90.0, 40.0, 75.0])
"""That each edge adds at the end of its life."""
INCLUDES = ["shear", "edge_force", "tool_wear"]
COURSES: dict[str, Course] = {
    "bends down": lambda spent: spent**0.6,
    "bends up": lambda spent: spent**1.7,
    "bends both ways": lambda spent: 0.5 * spent**0.5 + 0.5 * spent**2,
}


def _conditions() -> dict[str, Array]:
    count = EDGES * CUTS
    return {
        "cut": np.arange(1.0, count + 1), "t": 600.0 * np.arange(count),
        "tool.edge": np.repeat(np.arange(1.0, EDGES + 1), CUTS),
        "tool.cutting_time": np.tile(LIFE_S * np.linspace(0.0, 1.0, CUTS), EDGES),
        "cutting.feed": np.repeat([0.1, 0.2, 0.1, 0.2], CUTS),
        "cutting.depth": np.repeat([0.75, 1.5, 1.5, 0.75], CUTS),
    }  # fmt: skip


def _chip(conditions: dict[str, Array]) -> Array:
    """Neither a power of the feed nor in proportion to the depth: no law that is known here."""
    feed, depth = conditions["cutting.feed"], conditions["cutting.depth"]
    return np.asarray(900.0 * np.tanh(4.0 * feed) * (depth + 0.1) + 30.0 * depth)


def _worn(conditions: dict[str, Array], course: Course) -> Array:
    spent = conditions["tool.cutting_time"] / LIFE_S
    return np.asarray(np.repeat(N_MM, CUTS) * conditions["cutting.depth"] * course(spent))


def _table(conditions: dict[str, Array], force: Array) -> CutTable:
    return CutTable(Path("cuts.csv"), {**conditions, "force.y": force})


@pytest.mark.parametrize("course", COURSES.values(), ids=list(COURSES))
def test_wear_is_what_cuts_of_the_same_conditions_differ_by(course: Course) -> None:
    conditions = _conditions()
    worn = _worn(conditions, course)
    for sign in (1.0, -1.0):
        force = sign * (_chip(conditions) + worn)
        known = table_conditions(_table(conditions, force))
        wear = wear_read_off(force[None, :], known)
        assert wear is not None
        assert_allclose(wear.force(known)[0], sign * worn, atol=0.02 * worn.max())


def test_no_wear_is_read_where_cuts_do_not_repeat_or_differ_otherwise() -> None:
    conditions = _conditions()
    worn = _worn(conditions, COURSES["bends up"])
    known = table_conditions(_table(conditions, worn))
    assert wear_read_off(_chip(conditions)[None, :], known) is None
    late = 0.2 * worn.max() * (np.arange(EDGES * CUTS) % 2)
    assert wear_read_off((_chip(conditions) + worn + late)[None, :], known) is None
    feeds = np.linspace(0.1, 0.3, EDGES * CUTS)
    other = table_conditions(_table(conditions | {"cutting.feed": feeds}, worn))
    assert wear_read_off((_chip(conditions) + worn)[None, :], other) is None


def _causes(factor: float, seed: int) -> list[Cause]:
    """Return what is said where the edges wear ``factor`` times as fast as simulated."""
    conditions = _conditions()
    chip, worn = _chip(conditions), _worn(conditions, COURSES["bends down"])
    scatter = 2.0 * np.random.default_rng(seed).standard_normal(len(chip))
    recording = _table(conditions, chip + factor * worn + scatter)
    simulation = CutTable(Path("cuts.csv"), {"cut": conditions["cut"], "force.y": chip + worn})
    found = explain(recording, simulation, includes=INCLUDES)
    return list(found.explanation.channels["force.y"].missing)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_wear_that_is_off_by_a_factor_is_mistuned_by_it(seed: int) -> None:
    (cause,) = _causes(1.4, seed)
    assert (cause.term, cause.kind) == ("tool_wear", "mistuned")
    conditions = _conditions()
    worn = _worn(conditions, COURSES["bends down"])
    line = conditions["cutting.depth"] * conditions["tool.cutting_time"]
    simulated = float(worn @ line / (line @ line))
    assert cause.parameters["rate"].value == pytest.approx(1.4 * simulated, rel=0.05)
    assert cause.parameters["size"].value == pytest.approx(0.4 * worn.max(), rel=0.1)
    assert "The simulation has rate 0;" not in cause.statement


def test_a_wear_that_is_right_is_not_spoken_of() -> None:
    assert not _causes(1.0, 3)


def test_cuts_that_follow_are_worn_as_the_simulation_has_it() -> None:
    """Of twice the depth, in place of the table's cuts."""
    conditions = _conditions()
    force = _chip(conditions) + _worn(conditions, COURSES["bends up"])
    scatter = 2.0 * np.random.default_rng(4).standard_normal(len(force))
    table = _table(conditions, force + scatter)
    result = look_in_cuts(stack_of(table, {"force.y": force}, INCLUDES), INCLUDES)
    deeper = conditions | {"cutting.depth": 2.0 * conditions["cutting.depth"]}
    there = elsewhere(result, table_conditions(_table(deeper, force)), 0).stack
    assert_allclose(there.worn, 2.0 * result.stack.worn)
    assert_allclose(there.simulation - there.worn, there.chip + there.edge_N_mm[0] * there.edge_mm)
