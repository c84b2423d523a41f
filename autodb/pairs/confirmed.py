"""Effects beside the law that a person confirmed of a pair, learnt from its readings.

All forces of one lot of material are larger by one share, as the term `hard_spot` has them. Centre
and width of a band of speeds are searched for by the evidence of what cuts say, with the covariance
that its curvature leaves.
"""

from collections.abc import Callable, Iterable
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.elements import mean_speed_m_min
from autodb.errors import UnusableInput
from autodb.pairs.averaging import log_evidence
from autodb.pairs.observed import CHIP, Observed
from autodb.pairs.posterior import PairPosterior, PairTerms, SpeedBand, open_lot
from autodb.pairs.updating import log_evidence_near, posterior_of_readings
from autodb.pairs.worn import with_wear
from autodb.terms.chip import BUILT_UP_EDGE

Array = NDArray[np.float64]

CENTRES, WIDTHS = (
    next(one.starts for one in BUILT_UP_EDGE.shape if one.name == name)
    for name in ("centre", "width")
)
NEAR = (0.3, 0.2)
"""Step of ln centre, in widths, and of ln width, between shapes whose evidence is compared.
Chosen."""
MOST = 100
"""Steps in which a shape's numbers are learnt; one that takes more is no candidate. Chosen: 20 to
60 do where a band is near the right place."""
ROUNDS = 4
"""Rounds in which the middle of nine shapes moves to the best of them. Chosen."""
WIDEST = (0.5, 0.5)
"""Standard deviations of ln centre, in widths, and of ln width where evidence does not bend down.
Chosen: as good as not known."""

TOLD = 0.5
"""Share of WIDEST that standard deviations are less than where evidence bends. Chosen."""


def with_terms(observed: Observed, terms: PairTerms) -> Observed:
    """Return readings that also know what confirmed terms move."""
    return _with_lots(with_wear(observed, terms.wear), terms.lots)


def _with_lots(observed: Observed, lots: Iterable[str]) -> Observed:
    """Return readings that share what their lot's forces are larger by."""
    named = [lot for cuts in observed.cuts for lot in (cuts.lots or (None,) * cuts.elements.count)]
    of_reading = np.array([named[k] or "" for k in observed.cut])
    force = observed.quantity != CHIP
    for lot in lots:
        inside = ((of_reading == lot) & force).astype(np.float64)[:, None]
        shift = observed.shift
        observed = replace(
            observed,
            shared=(*observed.shared, open_lot(lot)),
            common=np.column_stack([observed.common, inside]),
            shift=None if shift is None else np.column_stack([shift, 0.0 * inside]),
        )
    return observed


def learn_banded(
    start: PairPosterior,
    observed: Observed,
    *,
    near: PairPosterior,
    hint: tuple[float, float] | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> PairPosterior:
    """Return the posterior after readings of a pair with a band of speeds, from one without it.

    Its law is as far off as ``start`` says; ``near``: a posterior without the band, where the
    search begins. Readings know what other terms move (``with_terms``). ``hint``: centre, m/min,
    and width in ln v that the band has about; None: not known. Raises UnusableInput where learning
    does not come to rest.
    """
    known: dict[tuple[float, float], float] = {}

    def after(ln_centre: float, ln_width: float) -> float:
        at = round(ln_centre, 6), round(ln_width, 6)
        if at not in known:
            band = SpeedBand(float(np.exp(at[0])), float(np.exp(at[1])))
            progress(f"a band around {band.centre_m_min:.3g} m/min")
            known[at] = _evidence(_banded(start, band), observed, near)
        return known[at]

    speeds = np.concatenate([mean_speed_m_min(cuts.elements) for cuts in observed.cuts])
    inside = [one for one in CENTRES if speeds.min() <= one <= speeds.max()]
    tried = product(np.log(inside or [np.median(speeds)]).tolist(), np.log(WIDTHS).tolist())
    some = list(tried) if hint is None else [(float(np.log(hint[0])), float(np.log(hint[1])))]
    middle = max(some, key=lambda at: after(*at))
    band = _climbed(middle, after)
    return posterior_of_readings(_banded(start, band), observed, near=near)


def band_after(
    start: PairPosterior, observed: Observed, *, near: PairPosterior, band: SpeedBand
) -> SpeedBand:
    """Return where a band lies by all readings, of a pair of which it was known before as ``band``.

    Cuts at speeds that none was made at before move its flanks. Shapes are weighed by evidence that
    is linearised at the posterior ``near``; ``start`` and the readings as in ``learn_banded``. It
    stays where it was if readings do not tell, or would have it beyond the speeds that were cut.
    """
    known: dict[tuple[float, float], float] = {}

    def after(ln_centre: float, ln_width: float) -> float:
        at = round(ln_centre, 6), round(ln_width, 6)
        if at not in known:
            shape = SpeedBand(float(np.exp(at[0])), float(np.exp(at[1])))
            known[at] = log_evidence_near(_banded(start, shape), observed, near)
        return known[at]

    found = _climbed((float(np.log(band.centre_m_min)), float(np.log(band.width))), after)
    speeds = np.concatenate([mean_speed_m_min(cuts.elements) for cuts in observed.cuts])
    cut = bool(speeds.min() <= found.centre_m_min <= speeds.max())
    return found if cut and _is_told(found) else band


def _is_told(band: SpeedBand) -> bool:
    """Say whether evidence bends about a band, so that where it lies is known at all."""
    sd = np.sqrt(np.diag(np.array(band.covariance))) / band.width
    return bool(np.all(sd < TOLD * np.array(WIDEST)))


def _climbed(middle: tuple[float, float], after: Callable[[float, float], float]) -> SpeedBand:
    """Return the likeliest band about a shape, ln centre and ln width, with its covariance.

    ``after``: the log evidence of such a shape.
    """
    for _ in range(ROUNDS):
        best = max(_around(middle), key=lambda at: after(*at))
        if best == middle:
            break
        middle = best
    found, covariance = _top(middle, [after(*at) for at in _around(middle)])
    width = float(np.exp(found[1]))
    to_width = np.diag([1.0, width])
    (one, two), (_, four) = (to_width @ covariance @ to_width).tolist()
    return SpeedBand(float(np.exp(found[0])), width, ((one, two), (two, four)))


def _banded(start: PairPosterior, band: SpeedBand) -> PairPosterior:
    return replace(start, terms=replace(start.terms, band=band))


def _evidence(before: PairPosterior, observed: Observed, near: PairPosterior) -> float:
    """Return the log evidence of readings; −∞ where they do not determine the pair."""
    try:
        learnt = posterior_of_readings(before, observed, near=near, most=MOST)
    except UnusableInput:
        return -np.inf
    return log_evidence(before, learnt, observed)


def _around(middle: tuple[float, float]) -> list[tuple[float, float]]:
    """Return nine shapes, ln centre and ln width, around one of them."""
    steps = NEAR[0] * np.exp(middle[1]), NEAR[1]
    return [
        (middle[0] + i * steps[0], middle[1] + k * steps[1])
        for i, k in product((0, -1, 1), (0, -1, 1))
    ]


def _top(middle: tuple[float, float], log: list[float]) -> tuple[Array, Array]:
    """Return the top of a parabola through the evidence of nine shapes, and its covariance.

    Within a step of the middle; a direction in which evidence does not bend is as good as not
    known.
    """
    steps = np.array([NEAR[0] * np.exp(middle[1]), NEAR[1]])
    x, y = np.array(list(product((0.0, -1.0, 1.0), (0.0, -1.0, 1.0)))).T
    columns = np.column_stack([np.ones(9), x, y, 0.5 * x * x, x * y, 0.5 * y * y])
    finite = np.isfinite(log)
    found = np.linalg.lstsq(columns[finite], np.array(log)[finite], rcond=None)[0]
    _, a, b, c, d, e = found.tolist()
    bends, ways = np.linalg.eigh(np.array([[-c, -d], [-d, -e]]))
    widest = np.array([WIDEST[0] * np.exp(middle[1]), WIDEST[1]]) / steps
    bends = np.maximum(bends, 1.0 / np.max(widest) ** 2)
    covariance = ways @ np.diag(1.0 / bends) @ ways.T
    off = np.clip(covariance @ np.array([a, b]), -1.0, 1.0)
    return np.array(middle) + steps * off, steps[:, None] * covariance * steps
