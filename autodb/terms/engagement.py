"""The engagement that was not as programmed: depth set wrong, depth lost to bending."""

import numpy as np
from numpy.typing import NDArray

from autodb.terms.term import Factor, ParameterPrior, TermParameter

Array = NDArray[np.float64]

SHALLOWEST_MM = 0.01
"""Shallower than any depth that is programmed: relative errors grow no further. Chosen."""
CUTTING = ("shear", "edge_force", "tool_wear")


def depth_error(depth_mm: Array, *, error_mm: float) -> Array:
    """The real depth differs by a constant: factor (a_p + δ)/a_p on all that cuts, never < 0, (n,).

    a_p programmed depth [mm], not below SHALLOWEST_MM; δ [mm] positive where more is cut. Valid
    where forces grow in proportion to depth; in milling the limits of the engagement move too.
    Source: by construction, relative error ∝ 1/a_p.
    """
    depth = np.maximum(depth_mm, SHALLOWEST_MM)
    return np.maximum(1.0 + error_mm / depth, 0.0)


def deflection(normal_force_N: Array, depth_mm: Array, *, compliance_mm_N: float) -> Array:
    """Tool or work springs away from the cut and takes depth off: factor 1/(1 + c|F_n|/a_p), (n,).

    The real depth is a = a_p − c·F; the force it gives is F = F_n·a/a_p. Put together,
    F = F_n − F_n c F/a_p, so a/a_p = 1/(1 + c F_n/a_p). F_n simulated force normal to the surface
    [N], c = 1/stiffness [mm/N] of tool, holder and work at one overhang; c = 0 changes nothing.
    Where F_n ∝ a_p the factor depends on the feed alone.
    Source: physics of a spring between tool and work, force in proportion to depth.
    """
    depth = np.maximum(depth_mm, SHALLOWEST_MM)
    return np.asarray(1.0 / (1.0 + compliance_mm_N * np.abs(normal_force_N) / depth))


DEPTH_ERROR = Factor(
    name="depth_error",
    title="a wrong depth of cut",
    channels=("cuts",),
    inputs=("depth",),
    function=depth_error,
    shape=(
        TermParameter(
            "error", "mm", "real depth less programmed depth", -2.0, 2.0,
            prior=ParameterPrior(0.0, 0.05, "chosen: a tool set to 0.1 mm of diameter"),
            keyword="error_mm", starts=(-0.1, 0.05, 0.3),
        ),
    ),
    modifies=CUTTING,
    needs=("cutting.depth",),
    statement="Every cut was deeper or shallower than programmed by the same amount.",
    excited_by="the same feed at the smallest and the largest depth, and a micrometer on the work",
    source="by construction (force ∝ depth)",
    alike=("nose_radius",),
    distinguished_by="Measure the diameter before and after one cut: a depth error is there, a "
    "nose's is not. All components have a depth error, the tangential one has no nose.",
    check="Check tool length and wear offset, the zero of the work and the size of the blank; a "
    "real depth off by a constant shows most in shallow cuts, and the size after a pass tells it.",
    check_source="P1 section 1 (geometric, thermal and force-induced errors)",
    sits=("tool", "machine"),
)  # fmt: skip
DEFLECTION = Factor(
    name="deflection",
    title="bending of the tool",
    channels=("cuts",),
    inputs=("normal_force", "depth"),
    function=deflection,
    shape=(
        TermParameter(
            "compliance", "mm/N", "distance that tool and work give per force", 0.0, 0.01,
            prior=ParameterPrior(1e-4, 2e-4, "chosen: 10 N/µm, a bar of usual overhang"),
            keyword="compliance_mm_N", starts=(1e-5, 1e-4, 1e-3),
        ),
    ),
    modifies=CUTTING,
    needs=("cutting.depth",),
    statement="Tool or work springs away: the harder the cut, the less of its depth is cut.",
    excited_by="the same cut at two overhangs, and a micrometer on the work",
    source="physics of a spring between tool and work",
    alike=("size_effect",),
    distinguished_by="Repeat the cuts with a shorter overhang: bending goes, the size "
    "effect stays.",
    check="Check overhang and clamping of tool and work; a force that falls behind as the load "
    "grows may be something that bends away, and the same cut with a shorter overhang or in two "
    "passes shows it.",
    check_source="P1 section 1; Altintas, Manufacturing Automation, 2nd ed. (2012), chapter 2",
    sits=("tool", "machine"),
)  # fmt: skip
