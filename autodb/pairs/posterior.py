"""Posterior about one pair: the law's numbers, what its cuts scatter by, the errors they share.

A normal posterior about the coordinates of the thin-shear-zone law and, behind them, what many cuts
share: the errors of the calibrations that sensed them, and by what share the law is off in an
operation. These stay in the posterior, so that a later cut sensed by the same calibration finds
them as far known as they are: never taken for scatter, never averaged away. Its size
does not grow with the number of cuts.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.shear import NAMES
from autodb.fitting.gaussian import NORMAL_95, Gaussian, student_95
from autodb.terms.chip import BUILT_UP_EDGE, HARD_SPOT

Array = NDArray[np.float64]
Three = tuple[float, float, float]

OWN = len(NAMES)
"""Coordinates of the law, the first of a posterior's state."""
ALONG, ACROSS = range(2)
"""Parts of a force that scatter on their own: along the cutting speed, and across it."""


@dataclass(frozen=True)
class Scatter:
    """What forces of cuts scatter by around a law, a share of each of their parts (2,).

    ``weight``: number of cuts it counts as, those of the prior included.
    """

    share: Array
    weight: Array

    @property
    def of_next(self) -> "Scatter":
        """What the next cut scatters by: a normal as wide at 95 % as Student's t of ``weight``, but
        no wider than of FEWEST.
        """
        freedom = np.maximum(self.weight, FEWEST)
        return Scatter(self.share * student_95(freedom) / NORMAL_95, self.weight)

    def log_chance(self, other: "Scatter") -> float:
        """Return the logarithm of how probable another scatter is by this one, but for a constant.

        Variances are scaled inverse χ² with ``weight`` degrees of freedom, in their logarithm.
        """
        ratio = (other.share / self.share) ** 2
        return float(-0.5 * np.sum(self.weight * (np.log(ratio) + 1.0 / ratio)))


FEWEST = 4.0
"""Degrees of freedom below which a scatter is not taken to be less known. Chosen."""
USUAL_SCATTER = Scatter(share=np.array([0.04, 0.10]), weight=np.full(2, 2.0))
"""What cuts of a pair scatter by before any is known. One cut repeated within a day scatters by 1.9
and 5.5 % (P1 Table 2: 84 N² at 486 N, 320 N² at 326 N, 12 cuts); around a power law of feed, depth
and speed forces of six published tables by 4 to 27 and 4 to 24 % (median 7 and 17;
`published_tables` of the proofs). Share and weight: chosen between them."""
CUT_SHARE = 0.015
"""Share by which the law may be off from one chip to another within an operation. Chosen."""


@dataclass(frozen=True)
class Shared:
    """Errors that many readings share: ``key`` of what makes them, covariance (k, k)."""

    key: str
    covariance: Array


@dataclass(frozen=True)
class LawDiscrepancy:
    """How far a law may be off in each operation, standard deviations.

    ``along`` and ``across`` the cutting speed, shares; ``direction_rad`` of what is across; by how
    much these ``grow`` with a factor e of the engaged edge; ``cut_direction_rad``: the direction
    from one chip to another; ``grow_in_chip``: by how much the three grow with a factor e of the
    chip's thickness, and of the cutting speed. ``near``: the probability that the law is NEAR,
    where these are averages over laws.
    """

    along: float
    across: float
    direction_rad: float
    grow: Three
    cut_direction_rad: float
    grow_in_chip: Three
    near: float = 1.0


def averaged_law(laws: Sequence[LawDiscrepancy], shares: Sequence[float]) -> LawDiscrepancy:
    """Return how far off a law is that is each of some with a probability of ``shares``."""

    def sd(*of_laws: float) -> float:
        return float(np.sqrt(np.dot(shares, np.square(of_laws))))

    def sds(each: Sequence[Three]) -> Three:
        first, second, third = map(sd, *each)
        return first, second, third

    return LawDiscrepancy(
        sd(*(one.along for one in laws)),
        sd(*(one.across for one in laws)),
        sd(*(one.direction_rad for one in laws)),
        sds([one.grow for one in laws]),
        sd(*(one.cut_direction_rad for one in laws)),
        sds([one.grow_in_chip for one in laws]),
        float(np.dot(shares, [one.near for one in laws])),
    )


NEAR = LawDiscrepancy(0.025, 0.025, 0.0, (0.0, 0.0, 0.0), 0.0, (0.0, 0.0, 0.0))
"""A law that holds but for its size. Chosen, where Aksu, Celebi and Budak 2016 find orthogonal
tests transformed to oblique edges about 10 % off before anything was learnt of such an edge."""
FAR = LawDiscrepancy(0.05, 0.05, 0.15, (0.25, 0.25, 0.25), 0.05, (0.0, 0.0, 0.0), near=0.0)
"""One that leaves out what grooves, breakers and the nose do to a chip: laws of chip flow over a
nose are off by 5 to 10° where they were measured (Young, Mathew and Oxley 1987); forces of six
published tables grow with depth by exponents of 0.6 to 1.4 (standard deviation 0.23;
`published_tables` of the proofs). Else chosen."""
FARTHER = replace(FAR, grow_in_chip=(0.2, 0.2, 0.2))
"""One that is off in how its forces grow with the chip and the speed, too. Chosen."""
BENDS_MM = np.array([0.1, 0.05])
"""Chips below each of which the law's exponents in thickness may change. Chosen: halves of the
feeds of turning down to those of finishing and milling."""
BEND = 0.1
"""Standard deviation of such a change."""
OF_CARD = "orthogonal"
"""What the edge is called that a card's values are of: over its chips the card says its shape."""
OF_OPERATION, OF_GROWTH = slice(0, 6), slice(6, 12)
OF_BENDS = slice(12, 12 + 2 * len(BENDS_MM))
"""Columns, of what errors of the law change, of those in an operation, of how they grow there with
the chip's thickness and the speed, and of those of thin chips.
"""
LAW_BENDS = Shared("law, thin chips", BEND**2 * np.eye(2 * len(BENDS_MM)))
"""How far the law may be off under thin chips, along and then across the cutting speed, whatever
the operation: what its exponents in thickness change by below each of BENDS_MM. They add up: the
farther below the chips that were cut, the less is known."""
DRILL = (0.05, 0.2)
"""Shares that a drill's forces are off by at least: its chisel edge makes most of the thrust.
Chosen."""


def law_error(operation: str, off: LawDiscrepancy = NEAR) -> Shared:
    """Return how far the law may be off in an operation: along, across, in direction; then by how
    much each grows with the logarithm of the engaged edge.
    """
    least = DRILL if operation == "drill" else (0.0, 0.0)
    shares = max(least[0], off.along), max(least[1], off.across)
    sd = np.array([*shares, off.direction_rad, *off.grow])
    return Shared(f"law, {operation}", np.diag(sd**2))


def growth_error(operation: str, off: LawDiscrepancy = NEAR) -> Shared:
    """Return how far exponents of the law may be off in an operation, in the chip's thickness and
    then in the cutting speed: along, across, in direction. Over its own chips a card says that
    itself.
    """
    sd = np.zeros(6) if operation == OF_CARD else np.array(2 * off.grow_in_chip)
    return Shared(f"law in thickness and speed, {operation}", np.diag(sd**2))


CALIBRATION, REFERENCES, GAIN = "calibration", "references", "gain"
"""What keys of errors begin with that are of what senses a machine's forces, whatever the pair."""
DAY = "day"
"""What keys of errors begin with that only the cuts of one day share."""
WEAR, EDGE = "tool_wear", "wear of edge"
"""Key of what wear adds to an edge's force; what keys begin with of what one edge wears otherwise.
"""


@dataclass(frozen=True)
class Wear:
    """Each mm of a worn edge takes w (T/T_r)^``power`` N more, of both force along and across.

    T cutting time of the edge, T_r ``reference_s``. w, N/mm, stands in a posterior's state under
    WEAR, along the cutting speed and across the edge; edges differ by the share ``between`` of
    ``size``, which is w as it was when that share was estimated. ``power_sd``: how well the power
    is known, a standard deviation of its logarithm.
    """

    power: float
    reference_s: float
    between: float = 0.0
    size: tuple[float, float] = (0.0, 0.0)
    power_sd: float = 0.0

    def grown(self, worn_s: Array) -> Array:
        """Return what is reached of w after cutting times."""
        return np.asarray((worn_s / self.reference_s) ** self.power)

    def bends(self, worn_s: Array) -> Array:
        """Return by what share of itself wear differs after cutting times, for an sd of the power.

        d ln(T/T_r)^p / d ln p = p ln(T/T_r): none at T_r, where w is learnt.
        """
        used = np.maximum(worn_s, TINY_S) / self.reference_s
        return np.asarray(self.power * self.power_sd * np.log(used))


TINY_S = 1e-3
"""Time on an edge below which there is none, s."""
BAND, LOT = "built_up_edge", "lot"
"""Key of what a band of speeds changes; what keys begin with of what one lot's forces are more by.
"""


@dataclass(frozen=True)
class SpeedBand:
    """In a band of speeds forces along and across the cutting speed change by a share of each.

    The bell of the term `built_up_edge`, of ``centre_m_min`` and ``width`` in ln v; ``covariance``
    (2, 2) of ln centre and width. The two shares stand in a posterior's state under BAND.
    """

    centre_m_min: float
    width: float
    covariance: tuple[tuple[float, float], tuple[float, float]] = ((0.0, 0.0), (0.0, 0.0))


@dataclass(frozen=True)
class PairTerms:
    """Effects beside the law that a person confirmed: wear, a band of speeds, and hard lots.

    All forces of a lot are larger by one share, in a posterior's state under LOT and its name.
    """

    wear: Wear | None = None
    band: SpeedBand | None = None
    lots: tuple[str, ...] = ()


NO_TERMS = PairTerms()


def lot_key(lot: str) -> str:
    """Return the key of what a lot's forces are larger by."""
    return f"{LOT} {lot}"


WORN = Shared(WEAR, np.diag([300.0**2, 300.0**2]))
"""What wear may add, N/mm, before it is fitted. Chosen: several times the edge force of any fresh
edge."""
BANDED = Shared(BAND, BUILT_UP_EDGE.prior_sd("change") ** 2 * np.eye(2))
"""What a band may change before it is fitted."""


def open_lot(lot: str) -> Shared:
    """Return what a lot's forces may be larger by before that is fitted."""
    return Shared(lot_key(lot), HARD_SPOT.prior_sd("factor") ** 2 * np.eye(1))


@dataclass(frozen=True)
class PassiveKnown:
    """Passive forces that were learnt: how many, and the mean variance of their readings, N²."""

    count: int
    variance_N2: float

    def also(self, sd_N: Array) -> "PassiveKnown":
        """Return it with further readings (m,)."""
        count = self.count + len(sd_N)
        total = self.count * self.variance_N2 + float(np.sum(sd_N**2))
        return PassiveKnown(count, total / max(count, 1))


@dataclass(frozen=True)
class PairPosterior:
    """``state``: the law's coordinates, then the errors of each of ``shared`` in their order.

    ``terms``: what was confirmed beside the law. ``passive``: what was learnt of passive forces, by
    operation; none: their direction is the law's alone. ``lot``: the lot of material that forces
    are asked of; None: as of any that is not among the terms. ``worked_out``: what was worked out
    of it (``in_operation``): of a posterior that nobody changes it holds for good.
    """

    state: Gaussian
    shared: tuple[Shared, ...]
    scatter: Scatter
    cuts: int
    off_law: LawDiscrepancy = NEAR
    terms: PairTerms = NO_TERMS
    passive: Mapping[str, PassiveKnown] = field(default_factory=dict)
    lot: str | None = None
    worked_out: dict[tuple[str, ...], object] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    @property
    def wear(self) -> Wear | None:
        """How the edge's force grows with its cutting time; None: not fitted."""
        return self.terms.wear

    def law_error(self, operation: str) -> Shared:
        """Return how far the law may be off in an operation."""
        return law_error(operation, self.off_law)

    def errors_in(self, operation: str) -> tuple[Shared, ...]:
        """Return how far the law may be off in an operation, and in how it grows there."""
        return self.law_error(operation), growth_error(operation, self.off_law)

    def law_errors(self, *operations: str) -> tuple[Shared, ...]:
        """Return how far the law may be off in operations, and under thin chips in any."""
        return (*chain.from_iterable(map(self.errors_in, operations)), LAW_BENDS)

    @property
    def open_terms(self) -> tuple[Shared, ...]:
        """What the terms beside the law may be before they are fitted."""
        worn = () if self.wear is None else (WORN,)
        banded = () if self.terms.band is None else (BANDED,)
        return (*worn, *banded, *map(open_lot, self.terms.lots))

    @property
    def law(self) -> Gaussian:
        """Posterior about the law's coordinates alone."""
        return Gaussian(self.state.mean[:OWN], self.state.covariance[:OWN, :OWN])

    def given(self, beginnings: tuple[str, ...]) -> Gaussian:
        """Return the posterior about the law's coordinates were the errors of some keys none.

        ``beginnings``: what those keys begin with.
        """
        known = [self.columns(one.key) for one in self.shared if one.key.startswith(beginnings)]
        rows = np.concatenate([np.r_[one] for one in known]) if known else np.zeros(0, np.intp)
        mean, covariance = self.state.mean, self.state.covariance
        gain = covariance[:OWN, rows] @ np.linalg.pinv(covariance[np.ix_(rows, rows)])
        return Gaussian(
            mean[:OWN] - gain @ mean[rows],
            covariance[:OWN, :OWN] - gain @ covariance[rows, :OWN],
        )

    def columns(self, key: str) -> slice:
        """Return where in the state errors stand."""
        begin = OWN
        for one in self.shared:
            if one.key == key:
                return slice(begin, begin + len(one.covariance))
            begin += len(one.covariance)
        raise KeyError(key)

    def past(self) -> "PairPosterior":
        """Return the posterior without errors of days and edges: no later cut shares them."""
        kept = tuple(one for one in self.shared if not one.key.startswith((DAY, EDGE)))
        if len(kept) == len(self.shared):
            return self
        rows = np.concatenate([np.arange(OWN), *(np.r_[self.columns(one.key)] for one in kept)])
        state = Gaussian(self.state.mean[rows], self.state.covariance[np.ix_(rows, rows)])
        return replace(self, state=state, shared=kept)

    def also(self, others: tuple[Shared, ...]) -> "PairPosterior":
        """Return the posterior with errors that it has not met yet."""
        known = {one.key for one in self.shared}
        new = tuple({one.key: one for one in others if one.key not in known}.values())
        if not new:
            return self
        ends = np.cumsum([len(self.state.mean), *(len(one.covariance) for one in new)])
        covariance = np.zeros((ends[-1], ends[-1]))
        covariance[: ends[0], : ends[0]] = self.state.covariance
        for one, begin, end in zip(new, ends[:-1], ends[1:], strict=True):
            covariance[begin:end, begin:end] = one.covariance
        mean = np.concatenate([self.state.mean, np.zeros(ends[-1] - ends[0])])
        return replace(self, state=Gaussian(mean, covariance), shared=(*self.shared, *new))
