"""What the chip itself may cost more or less by: its edge, its thickness, its speed."""

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.candidates.laws import (
    alike,
    chip_factor,
    curve_of,
    each,
    grows,
    monotone,
    mostly_positive,
    per_depth,
    values_of,
)
from autodb.explain.cuts.stack import Conditions, Stack
from autodb.explain.engine.candidates import Candidate, CandidateForm
from autodb.terms.chip import size_effect, speed_softening

Array = NDArray[np.float64]

EXPONENTS = (0.1, 0.25, 0.5)
EDGE_ROUNDING_MM = (0.004, 0.02)
"""Thickness over which a rounded edge begins to plough."""
BAND_WIDTHS = (0.08, 0.14, 0.25, 0.45)
BAND_STEP = 0.8
"""Distance of the centres that are tried, in widths."""
FLANK = 0.6
"""A band of speeds is one only where both its flanks are seen: what is left of it there at most."""
CURVE = 5


def _log_thickness(known: Conditions) -> Array:
    assert known.thickness_mm is not None
    return np.log(known.thickness_mm)


def _log_speed(known: Conditions) -> Array:
    assert known.speed_m_min is not None
    return np.log(known.speed_m_min)


def _thickness_varies(frame: Stack) -> bool:
    thickness = frame.known.thickness_mm
    return thickness is not None and bool(np.ptp(thickness) > 0)


def edge_force_candidates(stack: Stack, own: frozenset[str]) -> list[Candidate]:
    """Return the edge's own force, per depth of cut; none where the thickness does not vary."""
    thickness = stack.known.thickness_mm
    if "edge_force" in own or thickness is None or not _thickness_varies(stack.frame):
        return []
    shapes: list[tuple[Array, dict[str, float]]] = [(np.ones_like(thickness), {})]
    shapes += [(-np.expm1(-thickness / h), {"rounding": h}) for h in EDGE_ROUNDING_MM]
    forms = []
    for values, shape in shapes:
        columns = each(stack, per_depth(stack, values_of(values)))
        forms.append(CandidateForm(columns, shape, allowed=mostly_positive(columns)))
    variables = ("cutting.feed", "cutting.depth")
    return [Candidate("edge_force", "edge_force", tuple(forms), variables)]


def size_candidates(stack: Stack) -> list[Candidate]:
    """Return the chip that costs more the thinner it is; none where the thickness does not vary."""
    thickness = stack.known.thickness_mm
    if thickness is None or not _thickness_varies(stack.frame):
        return []
    laws = [
        chip_factor(stack, values_of(size_effect(thickness, exponent=m) - 1.0)) for m in EXPONENTS
    ]
    forms = [
        grows(spread(stack, law), {"exponent": m})
        for m, law in zip(EXPONENTS, laws, strict=True)
        for spread in (alike, each)
    ]
    curve = curve_of(stack, _log_thickness, CURVE)
    columns = alike(stack, chip_factor(stack, curve, curve.width))
    falls = monotone(curve, columns, direction=-1.0)
    forms.append(CandidateForm(columns, allowed=falls))
    detail = each(stack, chip_factor(stack, curve, curve.width))
    variables = ("cutting.feed",)
    return [Candidate("size_effect", "size_effect", tuple(forms), variables, detail=detail)]


def speed_candidates(stack: Stack) -> list[Candidate]:
    """Return the chip that costs less or more the faster it is cut, one way over all speeds."""
    speed, seen = stack.known.speed_m_min, stack.frame.known.speed_m_min
    if speed is None or seen is None or np.ptp(seen) == 0:
        return []
    forms = []
    for e in (-0.4, 0.05, 0.5):
        law = chip_factor(stack, values_of(speed_softening(speed, exponent=e) - 1.0))
        forms += [CandidateForm(spread(stack, law), {"exponent": e}) for spread in (alike, each)]
    curve = curve_of(stack, _log_speed, CURVE)
    law = chip_factor(stack, curve, curve.width)
    if curve.width > 2:
        for columns in (alike(stack, law), each(stack, law)):
            forms.append(CandidateForm(columns, allowed=monotone(curve, columns)))
    variables, detail = ("cutting.speed",), each(stack, law)
    return [Candidate("speed_softening", "speed_softening", tuple(forms), variables, detail=detail)]


def bell(speed_m_min: Array, centre_m_min: float, width: float) -> Array:
    """Return the band of speeds of a built-up edge, 1 in its middle, (n,)."""
    off = np.log(speed_m_min / centre_m_min) / width
    return np.asarray(np.exp(-0.5 * off**2), dtype=np.float64)


def band_candidates(stack: Stack) -> list[Candidate]:
    """Return a band of speeds in which the chip costs other force: a built-up edge."""
    speed, seen = stack.known.speed_m_min, stack.frame.known.speed_m_min
    if speed is None or seen is None or len(np.unique(seen)) < 4:
        return []
    low, high = np.log(seen.min()), np.log(seen.max())
    forms = []
    for width in BAND_WIDTHS:
        for centre in np.exp(np.arange(low + 0.5 * width, high, BAND_STEP * width)):
            flanks = bell(np.exp([low, high]), centre, width)
            if flanks.max() > FLANK or bell(seen, centre, width).max() < 0.5:
                continue
            law = chip_factor(stack, values_of(bell(speed, centre, width)))
            shape = {"centre": float(centre), "width": width}
            forms += [CandidateForm(s(stack, law), shape, tries=6) for s in (alike, each)]
    curve = curve_of(stack, _log_speed, 2 * CURVE)
    detail = each(stack, chip_factor(stack, curve, curve.width))
    variables = ("cutting.speed",)
    return [Candidate("built_up_edge", "built_up_edge", tuple(forms), variables, detail=detail)]
