"""Wear: an edge's force grows with its cutting time, at one rate or at each edge's own."""

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.candidates.laws import (
    Rows,
    SmoothCurve,
    curve_of,
    each,
    grows,
    monotone,
    per_depth,
    relative,
    tied,
    values_of,
)
from autodb.explain.cuts.stack import Conditions, Stack
from autodb.explain.engine.candidates import Candidate, CandidateForm

Array = NDArray[np.float64]

WEAR_POWERS = (0.6, 1.7)
MOST_EDGES = 40
"""Edges with a rate of their own in the search; with more, only one rate for all."""
CURVE = 5


def _cutting_time(known: Conditions) -> Array:
    assert known.cutting_time_s is not None
    return known.cutting_time_s


def wear_candidates(stack: Stack, own: frozenset[str]) -> list[Candidate]:
    """Return what grows with the cutting time of an edge; none where no such time is known."""
    time, seen = stack.known.cutting_time_s, stack.frame.known.cutting_time_s
    if "tool_wear" in own or time is None or seen is None or np.ptp(seen) == 0:
        return []
    spent = time / float(seen.max())
    forms = []
    for power in (1.0, *WEAR_POWERS):
        shape = {} if power == 1.0 else {"power": power}
        law = per_depth(stack, values_of(spent**power))
        forms.append(grows(each(stack, law), shape))
        forms.append(grows(each(stack, relative(stack, values_of(spent**power))), shape))
    curve = curve_of(stack, _cutting_time, CURVE)
    if curve.levels is None:
        fresh = _fresh(curve)
        law = per_depth(stack, lambda rows: curve(rows) - fresh, curve.width)
        columns = each(stack, law)
        forms.append(CandidateForm(columns, allowed=monotone(curve, columns, direction=1.0)))
        forms += _edge_forms(stack, spent, curve)
    bow = np.column_stack([spent, spent**2, spent**3])
    detail = each(stack, per_depth(stack, values_of(bow), 3))
    variables = ("tool.cutting_time", "tool.edge")
    return [Candidate("tool_wear", "tool_wear", tuple(forms), variables, detail=detail)]


def _fresh(curve: SmoothCurve) -> Array:
    """Return the curve's columns at no cutting time (1, width); 0 where no such edge was seen."""
    return curve.at(np.zeros(1)) if curve.frame.min() <= 0 else np.zeros((1, curve.width))


def _members(stack: Stack) -> Array:
    """Return which of the table's edges made each cut, (n, E); of another edge their mean."""
    edge, edges = stack.known.edge, stack.frame.known.edges
    assert edge is not None
    member = np.asarray(edge[:, None] == edges[None, :], dtype=np.float64)
    member[~member.any(axis=1)] = 1.0 / len(edges)
    return member


def _edge_forms(stack: Stack, spent: Array, curve: SmoothCurve) -> list[CandidateForm]:
    """Return shapes with a rate for each edge, the components in the ratio of the common rate."""
    cuts, edges = len(stack.frame.known), len(stack.frame.known.edges)
    if not 2 <= edges <= min(MOST_EDGES, cuts // 4):
        return []
    ratio, member = wear_ratio(stack.frame), _members(stack)
    forms = []
    for power in (1.0, *WEAR_POWERS):
        law = per_depth(stack, values_of(member * spent[:, None] ** power), edges)
        forms.append(grows(tied(stack, law, ratio), {"power": power, "edges": float(edges)}))
    if cuts > 30 * edges:
        fresh = _fresh(curve)

        def shape(rows: Rows) -> Array:
            grown = curve(rows) - fresh
            columns = member[rows][:, :, None] * grown[:, None, :]
            return np.asarray(columns.reshape(-1, edges * curve.width))

        law = per_depth(stack, shape, edges * curve.width)
        forms.append(grows(tied(stack, law, ratio), {"curved": 1.0, "edges": float(edges)}))
    return forms


def wear_ratio(stack: Stack) -> Array:
    """Return how strongly wear acts on each component, (C,), the strongest 1."""
    time = _cutting_time(stack.known)
    spent, found = time / float(time.max()), []
    for i in range(len(stack.names)):
        sd = stack.sd[i]
        grown = stack.sign[i] * stack.known.depth_mm * spent
        design = np.column_stack([grown, stack.simulation[i], stack.known.depth_mm]) / sd[:, None]
        difference = (stack.recording[i] - stack.simulation[i]) / sd
        found.append(np.linalg.lstsq(design, difference, rcond=1e-8)[0][0])
    ratio = np.maximum(np.array(found), 0.0)
    most = float(ratio.max())
    return np.asarray(ratio / most if most > 0 else np.ones_like(ratio))
