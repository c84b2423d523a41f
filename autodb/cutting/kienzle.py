"""Planners' views of one law: Kienzle's two numbers and the linear edge's, with their errors.

Kienzle: specific tangential force k_c = F_t/(b h) = k_c1.1 h^-m_c, h in mm, k_c1.1 in N/mm². Linear
edge: F_t = K_tc h b + K_te b, and so for the thrust. Both are lines fitted to the law's own force
over a range of chip thickness, the first in logarithms, so that they change with the posterior
of the law; how far the law is off the line in that range is given too.
Source: Kienzle 1952.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import shear
from autodb.cutting.shear import Edge, Values
from autodb.fitting.gaussian import Gaussian

Array = NDArray[np.float64]

NODES = 12


@dataclass(frozen=True)
class ViewRange:
    """Where a view is taken: range of chip thickness, cutting speed, normal rake."""

    thinnest_mm: float = 0.05
    thickest_mm: float = 0.4
    speed_m_min: float = 100.0
    rake_rad: float = 0.0

    @property
    def edge(self) -> Edge:
        """An orthogonal edge at chips spread evenly in the logarithm of thickness."""
        chips = np.geomspace(self.thinnest_mm, self.thickest_mm, NODES)
        one = np.ones(1)
        return Edge(chips, self.speed_m_min * one, self.rake_rad * one, 0.0 * one)


@dataclass(frozen=True)
class View:
    """Numbers by name (k,), their posterior, and the largest share the view is off by."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    posterior: Gaussian
    off: float


def kienzle(posterior: Gaussian, at: ViewRange) -> View:
    """Return k_c1.1 and m_c of a posterior about the law's coordinates (p,)."""
    design = np.column_stack([np.ones(NODES), -np.log(at.edge.thickness_mm)])

    def fitted(theta: Values) -> Values:
        specific = shear.per_width(theta, at.edge)[0] / at.edge.thickness_mm
        line = np.log(specific) @ np.linalg.pinv(design).T
        return np.stack([np.exp(line[..., 0]), line[..., 1]], axis=-1)

    tangential = shear.per_width(posterior.mean, at.edge)[0] / at.edge.thickness_mm
    number = fitted(posterior.mean)
    off = number[0] * at.edge.thickness_mm ** -number[1] / tangential - 1.0
    return _view(("k_c1.1", "m_c"), ("N/mm²", "1"), fitted, posterior, off)


def linear_edge(posterior: Gaussian, at: ViewRange) -> View:
    """Return K_tc, K_te, K_rc, K_re of a posterior about the law's coordinates (p,)."""
    design = np.column_stack([at.edge.thickness_mm, np.ones(NODES)])

    def fitted(theta: Values) -> Values:
        inverse = np.linalg.pinv(design).T
        tangential, thrust, _ = shear.per_width(theta, at.edge)
        return np.concatenate([tangential @ inverse, thrust @ inverse], axis=-1)

    number = fitted(posterior.mean)
    tangential, thrust, _ = shear.per_width(posterior.mean, at.edge)
    off = np.append(design @ number[:2] / tangential, design @ number[2:] / thrust) - 1.0
    units = ("N/mm²", "N/mm", "N/mm²", "N/mm")
    return _view(("K_tc", "K_te", "K_rc", "K_re"), units, fitted, posterior, off)


def _view(
    names: tuple[str, ...], units: tuple[str, ...], fitted: object, posterior: Gaussian, off: Values
) -> View:
    assert callable(fitted)
    slope = shear.gradient(fitted, posterior.mean, axes=1).T
    number = np.real(fitted(posterior.mean))
    covariance = slope @ posterior.covariance @ slope.T
    return View(names, units, Gaussian(number, covariance), float(np.max(np.abs(off))))
