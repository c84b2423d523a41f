"""A design cut in its order: what comes back with a setting is put down to that setting."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.explain.cuts.candidates.library import families, of_forces
from autodb.explain.cuts.cut_search import stack_of
from autodb.explain.cuts.plain_rows import TableRows
from autodb.explain.cuts.stack import Stack, designed
from autodb.records.tables import CutTable

Array = NDArray[np.float64]
LEVELS = {"cutting.speed": [80.0, 140.0, 240.0], "cutting.feed": [0.1, 0.2, 0.3],
          "cutting.depth": [0.5, 1.0, 2.0]}  # fmt: skip


def _stack(order: np.random.Generator | None = None) -> Stack:
    """Return a full design of three levels, the depth changing from cut to cut; or in any order."""
    design = np.array(np.meshgrid(*LEVELS.values(), indexing="ij")).reshape(3, -1)
    if order is not None:
        design = order.permutation(design.T).T
    conditions = dict(zip(LEVELS, design, strict=True))
    number = np.arange(1.0, design.shape[1] + 1)
    force = 1900.0 * conditions["cutting.feed"] * conditions["cutting.depth"]
    table = {"cut": number, "t": 60.0 * number, **conditions, "force.y": force + 1.0}
    return stack_of(CutTable(Path("cuts.csv"), table), {"force.y": force}, ["shear"])


def test_the_order_of_a_design_is_its_settings() -> None:
    stack = _stack()
    row, design = stack.row, designed(stack)
    third = 2.0 * np.pi * row / 3.0
    assert design.holds(np.column_stack([np.cos(third), np.sin(third)]))  # the depth
    assert design.holds(1.0 * (row[:, None] // 9 == np.arange(3)))  # the speed
    assert not design.holds(1.0 * (row[:, None] % 2 == np.arange(2)))
    assert design.holds(row[:, None])  # slow, less slow and quick settings in turn: a drift
    assert not designed(_stack(np.random.default_rng(1))).holds(row[:, None])


@pytest.mark.parametrize(
    ("order", "turns"), [(None, {2, 4}), (np.random.default_rng(1), {2, 3, 4})]
)
def test_cuts_in_turn_are_no_effect_where_a_setting_takes_turns(
    order: np.random.Generator | None, turns: set[int]
) -> None:
    found = next(one for one in families(_stack(order)) if one.key == "unknown in turns")
    assert {int(form.shape["every"]) for form in found.forms} == turns


def test_blocks_left_out_of_a_design_hold_all_of_its_levels() -> None:
    """The difference is the force times the speed, so that a row shows the speed of its cut."""
    sorted_by_speed, mixed = _stack(), _stack(np.random.default_rng(1))
    speeds = [_speeds_of_rows(stack) for stack in (sorted_by_speed, mixed)]
    for rows in speeds:
        assert sorted(rows) == pytest.approx(sorted(LEVELS["cutting.speed"] * 9), rel=1e-9)
        assert all(len(np.unique(np.round(third))) == 3 for third in np.split(rows, 3))


def _speeds_of_rows(stack: Stack) -> Array:
    speed = stack.known.other["cutting.speed"]
    stack = replace(stack, recording=stack.simulation * (1.0 + speed))
    rows = TableRows(stack, of_forces(["shear"]).own(stack))
    return np.asarray(rows.reduced_difference / rows.chosen(())[:, 0])
