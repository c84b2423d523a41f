"""Weak effects beside strong ones, and tones that wander: known truth recovered."""

import numpy as np
import pytest

from autodb.explain.engine.candidates import Candidate, CandidateForm
from autodb.explain.engine.evidence import Products
from autodb.explain.engine.search import FAINT, CandidateSearch
from autodb.explain.waves.refined import shared_course
from autodb.explain.waves.scans import LINE, WIDE, standing_out

STRONG, WEAK = 300.0, 20.0
"""Clarities: squares are what columns explain."""


def _candidate(key: str, *, sure: bool = False) -> Candidate:
    return Candidate(key, key, (CandidateForm(np.ones),), ("t",), sure=sure)


@pytest.mark.parametrize(
    ("faint", "sure", "named"),
    [
        (FAINT, False, {"strong"}),
        (0.002, False, {"strong", "weak"}),
        (FAINT, True, {"strong", "weak"}),
    ],
)
def test_a_weak_effect_beside_a_strong_one(faint: float, sure: bool, named: set[str]) -> None:
    """Effects at right angles: what is put down to a strong one's shape is a share of it."""
    inner = np.array([[1e5, STRONG, WEAK], [STRONG, 1.0, 0.0], [WEAK, 0.0, 1.0]])
    widths = {("strong", 0): 1, ("weak", 0): 1}
    products = Products(inner, own=0, widths=widths, rows=10_000, variance=1.0)
    both = [_candidate("strong", sure=sure), _candidate("weak")]
    assert set(CandidateSearch(products, both, faint=faint).best().keys) == named


def test_a_tone_that_wanders_stands_out_over_several_frequencies() -> None:
    """15 of 2000 powers three times the mean of the others, which are of three components each.

    Twice the logarithm of the likelihood is about 80 there; in 2000 places of four widths chance
    gives more than 40 in fewer than one of 10 000.
    """
    power = np.random.default_rng(7).gamma(3.0, 1.0, 2000)
    power[1000:1015] *= 3.0
    at, width, evidence = standing_out(power, 3, WIDE)
    assert abs(at - 1007) <= 10
    assert width >= 7
    assert evidence > 40.0


def test_a_steady_tone_stands_out_in_one_frequency() -> None:
    power = np.random.default_rng(8).gamma(3.0, 1.0, 2000)
    power[421], power[:5] = 60.0, 0.0
    at, width, evidence = standing_out(power, 3, LINE)
    assert (at, width) == (421, 1)
    m = 60.0 / np.mean(power[5:])
    assert evidence == pytest.approx(6.0 * (m - 1.0 - np.log(m)), rel=1e-9)


def test_components_share_the_course_of_one_vibration() -> None:
    """Of coefficients w_j e_k the course is e, but for a factor that each component has its own."""
    rng = np.random.default_rng(9)
    t, knots, count = np.linspace(0.0, 1.0, 400), 6, 3
    slow = np.column_stack([t**k for k in range(knots)])
    wave = np.exp(40j * t)
    base = np.concatenate([slow * wave.real[:, None], slow * wave.imag[:, None]], axis=1)
    columns = np.zeros((count, len(t), count, 2 * knots))
    for j in range(count):
        columns[j, :, j] = base
    stacked = columns.reshape(count, len(t), -1)
    ways, e = (rng.normal(size=n) + 1j * rng.normal(size=n) for n in (count, knots))
    each = ways[:, None] * e
    coefficients = np.stack([each.real, -each.imag], axis=1).ravel()
    found = shared_course(stacked, coefficients, np.array([1.0, 2.0, 5.0]))
    for j in range(count):
        part = stacked[j] @ coefficients
        np.testing.assert_allclose(found @ np.linalg.lstsq(found, part)[0], part, atol=1e-9)
