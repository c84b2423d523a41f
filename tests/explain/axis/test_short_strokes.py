"""A stroke on a drive's oscilloscope: half a second, and a thousand rows."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import autodb
from autodb.errors import UnusableInput
from autodb.explain.answer import ChannelAnswer
from autodb.explain.axis.loads import told_by_phases
from autodb.explain.axis.signals import axis_signals
from autodb.records.tables import Recording


def _stroke(
    *, mass: float = 0.0, load: float = 0.0, rows: int = 1000, seed: int = 1
) -> ChannelAnswer:
    """Return the answer for a feed axis that goes 150 mm forth and 20 mm back in half a second.

    The load is there from 0.1 to 0.2 s.
    """
    rng, t = np.random.default_rng(seed), np.linspace(0.0, 0.5, rows)
    forth, back = np.clip(t / 0.32, 0.0, 1.0), np.clip((t - 0.36) / 0.12, 0.0, 1.0)
    steps = [way - np.sin(2.0 * np.pi * way) / (2.0 * np.pi) for way in (forth, back)]
    position = 150.0 * steps[0] - 20.0 * steps[1]
    velocity = np.gradient(position, t)
    friction = 3.0 * np.tanh(velocity / 5.0) + 0.008 * velocity
    pushed = mass * np.gradient(velocity, t) + load * ((t > 0.1) & (t < 0.2))
    effort = friction + pushed + rng.normal(0.0, 0.3, rows)
    recorded = {"t": t, "x.position": position, "x.velocity": velocity, "x.current": effort}
    simulated = pd.DataFrame({"t": t, "x.current": friction})
    done = autodb.explain(pd.DataFrame(recorded), simulated, includes=["coulomb", "viscous"])
    return done.answer.explanation.channels["x.current"]


def test_a_mass_is_found_in_half_a_second() -> None:
    """A recording is short in rows and in moves, not in seconds."""
    (first, *_) = _stroke(mass=0.0008).missing
    assert first.term == "inertia"
    assert first.confidence > 0.9
    assert first.parameters["coefficient"].value == pytest.approx(0.0008, rel=0.05)


def test_a_load_during_a_part_of_a_stroke_is_found() -> None:
    """Friction in other sizes takes up most of it, and what is left is largest at the end."""
    answer = _stroke(load=4.0, seed=3)
    (first, *_) = answer.missing
    assert first.term == "external_load"
    assert first.confidence > 0.9
    assert first.parameters["level"].value == pytest.approx(4.0, rel=0.1)
    assert answer.where.intervals[0] == pytest.approx((0.1, 0.2), abs=0.01)


def test_what_the_phases_of_a_stroke_tell_is_no_load() -> None:
    t = np.linspace(0.0, 4.0, 2000)
    velocity = 100.0 * np.clip(np.minimum(t - 1.0, 3.0 - t) / 0.2, 0.0, 1.0)
    moved = {"t": t, "x.position": np.cumsum(velocity) * t[1], "x.velocity": velocity}
    recording = Recording(Path("a.csv"), moved | {"x.current": np.sign(velocity)})
    signals = axis_signals(recording, np.zeros(2000), "x.current")
    assert told_by_phases(signals, 1.0, 3.0)
    assert told_by_phases(signals, 1.2, 2.8)
    assert not told_by_phases(signals, 1.4, 1.8)


def test_half_a_second_in_which_nothing_is_missing_names_nothing_surely() -> None:
    assert all(cause.confidence < 0.9 for cause in _stroke(mass=0.0, seed=2).missing)


def test_too_few_rows_are_refused() -> None:
    with pytest.raises(UnusableInput, match=r"150 rows are too few .* at least 200 rows"):
        _stroke(mass=0.0008, rows=150)
