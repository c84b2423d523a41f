"""How good past predictions were, and by what the next ones are wider for it.

    z(f) = (y - F) / sqrt(f² s_F² + s_y²)

F is the force that was predicted with the standard deviation s_F, y what was then measured or
sensed with s_y. Of predictions that say rightly how sure they are z(1) has a variance of 1. The
factor f on the next standard deviation is the scale of a scaled inverse chi-squared posterior,

    f² = (n_0 f_0² + sum_r n_r m_r f²) / (n_0 + sum_r n_r)

(Gelman et al., Bayesian Data Analysis, 3rd ed., 2.6), which begins with f_0 = 1 at the weight of
n_0 cuts; of many cuts all z(f) have a variance of 1. m_r is the mean of z(f)² over the cuts of a
recording r, limited at c² and made consistent for normal errors, so that one broken edge widens
little (Huber 1964, proposal 2). The cuts of a recording share an error of its day: k of them count
n_r = k / (1 + (k - 1) rho) (Kish 1965, 8.2).
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import erfc, exp, pi, sqrt

import numpy as np

from autodb.fitting.gaussian import NORMAL_95
from autodb.forward.prediction import Interval, wider_interval
from autodb.wording import listed, localized, phrase

PRIOR_CUTS = 10.0
"""n_0: a handful of cuts changes little. Chosen."""
TOGETHER = 0.25
"""rho of z² within a recording. Chosen: where half of an error's variance is its day's, errors
correlate by 1/2, and the squares of normal errors by its square."""
LIMIT = 2.5
"""c, in standard deviations. Chosen: 1.2 % of normal errors are beyond."""
CONSISTENT = (
    1.0 - LIMIT * sqrt(2.0 / pi) * exp(-0.5 * LIMIT**2) + (LIMIT**2 - 1.0) * erfc(LIMIT / sqrt(2.0))
)
"""Mean of z² limited at c² of a normal z."""
TINY = 1e-9
"""Share of a prediction, of one below 1 in its unit, that its standard deviation is at least."""
LEAST = 1.05
"""A smaller factor is none: nobody sees it. Chosen."""
ROUNDS, SETTLED = 200, 1e-6
"""Of a fixed point: rounds at the most, and the relative change that ends it."""


@dataclass(frozen=True)
class Scored:
    """One quantity of one cut that was predicted, by channel, and what it then was.

    ``cut`` and ``recording`` by id; ``widened``: the factor that its interval already has;
    ``sd``: of what was made; None: not known, and then it says nothing of the width.
    """

    quantity: str
    cut: int
    recording: int
    predicted: Interval
    made: float
    sd: float | None
    widened: float = 1.0

    @property
    def error(self) -> float:
        """By what share the prediction was off what was made."""
        return self.predicted.value / self.made - 1.0

    @property
    def off(self) -> float:
        """What was made, less what was predicted."""
        return self.made - self.predicted.value

    @property
    def z(self) -> float:
        """How many standard deviations what was made is off, of both as stated."""
        return self.off / float(np.hypot(_sd(self.predicted, self.off), self.sd or 0.0))

    @property
    def held(self) -> bool:
        """Whether its 95 % interval, and the uncertainty of what was made, hold the difference."""
        return abs(self.z) <= NORMAL_95

    @property
    def sd_of_posterior(self) -> float:
        """The prediction's standard deviation towards what was made, as no past had widened it."""
        return _sd(wider_interval(self.predicted, 1.0 / self.widened), self.off)


def _sd(predicted: Interval, off: float) -> float:
    """Return the standard deviation of a prediction on the side where what was made is."""
    high = predicted.high - predicted.value
    half = high if off > 0.0 else predicted.value - predicted.low
    return max(half / NORMAL_95, TINY * max(abs(predicted.value), 1.0))


@dataclass(frozen=True)
class Score:
    """Of one quantity: how many cuts of how many recordings, and how far off they were.

    ``error``: median share by which a prediction was off, by size; ``bias``: with its sign.
    ``inside``: share within the stated 95 % interval and the uncertainty of what was made, with the
    95 % ends of that share (Clopper and Pearson 1934, at what the cuts count). ``rms_z``: 1 where
    intervals are as wide as they should be.
    """

    quantity: str
    cuts: int
    recordings: int
    error: float
    bias: float
    inside: float
    inside_low: float
    inside_high: float
    rms_z: float


def score_of(quantity: str, some: Sequence[Scored]) -> Score:
    """Return the score of one quantity of cuts, one at least."""
    from scipy.special import betaincinv

    z, error = (np.array([getattr(one, of) for one in some]) for of in ("z", "error"))
    recordings = Counter(one.recording for one in some)
    inside = float(np.mean([one.held for one in some]))
    n = sum(map(counts_as, recordings.values()))
    held, missed = inside * n, (1.0 - inside) * n
    low = betaincinv(held, missed + 1.0, 0.025) if inside > 0.0 else 0.0
    high = betaincinv(held + 1.0, missed, 0.975) if inside < 1.0 else 1.0
    return Score(
        quantity=quantity,
        cuts=len(some),
        recordings=len(recordings),
        error=float(np.median(np.abs(error))),
        bias=float(np.median(error)),
        inside=inside,
        inside_low=float(low),
        inside_high=float(high),
        rms_z=float(np.sqrt(np.mean(z**2))),
    )


def counts_as(cuts: int) -> float:
    """Return how many independent cuts the cuts of one recording count as."""
    return cuts / (1.0 + (cuts - 1) * TOGETHER)


@dataclass(frozen=True)
class Width:
    """The factor on the intervals of the next predictions, and what it is from.

    ``cuts`` and ``recordings`` of the pair itself; ``others``: cuts of the machine's other pairs
    that it began with. ``upto``: the last link, by id, that it knew of.
    """

    factor: float = 1.0
    cuts: int = 0
    recordings: int = 0
    others: int = 0
    upto: int | None = None

    def words(self, machine: str) -> str:
        """Return what a planner has to know of it."""
        of_pair = phrase("{cuts} cuts of the pair", cuts=self.cuts) if self.cuts else ""
        of_others = phrase("{cuts} cuts of other pairs", cuts=self.others) if self.others else ""
        return phrase(
            "intervals × {factor}: past predictions of {cuts} were off by more than stated; "
            "'autodb predictions score --machine {machine}' tells by how much",
            factor=localized(f"{self.factor:.2f}"),
            cuts=listed(filter(None, (of_pair, of_others)), phrase(" and ")),
            machine=machine,
        )


AS_STATED = Width()
"""Nothing is known against the intervals of a posterior."""


def width_of(pair: Sequence[Scored], others: Sequence[Scored], *, upto: int | None) -> Width:
    """Return by what the next intervals of a pair are wider.

    What the machine's other pairs say is what the pair's own begin with. Never below 1: a
    calibration that is off moves predictions and what is sensed alike, and does not show.
    """
    begun, other_cuts, _ = _variance(others, 1.0)
    variance, cuts, recordings = _variance(pair, begun)
    factor = float(np.sqrt(variance))
    return Width(factor if factor >= LEAST else 1.0, cuts, recordings, other_cuts, upto)


def _variance(some: Iterable[Scored], begun: float) -> tuple[float, int, int]:
    """Return f² after some predictions, ``begun`` before; their cuts and recordings."""
    known = [one for one in some if one.sd is not None]
    quantities = Counter((one.recording, one.cut) for one in known)
    cuts = Counter(recording for recording, _ in quantities)
    weight = np.array(
        [
            counts_as(cuts[one.recording])
            / (cuts[one.recording] * quantities[one.recording, one.cut])
            for one in known
        ]
    )
    off, own, sensed = (
        np.array([getattr(one, of) for one in known]) ** 2
        for of in ("off", "sd_of_posterior", "sd")
    )
    variance = begun
    for _ in range(ROUNDS if known else 0):
        before = variance
        z2 = np.minimum(off / (variance * own + sensed), LIMIT**2) / CONSISTENT
        total = PRIOR_CUTS * begun + variance * float(weight @ z2)
        variance = total / (PRIOR_CUTS + float(weight.sum()))
        if abs(variance - before) < SETTLED * before:
            break
    return variance, len(quantities), len(cuts)
