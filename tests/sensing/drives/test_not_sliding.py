"""Rows in which an axis does not slide as its laws say: they tell nothing of these laws."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.records import source as records
from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import identify
from autodb.sensing.drives.moves.motion import term_inputs
from autodb.sensing.drives.reconstruct import DriveModel, reconstruct
from tests.conftest import shared
from tests.helpers.campaigns import first
from tests.helpers.wandering_axis import WanderingAxis, wandering_axis

Array = NDArray[np.float64]

PRESLIDES_MM = 0.3


def _bending(axis: WanderingAxis, seed: int) -> Recording:
    """Return an axis whose friction comes to its law over a way after each turn and stays at rest,
    under noise that is nearly constant over a move.
    """
    x, v = axis.channels["x.position"], axis.channels["x.velocity"]
    sense, way, state, begun = np.zeros(len(x)), 0.0, np.zeros(len(x)), 0.0
    for k in range(1, len(x)):
        sense[k] = np.sign(v[k]) if abs(v[k]) > 1e-9 else sense[k - 1]
        way = way + abs(x[k] - x[k - 1]) if sense[k] == sense[k - 1] else 0.0
        begun = begun if sense[k] == sense[k - 1] else state[k - 1]
        state[k] = sense[k] + (begun - sense[k]) * np.exp(-way / PRESLIDES_MM)
    rng = np.random.default_rng([seed, 81])
    noise = np.zeros(len(x))
    for k, step in enumerate(0.004 * axis.coulomb * rng.standard_normal(len(x) - 1)):
        noise[k + 1] = 0.995 * noise[k] + step
    force = state * (axis.coulomb + axis.viscous * np.abs(v)) + axis.weight + noise
    force = force + axis.inertia * axis.channels["x.acceleration"]
    return Recording(Path("axis.csv"), {**axis.channels, "x.drive_force": force})


@pytest.mark.parametrize("seed", first(2, range(6)))
def test_coulomb_friction_is_not_told_by_what_happens_after_a_turn(seed: int) -> None:
    """Within 4 %; where turns and rests counted it was less than half, and sure of it."""
    axis = wandering_axis(seed, share=0.0)
    found = identify(_bending(axis, seed), axis="x")
    assert abs(found.value("coulomb") / axis.coulomb - 1.0) < 0.04


def test_a_velocity_that_is_noise_is_no_motion() -> None:
    """Noise of ± 0.1 mm/s at rest turns nothing; a motion of five times that counts whole."""
    rng = np.random.default_rng(3)
    v = np.concatenate([np.zeros(400), np.full(400, 0.6), np.zeros(400)])
    x = np.concatenate([[0.0], np.cumsum(v)[:-1] * 0.01])
    seen = v + 0.1 * rng.standard_normal(len(v))
    recording = Recording(
        Path("noisy.csv"),
        {"t": np.linspace(0.0, 12.0, len(v), endpoint=False), "x.position": x, "x.velocity": seen},
    )
    sense = np.abs(term_inputs(recording, "x", cutoff_hz=20.0)["direction"])
    assert np.mean(sense[v == 0.0]) < 0.03
    assert np.mean(sense[v > 0.0]) > 0.9


@pytest.mark.parametrize("axis", ["x", "y"])
def test_a_real_mill_is_identified_from_a_part_of_its_moves(axis: str) -> None:
    """SMART lab's mill, 10 samples a second, rapids in few rows: Coulomb friction of ± 5 A.

    The first third is predicted from the others. Friction was not told at all there: the load was 4
    A off for 1 A of plain least squares, and intervals held in 5 %.
    """
    whole = records.read(shared("data", "real", f"smart-{axis}-null", "recording.csv"))
    assert isinstance(whole, Recording)
    third = len(whole) // 3
    parts = [slice(third, None), slice(0, third)]
    fitted, left_out = (
        Recording(whole.path, {name: values[rows] for name, values in whole.channels.items()})
        for rows in parts
    )
    load = reconstruct(left_out, DriveModel.of(identify(fitted)), bandwidth_hz=1.0)
    moves = ~load.standing
    assert np.sqrt(np.mean(load.value[moves] ** 2)) < 2.0
    assert np.mean(np.abs(load.value) < 1.96 * load.sd) > 0.95
