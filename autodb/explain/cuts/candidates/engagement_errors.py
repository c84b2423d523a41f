"""What engages may be other than simulated: another depth, a nose, a tool or work that bends."""

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.candidates.laws import (
    LawColumns,
    SmoothCurve,
    SpreadLaw,
    alike,
    curve_of,
    each,
    mostly_negative,
    relative,
    turns_away,
    values_of,
)
from autodb.explain.cuts.stack import Conditions, Stack
from autodb.explain.engine.candidates import Candidate, CandidateForm
from autodb.terms.nose import nose_axial, nose_length

Array = NDArray[np.float64]

NOSE_MM = (0.2, 0.4, 0.8, 1.2, 2.0)
CURVE = 5


def _log_depth(known: Conditions) -> Array:
    return np.log(known.depth_mm)


def depth_candidates(stack: Stack) -> list[Candidate]:
    """Return a depth that is off by a constant; none where the depth does not vary."""
    depth = stack.known.depth_mm
    if np.ptp(stack.frame.known.depth_mm) == 0:
        return []
    laws = [(values_of(depth**-p), {"power": p}) for p in (1.0, 0.8, 1.25)]
    forms = [CandidateForm(alike(stack, relative(stack, shape)), at) for shape, at in laws]
    curve = curve_of(stack, _log_depth, CURVE)
    detail = each(stack, relative(stack, curve, curve.width))
    variables = ("cutting.depth",)
    return [Candidate("depth_error", "depth_error", tuple(forms), variables, detail=detail)]


def nose_candidates(stack: Stack) -> list[Candidate]:
    """A nose takes from the axial chip force and gives to the radial; the tangential stays."""
    depth = stack.known.depth_mm
    if np.ptp(stack.frame.known.depth_mm) == 0 or "force.z" not in stack.names:
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
    return [Candidate("nose_radius", "nose_radius", tuple(forms), variables, detail=detail)]


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


def deflection_candidates(stack: Stack) -> list[Candidate]:
    """Return force that falls where tool or work bends; none where the load hardly varies."""
    seen = normal_force(stack.frame)
    if np.ptp(seen) <= 0.02 * seen.max():
        return []
    bending, most = _bending(stack), _bending(stack.frame)
    forms = []
    for name, values in bending.items():
        for less, share in _giving_way(values, float(most[name].max())).items():
            for spread in (alike, each):
                columns = spread(stack, relative(stack, values_of(share)))
                forms.append(CandidateForm(columns, {name: less}, allowed=mostly_negative(columns)))
    curve = SmoothCurve(bending["whole"], CURVE, most["whole"])
    detail = each(stack, relative(stack, curve, curve.width))
    variables = tuple(n for n in stack.names if n == "force.x")
    return [Candidate("deflection", "deflection", tuple(forms), variables, detail=detail)]
