"""A sinusoid fitted to less than a period of phase currents."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb import signals
from tests.helpers.campaigns import first

Array = NDArray[np.float64]

RATE = 1000.0


def _clock(phases: list[Array]) -> Array:
    return np.arange(phases[0].size) / RATE


AIR_A, CUT_A, NOISE_A = 2.0, 5.0, 0.02
RUNS = 60


def _phases(
    rng: np.random.Generator, range_A: float, hertz: float, lasts_s: float, offsets_A: Array
) -> list[Array]:
    """Return as many phase currents as there are offsets."""
    angle = 2.0 * np.pi * hertz * np.arange(round(lasts_s * RATE)) / RATE + rng.uniform(0.0, 6.0)
    return [
        0.5 * range_A * np.sin(angle - 2.0 * np.pi / 3.0 * k)
        + offset
        + NOISE_A * rng.standard_normal(angle.size)
        for k, offset in enumerate(offsets_A)
    ]


@pytest.mark.parametrize("count", first(1, [3, 1]))
@pytest.mark.parametrize("hertz", first(1, [0.4, 1.2, 4.0]))
def test_a_fraction_of_a_period_is_read_beside_what_follows(hertz: float, count: int) -> None:
    """0.75 s of air at 0.4 Hz is 0.3 of a period: read within 5 %, and its standard error is true.

    60 runs: the root mean square of errors over standard errors is above 1.5 in less than one of
    1000, and offsets and slip are drawn well within what is held of them.
    """
    rng, off, z = np.random.default_rng(31), [], []
    for _ in range(RUNS):
        offsets_A = 0.03 * rng.standard_normal(count)
        turning = rng.choice([-1.0, 1.0]) * hertz if count == 3 else hertz
        made = _phases(rng, CUT_A, turning, 2.0 / hertz + 1.0, offsets_A)
        cut = signals.steady_sinusoid(made, t_s=_clock(made), frequency_hz=1.02 * turning)
        assert cut is not None
        assert_allclose(cut.range_A, CUT_A, rtol=0.002)
        assert_allclose(cut.frequency_hz, turning, rtol=0.002)
        made = _phases(rng, AIR_A, 0.99 * turning, 0.75, offsets_A)
        air = signals.steady_sinusoid(
            made, t_s=_clock(made), frequency_hz=cut.frequency_hz, beside=cut
        )
        assert air is not None
        off.append(air.range_A - AIR_A)
        z.append(off[-1] / air.sd_A)
    assert np.max(np.abs(off)) < 0.05 * AIR_A
    assert np.sqrt(np.mean(np.square(z))) < 1.5


def test_what_is_no_steady_sinusoid_is_refused() -> None:
    rng = np.random.default_rng(3)
    starts = _phases(rng, AIR_A, 2.0, 1.0, np.zeros(3))
    for phase in starts:
        phase[:700] = phase[700]
    for hertz in (2.0, 0.0):
        assert signals.steady_sinusoid(starts, t_s=_clock(starts), frequency_hz=hertz) is None
