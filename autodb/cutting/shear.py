"""A chip is sheared off in a thin zone, and the edge rubs: forces per width of any edge element.

The five numbers of Armarego (P1 section 3) - shear stress τ, friction angle β, chip-length ratio r,
edge coefficients K_te, K_re - and how they go with speed, chip thickness and rake:

    τ = τ_0 (v/v_0)^e_τ (h/h_0)^a_τ      tan β = tan β_0 (v/v_0)^e_β (h/h_0)^a_β exp(s_β α)
    r = r_0 (v/v_0)^e_r (h/h_0)^a exp(s_r α)      K_te, K_re ∝ 1 - exp(-h/h_e)

with v cutting speed [m/min], h uncut chip thickness [mm], α normal rake [rad]. r ∝ h^a is that of
Budak, Altintas and Armarego 1996; what goes with speed, the other exponents in thickness and the
edge's force that fades under chips as thin as the edge is round (h_e) are ours: the law has none
of them, cuts say how large they are, and all may be nought. They are of tan β, the coefficient of
friction, because β itself would go beyond 90°.

An oblique edge with inclination i, chip flow η = c_η i (Stabler: c_η = 1), r and β taken at the
normal rake:

    tan φ = r cos α / (1 - r sin α)    tan β_n = tan β cos η
    D = √(cos²(φ + β_n - α) + tan² η sin² β_n)
    K_tc = τ/sin φ · (cos(β_n - α) + tan i tan η sin β_n) / D
    K_rc = τ/(sin φ cos i) · sin(β_n - α) / D
    K_ac = τ/sin φ · (cos(β_n - α) tan i - tan η sin β_n) / D

    F_t = (K_tc h + K_te) b    F_r = (K_rc h + K_re) b    F_a = (K_ac h + K_ae) b

F_t along the work's velocity at the edge, F_r away from the work across the edge, F_a along the
edge against the way that the work moves along it, on the tool; b = edge length · cos i [mm]. An
orthogonal edge is i = 0. Checked against the resolution of vectors in the tests. Valid for
continuous chips.

At φ + β_n - α = 90° a force would be infinite that no chip ever asked for. Exponents that were
learnt from thicker chips or other speeds lead there, so that below D_0 D is (D² + D_0²)/(2 D_0):
it goes on as steep as it was, and ends at D_0/2.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Values = NDArray[Any]
"""Real, or complex where a derivative is taken by a step along the imaginary axis."""

SPEED_M_MIN = 100.0
"""v_0: a round speed for steel."""
THICKNESS_MM = 0.1
"""h_0: between the chips of milling and of turning."""
THINNEST_MM = 0.01
"""Thinner chips have this one's r, τ and β: an edge is round, and nothing was measured below.
Chosen."""
LEAST_D = 0.1
"""D_0: φ + β_n - α of 84°. Chosen: far beyond what is measured of continuous chips."""
NOUGHT = 1e-16
"""Added to D², so that nothing is divided by nought."""
STEP = 1e-30
"""Step along the imaginary axis: no difference is taken, so that it may be as small as this."""


def _plain(value: Array) -> Array:
    return value


def _log_tan(angle_deg: Array) -> Array:
    return np.log(np.tan(np.radians(angle_deg)))


def _angle_deg(log_tan: Array) -> Array:
    return np.degrees(np.arctan(np.exp(log_tan)))


@dataclass(frozen=True)
class LawParameter:
    """A number of the law: its name, its unit, what it says.

    ``inner`` makes the law's coordinate, which may be any number, of a value in the unit; ``outer``
    the value of a coordinate; ``coordinate`` says which it is.
    """

    name: str
    unit: str
    meaning: str
    inner: Callable[[Array], Array] = _plain
    outer: Callable[[Array], Array] = _plain
    coordinate: Literal["plain", "ln", "ln tan"] = "plain"

    def inside(self, value: Array | float) -> Array:
        """Return a value in its unit as the law's coordinate."""
        return np.asarray(self.inner(np.asarray(value, dtype=np.float64)))

    def outside(self, coordinate: Array | float) -> Array:
        """Return the law's coordinate as a value in its unit."""
        return np.asarray(self.outer(np.asarray(coordinate, dtype=np.float64)))


def _positive(name: str, unit: str, meaning: str) -> LawParameter:
    return LawParameter(name, unit, meaning, np.log, np.exp, "ln")


PARAMETERS = (
    _positive("shear_stress", "MPa", "stress in the shear zone"),
    LawParameter(
        "friction_angle", "deg", "friction of the chip on the rake face",
        _log_tan, _angle_deg, "ln tan",
    ),
    _positive("chip_ratio", "1", "chip length over length cut"),
    _positive("K_te", "N/mm", "tangential force of the edge"),
    _positive("K_re", "N/mm", "thrust of the edge"),
    LawParameter("K_ae", "N/mm", "force of the edge along itself"),
    LawParameter("chip_ratio_thickness", "1", "exponent a of the chip ratio in thickness"),
    LawParameter("shear_stress_speed", "1", "exponent of the shear stress in speed"),
    LawParameter("friction_speed", "1", "exponent of the coefficient of friction in speed"),
    LawParameter("chip_ratio_speed", "1", "exponent of the chip ratio in speed"),
    LawParameter("friction_rake", "1/rad", "growth of the coefficient of friction with rake"),
    LawParameter("chip_ratio_rake", "1/rad", "growth of the chip ratio with rake"),
    LawParameter("chip_flow", "1", "share of a chip's thrust that has one direction for all of it"),
    LawParameter("shear_stress_thickness", "1", "exponent of the shear stress in thickness"),
    LawParameter("friction_thickness", "1", "exponent of the coefficient of friction in thickness"),
    LawParameter("flow_angle", "1", "angle of the chip's flow over the inclination (Stabler: 1)"),
    _positive("edge_mm", "mm", "chip at which two thirds of the edge's force act"),
)  # fmt: skip
NAMES = tuple(parameter.name for parameter in PARAMETERS)
(
    TAU, BETA, RATIO, EDGE_T, EDGE_R, EDGE_A,
    RATIO_H, TAU_V, BETA_V, RATIO_V, BETA_RAKE, RATIO_RAKE, FLOW, TAU_H, BETA_H, ETA, EDGE_H,
) = range(len(PARAMETERS))  # fmt: skip


@dataclass(frozen=True)
class Edge:
    """How elements of an edge meet the work: arrays that broadcast to one shape (m,).

    ``thickness_mm`` uncut chip, ``rake_rad`` normal rake, ``inclination_rad``.
    """

    thickness_mm: Array
    speed_m_min: Array
    rake_rad: Array
    inclination_rad: Array

    # Worked out once: a law is learnt by hundreds of steps at the same edge
    @cached_property
    def thick(self) -> Array:
        """Return the logarithm of the thickness over the one that the law's numbers are of."""
        return np.log(np.maximum(self.thickness_mm, THINNEST_MM) / THICKNESS_MM)

    @cached_property
    def fast(self) -> Array:
        """Return the logarithm of the speed over the one that the law's numbers are of."""
        return np.log(self.speed_m_min / SPEED_M_MIN)

    @cached_property
    def rake(self) -> tuple[Array, Array]:
        """Return the rake's sine and cosine."""
        return np.sin(self.rake_rad), np.cos(self.rake_rad)

    @cached_property
    def inclination(self) -> tuple[Array, Array]:
        """Return the inclination's tangent and cosine."""
        return np.tan(self.inclination_rad), np.cos(self.inclination_rad)


def law_coordinates(values: dict[str, float]) -> Array:
    """Return the law's coordinates (p,) of values by name and in their units."""
    return np.array([float(p.inside(values[p.name])) for p in PARAMETERS])


def law_values(coordinates: Array) -> dict[str, float]:
    """Return the values by name, in their units, of the law's coordinates (p,)."""
    return {p.name: float(p.outside(c)) for p, c in zip(PARAMETERS, coordinates, strict=True)}


def chip_ratio(theta: Values, edge: Edge) -> Values:
    """Return the chip ratio r of elements (m,)."""
    of_cut = theta[RATIO] + theta[RATIO_V] * edge.fast + theta[RATIO_RAKE] * edge.rake_rad
    ratio: Values = np.exp(of_cut + theta[RATIO_H] * edge.thick)
    return ratio


@dataclass(frozen=True)
class Zone:
    """The shear zone of elements (m,): what their coefficients are worked out of.

    ``thick`` and ``fast``: logarithms of thickness and speed over those that the law's numbers are
    of; ``rake`` and ``inclination``: (sine, cosine) and (tangent, cosine). With η the angle of the
    chip's flow, p = tan φ, t = tan β_n, c = cos α + t sin α and s = t cos α - sin α the cosines of
    β_n and φ cancel: ``tan_friction`` t, ``sideways`` tan η t, ``along`` c, ``off`` s, ``straight``
    1 - r sin α, ``tan_phi`` p, ``secant`` 1 + p², ``ahead`` c - p s and

        sin φ D = p √``square`` / (1 + p²)    square = (c - p s)² + (1 + p²) tan²η t²

    each of c, s, D over cos β_n; ``strength`` τ / (sin φ D). ``slowed``: ∂ ln D/∂ ln D of what D
    is below D_0 by what it would be; None where all are above.
    """

    thick: Array
    fast: Array
    rake: tuple[Array, Array]
    inclination: tuple[Array, Array]
    tan_friction: Values
    sideways: Values
    along: Values
    off: Values
    straight: Values
    tan_phi: Values
    secant: Values
    ahead: Values
    square: Values
    strength: Values
    slowed: Values | None

    def directed(
        self, along: Values, off: Values, sideways: Values
    ) -> tuple[Values, Values, Values]:
        """Return what acts tangential, as thrust and along the edge, of such c, s and tan η t."""
        tan_i, cos_i = self.inclination
        return along + tan_i * sideways, off / cos_i, along * tan_i - sideways


def zone(theta: Values, edge: Edge) -> Zone:
    """Return the shear zone of elements (m,) for the law's coordinates (p,)."""
    thick, fast = edge.thick, edge.fast
    stress = np.exp(theta[TAU] + theta[TAU_V] * fast + theta[TAU_H] * thick)
    of_cut = theta[BETA] + theta[BETA_V] * fast + theta[BETA_RAKE] * edge.rake_rad
    friction = np.exp(of_cut + theta[BETA_H] * thick)
    flow = theta[ETA] * edge.inclination_rad
    tan_friction, sideways = friction * np.cos(flow), friction * np.sin(flow)
    sin, cos = edge.rake
    along, off = cos + tan_friction * sin, tan_friction * cos - sin

    ratio = chip_ratio(theta, edge)
    straight = 1.0 - ratio * sin
    tan_phi = ratio * cos / straight
    secant = 1.0 + tan_phi * tan_phi
    ahead = along - tan_phi * off
    square = ahead * ahead + secant * (sideways * sideways) + NOUGHT
    strength = stress * secant / (tan_phi * np.sqrt(square))
    slowed = None
    steep = square / ((1.0 + tan_friction * tan_friction) * secant)
    below = steep.real < LEAST_D**2
    if below.any():
        sum_of_squares = np.where(below, steep + LEAST_D**2, 2.0 * LEAST_D**2)
        slowed = np.where(below, 2.0 * steep / sum_of_squares, 1.0)
        strength = strength * np.where(below, 2.0 * LEAST_D * np.sqrt(steep) / sum_of_squares, 1.0)
    return Zone(
        thick=thick,
        fast=fast,
        rake=(sin, cos),
        inclination=edge.inclination,
        tan_friction=tan_friction,
        sideways=sideways,
        along=along,
        off=off,
        straight=straight,
        tan_phi=tan_phi,
        secant=secant,
        ahead=ahead,
        square=square,
        strength=strength,
        slowed=slowed,
    )


def chip_coefficients(theta: Values, edge: Edge) -> tuple[Values, Values, Values]:
    """Return K_tc, K_rc, K_ac, N/mm², of elements (m,) for the law's coordinates (p,)."""
    there = zone(theta, edge)
    strength = there.strength
    return there.directed(strength * there.along, strength * there.off, strength * there.sideways)


def per_width(theta: Values, edge: Edge) -> tuple[Values, Values, Values]:
    """Return F_t, F_r, F_a over the width, N/mm, of elements (m,)."""
    shear_t, shear_r, shear_a = chip_coefficients(theta, edge)
    h = edge.thickness_mm
    edge_t, edge_r, edge_a = edge_coefficients(theta, edge)
    return shear_t * h + edge_t, shear_r * h + edge_r, shear_a * h + edge_a


def edge_coefficients(theta: Values, edge: Edge) -> tuple[Values, Values, Values]:
    """Return K_te, K_re, K_ae, N/mm, of elements (m,): what of them acts at their chips."""
    rubs = -np.expm1(-edge.thickness_mm * np.exp(-theta[EDGE_H]))
    return np.exp(theta[EDGE_T]) * rubs, np.exp(theta[EDGE_R]) * rubs, theta[EDGE_A] * rubs


def gradient(function: Callable[[Values], Values], theta: Array, *, axes: int) -> Array:
    """Return the derivatives of values with ``axes`` axes by the coordinates, in front: (p, …).

    By a step of each coordinate along the imaginary axis, all steps at once, exact to rounding: the
    function must be analytic, and take coordinates (p, …) that each have axes in front of its own.
    """
    return np.imag(function(stepped(theta, axes=axes))) / STEP


def stepped(theta: Array, *, axes: int) -> Values:
    """Return coordinates (p, p, …), the last ``axes`` of length 1: each stepped in its own row."""
    each = theta[:, None] + 1j * STEP * np.eye(len(theta))
    return each.reshape(len(theta), len(theta), *(1,) * axes)
