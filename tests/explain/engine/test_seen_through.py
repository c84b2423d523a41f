"""What changes all that is recorded is not changed by itself, nor anything else twice."""

import numpy as np
from numpy.testing import assert_allclose

from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import Candidate, CandidateForm, Choice, near_one
from autodb.explain.engine.fitted import fit_white_rows
from autodb.explain.engine.noise import PLAIN

NOISE_A = 0.01


def test_a_limit_that_all_is_seen_through_keeps_what_it_takes() -> None:
    """Seen through itself it would take nothing: the correction would be none."""
    rng, effort_A = np.random.default_rng(1), 1.5 * np.sin(np.linspace(0.0, 60.0, 3000))
    free = np.abs(effort_A) <= 1.0
    taken_A = np.where(free, 0.0, np.sign(effort_A) - effort_A)
    limit = CandidateForm(
        lambda: taken_A,
        names=("share",),
        allowed=near_one,
        through=lambda columns: columns * free[:, None],
    )
    choice = Choice(Candidate("saturation", "saturation", (limit,)), 0)
    bench = WhiteRows(taken_A + rng.normal(0.0, NOISE_A, 3000), {"viscous": effort_A}, 1)
    bench.look_through([choice])
    fitted = fit_white_rows(bench, [choice], (PLAIN, NOISE_A**2))
    assert_allclose(fitted.correction, taken_A, atol=0.2 * NOISE_A)


def test_an_effect_is_seen_through_lost_signs_once() -> None:
    """Twice it would have its sign again: half of its rows would be corrected the wrong way."""
    rng, t = np.random.default_rng(2), np.linspace(0.0, 60.0, 3000)
    sign, ripple_A = np.sign(np.sin(t)), 0.1 * np.sin(7.0 * t)
    lost = CandidateForm(
        lambda: np.zeros(3000), names=("share",), through=lambda columns: columns * sign[:, None]
    )
    ripple = Choice(
        Candidate("cogging", "cogging", (CandidateForm(lambda: ripple_A, names=("size",)),)), 0
    )
    bench = WhiteRows(sign * ripple_A + rng.normal(0.0, NOISE_A, 3000), {}, 1)
    bench.look_through([Choice(Candidate("lost_sign", "lost_sign", (lost,)), 0)])
    fitted = fit_white_rows(bench, [ripple], (PLAIN, NOISE_A**2))
    assert_allclose(fitted.effects[0], sign * ripple_A, atol=0.2 * NOISE_A)
