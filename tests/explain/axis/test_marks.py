"""Clips, lost signs, ramps and reversals are told by the marks that they leave in a recording.

A virtual axis with friction, mass and a little noise; simulations are its own terms, as they are or
fitted by least squares to what was recorded.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.answer import ChannelAnswer
from autodb.explain.axis.marks import clipping, lost_sign_candidate
from autodb.explain.axis.sensors_of_axis import shift
from autodb.explain.axis.signals import axis_signals
from autodb.explain.engine.candidates import CandidateForm
from autodb.records.tables import Recording
from autodb.sensing.drives.moves.motion import without_flicker
from autodb.terms.friction import backlash, since_reversal
from tests.helpers.campaigns import first

Array = NDArray[np.float64]

T_S = np.arange(6000) / 200.0
POSITION = 120.0 * np.sin(0.7 * T_S) + 35.0 * np.sin(3.1 * T_S)
VELOCITY = np.asarray(np.gradient(POSITION, T_S))
ACCELERATION = np.asarray(np.gradient(VELOCITY, T_S))
TERMS = np.column_stack([np.tanh(VELOCITY / 2.0), VELOCITY, ACCELERATION])
EFFORT = TERMS @ [0.9, 0.004, 0.006]
NOISE = 0.02 * np.random.default_rng(11).normal(size=len(T_S))
INCLUDES = ["coulomb", "viscous", "inertia"]


def _fitted(recorded: Array) -> Array:
    return np.asarray(TERMS @ np.linalg.lstsq(TERMS, recorded, rcond=None)[0])


def _recording(effort: Array, **channels: Array) -> Recording:
    motion = {"x.position": POSITION, "x.velocity": VELOCITY, "x.acceleration": ACCELERATION}
    every = {"t": T_S, **motion, "x.current": effort, **channels}
    return Recording(path=Path("recording.csv"), channels=every)


def _answer(recorded: Array, simulated: Array, includes: list[str] = INCLUDES) -> ChannelAnswer:
    simulation = {"t": T_S, "x.current": simulated}
    done = explain(
        _recording(recorded),
        Recording(path=Path("simulation.csv"), channels=simulation),
        includes=includes,
    )
    return done.explanation.channels["x.current"]


def _value(answer: ChannelAnswer, term: str, name: str = "size") -> float:
    (cause,) = (one for one in answer.missing if one.term == term and one.kind == "missing")
    assert cause.confidence >= 0.5
    return cause.parameters[name].value


@pytest.mark.parametrize("low", first(1, [-1.2, -9.0]), ids=["both ways", "one way"])
def test_a_simulation_fitted_to_a_clipped_effort_leaves_out_the_clip(low: float) -> None:
    whole = EFFORT + NOISE
    recorded = np.clip(whole, low, 1.2)
    answer = _answer(recorded, _fitted(recorded))
    beyond = np.abs(EFFORT - np.clip(EFFORT, low, 1.2)).max()
    assert_allclose(_value(answer, "saturation"), beyond, rtol=0.05)
    assert_allclose(_value(answer, "saturation", "limit"), 1.2, rtol=1e-4)
    assert answer.fit.heldout_after < 1.3 * np.std(NOISE)


def test_a_simulation_fitted_to_magnitudes_leaves_out_their_sign() -> None:
    """Its own signs are lost with it, or what is left of them."""
    recorded = np.abs(EFFORT + NOISE)
    level = np.ones_like(EFFORT)
    terms = np.column_stack([TERMS, level])
    simulated = np.asarray(terms @ np.linalg.lstsq(terms, recorded, rcond=None)[0])
    assert np.quantile(simulated, 0.02) > 0.0
    answer = _answer(recorded, simulated, [*INCLUDES, "gravity"])
    assert_allclose(_value(answer, "lost_sign"), 2.0 * np.abs(EFFORT).max(), rtol=0.05)


def test_a_load_that_never_turns_has_its_sign() -> None:
    recorded = 0.3 * EFFORT + 1.5 + NOISE
    assert recorded.min() > 0.0
    signals = axis_signals(_recording(recorded), 0.3 * EFFORT, "x.current", includes=INCLUDES)
    (form, *_) = lost_sign_candidate(signals).forms
    assert form.allowed is not None
    assert not form.allowed(np.ones(1))
    magnitude = _recording(np.abs(0.3 * EFFORT + NOISE))
    (form, *_) = lost_sign_candidate(axis_signals(magnitude, 0.3 * EFFORT, "x.current")).forms
    assert form.allowed is not None
    assert form.allowed(np.ones(1))


def test_few_signs_are_lost_where_none_is_left() -> None:
    """Of an effort with the other sign in one row of fifty; not where one row recorded has it."""
    level = -float(np.quantile(EFFORT, 0.02))
    effort = EFFORT + level
    assert np.mean(effort < 0.0) == pytest.approx(0.02, abs=1e-3)
    recorded = np.abs(effort + NOISE)
    answer = _answer(recorded, effort, [*INCLUDES, "gravity"])
    assert_allclose(_value(answer, "lost_sign"), -2.0 * effort.min(), rtol=0.05)
    recorded[np.argmin(effort)] *= -1.0
    (form, *_) = lost_sign_candidate(axis_signals(_recording(recorded), effort, "x.current")).forms
    assert form.allowed is not None
    assert not form.allowed(np.ones(1))


def test_a_wave_that_turns_back_below_its_top_is_not_clipped() -> None:
    """Simulated too high: of the limits that are tried none has a flat recording beyond it."""
    wave = np.sin(2.0 * T_S)
    recorded = _recording(wave + 0.25 * np.sin(6.0 * T_S) + 0.1 * NOISE)
    offered = clipping(axis_signals(recorded, wave, "x.current")).forms
    clipped = _recording(np.clip(wave + 0.1 * NOISE, -0.8, 0.8))
    assert not offered
    assert clipping(axis_signals(clipped, wave, "x.current")).forms


def test_an_effort_that_is_switched_has_no_limit() -> None:
    switched = np.where(np.sin(3.0 * T_S) >= 0.0, 0.8, -0.8)
    signals = axis_signals(_recording(switched), EFFORT, "x.current", includes=INCLUDES)
    assert not clipping(signals).forms
    beside = np.where(np.arange(len(T_S)) % 25 == 0, 0.1, switched)  # a twenty-fifth between them
    signals = axis_signals(_recording(beside), EFFORT, "x.current", includes=INCLUDES)
    assert clipping(signals).forms


def test_a_shift_of_a_part_of_a_row_turns_no_phase() -> None:
    """Of a ripple of four rows a wave, known at every moment; lines between rows turn it by 45°."""
    a_row = 1.0 / 200.0

    def wave(t_s: Array) -> Array:
        return np.asarray(np.sin(2.0 * np.pi * t_s / (4.0 * a_row)))

    for delay_s in (0.1 * a_row, -0.1 * a_row):
        change = wave(T_S - delay_s) - wave(T_S)
        (form, *_) = shift(axis_signals(_recording(change), wave(T_S), "x.current")).forms
        column = form.build()[1:-1, 0]
        size = float(column @ change[1:-1] / (column @ column))
        left = change[1:-1] - size * column
        assert form.allowed is not None
        assert form.allowed(np.array([size]))
        assert size * delay_s > 0.0
        assert np.sum(left**2) < 0.02 * np.sum(change**2)


def test_ripples_of_two_periods_are_one_cause_of_the_size_that_they_have_together() -> None:
    ripple = 0.3 * np.sin(2 * np.pi * POSITION / 20.0) + 0.25 * np.sin(2 * np.pi * POSITION / 8.3)
    answer = _answer(EFFORT + ripple + NOISE, EFFORT)
    assert_allclose(_value(answer, "cogging"), np.abs(ripple).max(), rtol=0.05)


def test_a_gain_that_ramps_is_said_with_its_times() -> None:
    ramp = np.clip((T_S - 12.0) / 9.0, 0.0, 1.0)
    answer = _answer(EFFORT * (1.0 + 0.3 * ramp) + NOISE, EFFORT)
    assert_allclose(_value(answer, "gain", "factor"), 1.3, atol=0.02)
    assert_allclose(_value(answer, "gain", "start"), 12.0, atol=0.5)
    assert_allclose(_value(answer, "gain", "duration"), 9.0, atol=1.0)


def test_the_last_step_of_an_encoder_turns_nothing() -> None:
    """Three moves with a rest after each, at which the last digit comes and goes."""
    rng = np.random.default_rng(5)
    place = np.interp(np.arange(1400), [0, 200, 400, 600, 800, 1000, 1200], [0, 9, 9, 18, 18, 4, 4])
    written = 0.003 * np.round(place / 0.003 + 0.4 * (rng.random(1400) - 0.5))
    sense = np.clip(np.gradient(written, 0.004) / 0.05, -1.0, 1.0)
    turns = np.flatnonzero(np.diff(since_reversal(sense, written)[0]) != 0)
    kept = without_flicker(sense, written)
    last, _ = since_reversal(kept, written)
    assert len(turns) > 20
    assert np.flatnonzero(np.diff(last) != 0).tolist() == [pytest.approx(800, abs=4)]
    moving = np.abs(np.gradient(place)) > 0.01
    assert_allclose(kept[moving], np.sign(np.gradient(place))[moving])


def test_play_is_found_where_an_axis_rests_on_the_last_step_of_its_encoder() -> None:
    rests = np.interp(T_S, np.arange(0.0, 31.0, 1.5), 60.0 * np.array([0, 1, 1, 2, 2, 0, 0] * 3))
    jitter = 0.4 * (np.random.default_rng(3).random(len(T_S)) - 0.5)
    written = 0.003 * np.round(rests / 0.003 + jitter)
    speed = np.gradient(rests, T_S)
    turning = np.clip(speed / 1.0, -1.0, 1.0)
    friction = 0.9 * turning
    missing = 0.5 * backlash(turning, rests, gap_mm=8.0)
    channels = {"t": T_S, "x.position": written, "x.current": friction + missing + NOISE}
    simulation = {"t": T_S, "x.current": friction}
    done = explain(
        Recording(path=Path("recording.csv"), channels=channels),
        Recording(path=Path("simulation.csv"), channels=simulation),
        includes=["coulomb"],
    )
    answer = done.explanation.channels["x.current"]
    assert_allclose(_value(answer, "backlash"), 0.5, rtol=0.1)
    assert_allclose(_value(answer, "backlash", "gap"), 8.0, rtol=0.1)


def test_the_direction_is_that_of_the_motion_which_the_simulation_was_computed_with() -> None:
    rough = POSITION + 0.02 * np.random.default_rng(2).normal(size=len(T_S))
    recording = Recording(
        path=Path("recording.csv"),
        channels={"t": T_S, "x.position": rough, "x.current": EFFORT + NOISE},
    )
    read = axis_signals(recording, 0.004 * VELOCITY, "x.current", includes=["viscous"])
    assert_allclose(read.sense, read.direction)


def test_noise_that_a_limit_lets_through_is_no_slope() -> None:
    """A limit 0.1 A below the largest effort, under noise of 0.4 A: rows that noise takes below it
    are recorded there, so that on the mean they follow the effort by nearly a half."""
    noise = 0.4 * np.random.default_rng(12).normal(size=len(T_S))
    limit = 0.97 * float(EFFORT.max())
    recorded = np.clip(EFFORT + noise, -limit, limit)
    signals = axis_signals(_recording(recorded), EFFORT, "x.current")
    between = [form.within["limit"] for form in clipping(signals).forms if form.within]
    assert any(low < limit < high for low, high in between)
    free = axis_signals(_recording(EFFORT + 0.2 * noise), 1.05 * EFFORT, "x.current")
    assert not clipping(free).forms


def test_a_spike_of_a_few_rows_shows_no_limit() -> None:
    """Six rows in which a simulation goes half as high again as anything that was recorded: nothing
    says where these would have ended. Of twelve rows it does."""
    few, more = (EFFORT.copy() for _ in range(2))
    highest = float(EFFORT.max())
    rows = np.random.default_rng(6).permutation(np.argsort(EFFORT)[-12:])
    spikes = highest * np.linspace(1.5, 1.7, 12)
    few[rows[:6]], more[rows] = spikes[:6], spikes
    recording = _recording(np.clip(EFFORT + NOISE, None, 0.99 * highest))
    for simulated, some in ((few, False), (more, True)):
        forms = clipping(axis_signals(recording, simulated, "x.current")).forms
        above = [form.shape["limit"] > 1.02 * highest for form in forms if form.within]
        assert any(above) == some


def test_a_limit_that_rows_stand_above_is_none() -> None:
    """A wave that ends a fifth lower than simulated, and the same with single rows above its end,
    one in eight there: these have no limit."""
    wave = np.sin(2.0 * T_S)
    ended = np.clip(wave, -0.8, 0.8)
    spiked = ended.copy()
    rows = np.flatnonzero(np.abs(wave) > 0.9)[::8]
    spiked[rows] *= 1.25
    for effort, some in ((ended, True), (spiked, False)):
        offered = clipping(axis_signals(_recording(effort + 0.1 * NOISE), wave, "x.current")).forms
        at_limit = [replace(form, shape={"limit": 0.8}) for form in offered if form.within]
        assert at_limit
        assert any(form.is_shown for form in at_limit) == some


def test_a_faint_clip_goes_where_no_limit_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    """A limit 0.7 % below the largest effort is too faint for plain rows: white ones hold it,
    tuned. It stands as long as what was recorded shows its limit."""
    asked: list[CandidateForm] = []
    monkeypatch.setattr(CandidateForm, "is_shown", property(asked.append))
    limit = 0.993 * float(EFFORT.max())
    answer = _answer(np.clip(EFFORT + NOISE, -limit, limit), EFFORT)
    assert [form for form in asked if "limit" in form.shape]
    assert "saturation" not in [one.term for one in answer.missing]
