"""The shape of an unnamed effect in words."""

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.table import Stack
from autodb.explain.engine.candidates import Choice

Array = NDArray[np.float64]

BINS = 8
ONE_WAY = 0.85
"""Rank correlation from which a dependence is called one of rising or falling."""


def shape_words(stack: Stack, choice: Choice, part: Array, component: int) -> str:
    """Return how a contribution (n,) goes with what it depends on, one sentence."""
    shape = choice.shape.shape
    if "period" in shape:
        return f"it comes round every {shape['period']:.3g} of it."
    variable = choice.suspect.variables[0]
    values = {**stack.known.other, "cut": stack.known.number, "t": stack.known.t_s}[variable]
    if "every" in shape:
        return f"it differs from cut to cut and comes back after {shape['every']:.0f}."
    share = part / np.maximum(np.abs(stack.simulation[component]), 1e-12)
    return _along(values, share - share.mean())


def _along(values: Array, share: Array) -> str:
    rank = np.argsort(np.argsort(values, kind="stable"), kind="stable")
    order = np.argsort(np.argsort(share, kind="stable"), kind="stable")
    together = float(np.corrcoef(rank, order)[0, 1]) if np.ptp(share) > 0 else 0.0
    if abs(together) > ONE_WAY:
        return f"it {'rises' if together > 0 else 'falls'} with it."
    edges = np.quantile(values, np.linspace(0, 1, BINS + 1))
    place = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, BINS - 1)
    mean = np.array([share[place == b].mean() if np.any(place == b) else 0.0 for b in range(BINS)])
    middle = 0.5 * (edges[1:] + edges[:-1])
    top, bottom = middle[np.argmax(mean)], middle[np.argmin(mean)]
    return f"it is highest near {top:.3g} and lowest near {bottom:.3g}."
