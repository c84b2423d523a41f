"""The range of phase currents over a part too short to be averaged: a sinusoid fitted to it.

A drive that feeds at the speed of the cut turns at its frequency in air too. With that, and with
the sensors' offsets as the cut shows them, a part of a period is enough:

    i(t) = c e^{iωt} + o,  least squares on c and o, ω and o held near what the cut has.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.signals.phases import space_vector

Array = NDArray[np.float64]

BESIDE = 0.08
"""Share of the frequency within which it is looked for."""
SLIPS = 0.02
"""Share by which a drive's frequency differs between air and cut, standard deviation: an induction
motor's slip at its rated load. Chosen."""
DRIFTS = 0.02
"""Share of the amplitude by which an offset does, standard deviation. Chosen."""
FINER, LEAST_PERIODS, STRONG = 8, 1.5, 0.8
"""Of the strongest swing: how much finer than 1/T it is looked for, its periods at least, and its
share of all power. Chosen."""
FEWEST = 50
"""Samples of a part."""
TINY = 1e-12
NOISE = 1.5
"""What may be left of a part, of what is left beside it. Chosen."""
UNSTEADY = 0.25
"""Share of the amplitude that is left of a part, above which it is none of a steady sinusoid."""


@dataclass(frozen=True)
class SteadySinusoid:
    """A sinusoid: its range and standard error, A, frequency, Hz, the sensors' offset (1,) or (2,)
    and what is left, root mean square, A."""

    range_A: float
    sd_A: float
    frequency_hz: float
    offset_A: Array
    left_A: float


def steady_sinusoid(
    phases_A: Sequence[Array],
    *,
    t_s: Array,
    frequency_hz: float,
    beside: SteadySinusoid | None = None,
) -> SteadySinusoid | None:
    """Return the sinusoid of one phase current or three, each (n,), near a frequency.

    ``t_s`` (n,): a clock in which it is steady, that of the spindle's turns where the feed goes
    with them. ``beside``: that of the same drive in another part, whose offset it has. None where
    the part is no steady sinusoid. The frequency of three phases is signed as that of `PhaseRange`.
    """
    from scipy.optimize import minimize_scalar

    samples = _samples(phases_A)
    if samples.shape[1] < FEWEST or not frequency_hz or not np.isfinite(samples).all():
        return None
    t = t_s - t_s.mean()

    def cost(share: float) -> float:
        left = _fit(samples, t, frequency_hz * (1.0 + share), beside)[1]
        squares = float(left @ left)
        if beside is None:
            return squares
        return squares / max(beside.left_A, TINY) ** 2 + (share / SLIPS) ** 2

    grid = np.linspace(-BESIDE, BESIDE, 33)
    at = int(np.argmin([cost(share) for share in grid]))
    ends = grid[max(at - 1, 0)], grid[min(at + 1, len(grid) - 1)]
    share = float(minimize_scalar(cost, bounds=ends, method="bounded").x)
    return _sinusoid(samples, t, frequency_hz * (1.0 + share), beside)


def strongest_hz(current_A: Array, *, rate_hz: float) -> float:
    """Return the frequency of the largest swing of a current (n,), Hz; 0 where none stands out.

    Of what swings for a period and a half at least.
    """
    size = current_A.size
    if size < FEWEST or not np.isfinite(current_A).all():
        return 0.0
    weighed = (current_A - current_A.mean()) * np.hanning(size)
    power = np.abs(np.fft.rfft(weighed, n=FINER * size)) ** 2
    hertz = np.fft.rfftfreq(FINER * size, 1.0 / rate_hz)
    inside = hertz >= LEAST_PERIODS * rate_hz / size
    at = int(np.argmax(np.where(inside, power, 0.0)))
    around = np.abs(hertz - hertz[at]) <= 2.0 * rate_hz / size
    stands_out = power[around].sum() > STRONG * power[inside].sum()
    return float(hertz[at]) if stands_out else 0.0


def _samples(phases_A: Sequence[Array]) -> Array:
    """Return the space vector of three phases, (2, n), or the first of fewer, (1, n)."""
    if len(phases_A) < 3:
        return phases_A[0][None, :]
    vector = space_vector(*phases_A)
    return np.stack([vector.real, vector.imag])


def _design(
    t: Array, hertz: float, beside: SteadySinusoid | None, components: int
) -> tuple[Array, Array]:
    """Return the columns of both parts of the amplitude and of each offset, and what the rows of
    the offsets' prior, below them, are held to."""
    angle = 2.0 * np.pi * hertz * t
    cos, sin = np.cos(angle), np.sin(angle)
    columns = np.zeros((components, t.size, 2 + components))
    columns[0, :, :2] = np.column_stack([cos, -sin])
    if components == 2:
        columns[1, :, :2] = np.column_stack([sin, cos])
    for k in range(components):
        columns[k, :, 2 + k] = 1.0
    flat = columns.reshape(-1, 2 + components)
    if beside is None:
        return flat, np.zeros(0)
    weight = beside.left_A / (DRIFTS * 0.5 * beside.range_A)
    held = np.hstack([np.zeros((components, 2)), weight * np.eye(components)])
    return np.vstack([flat, held]), weight * beside.offset_A


def _fit(
    samples: Array, t: Array, hertz: float, beside: SteadySinusoid | None
) -> tuple[Array, Array, Array]:
    """Return the least-squares coefficients, what is left of rows and prior, and the columns."""
    columns, prior = _design(t, hertz, beside, len(samples))
    wanted = np.append(samples.ravel(), prior)
    found, *_ = np.linalg.lstsq(columns, wanted, rcond=None)
    return np.asarray(found), wanted - columns @ found, columns


def _sinusoid(
    samples: Array, t: Array, hertz: float, beside: SteadySinusoid | None
) -> SteadySinusoid | None:
    found, left, columns = _fit(samples, t, hertz, beside)
    size = float(np.hypot(*found[:2]))
    left_A = float(np.sqrt(np.mean(left[: samples.size] ** 2)))
    noise_A = 0.0 if beside is None else NOISE * beside.left_A
    if size == 0.0 or left_A > max(UNSTEADY * size, noise_A):
        return None
    turns = columns[:, 1] * found[0] - columns[:, 0] * found[1]  # by the angle
    turns[: samples.size] *= 2.0 * np.pi * np.tile(t, len(samples))
    wider = np.column_stack([columns, turns])
    if beside is not None:
        slips = np.zeros((1, wider.shape[1]))
        slips[0, -1] = max(beside.left_A, TINY) / (SLIPS * abs(hertz))
        wider = np.vstack([wider, slips])
    covariance = np.linalg.inv(wider.T @ wider)[:2, :2] * left_A**2
    along = found[:2] / size
    sd_A = 2.0 * float(np.sqrt(along @ covariance @ along))
    return SteadySinusoid(2.0 * size, sd_A, hertz, found[2:], left_A)
