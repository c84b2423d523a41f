"""Shapes that are tuned end at their best, in whatever order they are taken."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import Candidate, CandidateForm, Choice
from autodb.explain.engine.noise import Noise, Whitener
from autodb.explain.engine.symbolic import nearest_candidates
from autodb.explain.engine.tuning import BesideShapes, tuned_together

Array = NDArray[np.float64]

T_S = np.linspace(0.0, 1.0, 800)
NOISE = 0.05
TRUE_S = {"fast": 0.08, "slow": 0.3}


def _settling(time_s: float) -> Array:
    return -np.expm1(-T_S / time_s)


def _decaying(name: str, start_s: float) -> Choice:
    form = CandidateForm(
        _settling,
        shape={"time_s": start_s},
        within={"time_s": (start_s / 2.0, start_s * 2.0)},
        names=("level",),
    )
    return Choice(Candidate(name, "unknown", (form,)), 0)


@pytest.fixture
def bench() -> WhiteRows:
    """Return what two effects add that are much alike."""
    drawn = np.random.default_rng(17).normal(0.0, NOISE, len(T_S))
    signs = zip((1.0, -0.8), TRUE_S.values(), strict=True)
    return WhiteRows(sum(k * _settling(s) for k, s in signs) + drawn, {}, 1)


def test_two_effects_end_where_neither_moves(bench: WhiteRows) -> None:
    noise: Noise = (Whitener(np.zeros(1)), NOISE**2)
    starts = [_decaying("fast", 0.06), _decaying("slow", 0.4)]
    one = tuned_together(bench, starts, noise)
    other = tuned_together(bench, starts[::-1], noise)[::-1]
    for found, again, name in zip(one, other, TRUE_S, strict=True):
        beside = BesideShapes(bench, [c for c in one if c is not found], noise)
        here = found.shape.shape["time_s"]
        sd = _sd(beside, found, here)
        assert_allclose(again.shape.shape["time_s"], here, atol=1e-3 * sd, rtol=0, err_msg=name)
        assert_allclose(here, TRUE_S[name], atol=6.0 * sd + 0.5 * TRUE_S[name], err_msg=name)
        slope = np.diff([_gain(beside, found, here + k * 1e-2 * sd) for k in (-1.0, 1.0)])[0]
        assert abs(slope) / 0.02 < 0.02, "in standard errors what is left to the best"


def _gain(beside: BesideShapes, found: Choice, time_s: float) -> float:
    form = found.shape
    return beside.gain(CandidateForm(form.law, shape={"time_s": time_s}, names=form.names))


def _sd(beside: BesideShapes, found: Choice, here: float) -> float:
    width = 1e-2 * here
    below, at, above = (_gain(beside, found, here + k * width) for k in (-1.0, 0.0, 1.0))
    return float(width * np.sqrt(2.0 / (2.0 * at - below - above)))


def _waves(of: Array) -> Array:
    return np.column_stack([f(2.0 * np.pi * k * of) for k in (1, 2, 3) for f in (np.cos, np.sin)])


@pytest.mark.parametrize(
    "columns",
    [
        _waves(T_S) * np.array([1e3, 1.0, 1e-3, 1.0, 1.0, 1.0]),
        _waves(0.02 * T_S),
        np.column_stack([np.ones_like(T_S), 1.0 + 1e-5 * T_S]),
        np.column_stack([T_S, 3.0 * T_S]),
        np.column_stack([T_S, np.zeros_like(T_S)]),
    ],
    ids=["waves", "a part of a wave", "nearly one column", "one column twice", "one and none"],
)
def test_what_a_shape_explains_is_what_least_squares_take_away(columns: Array) -> None:
    target = np.exp(-T_S) + np.random.default_rng(3).normal(0.0, NOISE, len(T_S))
    bench = WhiteRows(target, {}, 1)
    gain = BesideShapes(bench, [], (Whitener(np.zeros(0)), 1.0)).gain(
        CandidateForm(lambda: columns)
    )
    sizes = np.linalg.lstsq(columns, target, rcond=1e-9)[0]
    assert_allclose(gain, target @ target - np.sum((target - columns @ sizes) ** 2), rtol=1e-7)


def test_a_column_that_others_give_takes_no_direction_of_its_own() -> None:
    """A curve whose columns add up to an own one spans no more: what is left of it is rounding,
    and a direction of rounding takes something at random from what a shape explains."""
    target = 0.2 * _settling(0.1) + np.random.default_rng(4).normal(0.0, NOISE, len(T_S))
    waves = _waves(T_S)
    curve = CandidateForm(lambda: waves, names=())
    twice = CandidateForm(lambda: np.column_stack([waves, waves @ np.arange(1.0, 7.0)]), names=())
    gains = [
        BesideShapes(
            WhiteRows(target, {"level": np.ones_like(T_S)}, 1),
            [Choice(Candidate("curve", "unknown", (form,)), 0)],
            (Whitener(np.zeros(0)), NOISE**2),
        ).gain(CandidateForm(lambda: _settling(0.1)))
        for form in (curve, twice)
    ]
    assert_allclose(gains[1], gains[0], rtol=1e-9)


def test_of_forms_that_are_the_same_beside_others_the_first_is_nearest() -> None:
    """x v, (x − a) v and (b − x) v differ by a multiple of v, whatever the last digit says."""
    rng = np.random.default_rng(6)
    x, v = np.cumsum(rng.normal(size=400)), rng.normal(size=400)
    same = [(x * v)[:, None], ((x - 3.0) * v)[:, None], ((7.0 - x) * v)[:, None]]
    other = rng.normal(size=(400, 1))
    for seed in range(20):
        drawn = np.random.default_rng(seed).normal(size=400)
        curve = (x * v) * (1.0 + 1e-12 * drawn)
        assert nearest_candidates(curve, v[:, None], [other, *same], 3) == [1, 2, 3]
