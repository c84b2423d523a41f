"""An edge change that nobody recorded: wear falls back to its beginning, and stays there.

Of each cut of a pair the logarithm q of each force over that of a fresh edge is known, the edge
that was written down, and for how long that had cut, T. Each component c grows with it,

    q_c = a_c + A_c T^p,    A_c >= 0

Where the edge was changed unseen before a cut k, T has begun anew there: T - T_k from it on. This
is compared, all components together and with robust fits (Student's t, 4 degrees of freedom), with
no change, and with a step that stays (other work, a calibration that drifted) in place of it; the
cuts around it must show half of the fall, since real wear bends as no power of T does. Other powers
p are tried, too: what a pair has learnt of p may be from wrong counters.

Source: robust regression by t likelihoods, Lange, Little and Taylor 1989.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.intp]

FREEDOM, ROUNDS = 4.0, 12
BEATS = 6.0
"""Log likelihood by which a change must beat none. Chosen: odds of 400, for some 100 places."""
STEP_BEATS = 1.0
"""Log likelihood by which a step that stays may be better, with its share for each component."""
BENDS = (1.0, 2.0, 3.0)
"""Powers that are tried beside the one that cuts come with: from steady to the latest that wear is
learnt with (`worn.POWERS`), as of an edge that breaks down. Chosen."""
AROUND = 4
"""Cuts on an edge before its change at least, and after it where not each shows the fall."""
SOON = 2
"""Cuts after a change at least: each of fewer than AROUND must show most of the fall. Chosen: a
single cut of softer work looks alike."""
DROP = 0.1
"""Share of the force, of some component, that falls away at least. Chosen: less is no edge's
end."""
SEEN = 0.5
"""Of the fall that growth has come to, what cuts around it must show: wear that only bends shows
none. Chosen: on virtual shops 0.9 to 1.0 of it where the edge was changed, 0.35 at most else."""
MOST = 3
"""Changes that are looked for at once."""
LEAST_SCALE = 0.01


@dataclass(frozen=True)
class EdgeCuts:
    """Cuts (n,) of a pair in the order of time: ``q`` (n, c), NaN: not sensed; ``edge``: its place
    among the edges; ``used_s``; ``power``: p.
    """

    q: Array
    edge: Ints
    used_s: Array
    power: float

    def changed(self, cut: int) -> "EdgeCuts":
        """Return them with a new edge from a cut on."""
        later = (self.edge == self.edge[cut]) & (np.arange(len(self.edge)) >= cut)
        used = np.where(later, self.used_s - self.used_s[cut], self.used_s)
        return replace(self, edge=np.where(later, self.edge.max() + 1, self.edge), used_s=used)


@dataclass(frozen=True)
class EdgeChange:
    """The first cut with a new edge, by place, and by what shares its forces fell (c,).

    NaN: a component that is not sensed there.
    """

    cut: int
    fell: tuple[float, ...]
    evidence: float


def wears(cuts: EdgeCuts) -> bool:
    """Say whether forces grow with how long their edges have cut, edge after edge.

    Where nothing grows it is said of 2 to 5 pairs in 1000, with 60 to 12 cuts: an explanation then
    finds nothing.
    """
    return _fitted(cuts, None)[0] - _fitted(cuts, None, grows=False)[0] > BEATS


def edge_changes(cuts: EdgeCuts) -> list[EdgeChange]:
    """Return the changes that nobody recorded, the surest first."""
    found: list[EdgeChange] = []
    while len(found) < MOST:
        best = _best(cuts)
        if best is None:
            break
        found.append(best)
        cuts = cuts.changed(best.cut)
    return found


def _best(cuts: EdgeCuts) -> EdgeChange | None:
    """Return the surest change, of any power; None where there is none."""
    powers = dict.fromkeys((cuts.power, *BENDS))
    found = [_surest(replace(cuts, power=power)) for power in powers]
    return max((one for one in found if one is not None), key=_evidence, default=None)


def _evidence(change: EdgeChange) -> float:
    return change.evidence


def _surest(cuts: EdgeCuts) -> EdgeChange | None:
    """Return the surest change; None where there is none."""
    none, _ = _fitted(cuts, None)
    tried = [(*_fitted(cuts.changed(k), None), k) for k in _places(cuts)]
    if not tried:
        return None
    score, growth, cut = max(tried, key=lambda one: one[0])
    grown = growth * (cuts.used_s[cut] / 1000.0) ** cuts.power
    fell = np.where(np.isfinite(cuts.q[cut]), grown, np.nan)
    step, _ = _fitted(cuts, _after(cuts, cut))
    if score - none < BEATS or step - score > STEP_BEATS or not np.nanmax(fell) >= DROP:
        return None
    if np.nansum(_fall(cuts, cut)) < SEEN * np.nansum(fell) or not _each_fell(cuts, cut, fell):
        return None
    return EdgeChange(cut, tuple(fell.tolist()), score - none)


def _places(cuts: EdgeCuts) -> Iterator[int]:
    """Give the cuts before which their edge may have been changed."""
    for edge in np.unique(cuts.edge):
        rows = np.flatnonzero((cuts.edge == edge) & np.isfinite(cuts.used_s))
        yield from (int(k) for k in rows[AROUND : len(rows) - SOON + 1])


def _fall(cuts: EdgeCuts, cut: int) -> Array:
    """Return by what the mean of an edge's cuts falls at one of them, AROUND before and after."""
    rows = np.flatnonzero(cuts.edge == cuts.edge[cut])
    place = int(np.searchsorted(rows, cut))
    before, after = rows[max(place - AROUND, 0) : place], rows[place : place + AROUND]
    return _mean(cuts.q[before]) - _mean(cuts.q[after])


def _each_fell(cuts: EdgeCuts, cut: int, fell: Array) -> bool:
    """Whether each of fewer cuts than AROUND after a change shows the share SEEN of its fall."""
    rows = np.flatnonzero(cuts.edge == cuts.edge[cut])
    place = int(np.searchsorted(rows, cut))
    before, after = rows[max(place - AROUND, 0) : place], rows[place:]
    if len(after) >= AROUND:
        return True
    each = np.nansum(_mean(cuts.q[before]) - cuts.q[after], axis=1)
    return bool(np.all(each > SEEN * np.nansum(fell)))


def _mean(q: Array) -> Array:
    """Return the mean of each component (c,) over cuts (n, c); NaN where none is sensed."""
    known = np.isfinite(q)
    count = known.sum(axis=0)
    whole = np.where(known, q, 0.0).sum(axis=0)
    return np.asarray(np.where(count > 0, whole / np.maximum(count, 1), np.nan))


def _after(cuts: EdgeCuts, cut: int) -> Array:
    return np.asarray(np.arange(len(cuts.edge)) >= cut, dtype=np.float64)


def _fitted(cuts: EdgeCuts, step: Array | None, *, grows: bool = True) -> tuple[float, Array]:
    """Return the log likelihood of all components, and by what each ``grows`` in 1000 s."""
    score, growth = 0.0, []
    for q in cuts.q.T:
        rows = np.isfinite(q) & np.isfinite(cuts.used_s)
        if not rows.any():
            growth.append(0.0)
            continue
        worn = np.maximum(cuts.used_s[rows] / 1000.0, 0.0) ** cuts.power
        steady = np.column_stack([np.ones(len(worn)), *([] if step is None else [step[rows]])])
        own, found = robust_regression(np.column_stack([worn, steady]), q[rows])
        if not grows or found[0] < 0.0:
            own, found = robust_regression(steady, q[rows])[0], np.zeros(1)
        score += own
        growth.append(float(found[0]))
    return score, np.array(growth)


def robust_regression(design: Array, values: Array) -> tuple[float, Array]:
    """Return the log likelihood of a regression with errors of Student's t, and what it found."""
    scale = max(float(np.std(values)), LEAST_SCALE)
    weight = np.ones(len(values))
    found = np.zeros(design.shape[1])
    for _ in range(ROUNDS):
        root = np.sqrt(weight)
        found = np.asarray(np.linalg.lstsq(design * root[:, None], values * root)[0])
        residual = values - design @ found
        scale = max(float(np.sqrt(np.mean(weight * residual**2))), LEAST_SCALE)
        weight = (FREEDOM + 1.0) / (FREEDOM + (residual / scale) ** 2)
    z2 = ((values - design @ found) / scale) ** 2
    density = -0.5 * (FREEDOM + 1.0) * np.log1p(z2 / FREEDOM) - np.log(scale)
    return float(np.sum(density)), found
