"""Three laws of a turning edge, none of which is autodb's: forces per width over chip and speed.

    Kienzle      tangential, thrust and force along the edge: powers of the chip's thickness h, each
                 with its own exponent, and one power of the speed (Kienzle 1952)
    linear edge  K h ((h + h_s) / (h_0 + h_s))^-m: a specific force that saturates under thin chips,
                 and falls by a share with the logarithm of the speed
    shear        a shear zone at the angle of least work, φ = π/4 - (β - α)/2 (Merchant 1945), under
                 friction that falls with speed to what is left of it, tan β = μ + μ_1 e^(-v/v_1);
                 both are raised by 1 + A e^(-h/h_e) where chips are thin

Each has a size exponent m_c, of the specific tangential force from 0.08 to 0.4 mm, and an edge
force, K_te and K_re per width, or none. The chip's force across the cutting speed acts across each
place of the edge (Kienzle), across its chord (linear edge: Colwell 1954), or in the mean direction
of the chip's area (shear: Young, Mathew and Oxley 1987); the edge's own acts across each place.

On an edge inclined by λ_s (ISO 3002-1: negative, where the tip is the last to meet the work) the
rake face is turned about the normal of the edge. Its pressure N and its friction F, along the chip
that flows at λ_s (Stabler 1951), push the tool away from the work where λ_s is negative.

Numbers are chosen: 2500 N/mm² at 0.2 mm is a little less than Röhm's RN-1391, table 2, has for C45
(2800 at 0.18 mm); edge forces are about those that Budak, Altintas and Armarego 1996 give for a
titanium alloy.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CHIP_AT_MM = 0.2
"""h_0, where a law's size is stated."""
MIDDLE_M_MIN = 150.0
THIN_MM, THICK_MM = 0.08, 0.4
"""Chips that the size exponent is between."""
SCALE = 0.25
"""Spread of sizes, in logarithms: of forces, of the edge's forces, of thicknesses and speeds."""
OPEN_EXPONENT = 0.1
"""Spread of the size exponents: about that of 0.1, 0.25 and 0.35."""
STEEPER = 0.1
"""By what the thrust's exponent is above the tangential force's, and its spread."""


@dataclass(frozen=True)
class WidthForces:
    """Forces per width, N/mm (m,): of the chip along the speed, across the edge, along the edge
    away from the tip; then of the edge along the speed and across it.
    """

    tangential: Array
    thrust: Array
    along: Array
    edge_tangential: Array
    edge_thrust: Array


@dataclass(frozen=True)
class Slants:
    """How the rake face lies: normal rake and inclination λ_s, rad."""

    rake_rad: float
    inclination_rad: float


PerWidth = Callable[[dict[str, float], Array, float, Slants], tuple[Array, Array, Array]]
Weights = Callable[[Array, Array], Array | None]


@dataclass(frozen=True)
class EdgeLaw:
    """A law: its numbers' names, what is expected of them and their spreads (k,).

    Those whose name begins with ``ln`` are logarithms. ``m_c`` and the edge's forces are drawn
    apart. ``chip`` gives the chip's forces per width; ``flow`` the weights of places by which the
    chip's direction is a mean; None: each place has its own.
    """

    name: str
    names: tuple[str, ...]
    expected: tuple[float, ...]
    spread: tuple[float, ...]
    chip: PerWidth
    flow: Weights

    def per_width(
        self, numbers: dict[str, float], h_mm: Array, speed_m_min: float, slants: Slants
    ) -> WidthForces:
        """Return the forces of places whose chip is ``h_mm`` (m,) thick."""
        tangential, thrust, along = self.chip(numbers, h_mm, speed_m_min, slants)
        there = np.where(h_mm > 0.0, 1.0, 0.0)
        return WidthForces(
            tangential, thrust, along, numbers["K_te"] * there, numbers["K_re"] * there
        )


def _kienzle(
    n: dict[str, float], h_mm: Array, speed_m_min: float, slants: Slants
) -> tuple[Array, Array, Array]:
    """Return powers of the thickness; along the edge for an inclination as it was measured at."""
    soft = (speed_m_min / MIDDLE_M_MIN) ** n["speed"]
    thin = h_mm / CHIP_AT_MM

    def power(size: str, exponent: float) -> Array:
        return np.asarray(math.exp(n[size]) * CHIP_AT_MM * thin ** (1.0 - exponent) * soft)

    inclined = -math.tan(slants.inclination_rad)
    return (
        power("ln tangential", n["m_c"]),
        power("ln thrust", n["m_c"] + n["steeper"]),
        inclined * power("ln along", n["m_c"] + n["steeper along"]),
    )


def _linear(
    n: dict[str, float], h_mm: Array, speed_m_min: float, slants: Slants
) -> tuple[Array, Array, Array]:
    """Return specific forces that saturate under thin chips."""
    shift = math.exp(n["ln saturates_mm"])
    soft = 1.0 - n["softening"] * math.tanh(math.log(speed_m_min / MIDDLE_M_MIN))
    thin = (h_mm + shift) / (CHIP_AT_MM + shift)
    tangential = math.exp(n["ln tangential"]) * h_mm * thin ** -n["m_c"] * soft
    thrust = math.exp(n["ln thrust"]) * h_mm * thin ** -(n["m_c"] + n["steeper"]) * soft
    return tangential, thrust, -math.tan(slants.inclination_rad) * (tangential - thrust)


def _shear(
    n: dict[str, float], h_mm: Array, speed_m_min: float, slants: Slants
) -> tuple[Array, Array, Array]:
    """Return the rake face's pressure and friction along the speed, across and along the edge."""
    friction = math.exp(n["ln friction"])
    friction += math.exp(n["ln friction falls"] - speed_m_min / math.exp(n["ln falls_m_min"]))
    beta, alpha, incl = math.atan(friction), slants.rake_rad, slants.inclination_rad
    phi = 0.25 * math.pi - 0.5 * (beta - alpha)
    whole = math.exp(n["ln shear"]) / (math.sin(phi) * math.cos(phi + beta - alpha))
    whole_mm = whole * h_mm * _thin(h_mm, n["m_c"], math.exp(n["ln thin_mm"]))
    pressure, rubs = whole_mm * math.cos(beta), whole_mm * math.sin(beta)

    # The face's directions: upright to the edge, and down the face; the chip flows at λ_s
    upright, down = (math.cos(alpha), math.sin(alpha)), math.cos(incl)
    across_edge = pressure * upright[0] + rubs * upright[1] * down
    along_edge = rubs * math.sin(incl)
    return (
        across_edge * math.cos(incl) + along_edge * math.sin(incl),
        rubs * upright[0] * down - pressure * upright[1],
        along_edge * math.cos(incl) - across_edge * math.sin(incl),
    )


def _thin(h_mm: Array, exponent: float, scale_mm: float) -> Array:
    """Return 1 + A e^(-h/h_e), over that at h_0; from THIN_MM to THICK_MM it falls as h^-m."""
    fall = (THICK_MM / THIN_MM) ** exponent
    thin, thick = math.exp(-THIN_MM / scale_mm), math.exp(-THICK_MM / scale_mm)
    raised = (fall - 1.0) / (thin - fall * thick)
    at = 1.0 + raised * math.exp(-CHIP_AT_MM / scale_mm)
    return np.asarray((1.0 + raised * np.exp(-h_mm / scale_mm)) / at)


KIENZLE = EdgeLaw(
    "Kienzle",
    ("ln tangential", "ln thrust", "ln along", "steeper", "steeper along", "speed"),
    (math.log(2500.0), math.log(1100.0), math.log(1500.0), 0.15, 0.1, -0.07),
    (SCALE, SCALE, SCALE, STEEPER, STEEPER, 0.05),
    _kienzle,
    lambda _, __: None,
)
LINEAR_EDGE = EdgeLaw(
    "linear edge",
    ("ln tangential", "ln thrust", "ln saturates_mm", "steeper", "softening"),
    (math.log(2500.0), math.log(1100.0), math.log(0.02), STEEPER, 0.05),
    (SCALE, SCALE, SCALE, STEEPER, 0.05),
    _linear,
    lambda _, width_mm: width_mm,
)
SHEAR = EdgeLaw(
    "shear",
    ("ln shear", "ln friction", "ln friction falls", "ln falls_m_min", "ln thin_mm"),
    (math.log(650.0), math.log(0.4), math.log(0.35), math.log(120.0), math.log(0.15)),
    (SCALE, SCALE, SCALE, SCALE, 0.2),
    _shear,
    lambda h_mm, width_mm: h_mm * width_mm,
)
EDGE_LAWS = (KIENZLE, LINEAR_EDGE, SHEAR)
SIZE_EXPONENTS = (0.35, 0.25, 0.1)
EDGE_NUMBERS = ("K_te", "K_re")
EDGE_N_MM = (25.0, 40.0)
"""K_te and K_re, where there is an edge force."""
