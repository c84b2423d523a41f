"""What cutting itself may cost or engage otherwise than simulated, by the conditions of each cut.

The chip costs more or less by its edge, its thickness, its speed; what engages is another depth, a
nose, a tool or work that bends.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.candidates.laws import (
    Allowed,
    LawColumns,
    SmoothCurve,
    SpreadLaw,
    alike,
    chip_factor,
    curve_of,
    each,
    grows,
    monotone,
    mostly_negative,
    mostly_positive,
    per_depth,
    relative,
    turns_away,
    values_of,
)
from autodb.explain.cuts.stack import Conditions, Stack
from autodb.explain.engine.candidates import Candidate, CandidateForm
from autodb.terms.chip import REFERENCE_SPEED_M_MIN, size_effect, speed_softening
from autodb.terms.engagement import DEPTH_ERROR
from autodb.terms.nose import nose_axial, nose_length

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
MOST_BENT = 0.5
"""Share of the force that a depth lost by bending takes at most; with more it would trade against
the chip's own cost. Chosen."""
NOSE_MM = (0.2, 0.4, 0.8, 1.2, 2.0)


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
    return [Candidate("edge_force", "edge_force", tuple(forms), variables, static=True)]


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
    return [
        Candidate("size_effect", "size_effect", tuple(forms), variables, detail=detail, static=True)
    ]


def log_speed(stack: Stack) -> Array:
    """Return the logarithm of each cut's speed over the table's usual one, (n,)."""
    return np.asarray(_log_speed(stack.known) - np.mean(_log_speed(stack.frame.known)))


def speed_candidates(stack: Stack, own: frozenset[str]) -> list[Candidate]:
    """Return the chip that costs less or more the faster it is cut, one way over all speeds.

    A simulation is right at the table's usual speed: what is off there is its own chip's.
    """
    speed, seen = stack.known.speed_m_min, stack.frame.known.speed_m_min
    if "speed_softening" in own or speed is None or seen is None or np.ptp(seen) == 0:
        return []
    forms, fast = [], np.exp(log_speed(stack))
    for e in (-0.4, 0.05, 0.5):
        factor = speed_softening(fast * REFERENCE_SPEED_M_MIN, exponent=e)
        law = chip_factor(stack, values_of(factor - 1.0))
        forms += [CandidateForm(spread(stack, law), {"exponent": e}) for spread in (alike, each)]
    curve = curve_of(stack, _log_speed, CURVE)
    law = chip_factor(stack, curve, curve.width)
    if curve.width > 2:
        for columns in (alike(stack, law), each(stack, law)):
            forms.append(CandidateForm(columns, allowed=monotone(curve, columns)))
    variables, detail = ("cutting.speed",), each(stack, law)
    return [
        Candidate(
            "speed_softening",
            "speed_softening",
            tuple(forms),
            variables,
            detail=detail,
            static=True,
        )
    ]


def bell(speed_m_min: Array, centre_m_min: float, width: float) -> Array:
    """Return the band of speeds of a built-up edge, 1 in its middle, (n,)."""
    off = np.log(speed_m_min / centre_m_min) / width
    return np.asarray(np.exp(-0.5 * off**2), dtype=np.float64)


def band_candidates(stack: Stack) -> list[Candidate]:
    """Return a band of speeds in which the chip costs other force: a built-up edge."""
    speed, seen = stack.known.speed_m_min, stack.frame.known.speed_m_min
    if speed is None or seen is None or len(np.unique(seen)) < 3:
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


def _log_depth(known: Conditions) -> Array:
    return np.log(known.depth_mm)


def depth_candidates(stack: Stack) -> list[Candidate]:
    """Return a depth that is off by a constant, within the term's limits and by no more than the
    deepest cut; none where the depth does not vary.
    """
    depth = stack.known.depth_mm
    if np.ptp(stack.frame.known.depth_mm) == 0:
        return []
    forms = [
        CandidateForm(
            alike(stack, relative(stack, values_of(depth**-p))),
            {"power": p},
            allowed=_off_by(stack.frame.known.depth_mm, p),
        )
        for p in (1.0, 0.8, 1.25)
    ]
    curve = curve_of(stack, _log_depth, CURVE)
    detail = each(stack, relative(stack, curve, curve.width))
    variables = ("cutting.depth",)
    return [
        Candidate("depth_error", "depth_error", tuple(forms), variables, detail=detail, static=True)
    ]


def _off_by(depth: Array, power: float) -> Allowed:
    """Return whether a coefficient of 1/depth^power is of a depth that may be wrong by so much."""
    (error,) = DEPTH_ERROR.shape
    low, high = max(error.lower, -depth.max()), min(error.upper, depth.max())
    return lambda c: bool(low <= c[0] * depth.min() ** (1.0 - power) <= high)


def nose_candidates(stack: Stack) -> list[Candidate]:
    """A nose takes from the axial chip force and gives to the radial; the tangential stays."""
    depth = stack.known.depth_mm
    known = stack.frame.known
    if not known.turns or np.ptp(known.depth_mm) == 0 or "force.z" not in stack.names:
        return []
    forms = [
        CandidateForm(columns, {"radius": radius}, allowed=turns_away(columns))
        for radius in NOSE_MM
        for columns in (
            nose_columns(stack, radius, longer=False),
            nose_columns(stack, radius, longer=True),
            turned_columns(stack, np.exp(-depth / radius)),
            turned_columns(stack, 1.0 / (1.0 + (depth / radius) ** 2)),
        )
    ]
    curve = curve_of(stack, _log_depth, CURVE)
    detail = each(stack, relative(stack, curve, curve.width))
    variables = ("cutting.depth",)
    return [
        Candidate("nose_radius", "nose_radius", tuple(forms), variables, detail=detail, static=True)
    ]


def nose_columns(stack: Stack, radius_mm: float, *, longer: bool) -> LawColumns:
    """Return what a nose does to the axial and the radial force, each with a factor of its own.

    ``longer``: also to the tangential one, by the rubbing of a longer edge.
    """
    depth, place = stack.known.depth_mm, stack.names.index
    axial = stack.chip[place("force.z")]
    raw = np.zeros((*stack.simulation.shape, 1))
    raw[place("force.z"), :, 0] = axial * (nose_axial(depth, radius_mm=radius_mm) - 1.0)
    if "force.x" in stack.names:
        x = place("force.x")
        raw[x, :, 0] = stack.sign[x] * np.abs(axial) * _radial(depth, radius_mm)
    if longer and "force.y" in stack.names:
        y, length = place("force.y"), nose_length(depth, radius_mm=radius_mm)
        raw[y, :, 0] = stack.sign[y] * depth * (length - 1.0)
    return _present(stack, raw)


def turned_columns(stack: Stack, angle: Array) -> LawColumns:
    """Return thrust turned from the axial into the radial force by an angle of each cut (n,)."""
    z = stack.names.index("force.z")
    raw = np.zeros((*stack.simulation.shape, 1))
    raw[z, :, 0] = -stack.simulation[z] * angle
    if "force.x" in stack.names:
        x = stack.names.index("force.x")
        raw[x, :, 0] = stack.sign[x] * np.abs(stack.simulation[z]) * angle
        raw[z, :, 0] = -stack.sign[z] * np.abs(stack.simulation[x]) * angle
    return _present(stack, raw)


def _present(stack: Stack, raw: Array) -> LawColumns:
    """Return columns (C, n, 1), free for each component that has any."""
    law = SpreadLaw(lambda rows: raw[:, rows], 1)
    columns = each(stack, law)
    kept = [i for i in range(len(raw)) if np.any(raw[i])]
    return LawColumns(stack, law, columns.mix[:, :, kept])


def _radial(depth_mm: Array, radius_mm: float) -> Array:
    angle = np.arccos(1.0 - np.minimum(depth_mm / radius_mm, 1.0))
    return np.asarray(radius_mm * np.sin(angle) ** 2 / (2.0 * depth_mm))


def normal_force(stack: Stack) -> Array:
    """Return the simulated force that bends the tool off the surface [N], (n,).

    The radial one; of all that are there where it is not.
    """
    if "force.x" in stack.names:
        return np.asarray(np.abs(stack.simulation[stack.names.index("force.x")]))
    return np.asarray(np.sqrt(np.sum(stack.simulation**2, axis=0)))


def _bending(stack: Stack) -> dict[str, Array]:
    """Return what tool and work may give way to, (n,) each."""
    force = normal_force(stack)
    whole = np.sqrt(np.sum(stack.simulation**2, axis=0))
    return {"pressed": force / stack.known.depth_mm, "normal": force, "whole": whole}


def _giving_way(values: Array, most: float) -> dict[float, Array]:
    """Return a share that grows with a load (n,) and then less and less, by how much less."""
    shapes = {0.0: values / most}
    return shapes | {less: values / (most / less + values) for less in (1.0, 4.0)}


def _bends(columns: LawColumns, peak: float) -> Allowed:
    """Return whether force falls with the load, and nowhere by more than MOST_BENT.

    ``peak``: of the share that the columns grow to at a coefficient of 1.
    """
    falls = mostly_negative(columns)

    def allowed(coefficients: Array) -> bool:
        return falls(coefficients) and float(np.abs(coefficients).max()) * peak <= MOST_BENT

    return allowed


def deflection_candidates(stack: Stack) -> list[Candidate]:
    """Return force that falls where tool or work bends; none where the load hardly varies.

    Where the radial force is not there, any law of the forces that are looks like it.
    """
    seen = normal_force(stack.frame)
    if np.ptp(seen) <= 0.02 * seen.max():
        return []
    bending, most = _bending(stack), _bending(stack.frame)
    forms = []
    for name, values in bending.items():
        for less, share in _giving_way(values, float(most[name].max())).items():
            for spread in (alike, each):
                columns = spread(stack, relative(stack, values_of(share)))
                peak = less / (1.0 + less) if less else 1.0
                forms.append(CandidateForm(columns, {name: less}, allowed=_bends(columns, peak)))
    curve = SmoothCurve(bending["whole"], CURVE, most["whole"])
    detail = each(stack, relative(stack, curve, curve.width))
    variables = tuple(n for n in stack.names if n == "force.x")
    plain = Candidate("deflection", "deflection", tuple(forms), variables, detail=detail)
    return [replace(plain, static="force.x" in stack.names)]
