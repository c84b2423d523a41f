"""What is learnt of a pair is one answer: whatever order, units or start it is reached in."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.cutting.elements import cut_forces, engaged_mm, force_parts
from autodb.pairs.averaging import learn_averaging
from autodb.pairs.observed import Observed
from autodb.pairs.posterior import OWN, PairPosterior, Shared
from autodb.pairs.updating import posterior_of_readings
from autodb.pairs.worn import learn_worn
from tests.helpers.law_off import PRIOR, cuts_of, sensed
from tests.helpers.turned_pairs import prior
from tests.helpers.worn_pairs import WEARS, week

Array = NDArray[np.float64]

SAME = 1e-6
"""Of an own standard deviation."""


def readings(turned: float) -> Observed:
    """Return 24 cuts of a thrust that turns with the depth, ``turned`` rad a factor e; seed 3."""
    theta = PRIOR.law.mean + 0.5 * np.sqrt(np.diag(PRIOR.law.covariance))
    cuts = cuts_of(24, 1)
    whole, parts = cut_forces(theta, cuts.elements).force_N, force_parts(theta, cuts.elements)
    whole = whole + turned * np.log(engaged_mm(cuts.elements))[:, None] * parts[:, :3, 2]
    rng = np.random.default_rng(3)
    observed = sensed(cuts, whole * (1.0 + 0.02 * rng.standard_normal(whole.shape)))
    gain = Shared("calibration 1", np.array([[0.04**2]]))
    return replace(observed, common=np.ones((len(observed.value), 1)), shared=(gain,))


def apart(one: PairPosterior, other: PairPosterior) -> float:
    """Return by how many own standard deviations two posteriors differ, in mean, sd or scatter."""
    sd = np.sqrt(np.diag(one.state.covariance))
    open_ = sd > 0
    mean = np.abs(one.state.mean - other.state.mean)[open_] / sd[open_]
    wide = np.abs(np.sqrt(np.diag(other.state.covariance))[open_] / sd[open_] - 1.0)
    own = np.abs(np.log(one.scatter.share / other.scatter.share)) * np.sqrt(
        2.0 * one.scatter.weight
    )
    return float(max(mean.max(), wide.max(), own.max()))


@pytest.mark.parametrize("turned", [0.0, 0.12, 0.5])
def test_order_of_rows_changes_nothing(turned: float) -> None:
    observed = readings(turned)
    order = np.random.default_rng(4).permutation(len(observed.value))
    shuffled = replace(
        observed,
        **{k: getattr(observed, k)[order] for k in ("cut", "quantity", "value", "sd", "common")},
    )
    found = learn_averaging(PRIOR, observed)
    assert apart(found, learn_averaging(PRIOR, shuffled)) < SAME


@pytest.mark.parametrize("turned", [0.0, 0.12])
def test_a_start_nearby_changes_nothing(turned: float) -> None:
    observed = readings(turned)
    some = observed.cut < 12
    half = replace(
        observed,
        **{k: getattr(observed, k)[some] for k in ("cut", "quantity", "value", "sd", "common")},
    )
    before, found = (posterior_of_readings(PRIOR, one) for one in (half, observed))
    assert apart(found, before) > 0.1
    assert apart(found, posterior_of_readings(PRIOR, observed, near=before)) < SAME


def test_more_rounds_move_nothing() -> None:
    """What was learnt once is where learning from there begins and ends."""
    observed = readings(0.0)
    found = posterior_of_readings(PRIOR, observed)
    assert apart(found, posterior_of_readings(PRIOR, observed, near=found)) < SAME


def test_no_law_is_taken_by_a_rounding() -> None:
    """Over thrusts from a law that holds to one far off: the law's share goes over, in steps.

    Switched at odds of 20, what its direction may be off by jumped from 0 to 0.15 rad between two.
    """
    steps = np.linspace(0.045, 0.065, 11)
    laws = [learn_averaging(PRIOR, readings(float(step))).off_law for step in steps]
    far = np.array([law.direction_rad for law in laws]) ** 2 / 0.15**2
    assert far[0] < 1e-4
    assert far[-1] > 0.99
    assert (np.diff(far) > 0.0).all()
    assert ((far > 0.05) & (far < 0.95)).any()


def test_wear_moves_with_its_readings() -> None:
    """A change of 1e-6 of their noise moves wear, its bend and edges' differences by as little."""
    _, observed = week(12, wear=WEARS)
    near = posterior_of_readings(prior(), week(11, wear=None)[1])
    moved = observed.value + 1e-6 * observed.sd * np.cos(np.arange(len(observed.value)))
    found, other = (
        learn_worn(prior(), one, near=near) for one in (observed, replace(observed, value=moved))
    )
    assert found.wear is not None
    assert other.wear is not None
    assert abs(found.wear.power - other.wear.power) < 1e-4
    assert abs(found.wear.between - other.wear.between) < 1e-4
    law = np.sqrt(np.diag(found.state.covariance))[:OWN]
    moved_by = np.abs(found.state.mean - other.state.mean)[:OWN][law > 0] / law[law > 0]
    assert moved_by.max() < 1e-3
