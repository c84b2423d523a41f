"""A band of cutting speeds in which all forces of a pair are lower: a built-up edge nobody named.

Of each cut of a pair the logarithm q of each sensed force over the expected one is known. Each
component c is followed, robustly (Student's t, 4 degrees of freedom), by

    q_c = l_c(g) + x beta_c + b_c exp(-½ (ln(v/v_c)/w)²),    b_c < 0

with a level l of each recording and operation g (its day, its bar), and x what a pair's law may be
wrong in: the logarithms of speed, of feed and of depth, and the time on the edge. A band is told
from none by all components together: material that welds to the edge makes its rake sharper, so
that every force falls below what it is on both flanks, two half widths away. Faster cuts must be
there; slower ones need not be, where a shop makes none. Cuts of several recordings must lie in it:
what one recording has is its own.

Source: physics of a built-up edge (``autodb.terms.chip``); robust regression by t likelihoods,
Lange, Little and Taylor 1989.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.pairs.changes.edge_changes import robust_regression
from autodb.terms.chip import built_up_edge

Array = NDArray[np.float64]
Ints = NDArray[np.intp]

WIDTHS = (0.08, 0.12, 0.18, 0.25)
"""Half widths in ln v that are tried. Chosen: bands of some 20 to 60 % of their speed."""
STEP = 0.5
"""Of a half width, between the centres that are tried."""
BEATS = 10.0
"""Log likelihood by which a band must beat none. Chosen: on virtual shops 8 at most where there is
none, 18 and more from four cuts in one on."""
CLOSE = 3.0
"""Log likelihood by which a bell of higher forces, or one on a slope, may be better. Chosen: odds
of 20."""
INSIDE, RECORDINGS = 3, 2
"""Cuts in a band, and recordings that hold them, at least."""
FASTER, CLEAR = 5, 2.0
"""Cuts that are faster than a band, by so many half widths, at least."""
DROP = 0.1
"""Logarithm by which some component is lower in the middle than on its flanks, at least: less is
any law's error. Chosen."""
FEWEST = 12
"""Cuts that a component is sensed of, for anything to be said by it."""
TRIED = 24
"""Bells that are fitted robustly, the best by plain least squares. Chosen: a second's work at most,
where each of many recordings has a level."""
TINY = 1e-12
"""Square of what a law leaves of a bell, below which it leaves nothing."""
SCATTER = 0.03
"""Share that a cut scatters by beside its sensing, where weights are made. Chosen."""


@dataclass(frozen=True)
class CutsAtSpeeds:
    """Cuts (n,): ``off`` (n, c) and its ``sd``, NaN: not sensed; ``group``: recording and operation
    by place; ``recording``; ``speed_m_min``; ``beside`` (n, k): what else the law may be wrong in.
    """

    off: Array
    sd: Array
    group: Ints
    recording: Ints
    speed_m_min: Array
    beside: Array


@dataclass(frozen=True)
class FoundBand:
    """A band: its shape, by what share each component changes in its middle (c,), NaN: not sensed,
    by how much log likelihood it beats none, and which cuts (n,) lie in it.
    """

    centre_m_min: float
    width: float
    change: tuple[float, ...]
    evidence: float
    inside: NDArray[np.bool_]


def speed_band(cuts: CutsAtSpeeds) -> FoundBand | None:
    """Return the likeliest band of lower forces; None where there is none, or another bend of the
    law of the speed is as good an account.
    """
    if not _sensed(cuts).any() or np.ptp(cuts.speed_m_min) == 0.0 or np.min(cuts.speed_m_min) <= 0:
        return None
    ln_speed = np.log(cuts.speed_m_min)
    law = np.column_stack([ln_speed - ln_speed.mean(), _beside(cuts)])
    none, _ = _fitted(cuts, law)
    best, other = None, -np.inf
    for centre, width, bell in _promising(cuts, law):
        score, found = _fitted(cuts, np.column_stack([bell, law]))
        evidence = score - none
        slower = bool(np.any(ln_speed < np.log(centre) - CLEAR * width))
        if not _is_lower(found, width, slower=slower):
            other = max(other, evidence)
        elif evidence > (BEATS if best is None else best.evidence):
            share = np.full(len(cuts.off.T), np.nan)
            share[_sensed(cuts)] = np.expm1(found[:, 0])
            best = FoundBand(centre, width, tuple(share.tolist()), evidence, bell > 0.5)
    return None if best is None or best.evidence < other - CLOSE else best


def _is_lower(found: Array, width: float, *, slower: bool) -> bool:
    """Say whether every component is lower in a band's middle than on its flanks.

    ``found`` (c, k): of each component's bell and slope in ln v, first; ``slower``: whether the
    slow flank was cut.
    """
    sides = np.array([-1.0, 1.0] if slower else [-1.0])
    lower = np.max(found[:, :1] + CLEAR * width * sides * found[:, 1:2], axis=1)
    return bool(np.all(lower < 0.0) and np.min(lower) < -DROP)


def _promising(cuts: CutsAtSpeeds, law: Array) -> list[tuple[float, float, Array]]:
    """Return the bells by which plain least squares falls most beside a law's columns (n, k)."""
    bells = list(_bells(cuts))
    columns = np.array([bell for _, _, bell in bells]).reshape(len(bells), len(law)).T
    gain = np.zeros(len(bells))
    for off, sd in zip(cuts.off.T[_sensed(cuts)], cuts.sd.T[_sensed(cuts)], strict=True):
        rows = np.isfinite(off)
        weight = 1.0 / np.hypot(sd[rows], SCATTER)
        known = np.linalg.qr(law[rows] * weight[:, None])[0]
        left = off[rows] * weight
        left = left - known @ (known.T @ left)
        own = columns[rows] * weight[:, None]
        own = own - known @ (known.T @ own)
        gain += (own.T @ left) ** 2 / np.maximum(np.sum(own**2, axis=0), TINY)
    return [bells[k] for k in np.argsort(-gain, kind="stable")[:TRIED]]


def _bells(cuts: CutsAtSpeeds) -> Iterator[tuple[float, float, Array]]:
    """Give centre, half width and how far in it each cut is, of the bands that cuts can tell."""
    ln_speed = np.log(cuts.speed_m_min)
    for width in WIDTHS:
        for ln_centre in np.arange(ln_speed.min(), ln_speed.max(), STEP * width):
            shape = {"centre_m_min": float(np.exp(ln_centre)), "width": width}
            bell = built_up_edge(cuts.speed_m_min, change=1.0, **shape) - 1.0
            inside = bell > 0.5
            faster = np.sum(ln_speed > ln_centre + CLEAR * width)
            held = len(np.unique(cuts.recording[inside]))
            if np.sum(inside) >= INSIDE and held >= RECORDINGS and faster >= FASTER:
                yield shape["centre_m_min"], width, bell


def _beside(cuts: CutsAtSpeeds) -> Array:
    """Return the columns of levels and of what else the law may be wrong in, those that vary."""
    levels = (cuts.group[:, None] == np.unique(cuts.group)).astype(np.float64)
    wrong = cuts.beside - np.mean(cuts.beside, axis=0)
    return np.column_stack([levels, wrong[:, np.ptp(wrong, axis=0) > 0.0]])


def _sensed(cuts: CutsAtSpeeds) -> NDArray[np.bool_]:
    """Return which components (c,) are sensed of enough cuts."""
    return np.asarray(np.sum(np.isfinite(cuts.off), axis=0) >= FEWEST)


def _fitted(cuts: CutsAtSpeeds, design: Array) -> tuple[float, Array]:
    """Return the log likelihood of all components that are sensed, and their coefficients."""
    score, every = 0.0, []
    for off, sd in zip(cuts.off.T[_sensed(cuts)], cuts.sd.T[_sensed(cuts)], strict=True):
        rows = np.isfinite(off)
        weight = 1.0 / np.hypot(sd[rows], SCATTER)
        own, found = robust_regression(design[rows] * weight[:, None], off[rows] * weight)
        score += own
        every.append(found)
    return score, np.array(every).reshape(len(every), design.shape[1])
