"""A material card: Kienzle's two numbers and where they hold, as a prior or of a posterior.

A card says k_c = k_c1.1 h^-m_c (h in mm) of an edge with a normal rake, at a speed, over a range of
chips. Read, it is where a posterior starts; made of a posterior, it is what the posterior says
there, with 95 % bounds, and so are the four coefficients of a linear edge
(`autodb.cutting.kienzle`).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.kienzle import View, ViewRange, kienzle, linear_edge
from autodb.errors import UnusableInput
from autodb.fitting.gaussian import NORMAL_95, Gaussian
from autodb.pairs.prior import CardForces
from autodb.wording import localized, phrase

Array = NDArray[np.float64]

UNIT = "N/mm²"
"""Of k_c1.1."""
SHAPE = 0.03
"""Share by which a material may be off its card from one chip to another. Chosen: over a card's
chips it leaves an exponent open by about ± 0.03."""

STEEPEST = 0.9
"""Largest exponent m_c: near 1 the force hardly grows with the chip, as of no metal. Chosen."""


@dataclass(frozen=True)
class Bounded:
    """A value with its 95 % bounds."""

    value: float
    lower: float
    upper: float


@dataclass(frozen=True)
class KienzleCard:
    """A material's k_c1.1 [N/mm²] and m_c, where they hold, and where they are from.

    ``m_c_bounds``: its 95 % bounds, None where the card does not say them.
    """

    material: str
    k_c11: Bounded
    m_c: float
    m_c_bounds: tuple[float, float] | None
    at: ViewRange
    source: str

    @property
    def card(self) -> CardForces:
        """Tangential force per width at the card's chips, off by k_c1.1's bounds at all alike."""
        chips = self.at.edge.thickness_mm
        shape = SHAPE if self.m_c_bounds is None else _shape(chips, self.m_c_bounds)
        return CardForces(
            thickness_mm=chips,
            tangential=self.k_c11.value * chips ** (1.0 - self.m_c),
            thrust=None,
            level=level_of_bounds(np.array([self.k_c11.lower]), np.array([self.k_c11.upper])),
            shape=shape,
            rake_rad=self.at.rake_rad,
            speed_m_min=self.at.speed_m_min,
        )


def level_of_bounds(lower: Array, upper: Array) -> float:
    """Return the standard deviation, a share, that 95 % bounds (k,) of forces leave them all.

    σ = mean ln(upper/lower) / (2 · 1.96): bounds of the logarithm, in which the posterior is
    normal.
    """
    return float(np.mean(np.log(upper / lower))) / (2.0 * NORMAL_95)


def _shape(chips_mm: Array, bounds: tuple[float, float]) -> float:
    """Return the share σ of each chip on its own that leaves an exponent open by its bounds.

    A line through chips with S = Σ (ln h - mean)² has a slope open by σ/√S.
    """
    logs = np.log(chips_mm)
    spread = float(np.sqrt(np.sum((logs - logs.mean()) ** 2)))
    return (bounds[1] - bounds[0]) / (2.0 * NORMAL_95) * spread


def kienzle_card(material: str, posterior: Gaussian, at: ViewRange, *, source: str) -> KienzleCard:
    """Return the card that a posterior about the law's coordinates makes.

    Raises UnusableInput where k_c grows with the chip there, which no card says.
    """
    numbers = _bounded(kienzle(posterior, at))
    m_c = numbers["m_c"]
    if not 0.0 <= m_c.value <= STEEPEST:
        raise UnusableInput(
            phrase(
                "'{material}': m_c is {value} over chips of {thinnest} to {thickest} mm; use "
                "chips for which it is 0 to {steepest}",
                material=material,
                value=localized(f"{m_c.value:.3g}"),
                thinnest=localized(f"{at.thinnest_mm:g}"),
                thickest=localized(f"{at.thickest_mm:g}"),
                steepest=localized(f"{STEEPEST:g}"),
            )
        )
    bounds = (m_c.lower, m_c.upper)
    return KienzleCard(material, numbers["k_c1.1"], m_c.value, bounds, at, source)


def linear_coefficients(posterior: Gaussian, at: ViewRange) -> dict[str, Bounded]:
    """Return K_tc, K_te, K_rc, K_re [N/mm², N/mm] that a posterior about the law makes."""
    return _bounded(linear_edge(posterior, at))


def _bounded(view: View) -> dict[str, Bounded]:
    """Return a view's numbers with 95 % bounds: those of the logarithm where it has a unit.

    A force is not negative however little is known of it; an exponent may be, and so may the
    intercept of a line, which then has the bounds of a plain number.
    """
    far = NORMAL_95 * np.sqrt(np.diag(view.posterior.covariance))
    numbers = {}
    for name, unit, value, off in zip(
        view.names, view.units, view.posterior.mean, far, strict=True
    ):
        v, d = float(value), float(off)
        sized = unit != "1" and v > 0.0
        low, high = (v * np.exp(-d / v), v * np.exp(d / v)) if sized else (v - d, v + d)
        numbers[name] = Bounded(v, float(low), float(high))
    return numbers
