"""An axis that moves for a moment and rests: its laws are judged by blocks of the way, too."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.signal import lfilter

from autodb.explain.axis.look import explain_axis
from autodb.explain.engine.fit import block_edges
from autodb.records.tables import Recording

T_S = np.arange(2400) / 100.0
NOISE_A = 0.05


def test_blocks_hold_equal_shares_of_what_was_passed() -> None:
    """Nine tenths lie behind the first fifth of 1000 rows: so do seven of eight blocks."""
    progress = np.interp(np.arange(1.0, 1001.0), [0.0, 200.0, 1000.0], [0.0, 0.9, 1.0])
    edges = block_edges(1000, 8, progress)
    assert_allclose(
        np.interp(edges, [0.0, 200.0, 1000.0], [0.0, 0.9, 1.0]), np.arange(9) / 8, atol=0.005
    )
    assert np.sum(edges < 200) == 8


@pytest.mark.parametrize("rows", [800, 1154])
def test_steady_progress_makes_blocks_of_equal_length(rows: int) -> None:
    steady = np.arange(1.0, 2 * rows + 1) / (2 * rows)
    assert_array_equal(block_edges(rows, 40, steady), block_edges(rows, 40))


@pytest.mark.parametrize("seed", [0, 2])
def test_friction_is_sure_though_the_axis_moves_in_one_of_twelve_parts_of_the_time(
    seed: int,
) -> None:
    """Forth and back for two seconds of 24: in blocks of time one alone would show the motion, and
    none could be predicted by the others.
    """
    moves = T_S < 2.0
    velocity = np.where(moves, 40.0 * np.sin(np.pi * T_S), 0.0)
    friction_A = 0.3 * np.sign(velocity) * (np.abs(velocity) > 1.0)
    white = np.random.default_rng(seed).normal(size=len(T_S) + 300)
    noise = np.asarray(lfilter([1.0], [1.0, -0.95], white))[300:]
    simulation = 0.004 * velocity + 0.2
    channels = {
        "t": T_S,
        "x.position": np.cumsum(velocity) / 100.0,
        "x.velocity": velocity,
        "x.acceleration": np.where(moves, 40.0 * np.pi * np.cos(np.pi * T_S), 0.0),
        "x.current": simulation + friction_A + noise * NOISE_A / noise.std(),
    }
    recording = Recording(path=Path("r.csv"), channels=channels)
    answer, _ = explain_axis(recording, simulation, "x.current", ["viscous", "gravity"])
    (cause,) = answer.missing
    assert cause.term == "coulomb"
    assert cause.confidence > 0.9
    assert_allclose(cause.parameters["size"].value, 0.3, rtol=0.1)
