"""A simulation that was fitted to the recording has taken up what it could of what it lacks."""

from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

from autodb.explain import explain
from autodb.explain.engine.prior import OWN_SD, own_deviations
from autodb.records.tables import Recording

SPRING_A_MM, MASS_A_S2_MM, FRICTION_A = 0.05, 0.0018, 0.4
SWINGS_HZ, TWICE = 0.7, 0.25
"""Two frequencies: with one, a spring and a mass are one column."""


def _swinging(*, fitted: bool) -> tuple[Recording, Recording]:
    """Return an axis that swings on a spring, and its simulation without: of the machine's own mass
    and friction, or of those that a least-squares fit to this recording finds.
    """
    t, pulse = np.arange(4000) / 100.0, 2.0 * np.pi * SWINGS_HZ
    places = [(8.0, pulse, 0.0), (8.0 * TWICE, 2.0 * pulse, 0.4)]
    way = np.sum([size * np.sin(w * t + at) for size, w, at in places], axis=0)
    speed = np.sum([size * w * np.cos(w * t + at) for size, w, at in places], axis=0)
    slope = np.sum([-size * w**2 * np.sin(w * t + at) for size, w, at in places], axis=0)
    slow = lfilter([1.0], [1.0, -0.98], np.random.default_rng(3).normal(0.0, 1.0, len(t)))
    own = np.column_stack([np.sign(speed), slope])
    sizes = np.array([FRICTION_A, MASS_A_S2_MM])
    effort = own @ sizes + SPRING_A_MM * way + 0.08 * slow / slow.std()
    if fitted:
        sizes = np.linalg.lstsq(own, effort, rcond=None)[0]
    moved = {"x.position": way, "x.velocity": speed, "x.acceleration": slope}
    measured = Recording(Path("a.csv"), {"t": t, **moved, "x.current": effort})
    return measured, Recording(Path("b.csv"), {"t": t, "x.current": own @ sizes})


@pytest.mark.parametrize("fitted", [True, False])
def test_what_a_fit_has_taken_up_is_given_back(*, fitted: bool) -> None:
    """The fit's mass is less by a spring's share of it, more than a simulation's is off by: with
    the fit for true the spring had a fourth of its size, and uneven friction the rest."""
    measured, simulated = _swinging(fitted=fitted)
    answer = explain(measured, simulated, includes=["coulomb", "inertia"])
    (channel,) = answer.explanation.channels.values()
    (spring,) = (cause for cause in channel.missing if cause.kind == "missing")
    assert spring.term == "spring"
    most = SPRING_A_MM * float(np.abs(measured["x.position"]).max())
    assert spring.parameters["size"].value == pytest.approx(most, rel=0.1)
    own = np.column_stack([np.sign(measured["x.velocity"]), measured["x.acceleration"]])
    off_A = FRICTION_A - np.linalg.lstsq(own, simulated["x.current"], rcond=None)[0][0]
    for cause in channel.missing:
        if cause.kind == "mistuned":
            assert cause.term == "coulomb"
            assert cause.parameters["size"].value == pytest.approx(off_A, rel=0.2)


def test_a_simulation_says_nothing_of_terms_that_give_nothing_of_the_difference() -> None:
    sizes = np.array([2.0, -0.5])
    np.testing.assert_allclose(own_deviations(sizes, given=0.5, of=1.0), OWN_SD * np.abs(sizes))
    assert np.isinf(own_deviations(sizes, given=0.01, of=1.0)).all()
