"""Forward: what a pair's posterior expects of cuts not yet made, and how sure it is of that.

The variance of the next cut's force holds what is open of the law's numbers (and with them of the
calibrations), the share by which the law may be off in the operation, and what cuts scatter by.
Errors of sensing are not in it: it is the force that is predicted, not its next reading.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.elements import (
    cut_forces,
    edge_parts,
    force_parts,
    forces_by_laws,
    joined_elements,
    linearised_forces,
)
from autodb.fitting.gaussian import root_of
from autodb.pairs.in_operation import TINY_N, in_operation
from autodb.pairs.modelled import inside_band, moved_band, own_variance
from autodb.pairs.observed import (
    PairCuts,
    growth_and_bends,
    off_surface,
    with_grown,
    with_growth,
)
from autodb.pairs.posterior import (
    BAND,
    OF_BENDS,
    OWN,
    WEAR,
    PairPosterior,
)

Array = NDArray[np.float64]


MOST = 1.0
"""The largest skew: that of a logarithm's standard deviation of 1, beyond which no second-order
expansion holds. Chosen."""
WIDE = 0.1
"""Standard deviation of what is open of the law, a share of the force, from which on it is looked
how the law bends. Chosen: below, chances beyond a limit move by less than a point."""
AT_ONCE = 64
"""Cuts whose forces by laws apart are worked out at once. Chosen: of a mill they take 20 MB."""
ALL = 0.999
"""Share of a force from which on it is taken to be all along the cutting speed."""


@dataclass(frozen=True)
class Forecast:
    """Of cuts (n,): force x, y, z [N], torque [N·m] and power [W], columns of mean and sd (n, 5).

    ``own`` (n, 5): what of the variance is one cut's own, never to be learnt; ``slopes`` (n, 5, p):
    derivatives of the means by the posterior's state and, behind it, the law's error in the
    operation and those of what is assumed of the cuts. ``along`` (n, 3): share of each force that
    is along the cutting speed; ``turned`` (n, 3): what a radian of the direction of the rest
    changes; ``normal`` (n, 3): off the surface that is turned, in machine axes. ``skew`` (n, 5):
    a third of each quantity's skewness, by which the law is not linear; 0 of torque and power.
    ``freedom`` (n, 5): degrees of freedom of Student's t that each is shaped as.
    """

    mean: Array
    sd: Array
    own: Array
    slopes: Array
    along: Array
    turned: Array
    normal: Array
    skew: Array
    freedom: Array


@dataclass(frozen=True)
class Shares:
    """Steps (m,) that follow each other in cuts (n,), the shares that they have in their cut.

    ``begins`` (n,): the first step of each cut, rising from 0; ``share`` (m,) sums to 1 in a cut.
    """

    begins: NDArray[np.intp]
    share: Array

    def means(self, values: Array) -> Array:
        """Return means (n, ...) over each cut of values (m, ...) of its steps."""
        weighted = np.moveaxis(np.moveaxis(values, 0, -1) * self.share, -1, 0)
        return np.asarray(np.add.reduceat(weighted, self.begins, axis=0))

    def of_steps(self, values: Array) -> Array:
        """Return values (n, ...) of cuts for each of their steps (m, ...)."""
        return np.repeat(values, np.diff([*self.begins, len(self.share)]), axis=0)


def expected_means(posterior: PairPosterior, cuts: PairCuts) -> Array:
    """Return the means alone of a forecast (n, 5), without its derivatives."""
    its = in_operation(posterior, cuts)
    known, theta = its.known, its.theta
    parts = force_parts(theta, cuts.elements)
    whole = parts[..., 0] + parts[..., 1]
    mean = whole.copy()
    assumed = known.state.mean[its.assumed].tolist()
    for one, off in zip(cuts.variants, assumed, strict=True):
        if off:
            mean += off * (cut_forces(theta, one.elements).all - whole)
    mean *= 1.0 + its.of_lot
    mean += with_growth(parts, cuts.elements) @ its.off_law
    mean += _banded(known, cuts, parts).mean
    return np.asarray(mean + worn(known, cuts).mean)


def means_of_lots(posterior: PairPosterior, cuts: PairCuts) -> Array:
    """Return the means of a forecast (n, 5), each cut as one of its own lot."""
    lots = np.array([lot or "" for lot in cuts.lots or ("",) * cuts.elements.count])
    means = expected_means(posterior, cuts)
    for lot in set(lots.tolist()) & set(posterior.terms.lots):
        means[lots == lot] = expected_means(replace(posterior, lot=lot), cuts)[lots == lot]
    return means


@dataclass(frozen=True)
class InBand:
    """What a band of speeds adds to cuts (n,): means (n, 5), ``slopes`` (n, 5, 2) by the shares
    along and across the cutting speed, and variance ``own`` (n, 5) of where the band lies.
    """

    mean: Array
    slopes: Array
    own: Array


def _banded(known: PairPosterior, cuts: PairCuts, parts: Array) -> InBand:
    """Return what a band adds to cuts of ``parts`` (n, 5, 3); nothing where there is none."""
    band = known.terms.band
    if band is None:
        none = np.zeros((cuts.elements.count, 5))
        return InBand(none, np.zeros((*none.shape, 2)), none)
    change = known.state.mean[known.columns(BAND)]
    slopes = parts[..., :2] * inside_band(cuts, band)[:, None, None]
    by_shape = (parts[..., :2] @ change)[..., None] * moved_band(cuts, band)[:, None, :]
    own = np.vecdot(by_shape @ np.array(band.covariance), by_shape)
    return InBand(slopes @ change, slopes, own)


@dataclass(frozen=True)
class Worn:
    """What wear adds to cuts (n,): means (n, 5), and what edges differ by (n, 5), a signed sd.

    ``bent`` (n, 5): what a standard deviation of the power's logarithm changes, signed; ``slopes``
    (n, 5, 2) by w along and across the edge; ``turned`` (n, 3): what a radian of the direction of
    the latter changes in forces.
    """

    mean: Array
    apart: Array
    bent: Array
    slopes: Array
    turned: Array

    @property
    def own(self) -> Array:
        """Variance (n, 5) of edges that differ, and of how wear bends."""
        return self.apart**2 + self.bent**2

    def over(self, steps: Shares) -> "Worn":
        """Return the means over steps that one edge makes."""
        each = self.mean, self.apart, self.bent, self.slopes, self.turned
        return Worn(*map(steps.means, each))


def worn(posterior: PairPosterior, cuts: PairCuts) -> Worn:
    """Return what wear adds to cuts; nothing to fresh edges, or where none was fitted."""
    count = cuts.elements.count
    if posterior.wear is None or cuts.worn_s is None:
        none = np.zeros((count, 5))
        return Worn(none, none, none, np.zeros((count, 5, 2)), none[:, :3])
    grown = edge_parts(cuts.elements) * posterior.wear.grown(cuts.worn_s)[:, None, None]
    size = posterior.state.mean[posterior.columns(WEAR)]
    mean = grown[..., :2] @ size
    apart = posterior.wear.between * (grown[..., :2] @ np.array(posterior.wear.size))
    bent = mean * posterior.wear.bends(cuts.worn_s)[:, None]
    return Worn(mean, apart, bent, grown[..., :2], grown[:, :3, 2] * size[1])


def _linear(theta: Array, cuts: PairCuts, off: Array, law: Array) -> tuple[Array, ...]:
    """Return forces (n, 5) of cuts whose assumed quantities are ``off`` (v,) by so many sds.

    ``law`` (12 + 2 k,): what the law is off by.

    With them their parts as if they were not, with what these grow with (``with_growth``), and as
    they are, the slopes by the law's coordinates (n, 5, p), and what one standard deviation of each
    quantity changes (n, 5, v).
    """
    several = [cuts.elements, *(one.elements for one in cuts.variants)]
    joined, (grown, bends) = joined_elements(several), growth_and_bends(cuts.elements)
    by_error = np.zeros((joined.count, 3))
    by_error[: cuts.elements.count] = law[:3] + grown @ law[3 : OF_BENDS.start].reshape(3, 3)
    bent = bends @ law[OF_BENDS].reshape(2, -1).T
    by_error[: cuts.elements.count, :2] += bent
    whole, parts, slopes_of_both = (
        one.reshape(len(several), -1, *one.shape[1:])
        for one in linearised_forces(theta, joined, by_error)
    )
    by_law, of_errors = slopes_of_both[..., :OWN], slopes_of_both[..., OWN:]
    mean, found, slopes = whole[0], parts[0], by_law[0] + of_errors[0]
    for k, share in enumerate(off.tolist(), start=1):
        mean = mean + share * (whole[k] - whole[0])
        found = found + share * (parts[k] - parts[0])
        slopes = slopes + share * (by_law[k] - by_law[0])
    assumed = with_grown(parts[0], grown, bends)
    return mean, assumed, found, slopes, np.moveaxis(whole[1:] - whole[0], 0, -1)


def forecast(posterior: PairPosterior, cuts: PairCuts, over: Shares | None = None) -> Forecast:
    """Return what is expected of cuts; with ``over`` of the means over steps, which ``cuts`` are.

    The steps of a cut share all errors, what is its own too.
    """
    its = in_operation(posterior, cuts)
    known, state = its.known, its.known.state
    mean, assumed, parts, by_law, by_assumed = _linear(
        its.theta, cuts, state.mean[its.assumed], its.off_law
    )
    slopes = np.zeros((cuts.elements.count, 5, len(state.mean)))
    more = 1.0 + its.of_lot
    slopes[:, :, :OWN] = more * by_law
    slopes[:, :, its.law] = assumed
    slopes[:, :, its.assumed] = more * by_assumed
    if its.lot is not None:
        slopes[:, :, its.lot] = mean
    band, wear = _banded(known, cuts, assumed), worn(known, cuts)
    mean = more * mean + assumed @ its.off_law + band.mean + wear.mean
    if posterior.terms.band is not None:
        slopes[:, :, known.columns(BAND)] = band.slopes
    if posterior.wear is not None:
        slopes[:, :, known.columns(WEAR)] = wear.slopes
    of_band, normal = band.own, off_surface(cuts.elements)
    if over is not None:
        each = mean, slopes, parts, of_band, normal
        mean, slopes, parts, of_band, normal = map(over.means, each)
        wear = wear.over(over)
    open_ = np.vecdot(slopes @ state.covariance, slopes)
    own = own_variance(its.next_cut, posterior.off_law, parts) + wear.own + of_band
    along, across = np.abs(parts[:, :3, 0]), np.abs(parts[:, :3, 1])
    along = along / np.maximum(along + across, TINY_N)
    turned = parts[:, :3, 2] + wear.turned
    sd = np.sqrt(open_ + own)
    wide = _wide(mean, open_)[:, None]
    skew = np.where(wide, _skew(known, cuts, slopes, sd, over), 0.0) if wide.any() else 0.0 * sd
    freedom = its.freedom(slopes, parts, sd)
    found = Forecast(mean, sd, own, slopes, along, turned, normal, skew, freedom)
    return _at_middle(known, cuts, found, over) if _is_of_any_metal(known) else found


def _is_of_any_metal(known: PairPosterior) -> bool:
    """Return whether no reading has changed what any metal may have."""
    if known.cuts:
        return False
    from autodb.pairs.prior import any_metal

    return np.array_equal(known.law.covariance, any_metal().law.covariance)


def _wide(mean: Array, variance: Array) -> NDArray[np.bool_]:
    """Return where forces (n, 3 first) are so little known that their law's bend counts (n,)."""
    forces = mean[:, :3]
    return np.asarray(np.max(variance[:, :3], axis=1) > WIDE**2 * np.vecdot(forces, forces))


def _skew(
    known: PairPosterior, cuts: PairCuts, slopes: Array, sd: Array, over: Shares | None
) -> Array:
    """Return a third of the skewness (n, 5) of forces x, y, z; torque and power have none.

    Of F = m + g·δ + ½ δᵀHδ with δ ~ N(0, V) the third cumulant is 3 gᵀV H V g to the first order in
    H: what counts is how the law bends along d = V g, where the force leads the posterior. Errors
    of the law and of what is assumed are linear, and bend nothing.
    """
    forces = np.moveaxis(slopes[:, :3], 1, 0)
    led = forces @ known.state.covariance
    size = np.sqrt(np.maximum(np.vecdot(led, forces), TINY_N**2))
    bent = _bends(known, cuts, led[..., :OWN] / size[..., None], over)[0]
    skew = np.zeros_like(sd)
    for k in range(3):
        third = size[k] ** 2 * bent[k, :, k] / np.maximum(sd[:, k], TINY_N) ** 3
        skew[:, k] = np.clip(third, -MOST, MOST)
    return skew


def one_sign(along: Array) -> NDArray[np.bool_]:
    """Return which quantities (n, 5) have one sign, by the shares (n, 3) along the cutting speed.

    Torque, power and a force that is all along it.
    """
    return np.column_stack([along >= ALL, np.ones((len(along), 2), dtype=np.bool_)])


def _at_middle(
    known: PairPosterior, cuts: PairCuts, found: Forecast, over: Shares | None
) -> Forecast:
    """Return a forecast of any metal's cuts at medians, in place of what the middle law takes.

    Numbers δ ~ N(0, V) that no reading has changed are spread as is said. Across the direction
    d = V g in which they lead a force F it bends, too: its median is F + ½ (tr HV − dᵀHd), of what
    has one sign in its logarithm. After readings V is that of a tangent, along which forces bend
    while the numbers that give the same readings do not: nothing is added then.
    """
    slopes = np.moveaxis(found.slopes[..., :OWN], 1, 0)
    spread = known.law.covariance
    led = slopes @ spread
    size = np.sqrt(np.maximum(np.vecdot(led, slopes), TINY_N**2))
    root = root_of(spread).T
    ways = np.broadcast_to(root[:, None], (len(root), *led.shape[1:]))
    each = _bends(known, cuts, np.concatenate([ways, led / size[..., None]]), over)
    bent, in_log = (
        one[: len(root)].sum(axis=0) - np.einsum("knk->nk", one[len(root) :]) for one in each
    )
    signed, more = one_sign(found.along), np.exp(0.5 * in_log)
    return replace(
        found,
        mean=np.where(signed, more * found.mean, found.mean + 0.5 * bent),
        sd=np.where(signed, more, 1.0) * found.sd,
    )


def _bends(
    known: PairPosterior, cuts: PairCuts, towards: Array, over: Shares | None
) -> tuple[Array, Array]:
    """Return how forces, torque and power (k, n, 5) bend between steps (k, n, OWN) to either side.

    With it the same of their logarithms; 0 of those that change their sign, or are none here.
    """
    each = towards if over is None else np.array([over.of_steps(one) for one in towards])
    moved = np.concatenate([-each, each, np.zeros_like(each[:1])])
    several = max(AT_ONCE // cuts.elements.count, 1)
    forces = []
    for begin in range(0, len(moved), several):
        some = moved[begin : begin + several]
        theta = known.state.mean[:OWN] + some.reshape(-1, OWN)
        joined = joined_elements([cuts.elements] * len(some))
        found = forces_by_laws(theta.T, joined).reshape(*some.shape[:2], -1)
        forces += [*found] if over is None else [over.means(one) for one in found]
    low, high, here = forces[: len(each)], forces[len(each) : -1], forces[-1]
    product = np.array(low) * np.array(high)
    signed = (product > 0.0) & (here != 0.0)
    ratio = np.divide(product, here**2, out=np.ones_like(product), where=signed)
    return np.array(low) + np.array(high) - 2.0 * here, np.log(ratio)
