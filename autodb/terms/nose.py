"""The rounded nose of an insert against a simulation with a sharp corner (turning).

The simulation has a straight edge at an entering angle of 90° down to the machined surface. A nose
of radius r replaces its last piece by an arc. Cut the engaged edge into elements; one whose normal
makes the local entering angle κ lies at the height z = r(1 − cos κ) above the machined surface and
has the length ds = r dκ. The arc is engaged up to κ_m = arccos(1 − a_p/r), or up to 90° where
a_p ≥ r; above it a straight edge of length a_p − r follows. With a feed small against r:

    thickness      h = f sin κ
    chip load      h ds = f r sin κ dκ = f dz: the same as without a nose, a_p f in all
    edge length    L = r κ_m + max(a_p − r, 0)
    thrust         K_r h ds, along the normal: axial share sin κ, radial share cos κ

Per depth, so that a sharp corner gives 1 and 0, the shares of the chip's thrust are

    axial   (1/a_p) ∫ sin κ dz = [r(κ_m/2 − sin 2κ_m/4) + max(a_p − r, 0)]/a_p
    radial  (1/a_p) ∫ cos κ dz = r sin² κ_m/(2 a_p)

for a_p ≥ r: 1 − (1 − π/4) r/a_p and r/(2 a_p): the axial force is lower by the same amount at every
depth. The tangential chip force stays; the edge's tangential force is longer by L/a_p, and the mean
thickness is thinner, f a_p/L, which the size effect depends on. Source: derived here; an insert
with a nose is a static set of edge elements. Valid for entering angles near 90° (P1's insert has
93°). Depths below SHALLOWEST_MM count as that.
"""

import numpy as np
from numpy.typing import NDArray

from autodb.terms.engagement import SHALLOWEST_MM
from autodb.terms.term import Contribution, Factor, InputChange, ParameterPrior, TermParameter

Array = NDArray[np.float64]


def _engaged(depth_mm: Array, radius_mm: float) -> tuple[Array, Array, Array]:
    """Return depth, largest local entering angle [rad] and straight length above the nose, (n,)."""
    depth = np.maximum(depth_mm, SHALLOWEST_MM)
    angle = np.arccos(1.0 - np.minimum(depth / radius_mm, 1.0))
    return depth, angle, np.maximum(depth - radius_mm, 0.0)


def nose_axial(depth_mm: Array, *, radius_mm: float) -> Array:
    """The nose turns part of the thrust away from the axis: factor of the axial chip force, (n,).

    Share (r(κ_m/2 − sin 2κ_m/4) + max(a_p − r, 0))/a_p, in (0, 1], 1 for r → 0; a_p, r [mm]. The
    edge's own thrust keeps its axial part: ∫ sin κ ds = a_p.
    Source: derived in the module's docstring.
    """
    depth, angle, straight = _engaged(depth_mm, radius_mm)
    return np.asarray((radius_mm * (angle / 2 - np.sin(2 * angle) / 4) + straight) / depth)


def nose_radial(other_force_N: Array, depth_mm: Array, *, radius_mm: float) -> Array:
    """The nose turns thrust of chip and edge into the radius: two columns, (n, 2).

    Force = factor · F_a r sin²κ_m/(2 a_p) [N] + edge [N/mm] · r sin κ_m [mm]: F_a the axial chip
    force of the sharp simulation, input ``other_force`` (Part of="z" reads `z.force`), factor 1
    where that is right; ∫ cos κ ds = r sin κ_m. Depths below r separate the radius from the factor.
    Source: derived in the module's docstring.
    """
    depth, angle, _ = _engaged(depth_mm, radius_mm)
    chip = other_force_N * radius_mm * np.sin(angle) ** 2 / (2.0 * depth)
    return np.column_stack([chip, radius_mm * np.sin(angle)])


def nose_length(depth_mm: Array, *, radius_mm: float) -> Array:
    """A rounded edge is longer than the depth: factor L/a_p of the edge's tangential force, (n,).

    L = r κ_m + max(a_p − r, 0) [mm]; at least 1. Source: derived in the module's docstring.
    """
    depth, angle, straight = _engaged(depth_mm, radius_mm)
    return np.asarray((radius_mm * angle + straight) / depth)


def nose_thinning(thickness_mm: Array, depth_mm: Array, *, radius_mm: float) -> Array:
    """Along a rounded edge the chip is thinner: mean uncut thickness h · a_p/L [mm], (n,).

    The chip's cross-section over the edge's length; the size effect of the mean thickness stands
    for the mean over the elements. Source: derived in the module's docstring.
    """
    return thickness_mm / nose_length(depth_mm, radius_mm=radius_mm)


_RADIUS = TermParameter(
    "radius", "mm", "radius of the nose", 0.01, 10.0,
    prior=ParameterPrior(0.8, 0.4, "mean: the insert of P1's repeated cut; sd: chosen"),
    keyword="radius_mm", starts=(0.2, 0.4, 0.8, 1.6),
)  # fmt: skip
_SOURCE = "derived in autodb/terms/nose.py from edge elements"
_SHALLOW = "depths from a quarter of the nose radius to several of it"

NOSE_AXIAL = Factor(
    name="nose_radius",
    title="the nose radius",
    form="axial",
    channels=("cuts",),
    inputs=("depth",),
    function=nose_axial,
    shape=(_RADIUS,),
    modifies=("shear",),
    needs=("cutting.depth",),
    statement="The rounded nose turns part of the feed force away from the feed.",
    excited_by=_SHALLOW,
    source=_SOURCE,
    alike=("depth_error",),
    distinguished_by="Measure the diameter before and after one cut: a depth error is there, a "
    "nose's is not. A nose also raises the radial force.",
    check="Check the insert's designation against the tool table; another nose radius turns force "
    "from feed to passive most in shallow cuts, and two depths, one below and one well above the "
    "radius, show it.",
    check_source="ISO 1832; Altintas, Manufacturing Automation, 2nd ed. (2012), chapter 2",
    sits=("tool",),
)
NOSE_RADIAL = Contribution(
    name="nose_radius",
    form="radial",
    channels=("cuts",),
    inputs=("other_force", "depth"),
    function=nose_radial,
    coefficients=(
        TermParameter(
            "factor", "1", "thrust against the simulated axial force",
            prior=ParameterPrior(1.0, 0.3, "mean: by construction; sd: chosen"),
        ),
        TermParameter("edge", "U/mm", "edge force per length along the edge's normal"),
    ),
    shape=(_RADIUS,),
    needs=("cutting.depth",),
    statement="The rounded nose presses the tool out of the work.",
    excited_by=_SHALLOW,
    source=_SOURCE,
)  # fmt: skip
NOSE_LENGTH = Factor(
    name="nose_radius",
    form="edge length",
    channels=("cuts",),
    inputs=("depth",),
    function=nose_length,
    shape=(_RADIUS,),
    modifies=("edge_force", "tool_wear"),
    needs=("cutting.depth",),
    statement="A rounded edge is longer than the depth: it rubs more.",
    excited_by=_SHALLOW,
    source=_SOURCE,
)
NOSE_THINNING = InputChange(
    name="nose_radius",
    form="thickness",
    channels=("cuts",),
    inputs=("depth",),
    function=nose_thinning,
    changes=("thickness",),
    shape=(_RADIUS,),
    modifies=("size_effect",),
    needs=("cutting.depth", "cutting.feed"),
    statement="Along a rounded edge the chip is thinner than the feed.",
    excited_by=_SHALLOW,
    source=_SOURCE,
)
