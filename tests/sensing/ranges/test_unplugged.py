"""A sensor that gives nothing is named, and no other."""

from dataclasses import replace

import numpy as np
import pytest

from autodb.agent.sense.calibrating import calibrate_table
from autodb.records.tables import CutTable
from autodb.sensing.ranges import faults
from tests.helpers.campaigns import first
from tests.helpers.lathe_tables import (
    AXES,
    SEEDS,
    forces_of,
    lathe_cuts,
    protocol_of,
    unplugged,
    with_channels,
    without_forces,
)


@pytest.mark.usefixtures("calibrated_once")
@pytest.mark.parametrize("level_A", first(1, [0.0, 1.0, 0.05]))
@pytest.mark.parametrize("axis", AXES)
def test_a_sensor_that_gives_nothing_is_named_alone(axis: str, level_A: float) -> None:
    for seed in SEEDS:
        table = unplugged(lathe_cuts(seed), axis, seed, level_A)
        found = faults.silent(table, forces_of(table), AXES)
        assert list(found) == [axis]
        assert f"{axis}.current: the same in air, in light and in heavy" in found[axis].sentence
        assert "check its plug" in found[axis].sentence
        done, left_out = calibrate_table(table, axes=AXES)
        assert {c.axis for c in done} == set(AXES) - {axis}
        assert any("check its plug" in line for line in left_out)


def test_an_axis_that_stands_or_correlates_badly_is_not_unplugged() -> None:
    """X stands in turning; a current whose scatter is as large as its rise still has one."""
    for seed in SEEDS:
        table = lathe_cuts(seed)
        turned = [o == "turn" for o in table.texts["operation"]]
        rows = np.flatnonzero(turned)
        only = CutTable(
            path=table.path,
            channels={name: values[rows] for name, values in table.channels.items()},
            texts={"operation": ["turn"] * len(rows)},
        )
        assert "x" not in faults.silent_axes(only, forces_of(only), AXES)
        rise = table["z.current.range"] - table["z.current.air"]
        noise = rise.mean() * np.random.default_rng([seed, 78]).standard_normal(len(table))
        poor = with_channels(table, z__current__range=table["z.current.range"] + noise)
        assert not faults.silent(poor, forces_of(poor), AXES)


def test_without_an_operation_a_standing_axis_is_a_candidate_too() -> None:
    table = unplugged(lathe_cuts(SEEDS[0]), "x", 1, 0.9)
    without_texts = replace(table, texts={})
    (check,) = faults.silent(without_texts, forces_of(without_texts), AXES).values()
    assert "if x stands still in these cuts, state it by 'operation'" in check.sentence


def test_without_air_only_a_faint_current_is_silent() -> None:
    """A level like another axis' may be friction alone: the axis is refused by its R² instead."""
    for seed in SEEDS:
        for level_A, named in ((0.0, ["x"]), (1.0, [])):
            table = unplugged(lathe_cuts(seed), "x", seed, level_A)
            bare = {n: v for n, v in table.channels.items() if not n.endswith(".air")}
            found = faults.silent(replace(table, channels=bare), forces_of(table), AXES)
            assert list(found) == named
            assert all("the same in light and in heavy" in c.sentence for c in found.values())


def test_where_nothing_was_cut_no_axis_is_unplugged() -> None:
    table = lathe_cuts(SEEDS[0])
    for axis in AXES:
        table = unplugged(table, axis, 3, 0.5)
    assert faults.silent_axes(table, forces_of(table), AXES) == {}


@pytest.mark.usefixtures("calibrated_once")
def test_an_unplugged_sensor_is_found_with_a_protocol() -> None:
    for seed in SEEDS:
        table = lathe_cuts(seed)
        bare = unplugged(without_forces(table), "spindle", seed, 0.05)
        done, left_out = calibrate_table(bare, axes=AXES, protocol=protocol_of(table))
        assert {c.axis for c in done} == {"x", "z"}
        assert "spindle.current: the same in air, in light and in heavy cuts" in left_out[0]
