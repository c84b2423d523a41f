"""Plain least squares beside autodb: Kienzle's line in logarithms, with its usual interval.

    log F = c + log b + (1 - m) log h [+ e log v],  b = a_p / sin κ,  h = f sin κ

for the feed, tangential and passive force, each by itself, as for a straight edge (κ as stated,
else 90°). The interval of a next cut is that of a line, as textbooks have it: Student's t,
s √(1 + x (XᵀX)⁻¹ xᵀ), s of the residuals; what it makes of the force is asymmetric. In faces and
tapers the forces along and across the path are turned into x and z. What was not read is not
predicted. A reading below its noise counts as its noise. Source: Kienzle 1952.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.lathe.law_pairs import path_forces_N
from autodb.proofs.machines.lathe.power_pairs import TurnedCut
from autodb.proofs.runs.pairs.laws_case import LawsCase
from autodb.proofs.runs.score import LEVEL

Array = NDArray[np.float64]

ROLES = {2: "feed", 1: "tangential", 0: "passive"}
"""What the components are in turning along the axis."""
USUAL_KAPPA_DEG = 90.0
NO_SHARE = 1e-9
"""Share of a force along the path that is rounding."""


@dataclass(frozen=True)
class LineForces:
    """What is expected of forces (m, 3), and the ends of their 95 % intervals; NaN: not told."""

    value: Array
    low: Array
    high: Array


def kienzle_squares(case: LawsCase, *, speed: bool) -> LineForces:
    """Return what Kienzle's lines through a case's cuts say; ``speed``: with a power of it."""
    design = _design(case, case.cuts, speed=speed)
    asked = _design(case, case.asked, speed=speed)
    noise = case.pair.noise_N
    told = {}
    for k, component in enumerate(case.read):
        log_N = np.log(np.maximum(case.read_N[:, k], noise[component]))
        told[ROLES[component]] = line_through(design, log_N - _log_width(case, case.cuts), asked)
    each = [
        _turned(told, cut, place, float(width))
        for place, (cut, width) in enumerate(
            zip(case.asked, _log_width(case, case.asked), strict=True)
        )
    ]
    return LineForces(*np.moveaxis(np.array(each), 1, 0))


def _kappa_rad(case: LawsCase, cut: TurnedCut) -> float:
    if not case.pair.stated:
        return math.radians(USUAL_KAPPA_DEG)
    return case.pair.tool.entering_rad(cut.inward_deg)


def _log_width(case: LawsCase, cuts: tuple[TurnedCut, ...]) -> Array:
    return np.log([cut.depth_mm / math.sin(_kappa_rad(case, cut)) for cut in cuts])


def _design(case: LawsCase, cuts: tuple[TurnedCut, ...], *, speed: bool) -> Array:
    """Return the columns (n, 2 or 3) of a line."""
    h = np.log([cut.feed_mm * math.sin(_kappa_rad(case, cut)) for cut in cuts])
    columns = [np.ones(len(cuts)), h]
    if speed:
        columns.append(np.log([cut.speed_m_min for cut in cuts]))
    return np.column_stack(columns)


def line_through(design: Array, values: Array, asked: Array) -> Array:
    """Return middles of a line at other rows, and the half-widths of its intervals: (2, m).

    Rows that do not determine the line leave intervals without end.
    """
    from scipy.stats import t

    found, _, rank, _ = np.linalg.lstsq(design, values)
    free = len(values) - design.shape[1]
    if rank < design.shape[1]:
        return np.stack([asked @ found, np.full(len(asked), np.inf)])
    scatter = math.sqrt(float(np.sum((values - design @ found) ** 2)) / free)
    leverage = np.einsum("ni,ij,nj->n", asked, np.linalg.inv(design.T @ design), asked)
    half = float(t.ppf(0.5 * (1.0 + LEVEL), free)) * scatter * np.sqrt(1.0 + leverage)
    return np.stack([asked @ found, half])


def _turned(told: dict[str, Array], cut: TurnedCut, place: int, log_width: float) -> Array:
    """Return middle, low and high (3, 3) of force x, y, z of one cut.

    Where feed and passive force both are in a component, their half-widths add in squares.
    """
    roles = ("feed", "tangential", "passive")
    unknown = np.full((3, 3), math.nan)
    for k, role in enumerate(roles):
        if role in told:
            line, half = told[role][:, place]
            unknown[k] = np.exp(line + log_width + np.array([0.0, -half, half]))
    middle, low, high = unknown.T
    each = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    shares = np.array([path_forces_N(*one, cut.inward_deg) for one in each])
    shares = np.where(np.abs(shares) < NO_SHARE, 0.0, shares)
    down, up = (middle - low)[:, None], (high - middle)[:, None]
    value = _sum(shares, middle[:, None])
    below = _sum(shares**2, np.where(shares > 0.0, down, up) ** 2)
    above = _sum(shares**2, np.where(shares > 0.0, up, down) ** 2)
    return np.array([value, value - np.sqrt(below), value + np.sqrt(above)])


def _sum(shares: Array, values: Array) -> Array:
    """Return sums over roles of shares (roles, components), NaN where one that has a share is."""
    return np.asarray(np.sum(np.where(shares == 0.0, 0.0, shares * values), axis=0))
