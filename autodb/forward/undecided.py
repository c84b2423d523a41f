"""Intervals that hold what cuts showed whose cause nobody has decided on, beside what was learnt.

Of a pair with an open mismatch some cuts are excluded: they were not as learnt. Until a person says
what they were, the next cut may be of either kind, and its force F has a mixture of both,

    F ~ (1 - p) N(m (1 + b), s²) + p sum_j v_j N(m (1 + r_j), (m s_j)²),    sum v_j = 1

with m and s as learnt, and of each excluded cut j the share r_j by which its force was off what is
learnt, which s_j of sensing and scatter blurs. What nobody has decided on also bent what was learnt
from the others: b is what they are off by here. All is local: with weights of all cuts of the pair
to the one asked for,

    w_j = 2^(-a_j / A) exp(-½ sum_d (x_d - x_dj)² / h_d²)

a_j cuts ago, at x the logarithms of cutting speed, time on the edge and flank wear, as far as both
state them, p = (sum of excluded w_j + p_0) / (sum of w_j + 1), p_0 the excluded share of all cuts
by age alone, which also shares its one cut's weight among them, and b = sum of w_j r_j / (sum of
w_j + 1) over cuts that are not excluded. A band of speed widens where it is,
wear where edges are as old, what nobody can place everywhere; the newest cuts tell most. The
interval runs between the mixture's 2.5 and 97.5 %, and never inside of what was learnt.

Sources: mixture of predictive distributions, Gneiting and Ranjan 2013 (Electron. J. Statist. 7);
local weights, Nadaraya 1964.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import erfc, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.gaussian import NORMAL_95
from autodb.forward.prediction import Interval, PredictedCut
from autodb.forward.stretching import Reach, stretched
from autodb.pairs.engaged import BANDS, CUTTING_TIME, FLANK_WEAR, SPEED
from autodb.wording import phrase_many

Array = NDArray[np.float64]

FORCES = ("force_x_N", "force_y_N", "force_z_N")
TANGENTIAL = 1
HALF_LIFE = 30.0
"""A, cuts of the pair after which a cut tells half as much. Chosen: a shop's day or two."""
PLACED = {SPEED: (0.0, 0.12), CUTTING_TIME: (60.0, 0.35), FLANK_WEAR: (0.05, 0.35)}
"""What cuts are alike in: what is added before the logarithm is taken (m/min, s, mm), and h.
Chosen: 12 % of speed, a third of an edge's age."""
TAIL = 0.025
STEPS = 50
"""Halvings of the range in which an end is sought."""


@dataclass(frozen=True)
class UndecidedCuts:
    """The newest cuts of a pair, oldest first, and how they were off.

    ``placed`` (n, 3): logarithms as in PLACED, NaN: not stated; ``excluded`` (n,); ``off`` and
    ``sd`` (n, 3): of x, y, z by what share of what is learnt, NaN: not sensed. ``waiting``:
    the mismatches that are open, by number, channel and term.
    """

    placed: Array
    excluded: NDArray[np.bool_]
    off: Array
    sd: Array
    waiting: tuple[tuple[int, str, str], ...]

    @property
    def words(self) -> str:
        """Why intervals are wider, and what decides."""
        named = (f"{number} ({channel}: {term})" for number, channel, term in self.waiting)
        count = int(self.excluded.sum())
        return phrase_many(
            "intervals hold what {excluded} showed beside what was learnt, until mismatch "
            "{numbers} is decided: 'autodb mismatch confirm {first}' or 'autodb mismatch reject "
            "{first}'",
            "intervals hold what {excluded} showed beside what was learnt, until mismatches "
            "{numbers} are decided: 'autodb mismatch confirm {first}' or 'autodb mismatch reject "
            "{first}'",
            len(self.waiting),
            excluded=phrase_many("{count} excluded cut", "{count} excluded cuts", count),
            numbers=", ".join(named),
            first=self.waiting[0][0],
        )

    def widened(
        self, cuts: Sequence[PredictedCut], stated: Sequence[Mapping[str, float]]
    ) -> tuple[PredictedCut, ...]:
        """Return cuts that are predicted in the usual state with intervals that hold either kind.

        ``stated``: the conditions of each by channel, as far as they are known.
        """
        places = np.array(
            [placed({SPEED: c.speed_m_min, **s}) for c, s in zip(cuts, stated, strict=True)]
        )
        return tuple(
            cut if cut.state is not None else self._widened(cut, place)
            for cut, place in zip(cuts, places, strict=True)
        )

    def _widened(self, cut: PredictedCut, place: Array) -> PredictedCut:
        near, age = self._near(place)
        reach: dict[str, Reach] = {}
        for k, name in enumerate(FORCES):
            known = np.isfinite(self.off[:, k])
            there, others = known & self.excluded, known & ~self.excluded
            if not there.any():
                continue
            off = self.off[:, k]
            chance = (near + age / np.sum(age[known]))[there] / (np.sum(near[known]) + 1.0)
            bent = float(near[others] @ off[others] / (np.sum(near[others]) + 1.0))
            seen = _Seen(off[there], self.sd[there, k], chance, bent)
            reach[name] = seen.reach(getattr(cut, name))
        if not reach:
            return cut
        turned = cut.operation not in BANDS and FORCES[TANGENTIAL] in reach
        low, high = (max(ends) for ends in zip(*reach.values(), strict=True))
        both = reach[FORCES[TANGENTIAL]] if turned else (low, high)
        return stretched(cut, reach | dict.fromkeys(("torque_N_m", "power_W"), both))

    def _near(self, place: Array) -> tuple[Array, Array]:
        """Return the weights of all cuts (n,) for one asked for, and those by age alone."""
        age = np.exp2(-np.arange(len(self.excluded))[::-1] / HALF_LIFE)
        width = np.array([h for _, h in PLACED.values()])
        apart = np.nan_to_num((place - self.placed) / width)
        return age * np.exp(-0.5 * np.sum(apart**2, axis=1)), age


@dataclass(frozen=True)
class _Seen:
    """How excluded cuts (j,) were off, with which sd, how probable each is, and b of the others."""

    off: Array
    sd: Array
    chance: Array
    bent: float

    def reach(self, own: Interval) -> Reach:
        """Return by what the distances of an interval's ends are larger, 1 at least."""
        size = abs(own.value)
        if size == 0.0 or not own.low < own.value < own.high:
            return 1.0, 1.0
        learnt = own.value * (1.0 + self.bent)
        middle = np.concatenate([[learnt], own.value * (1.0 + self.off)])
        spread = np.concatenate([[(own.high - own.low) / (2.0 * NORMAL_95)], size * self.sd])
        share = np.concatenate([[1.0 - float(np.sum(self.chance))], self.chance])
        low, high = (_quantile(middle, spread, share, at) for at in (TAIL, 1.0 - TAIL))
        return (
            max((own.value - low) / (own.value - own.low), 1.0),
            max((high - own.value) / (own.high - own.value), 1.0),
        )


def placed(stated: Mapping[str, Any]) -> list[float]:
    """Return where a cut is among others: logarithms as in PLACED, NaN where it does not say."""
    return [
        float(np.log(stated[name] + more)) if stated.get(name) is not None else np.nan
        for name, (more, _) in PLACED.items()
    ]


def _quantile(middle: Array, spread: Array, share: Array, at: float) -> float:
    """Return where a mixture of normals has a share ``at`` below."""
    low, high = float(np.min(middle - 6.0 * spread)), float(np.max(middle + 6.0 * spread))
    for _ in range(STEPS):
        half = 0.5 * (low + high)
        below = [0.5 * erfc(score) for score in (middle - half) / (sqrt(2.0) * spread)]
        if share @ np.array(below) < at:
            low = half
        else:
            high = half
    return 0.5 * (low + high)
