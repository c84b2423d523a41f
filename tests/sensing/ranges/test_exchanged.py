"""Two cuts that stand in each other's row are named."""

from dataclasses import replace

import numpy as np
import pytest

from autodb.agent.sense.calibrating import calibrate_table
from autodb.errors import UnusableInput
from autodb.records.tables import CutTable
from autodb.sensing.ranges import faults
from tests.helpers.lathe_tables import (
    AXES,
    FORCES,
    SEEDS,
    forces_of,
    lathe_cuts,
    names_of,
    protocol_of,
    with_channels,
    without_forces,
)


def exchange(table: CutTable, i: int, j: int) -> CutTable:
    changed = dict(table.channels)
    for name in FORCES:
        changed[name] = changed[name].copy()
        changed[name][[i, j]] = changed[name][[j, i]]
    return replace(table, channels=changed)


def drawn_pair(table: CutTable, seed: int) -> tuple[int, int]:
    """Two turned cuts of which one has more than twice the other's tangential force."""
    rng = np.random.default_rng([seed, 79])
    turned = np.flatnonzero([o == "turn" for o in table.texts["operation"]])
    force = table["force.y"]
    while True:
        i, j = sorted(rng.choice(turned, 2, replace=False).tolist())
        if max(force[i], force[j]) > 2.0 * min(force[i], force[j]):
            return i, j


def test_two_exchanged_cuts_are_named() -> None:
    """Forces apart by more than a factor of two: 55 of 60 at least, and never another pair."""
    named = 0
    for seed in range(400, 460):
        table = lathe_cuts(seed)
        i, j = drawn_pair(table, seed)
        swapped = exchange(table, i, j)
        for check in faults.exchanged(swapped, forces_of(swapped), AXES, names_of(table)):
            if not check.passed:
                assert f"cut {table.cut[i]:g} and cut {table.cut[j]:g}" in check.sentence
                named += 1
    assert named >= 55


@pytest.mark.usefixtures("calibrated_once")
def test_exchanged_cuts_of_a_protocol_are_named() -> None:
    """What the log calls cut i was cut j: its currents are the other's. 55 of 60 at least."""
    named = 0
    for seed in range(400, 460):
        table = lathe_cuts(seed)
        protocol = protocol_of(table)
        i, j = drawn_pair(table, seed)
        bare = without_forces(table)
        changed = dict(bare.channels)
        for name in ("spindle.speed", "cutting.feed", "cutting.depth", "cutting.speed"):
            changed[name] = changed[name].copy()
            changed[name][[i, j]] = changed[name][[j, i]]
        changed["work.diameter"] = (
            1000.0 * changed["cutting.speed"] / np.pi / changed["spindle.speed"]
        )
        try:
            calibrate_table(replace(bare, channels=changed), axes=AXES, protocol=protocol)
        except UnusableInput as error:
            assert f"cut {table.cut[i]:g} and cut {table.cut[j]:g}" in str(error)
            named += 1
    assert named >= 55


def test_one_outlying_current_is_no_exchange() -> None:
    """A stop within a row lowers every axis' current of that cut."""
    for seed in SEEDS:
        table = lathe_cuts(seed)
        i, _ = drawn_pair(table, seed)
        halved = {}
        for axis in AXES:
            values = table[f"{axis}.current.range"].copy()
            values[i] = 0.5 * (values[i] + table[f"{axis}.current.air"][i])
            halved[f"{axis}__current__range"] = values
        outlying = with_channels(table, **halved)
        found = faults.exchanged(outlying, forces_of(outlying), AXES, names_of(outlying))
        assert all(check.passed for check in found)


def test_a_single_axis_does_not_tell_an_exchange() -> None:
    table = lathe_cuts(SEEDS[0])
    assert faults.exchanged(table, forces_of(table), ("z",), names_of(table)) == []
