"""A recording of hours is searched in means of its rows, with what its law shows at every row."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.explain import explain, long_recordings
from autodb.explain.long_recordings import long_recording
from autodb.records.tables import Recording
from autodb.timing import Timing

Array = NDArray[np.float64]

RATE_HZ, ROWS = 500.0, 60_000
MASS, RIPPLE_A, NOISE_A = 4e-3, 0.05, 0.02
"""A·s²/mm of the mass that the simulation leaves out, a ripple of 20 mm, the current's noise."""


def _recordings() -> tuple[Recording, Recording]:
    """Return two minutes of moves with friction, a mass and a ripple, and the friction alone."""
    rng = np.random.default_rng(20261130)
    t = np.arange(ROWS) / RATE_HZ
    speed = 120.0 * np.sin(0.9 * t) * np.sin(0.031 * t + 0.4)
    place = 250.0 + np.cumsum(speed) / RATE_HZ
    friction = 0.6 * np.tanh(speed / 0.1)
    left_out = MASS * np.gradient(speed, t) + RIPPLE_A * np.sin(2.0 * np.pi * place / 20.0)
    effort = friction + left_out + rng.normal(0.0, NOISE_A, ROWS)
    measured = Recording(Path("a.csv"), {"t": t, "x.position": place, "x.current": effort})
    return measured, Recording(Path("b.csv"), {"t": t, "x.current": friction})


def test_a_long_recording_is_explained_in_means_and_corrected_at_every_row(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(long_recordings, "MEANS", 12_000)
    measured, simulated = _recordings()
    long = explain(measured, simulated, includes=["coulomb"])
    found = {one.term: one for one in long.explanation.channels["x.current"].missing}
    assert {"inertia", "cogging"} <= {name for name, one in found.items() if one.confidence > 0.8}
    assert found["inertia"].parameters["coefficient"].value == pytest.approx(MASS, rel=0.01)
    assert found["cogging"].parameters["amplitude"].value == pytest.approx(RIPPLE_A, rel=0.03)
    left = measured["x.current"] - long.rows["x.current"]
    assert len(left) == ROWS
    assert float(np.std(left)) < 1.05 * NOISE_A
    assert long.notes[0] == (
        "a.csv: 60000 rows are searched, and their errors counted, as means of 5 each: 100 a "
        "second; corrections are written at every row"
    )
    assert "x.velocity and x.acceleration derived from x.position" in long.notes[1]


def test_motion_is_derived_at_every_row_before_it_is_a_mean(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """In chunks, none of which begins anew: as a whole."""
    monkeypatch.setattr(long_recordings, "MEANS", 6_000)
    measured, _ = _recordings()
    whole = long_recording(measured, ["x.current"])
    monkeypatch.setattr(long_recordings, "CHUNK", 7_001)
    parted = long_recording(measured, ["x.current"])
    assert whole is not None
    assert parted is not None
    t = whole.means.t_s
    speed = 120.0 * np.sin(0.9 * t) * np.sin(0.031 * t + 0.4)
    assert_allclose(whole.means["x.velocity"][5:-5], speed[5:-5], atol=0.5)
    for name in ("x.velocity", "x.acceleration"):
        assert_allclose(parted.means[name], whole.means[name], atol=1e-6 * np.ptp(speed))


def test_means_lie_within_the_pieces_of_a_recording(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(long_recordings, "MEANS", 6_000)
    measured, _ = _recordings()
    kept = np.r_[0:20_003, 30_000:60_000]
    pieces = (slice(0, 20_003), slice(20_003, len(kept)))
    timing = Timing(1.0 / RATE_HZ, pieces, len(kept))
    channels = {name: values[kept] for name, values in measured.channels.items()}
    long = long_recording(replace(measured, channels=channels, examined_as=timing), ["x.current"])
    assert long is not None
    assert long.rate.factor == 8
    assert long.means.pieces == (slice(0, 2_500), slice(2_500, 6_250))
    assert long.means.t_s[2_500] == pytest.approx(30_003.5 / RATE_HZ)
    assert len(long.at_every_row(np.zeros(6_250))) == len(kept)


def test_a_short_recording_and_one_in_many_pieces_stay_as_they_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    measured, _ = _recordings()
    assert long_recording(measured, ["x.current"]) is None
    monkeypatch.setattr(long_recordings, "MEANS", 6_000)
    pieces = tuple(slice(start, start + 8) for start in range(0, ROWS, 8))
    timing = Timing(1.0 / RATE_HZ, pieces, ROWS)
    parted = replace(measured, examined_as=timing)
    assert long_recording(parted, ["x.current"]) is None
