"""How forces per width of an edge change with the law's coordinates: the chain rule.

Of a shear zone the coordinates change four numbers alone, each in proportion to what the law has it
go with, g a coordinate's factor:

    d ln τ = Σ g dθ    d ln tan β = Σ g dθ    d ln r = Σ g dθ    dη = i dθ
    g = 1, ln v/v_0, ln h/h_0 of all but η, and α of β and r

With the signs of ``shear.zone``, u = c - p s and Q = 1 + p², K = S d has

    ∂ ln S/∂ ln τ = 1
    ∂ ln S/∂ ln tan β = -(u t (sin α - p cos α) + Q a²)/(u² + Q a²)
    ∂ ln S/∂ ln r = (1 - 2/Q + p (u s - p a²)/(u² + Q a²))/(1 - r sin α)
    ∂ ln S/∂η = a (u (sin α - p cos α) - Q t)/(u² + Q a²)

Where D is below D_0, it is less steep by a factor w, and (1 - w) ∂ ln D is to be added, with

    ln D = ½ ln(u² + Q a²) - ½ ln(1 + t²) - ½ ln Q

a = t tan η, and its directions d change with β and η alone, as ∂t/∂η = -a and ∂a/∂η = t. Of the
edge's force K ∝ 1 - e^-z the fourth number is ln h_e, z = h/h_e: d(1 - e^-z)/d ln h_e = -z e^-z.
Checked against steps along the imaginary axis in the tests.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import shear
from autodb.cutting.shear import Edge

Array = NDArray[np.float64]

STRESS, FRICTION, RATIO, LEAN = range(4)
"""What the coordinates change of a shear zone: ln τ, ln tan β, ln r and η."""
AS_THEY_ARE = np.ones(1)
ORDER = (
    shear.TAU, shear.BETA, shear.RATIO, shear.TAU_V, shear.BETA_V, shear.RATIO_V,
    shear.TAU_H, shear.BETA_H, shear.RATIO_H, shear.BETA_RAKE, shear.RATIO_RAKE, shear.ETA,
    shear.EDGE_T, shear.EDGE_R, shear.EDGE_A, shear.EDGE_H,
)  # fmt: skip
"""Coordinates of the law in the order of what ``sheared`` and then ``rubbed`` are driven by."""


@dataclass(frozen=True)
class DrivenCoordinate:
    """Coordinates of the law that change one of four numbers each: ``which``, and how much.

    ``factor``: of a shape that broadcasts to the elements'.
    """

    which: slice
    factor: Array


@dataclass(frozen=True)
class Steep:
    """How forces of elements, tangential, thrust and along the edge, change with four numbers.

    ``by``: derivatives (4, m) of each; ``drives``: what changes the numbers.
    """

    by: tuple[Array, Array, Array]
    drives: tuple[DrivenCoordinate, ...]


OF_EDGE = (DrivenCoordinate(slice(4), AS_THEY_ARE),)


def sheared(theta: Array, edge: Edge, area_mm2: Array) -> Steep:
    """Return what shears chips of some cross-section, N: by ln τ, ln tan β, ln r and η."""
    zone = shear.zone(theta, edge)
    (sin, cos), t, a, p = zone.rake, zone.tan_friction, zone.sideways, zone.tan_phi

    # What is in front of the directions: its logarithm
    less = sin - p * cos
    sideways, ahead = zone.secant * a, zone.ahead * less
    by_friction = -(t * ahead + sideways * a) / zone.square
    by_lean = (a * ahead - sideways * t) / zone.square
    turned = p * (zone.ahead * zone.off - p * (a * a)) / zone.square
    by_ratio = (1.0 - 2.0 / zone.secant + turned) / zone.straight
    if zone.slowed is not None:
        more, cos_squared = 1.0 - zone.slowed, 1.0 / (1.0 + t * t)
        by_friction = by_friction - more * (by_friction + 1.0 - cos_squared)
        by_lean = by_lean - more * (by_lean - t * a * cos_squared)
        by_ratio = by_ratio - more * (turned + 1.0 - 1.0 / zone.secant) / zone.straight

    # With c, s and a, of which the directions are sums
    strength = zone.strength * area_mm2
    by = np.empty((3, 4, *strength.shape))
    whole, friction, lean = by[:, STRESS], by[:, FRICTION], by[:, LEAN]
    whole[0], whole[1], whole[2] = zone.along, zone.off, a
    friction[0], friction[1], friction[2] = t * sin, t * cos, a
    lean[0], lean[1], lean[2] = -a * sin, -a * cos, t
    friction += whole * by_friction
    lean += whole * by_lean
    np.multiply(whole, by_ratio, out=by[:, RATIO])
    by *= strength
    return Steep(zone.directed(by[0], by[1], by[2]), _drives(zone, edge))


def _drives(zone: shear.Zone, edge: Edge) -> tuple[DrivenCoordinate, ...]:
    """Return what changes ln τ, ln tan β, ln r and η."""
    return (
        DrivenCoordinate(slice(STRESS, LEAN), AS_THEY_ARE),
        DrivenCoordinate(slice(STRESS, LEAN), zone.fast),
        DrivenCoordinate(slice(STRESS, LEAN), zone.thick),
        DrivenCoordinate(slice(FRICTION, LEAN), edge.rake_rad),
        DrivenCoordinate(slice(LEAN, LEAN + 1), edge.inclination_rad),
    )


def rubbed(theta: Array, edge: Edge, width_mm: Array) -> Steep:
    """Return what rubs on edges of some widths, N: by ln K_te, ln K_re, K_ae and ln h_e."""
    thin = edge.thickness_mm * np.exp(-theta[shear.EDGE_H])
    rubs = -np.expm1(-thin) * width_mm
    full = np.exp(theta[shear.EDGE_T]), np.exp(theta[shear.EDGE_R]), theta[shear.EDGE_A]
    fades = thin * (rubs - width_mm)
    by = np.zeros((3, 4, *rubs.shape))
    for k, of_one in enumerate((full[0], full[1], 1.0)):
        np.multiply(of_one, rubs, out=by[k, k])
        np.multiply(full[k], fades, out=by[k, 3])
    return Steep((by[0], by[1], by[2]), OF_EDGE)
