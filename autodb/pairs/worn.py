"""Wear of a pair's edges: what it adds to their cuts' forces, and how it is fitted to readings.

A worn edge rubs more: each mm of it takes w (T/T_r)^p N more along the cutting speed and across the
edge, T its cutting time, which starts again at an edge change. Added as forces of the edge are, so
that turning, milling and drilling, torque and power have it alike. w is learnt with the law, in one
normal posterior: what is wear is not taken for the material's force, nor the reverse. Edges wear
differently: what one differs by is shared by its cuts and forgotten after them; of the next edge it
is part of the interval.

How it bends (p) and how much edges differ are the means of a few tried by their evidence. The
edge's force is as Armarego has it, and grows with cutting time.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.elements import edge_parts
from autodb.pairs.averaging import log_evidence
from autodb.pairs.observed import CHIP, Observed, PairCuts
from autodb.pairs.posterior import EDGE, WEAR, WORN, PairPosterior, Shared, Wear
from autodb.pairs.updating import log_evidence_near, posterior_of_readings

Array = NDArray[np.float64]

POWERS = (0.5, 0.75, 1.0, 1.5, 2.0, 3.0)
"""Bends that are tried: from an edge that is soon blunt to one that breaks down late. Chosen."""
HALF_A_STEP = 0.1
"""The least standard deviation of a power's logarithm: that within a step of those tried, of some
0.35 (an even spread over a step has 0.35/√12)."""
BETWEEN = (0.1, 0.2, 0.4)
"""Shares by which edges may differ that are tried, beside none. Chosen."""


def with_wear(observed: Observed, wear: Wear | None) -> Observed:
    """Return readings that also know what wear moves, of the pair and of each edge alone."""
    if wear is None:
        return observed
    force = observed.quantity != CHIP
    by_cut = np.concatenate([added_by(cuts, wear) for cuts in observed.cuts])
    moved = by_cut[observed.cut, observed.quantity % CHIP] * force[:, None]
    errors, columns = [WORN], [moved]
    if wear.between > 0.0:
        labels = [label for cuts in observed.cuts for label in _labels(cuts)]
        of_reading = np.array([labels[k] or "" for k in observed.cut])
        for label in dict.fromkeys(filter(None, labels)):
            errors.append(Shared(f"{EDGE} {label}", np.array([[wear.between**2]])))
            own = (of_reading == label) * (moved @ np.array(wear.size))
            columns.append(own[:, None])
    added = np.column_stack(columns)
    shift = np.zeros_like(observed.common) if observed.shift is None else observed.shift
    return replace(
        observed,
        shared=(*observed.shared, *errors),
        common=np.column_stack([observed.common, np.zeros_like(added)]),
        shift=np.column_stack([shift, added]),
    )


def _labels(cuts: PairCuts) -> tuple[str | None, ...]:
    return cuts.edges or (None,) * cuts.elements.count


def added_by(cuts: PairCuts, wear: Wear) -> Array:
    """Return what 1 N/mm of wear, along and across, adds to the cuts' forces (n, 5, 2)."""
    if cuts.worn_s is None:
        return np.zeros((cuts.elements.count, 5, 2))
    return edge_parts(cuts.elements)[..., :2] * wear.grown(cuts.worn_s)[:, None, None]


def learn_worn(
    start: PairPosterior,
    observed: Observed,
    *,
    near: PairPosterior,
    progress: Callable[[str], None] = lambda _: None,
) -> PairPosterior:
    """Return the posterior after readings of edges that wear, from one that has no wear in it yet.

    Its law is as far off as ``start`` says; ``near``: the posterior without wear, where the
    search begins.
    """
    longest_s = max(float(c.worn_s.max()) for c in observed.cuts if c.worn_s is not None)

    def after(wear: Wear) -> tuple[float, PairPosterior]:
        progress(f"wear as T^{wear.power:.2g}, edges differ by {100.0 * wear.between:.0f} %")
        before = replace(start, terms=replace(start.terms, wear=wear))
        readings = with_wear(observed, wear)
        learnt = posterior_of_readings(before, readings, near=near)
        return log_evidence(before, learnt, readings), learnt

    bends = {power: after(Wear(power, longest_s)) for power in POWERS}
    logs = [log for log, _ in bends.values()]
    ln_power, spread = _moments(np.log(POWERS), logs)
    power = float(np.exp(ln_power))
    log, bent = after(Wear(power, longest_s))
    along, across = bent.state.mean[bent.columns(WEAR)]
    power_sd = float(np.hypot(spread, HALF_A_STEP))
    wear = Wear(power, longest_s, size=(float(along), float(across)), power_sd=power_sd)
    apart = [after(replace(wear, between=share))[0] for share in BETWEEN]
    between = _mean(np.array([0.0, *BETWEEN]), [log, *apart])
    return after(replace(wear, between=between))[1]


def wear_after(
    start: PairPosterior, observed: Observed, *, near: PairPosterior, wear: Wear
) -> Wear:
    """Return how edges wear by all readings, of a pair of which it was known before as ``wear``.

    Edges that cut longer than any before bend the curve otherwise. Powers and what edges differ by
    are weighed as in ``learn_worn``, by evidence that is linearised at the posterior ``near``.
    ``start`` and the readings as there. Where no edge of them has cut, as it was.
    """
    used_s = [float(one.worn_s.max()) for one in observed.cuts if one.worn_s is not None]
    longest_s = max(used_s, default=0.0)
    if longest_s <= 0.0:
        return wear

    def evidence(one: Wear) -> float:
        before = replace(start, terms=replace(start.terms, wear=one))
        return log_evidence_near(before, with_wear(observed, one), near)

    along, across = near.state.mean[near.columns(WEAR)] * float(wear.grown(np.array(longest_s)))
    size = float(along), float(across)
    tried = [Wear(power, longest_s, wear.between, size) for power in POWERS]
    ln_power, spread = _moments(np.log(POWERS), [evidence(one) for one in tried])
    found = Wear(
        float(np.exp(ln_power)), longest_s, 0.0, size, float(np.hypot(spread, HALF_A_STEP))
    )
    shares = (0.0, *BETWEEN)
    apart = [evidence(replace(found, between=share)) for share in shares]
    return replace(found, between=_mean(np.array(shares), apart))


def _moments(values: Array, log: Sequence[float]) -> tuple[float, float]:
    """Return mean and standard deviation of values by what readings say of each."""
    mean = _mean(values, log)
    return mean, float(np.sqrt(_mean((values - mean) ** 2, log)))


def _mean(values: Array, log: Sequence[float]) -> float:
    """Return the mean of values by what readings say of each, all alike beforehand."""
    weight = np.exp(np.asarray(log) - max(log))
    return float(weight @ values / weight.sum())
