"""Which speeds of an axis stick and slip, by its signals: halts of the way, unevenness of effort.

An axis sticks while the drive winds it up, its effort rising, and slips when that breaks it loose,
the effort falling: within a pass effort swings far more than friction along the travel does, and
less the faster the axis runs. P2 (section III B) leaves such speeds out of the weight.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from autodb.fitting import linear
from autodb.sensing.drives.moves.passes import SpeedPass, both_ways

Array = NDArray[np.float64]
Squares = Callable[[SpeedPass], Array]

FALSE_ALARM = 1e-3
"""Of a level that does not stick, by both unevennesses and ways together."""
TESTS = 4
"""Ways times scales: each is tested at FALSE_ALARM / TESTS."""
WINDOW_MM = 10.0
"""Longest window of way in which effort is looked at: about a turn of a screw. Chosen."""
BINS, CHUNK_ROWS = 16, 32
"""Means in a window of way; rows in a window of time. Chosen."""
FIRST_LEVELS, NEIGHBOURS = 3, 6
"""Fastest levels, which are taken to run smoothly (P2: sticking is of low speeds); and how many of
the smooth levels that are next faster a level is compared with. Chosen."""
FAR = 1.5
"""Times as uneven as those that a level sticks from on. Chosen: smooth levels differ by a tenth or
two beyond what their repeats show."""
HALT, JUMP, HALTS = 0.2, 1.8, 3
"""Parts of a pass' speed that a halt stays below and a jump exceeds; both in turn, so often in one
pass, are stick-slip. Chosen."""
SURE_SDS = 5.0
"""Standard deviations of the noise by which a halt differs from the pass' speed."""


@dataclass(frozen=True)
class StickingVerdict:
    """Whether a level sticks, and by what: how many times as uneven as the faster ones (rms over a
    window of way, and of time; the worse way), and the most halts in a pass.

    ``tested``: False where rows are too far apart for windows, or nothing faster is at hand.
    """

    speed_mm_s: float
    sticks: bool
    tested: bool
    over_way: float
    over_time: float
    halts: int


@dataclass(frozen=True)
class _Unit:
    """Passes (k,) at one level in one direction: mean ln of the squares within windows, number of
    windows, and the sum of squares by which the windows' differ from their pass'.
    """

    means: Array
    windows: Array
    within: Array


def sticking(
    passes: Sequence[SpeedPass], inputs: Mapping[str, Array], effort: Array
) -> dict[int, StickingVerdict]:
    """Judge the levels that were passed both ways, fastest first; effort (n,) in any unit.

    A pass' mean ln of squares within windows is compared with those of the next faster levels that
    run smoothly. Without stick-slip it is no larger the slower an axis runs: noise in time is the
    same, and along the way there is less of it. A squared deviation is taken absolutely and over
    the level's friction squared; what is uneven by one of these only is not: friction that is
    larger at creep swings more, and noise is a larger part of friction that is small.
    """
    levels = both_ways(passes)
    size = {k: _friction(passes, k, effort) for k in levels}
    over_way = _over_way(inputs["position"], effort, _window_mm(passes, levels))
    scales = [_units(passes, levels, squares) for squares in (over_way, _over_time(effort))]
    found: dict[int, StickingVerdict] = {}
    for k in sorted(levels, reverse=True):
        smooth = [j for j, one in found.items() if not one.sticks]
        tests = [_uneven(units, size, k, smooth) for units in scales]
        halts = max(_halts(one, inputs) for one in passes if one.level == k)
        ratio = [1.0 if test is None else test[0] for test in tests]
        found[k] = StickingVerdict(
            speed_mm_s=levels[k],
            sticks=halts >= HALTS or any(test is not None and test[1] for test in tests),
            tested=any(test is not None for test in tests),
            over_way=ratio[0],
            over_time=ratio[1],
            halts=halts,
        )
    return dict(sorted(found.items()))


def _friction(passes: Sequence[SpeedPass], level: int, effort: Array) -> float:
    """Return the size of a level's friction: half of what effort differs by direction."""
    way = [
        np.mean([effort[one.rows].mean() for one in passes if (one.level, one.sense) == (level, s)])
        for s in (1, -1)
    ]
    return float(max(abs(way[0] - way[1]) / 2.0, 1e-300))


def _window_mm(passes: Sequence[SpeedPass], levels: Mapping[int, float]) -> float:
    ways = [one.high_mm - one.low_mm for one in passes if one.level in levels]
    return min([WINDOW_MM, *ways])


def _over_way(position: Array, effort: Array, window_mm: float) -> Squares:
    """Return the function that gives mean squares of a pass in windows of way about a line, (w,).

    Of BINS means each: what noise there is in time is averaged the more the slower a pass is.
    """

    def squares(one: SpeedPass) -> Array:
        gone = np.abs(position[one.rows] - position[one.begin])
        count = int(gone.max() / window_mm * (1.0 + 1e-3))
        at = np.floor(gone / window_mm * BINS).astype(np.intp)
        inside = at < count * BINS
        rows = np.bincount(at[inside], minlength=count * BINS)
        if count == 0 or not rows.all():
            return np.empty(0)
        means = np.bincount(at[inside], effort[one.rows][inside], count * BINS) / rows
        return _about_lines(means.reshape(count, BINS))

    return squares


def _over_time(effort: Array) -> Squares:
    """Return the function that gives mean squares of a pass in windows of time about a line."""

    def squares(one: SpeedPass) -> Array:
        values = effort[one.rows]
        count = len(values) // CHUNK_ROWS
        return _about_lines(values[: count * CHUNK_ROWS].reshape(count, CHUNK_ROWS))

    return squares


def _about_lines(windows: Array) -> Array:
    """Return the mean squares (w,) of windows (w, m) about their straight lines."""
    place = np.linspace(-1.0, 1.0, windows.shape[1])
    line = np.linalg.qr(np.column_stack([np.ones_like(place), place]))[0]
    left = windows - (windows @ line) @ line.T
    return np.asarray(np.mean(left**2, axis=1))


def _units(
    passes: Sequence[SpeedPass], levels: Mapping[int, float], squares: Squares
) -> dict[tuple[int, int], _Unit]:
    """Return each level's and direction's unit, of those whose passes all have windows."""
    made = {}
    for k in levels:
        for sense in (1, -1):
            own = [squares(one) for one in passes if (one.level, one.sense) == (k, sense)]
            if all(len(values) and values.all() for values in own):
                logs = [np.log(values) for values in own]
                made[k, sense] = _Unit(
                    np.array([one.mean() for one in logs]),
                    np.array([float(len(one)) for one in logs]),
                    np.array([np.sum((one - one.mean()) ** 2) for one in logs]),
                )
    return made


def _uneven(
    units: Mapping[tuple[int, int], _Unit],
    size: Mapping[int, float],
    level: int,
    smooth: Sequence[int],
) -> tuple[float, bool] | None:
    """Return how many times as uneven a level is, the worse way, and whether that is stick-slip.

    ``smooth``: faster levels, fastest first. None where the level, or FIRST_LEVELS smooth ones,
    have no windows, or where nothing was passed twice.
    """
    own = [units[level, s] for s in (1, -1) if (level, s) in units]
    known = [j for j in smooth if (j, 1) in units and (j, -1) in units][-NEIGHBOURS:]
    if not own or len(known) < FIRST_LEVELS:
        return None
    found = []
    for one in own:
        tests = []
        for power in (0.0, 2.0):
            shift = {j: power * np.log(size[level] / size[j]) for j in known}
            others = [
                replace(units[j, s], means=units[j, s].means + shift[j])
                for j in known
                for s in (1, -1)
            ]
            tests.append(_test(one, others))
        found.append((min(ratio for ratio, _ in tests), all(beyond for _, beyond in tests)))
    if any(np.isnan(ratio) for ratio, _ in found):
        return None
    return max(ratio for ratio, _ in found), any(beyond for _, beyond in found)


def _test(one: _Unit, others: Sequence[_Unit]) -> tuple[float, bool]:
    """Return the ratio of rms, and whether it is FAR and beyond chance by Student's t.

    The variance of a pass is what passes of one level and direction differ by, pooled, and what
    its windows differ by over their number: a short pass has few. NaN where nothing tells it.
    """
    both = (one, *others)
    freedom = sum(len(unit.means) - 1 for unit in both)
    spread = sum(float(np.sum(unit.windows - 1.0)) for unit in both)
    if freedom == 0 or spread == 0.0:
        return np.nan, False
    passes = sum(float(np.sum((unit.means - unit.means.mean()) ** 2)) for unit in both) / freedom
    window = sum(float(unit.within.sum()) for unit in both) / spread
    means = np.concatenate([unit.means for unit in others])
    own = (passes + window * float(np.mean(1.0 / one.windows))) / len(one.means)
    sd = float(np.sqrt(own + passes / len(means)))
    excess = float(one.means.mean() - means.mean())
    limit = float(stats.t.ppf(1.0 - FALSE_ALARM / TESTS, freedom))
    ratio = float(np.exp(0.5 * excess))
    return ratio, ratio > FAR and excess > limit * sd


def _halts(one: SpeedPass, inputs: Mapping[str, Array]) -> int:
    """Return how often a pass halts and then jumps on.

    Speed is the way gone in so many rows that noise of the position alone makes no halt.
    """
    t, x = inputs["t"][one.rows], one.sense * inputs["position"][one.rows]
    step_s = float(np.median(np.diff(t)))
    noise_mm = linear.spread(np.diff(x, 3)) / np.sqrt(20.0)
    needed_s = SURE_SDS * np.sqrt(2.0) * noise_mm / ((1.0 - HALT) * one.speed_mm_s)
    rows = max(1, int(np.ceil(needed_s / step_s)))
    if rows > len(x) // 4:
        return 0
    share = (x[rows:] - x[:-rows]) / (rows * step_s * one.speed_mm_s)
    state = np.where(share < HALT, -1, np.where(share > JUMP, 1, 0))
    said = state[state != 0]
    return int(np.sum((said[:-1] == -1) & (said[1:] == 1)))
