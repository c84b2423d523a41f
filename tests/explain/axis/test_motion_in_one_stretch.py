"""An axis that moves in a part of its recording only: laws show there, and nowhere else."""

import numpy as np
import pandas as pd
import pytest
from scipy.signal import lfilter

import autodb
from autodb.explain.answer import ChannelAnswer


def _burst(*, mass: float, seed: int) -> ChannelAnswer:
    """Return the answer for an axis that swings ever faster in the first quarter of a recording and
    rests then; its simulation has friction alone."""
    rng, step_s = np.random.default_rng(seed), 0.01
    t = np.arange(0.0, 16.0, step_s)
    swing = np.where(t < 4.0, 1.0, 0.0) * np.sin(2.0 * np.pi * (0.4 + 0.2 * np.minimum(t, 4.0)) * t)
    position = 30.0 * np.convolve(np.pad(swing, 10, mode="edge"), np.ones(21) / 21.0, mode="valid")
    velocity = np.gradient(position, step_s)
    friction = 1.0 * np.tanh(velocity / 0.5) + 0.004 * velocity
    slow = lfilter([1.0], [1.0, -0.95], rng.normal(0.0, 0.03, len(t)))
    effort = friction + mass * np.gradient(velocity, step_s) + slow
    recorded = {"t": t, "x.position": position, "x.velocity": velocity, "x.current": effort}
    simulated = pd.DataFrame({"t": t, "x.current": friction})
    done = autodb.explain(pd.DataFrame(recorded), simulated, includes=["coulomb", "viscous"])
    return done.answer.explanation.channels["x.current"]


def test_a_mass_is_found_that_shows_in_two_blocks_of_eight() -> None:
    """In six of eight blocks nothing can be predicted better: no law would be needed in most."""
    (first, *_) = _burst(mass=0.001, seed=1).missing
    assert first.term == "inertia"
    assert first.confidence > 0.9
    assert first.parameters["coefficient"].value == pytest.approx(0.001, rel=0.05)


def test_where_nothing_is_missing_a_stretch_of_motion_names_nothing() -> None:
    """Blocks that all hold a part of the stretch are not easier to predict by chance."""
    assert all(cause.confidence < 0.9 for cause in _burst(mass=0.0, seed=2).missing)
