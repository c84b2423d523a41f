"""Where a mismatch sits: shares of the squared error beside shares of rows, of known truth."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.answer import ChannelAnswer, ChannelTrace, Regime
from autodb.explain.engine.locate import DENSER, SHARE, regimes, strongest_interval
from autodb.proofs.machines.axis.axis import PositionFriction, air_moves
from autodb.records.tables import CutTable, Recording

Array = NDArray[np.float64]
RNG = np.random.default_rng(5)
N = 20_000
TRAVEL = 250.0 + 250.0 * np.sin(np.linspace(0.0, 40.0, N))


def _noisy(effect: Array, sd: float = 0.1) -> Array:
    return effect + sd * RNG.standard_normal(len(effect))


def _inside(values: Array, regime: Regime) -> NDArray[np.bool_]:
    return (values >= regime.low) & (values <= regime.high)


def test_a_rough_stretch_is_a_regime_with_its_share_of_error_and_of_rows() -> None:
    rough = np.where((TRAVEL >= 310.0) & (TRAVEL <= 400.0), 0.5, 0.0)
    difference = _noisy(rough)
    (found,) = regimes(difference, rough, {"x.position": TRAVEL})
    assert_allclose([found.low, found.high], [310.0, 400.0], atol=1.0)
    inside = _inside(TRAVEL, found)
    assert_allclose(found.share, np.sum(difference[inside] ** 2) / np.sum(difference**2))
    assert_allclose(float(found.rows or 0.0), np.mean(inside))
    assert found.share > 0.75
    assert float(found.rows or 1.0) < 0.15


@pytest.mark.parametrize("offset", [0.3, -2.0])
def test_a_constant_load_is_nowhere_concentrated(offset: float) -> None:
    load = np.full(N, offset)
    signals = {"x.position": TRAVEL, "x.velocity": np.gradient(TRAVEL), "x.direction": _ways()}
    assert regimes(_noisy(load), load, signals) == ()


def _ways() -> Array:
    return np.sign(np.gradient(TRAVEL))


def test_a_place_where_the_axis_dwells_is_no_concentration() -> None:
    """Nine of ten rows stand at 200 mm and hold nine tenths of the error of a constant load."""
    place = np.where(RNG.uniform(size=N) < 0.9, 200.0, TRAVEL)
    load = np.full(N, 0.4)
    assert regimes(_noisy(load), load, {"x.position": place}) == ()
    rough = np.where((place > 50.0) & (place < 100.0), 3.0, 0.0)
    (found,) = regimes(_noisy(rough), rough, {"x.position": place})
    assert 50.0 < found.low < found.high < 100.0
    assert float(found.rows or 1.0) < 0.05


def test_noise_that_is_larger_somewhere_is_no_mismatch_there() -> None:
    load = np.full(N, 0.05)
    difference = load + np.where(TRAVEL > 400.0, 1.0, 0.02) * RNG.standard_normal(N)
    assert regimes(difference, load, {"x.position": TRAVEL}) == ()
    few = np.where(np.arange(N) % 6000 == 7, 50.0, 0.0)  # four rows that stand out are no range
    assert regimes(few, few, {"x.position": np.arange(float(N))}) == ()


def test_one_direction_alone_is_a_regime_of_the_direction() -> None:
    drag = np.where(_ways() > 0.0, 0.5, 0.0)
    (found,) = regimes(_noisy(drag, 0.05), drag, {"x.direction": _ways()})
    assert (found.low, found.high) == (1.0, 1.0)
    assert found.share > 0.95
    assert found.share > DENSER * float(found.rows or 1.0)


# Of whole answers


def _recomputed(
    recording: Recording | CutTable, trace: ChannelTrace, regime: Regime
) -> list[float]:
    """Return the shares of error and rows by the definition: rows whose value is in the range."""
    error = (trace.recording - trace.simulation) ** 2
    inside = _inside(recording[regime.signal], regime)
    return [float(np.sum(error[inside]) / np.sum(error)), float(np.mean(inside))]


def _shares(regime: Regime) -> list[float]:
    assert regime.rows is not None
    return [regime.share, regime.rows]


def _air(without: str, *extra: PositionFriction) -> tuple[Recording, ChannelAnswer, ChannelTrace]:
    channels, parts = air_moves(4, rate_hz=125.0, extra=extra)
    recording = Recording(path=Path("recording.csv"), channels=dict(channels))
    kept = {name: part for name, part in parts.items() if name != without}
    effort = np.asarray(sum(kept.values()))
    simulation = Recording(Path("sim.csv"), {"t": channels["t"], "x.current": effort})
    done = explain(recording, simulation, includes=list(kept))
    return recording, done.explanation.channels["x.current"], done.traces["x.current"]


def test_friction_at_the_far_end_is_located_along_the_travel_of_an_axis() -> None:
    recording, answer, trace = _air("position_friction", PositionFriction(0.004, from_mm=150.0))
    (cause,) = answer.missing
    (found,) = answer.where.regime
    assert (cause.term, found.signal) == ("position_friction", "x.position")
    assert answer.fit.heldout_after < 0.6 * answer.fit.heldout_before
    assert found.low > 150.0
    share, rows = _recomputed(recording, trace, found)
    assert_allclose(_shares(found), [share, rows])
    assert share >= max(SHARE, DENSER * rows)
    assert_allclose(trace.takes, [1.0 - (answer.fit.rms_after / answer.fit.rms_before) ** 2])


def test_cuts_in_a_band_of_speeds_are_located_by_speed_alone() -> None:
    """Forty of 120 cuts are at speeds with a built-up edge, a fifth harder; feed has no part."""
    rng = np.random.default_rng(8)
    n = 120
    speed, feed = rng.uniform(40.0, 220.0, n), rng.uniform(0.1, 0.4, n)
    force = 2000.0 * 1.5 * feed
    built_up = 0.25 * np.exp(-0.5 * (np.log(speed / 70.0) / 0.2) ** 2) * force
    known = {
        "cut": np.arange(1.0, n + 1.0), "t": 60.0 * np.arange(n), "cutting.speed": speed,
        "cutting.feed": feed, "cutting.depth": np.full(n, 1.5),
    }  # fmt: skip
    sensed = (force + built_up) * (1.0 + 0.01 * rng.standard_normal(n))
    table = CutTable(Path("cuts.csv"), {**known, "force.z": sensed})
    simulation = CutTable(Path("sim.csv"), {"cut": known["cut"], "force.z": force})
    done = explain(table, simulation, includes=["shear"])
    answer, trace = done.explanation.channels["force.z"], done.traces["force.z"]
    assert "built_up_edge" in {cause.term for cause in answer.missing}
    (found,) = answer.where.regime
    assert found.signal == "cutting.speed"
    assert 45.0 < found.low < 70.0 < found.high < 100.0
    assert_allclose(_shares(found), _recomputed(table, trace, found))
    assert_allclose(sum(trace.takes), 1.0 - (answer.fit.rms_after / answer.fit.rms_before) ** 2)


def test_the_strongest_interval_is_found_to_the_row() -> None:
    rng = np.random.default_rng(2)
    values = rng.normal(size=5000)
    values[1234:1834] += 2.0
    start, end, _ = strongest_interval(values)
    assert abs(start - 1234) < 15
    assert abs(end - 1834) < 15


def test_the_strongest_interval_is_what_own_terms_do_not_give() -> None:
    """A load during half of a stroke, of which a fit of mass and weight has taken up the most: what
    is left is largest elsewhere, and at the end, where no load can be told from a change."""
    rows = np.arange(2000)
    weight = np.cos(rows / 2000.0 * np.pi)
    mass = np.where(rows < 1000, 1.0, -1.0)
    load = np.where((rows >= 200) & (rows < 950), 5.0, 0.0)
    own = np.column_stack([weight, mass, np.ones(2000)])
    values = load + np.random.default_rng(3).normal(size=2000)
    left = values - own @ np.linalg.lstsq(own, values, rcond=None)[0]
    alone, beside = strongest_interval(left), strongest_interval(left, own, inside=0.02)
    assert abs(beside[0] - 200) < 15
    assert abs(beside[1] - 950) < 15
    assert alone[0] < 15


def test_a_stretch_that_own_terms_give_is_none() -> None:
    rows = np.arange(1000)
    known = ((rows >= 200) & (rows < 500)).astype(float)
    values = np.random.default_rng(4).normal(size=1000) + 3.0 * known
    start, end, _ = strongest_interval(values, known[:, None], inside=0.02)
    assert abs(start - 200) + abs(end - 500) > 40
    assert 20 <= start < end <= 980


def test_where_the_columns_give_every_stretch_there_is_none() -> None:
    every = np.tri(60)
    start, end, _ = strongest_interval(np.ones(60), every)
    assert start == end
