"""Candidates that change all that is recorded of an axis and leave a mark of their own: a limit at
which a recording ends flat, a sign that it never has.
"""

from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit, ndtr, ndtri

from autodb.explain.axis.signals import AxisSignals
from autodb.explain.engine.candidates import Candidate, CandidateForm, near_one

Array = NDArray[np.float64]

CLIPS = 28
SIDES = ((1.0, -1.0), (1.0,), (-1.0,))
"""Ways in which an effort is limited: a drive's limit acts both ways, a sensor's often one way."""
SOFTER = 2
"""Soft limits stand this many times as far apart as sharp ones."""
SOFT = 0.08
"""Width of a soft knee as a share of the limit."""
BELOW = 0.995
"""Share of the rows of a clipped effort that are below its limit, but for noise. Chosen."""
FLAT_SHARE, FLAT_ROWS, FLATTER, SAME = 0.005, 8, 4, 1e-6
"""A recording ends flat where at least this share of its rows, and so many, have one and the same
last value, and so many times more than have the next; the same within this share of its range.
Chosen."""
FLAT_SLOPE = 0.2
"""Share of what the effort rises beyond its limit that what was recorded follows, at most: a soft
limit lets some of it through. Chosen."""
ONE_SIGN, OTHER_SIGN, TURNING = 0.02, 0.1, 0.002
"""Where the sign is lost, rows but this share have one sign, but for noise of this share of their
size; of an effort with two signs twice the first share has the other where some rows recorded do,
and this last share of rows is as near to none as that of what was recorded, but for noise.
Chosen."""
ABOVE, ABOVE_SDS = 0.02, 3.0
"""Share of the rows beyond a limit of which as many may stand above it, by more than so many
deviations of a row's noise: a spike does. Chosen."""
NORMAL_MEDIAN = float(ndtri(0.75))
"""Median of the size of a standard normal."""
TERMS_WITH_SIGNS, FIT_ROUNDS = 2, 10
"""Terms that a simulation has at least for its signs to be looked for, and rounds of looking."""
SWITCHED, SWITCHED_END = 0.02, 0.01
"""A recording is switched where a smaller share of its rows is between its ends, these taken this
share of its range wide. Chosen."""
LOWEST_CLIP = 0.6
"""A limit is looked for from this quantile of the simulated effort on."""


def clipping(s: AxisSignals) -> Candidate:
    """The effort is clipped at a limit that the simulation exceeds, both ways or one way only, or
    that it would exceed had it not been fitted to what was clipped. An effort that is switched
    between two levels, as a drive is tried with a square wave, ends flat without a limit.
    """
    if _is_switched(s.recorded):
        return Candidate("saturation", "saturation", (), ())
    forms = [form for sides in SIDES for form in _limits(s, sides)]
    return Candidate("saturation", "saturation", (*forms, *_refitted(s)), (), first=True)


def _is_switched(recorded: Array | None) -> bool:
    """Whether hardly a row of a recording (n,) is between its two ends."""
    if recorded is None:
        return False
    low, high = float(recorded.min()), float(recorded.max())
    end = SWITCHED_END * (high - low)
    between = (recorded > low + end) & (recorded < high - end)
    return high > low and float(np.mean(between)) < SWITCHED


def _refitted(s: AxisSignals) -> list[CandidateForm]:
    """Return the limits at which the recording ends flat, of the simulation's terms fitted to the
    rows within them.
    """
    recorded, terms = s.recorded, _terms(s)
    if recorded is None or not terms.size:
        return []
    low, high = -_flat_end(-recorded), _flat_end(recorded)
    if not np.isfinite([low, high]).any():
        return []
    effort = _effort_within(terms, recorded, low, high)
    beyond = (effort < low) | (effort > high)
    return [
        CandidateForm(
            lambda **_: np.clip(effort, low, high) - s.simulation,
            shape={"limit": float(min(abs(low), abs(high)))},
            names=("share",),
            allowed=near_one,
            through=lambda columns, **_: columns * ~beyond[:, None],
            alone=lambda: np.clip(effort, low, high) - effort,
        )
    ]


def _flat_end(recorded: Array) -> float:
    """Return the highest value, less rounding, where a recording ends flat there, else infinity."""
    alike = SAME * float(np.ptp(recorded))
    end = float(recorded.max()) - alike
    below = recorded[recorded < end]
    there, next_to_it = len(recorded) - len(below), below > below.max(initial=-np.inf) - alike
    flat = there >= max(FLAT_SHARE * len(recorded), FLAT_ROWS, FLATTER * next_to_it.sum())
    return end if flat else float("inf")


def _effort_within(own: Array, recorded: Array, low: float, high: float) -> Array:
    """Return the effort of terms (n, p) fitted to what was recorded within two limits, (n,).

    A row at a limit says only that the effort was there or beyond it (Tobin 1958, Econometrica
    26:24, here by least squares).
    """
    free = (recorded > low) & (recorded < high)
    used = free
    effort = np.zeros(len(recorded))
    for _ in range(FIT_ROUNDS):
        effort = own @ np.linalg.lstsq(own[used], recorded[used], rcond=None)[0]
        short = np.where(recorded >= high, effort < high, effort > low)
        if np.array_equal(used, free | short):
            break
        used = free | short
    return np.asarray(effort)


def _limits(s: AxisSignals, sides: tuple[float, ...]) -> list[CandidateForm]:
    """Return sharp and soft limits on these sides."""
    size, sign = _beyond(s.effort, sides), np.sign(s.effort)
    like = _beyond(s.frame.effort, sides)
    highest = float(like.max())
    if highest <= 0:
        return []
    lowest = max(float(np.quantile(like, LOWEST_CLIP)), highest / CLIPS)
    step = (highest - lowest) / CLIPS
    lowest_seen = _recorded_end(s, sides) / (1.0 + 2.0 * SOFT)
    limits = [at for n in range(CLIPS) if (at := lowest + step * n) > lowest_seen]
    limits = [at for at in limits if _flat_beyond(s.frame, sides, at)]

    def ends(limit: float, knee: float) -> bool:
        there = _is_ceiling(s.frame, sides, limit, knee * limit)
        return there and _flat_beyond(s.frame, sides, limit)

    def sharp(limit: float) -> Array:
        return np.where(size > limit, sign * limit - s.simulation, 0.0)

    def clipped(columns: Array, limit: float) -> Array:
        return columns * (size <= limit)[:, None]

    def soft(limit: float) -> Array:
        width = SOFT * limit
        over = width * np.logaddexp(0.0, (size - limit) / width)
        added = s.effort - s.simulation
        return added - sign * over - softened(added[:, None], limit)[:, 0]

    def softened(columns: Array, limit: float) -> Array:
        return np.asarray(columns * expit((limit - size) / (SOFT * limit))[:, None])

    return [
        CandidateForm(
            law,
            shape={"limit": at},
            within={"limit": (at - step, at + step)},
            names=("share",),
            tries=len(SIDES) * len((*limits, *limits[::SOFTER])),
            allowed=near_one,
            through=through,
            shown=partial(ends, knee=knee),
        )
        for law, through, tried, knee in (
            (sharp, clipped, limits, 0.0),
            (soft, softened, limits[::SOFTER], SOFT * float(np.log(2.0))),
        )
        for at in tried
    ]


def _flat_beyond(s: AxisSignals, sides: tuple[float, ...], limit: float) -> bool:
    """Whether what was recorded stays where it is while the effort goes beyond a limit, but for
    what noise makes of it: a row that noise takes below the limit is recorded as it is.

    A wave that a simulation has too high turns back there, or goes on. Few rows beyond it are
    spikes: nothing shows that all of these would have ended at one height.
    """
    if s.recorded is None:
        return True
    noise = _row_noise(s.recorded - s.effort)
    along = across = free = 0.0
    rows = 0
    for side in sides:
        beyond = side * s.effort > limit
        if beyond.any():
            effort, recorded = s.effort[beyond], s.recorded[beyond]
            further = effort - effort.mean()
            along += float(further @ recorded)
            across += float(further @ further)
            free += float(further**2 @ ndtr((limit - side * effort) / noise))
            rows += len(effort)
    by_noise = free + noise * np.sqrt(across)
    return rows >= FLAT_ROWS and abs(along) <= FLAT_SLOPE * across + by_noise


def _is_ceiling(s: AxisSignals, sides: tuple[float, ...], limit: float, knee: float) -> bool:
    """Whether rows were recorded at a limit, or no further below it than its knee, and none above
    it but what noise of single rows takes there, and ABOVE of the rows beyond it.
    """
    if s.recorded is None:
        return True
    size, recorded = _beyond(s.effort, sides), _beyond(s.recorded, sides)
    by_noise = ABOVE_SDS * _row_noise(s.recorded - s.effort)
    there = np.count_nonzero(recorded > limit - max(knee, by_noise))
    above = np.count_nonzero(recorded > limit + by_noise)
    return bool(there >= FLAT_ROWS and above <= ABOVE * np.count_nonzero(size > limit))


def _row_noise(left: Array) -> float:
    """Return the noise of a row by itself, from the steps between rows of a residual (n,)."""
    step = float(np.median(np.abs(np.diff(left))) / np.sqrt(2.0))
    return max(step / NORMAL_MEDIAN, SAME * float(np.ptp(left)), 1e-300)


def _recorded_end(s: AxisSignals, sides: tuple[float, ...]) -> float:
    """Return where what was recorded ends on these sides, near its limit where it is clipped."""
    recorded = s.frame.recorded
    return 0.0 if recorded is None else float(np.quantile(_beyond(recorded, sides), BELOW))


def _beyond(effort: Array, sides: tuple[float, ...]) -> Array:
    """Return how far an effort is out on these sides, 0 on the other."""
    return np.asarray(np.max([side * effort for side in (*sides, 0.0)], axis=0))


def _has_one_sign(s: AxisSignals) -> bool:
    """Whether what was recorded has hardly another sign."""
    recorded = s.frame.recorded
    if recorded is None:
        return True
    low, high = np.quantile(recorded, (ONE_SIGN, 1.0 - ONE_SIGN))
    return bool(min(-low, high) < OTHER_SIGN * max(-low, high))


def _may_lose_its_sign(effort: Array, s: AxisSignals) -> bool:
    """Whether an effort has both signs, and what was recorded comes as near to none as it does.

    A load that never turns has its sign; dry friction jumps from one sign to the other. What was
    recorded without a single value of the other sign may have lost any that the effort has.
    """
    recorded = s.frame.recorded
    strictly = recorded is not None and recorded.min() * recorded.max() >= 0.0
    share = 0.0 if strictly else 2.0 * ONE_SIGN
    low, high = np.quantile(effort, (share, 1.0 - share))
    if recorded is None:
        return bool(low < 0.0 < high)
    little = OTHER_SIGN * float(np.quantile(np.abs(recorded), 1.0 - ONE_SIGN))
    least, its = (float(np.quantile(np.abs(one), TURNING)) for one in (recorded, effort))
    return bool(low < 0.0 < high and least < its + little)


def lost_sign_candidate(s: AxisSignals) -> Candidate:
    """A magnitude was recorded: of the simulation, or of its terms fitted to the magnitude."""
    one_sign = _has_one_sign(s)
    efforts = [s.effort, *_signed_efforts(s)] if one_sign else [s.effort]
    signed = [_may_lose_its_sign(effort, s) for effort in efforts]

    def law(number: int) -> Array:
        return np.asarray(np.abs(efforts[number]) - s.simulation)

    def alone(number: int) -> Array:
        return np.asarray(np.abs(efforts[number]) - efforts[number])

    def through(columns: Array, number: int) -> Array:
        return columns * np.where(efforts[number] < 0, -1.0, 1.0)[:, None]

    forms = tuple(
        CandidateForm(
            partial(law, number),
            names=("share",),
            tries=len(efforts),
            allowed=near_one if one_sign and signed[number] else _never,
            through=partial(through, number=number),
            alone=partial(alone, number) if number else None,
        )
        for number in range(len(efforts))
    )
    return Candidate("lost_sign", "lost_sign", forms, (), first=True)


def _terms(s: AxisSignals) -> Array:
    """Return the columns (n, p) of the terms that the simulation has, or is said to have."""
    empty = np.empty((len(s.simulation), 0))
    return np.column_stack([empty, *{**s.stated, **s.own}.values()])


def _never(_share: Array) -> bool:
    return False


def _signed_efforts(s: AxisSignals) -> list[Array]:
    """Return efforts of the simulation's terms whose magnitudes fit what was recorded.

    A simulation that was refitted to magnitudes has lost its signs with them. Fit and signs are
    found in turn, from the sign of each term on; the best stays.
    """
    terms = _terms(s)
    if s.recorded is None or terms.shape[1] < TERMS_WITH_SIGNS:
        return []
    found = []
    for column in terms.T:
        sign = np.sign(column)
        for _ in range(FIT_ROUNDS):
            effort = terms @ np.linalg.lstsq(terms, sign * s.recorded, rcond=None)[0]
            sign = np.sign(effort)
        found.append(effort)
    left = [float(np.sum((np.abs(effort) - s.recorded) ** 2)) for effort in found]
    return [found[int(np.argmin(left))]]
