"""How friction and ripples may deviate from their laws: groups of smooth columns beside the model.

Each group is free of what the laws say already, so that a law's parameters are those of its best
approximation over even speeds, whatever time was spent at which: two recordings agree on them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from autodb.terms.channel import Part, columns
from autodb.terms.drive import cogging

Array = NDArray[np.float64]
Inputs = Mapping[str, Array]

OVER_SPEED = frozenset({"coulomb", "viscous", "stribeck", "asymmetry"})
"""Friction that is a function of speed and direction alone."""
FINE_MM_S = 0.1
"""Speed below which the fine columns are even in speed, above in its logarithm."""
FINE_COLUMNS, EVEN_COLUMNS = 12, 16
EVEN_SPEEDS = 200
"""Speeds at which a law is compared with the columns."""
HARMONICS = (2, 3)
"""Harmonics of a ripple that its law, one sinusoid, leaves out."""


@dataclass(frozen=True)
class Group:
    """Columns (n, k) of inputs; ``over_speed``: part of friction over speed."""

    columns: Callable[[Inputs], Array]
    over_speed: bool


def rubs(part: Part) -> bool:
    """Say whether a part is friction over speed."""
    return part.term.name in OVER_SPEED


def deviation_groups(
    parts: tuple[Part, ...], *, highest_mm_s: float, travel_mm: tuple[float, float]
) -> list[Group]:
    """Return the groups by which an axis of these parts may deviate; none without a friction law.

    Friction over speed, alike in both directions; by direction where the model has that; its
    reversal along the travel where friction changes along it; harmonics of a ripple.
    """
    law = tuple(part for part in parts if rubs(part))
    names = {part.term.name for part in law}
    if not {"coulomb", "viscous"} <= names or highest_mm_s <= 0:
        return []
    bases = (_fine(highest_mm_s), _even(highest_mm_s))
    groups = [_over_speed(law, np.asarray, basis, highest_mm_s) for basis in bases]
    if "asymmetry" in names:
        groups += [_over_speed(law, np.abs, basis, highest_mm_s) for basis in bases]
    for part in parts:
        if part.term.name == "position_friction" and not part.term.form:
            groups.append(_along_travel(_fine(highest_mm_s), highest_mm_s, travel_mm))
        elif "period" in part.shape:
            groups.append(_harmonics(part))
    return groups


def _over_speed(
    law: tuple[Part, ...],
    sense: Callable[[Array], Array],
    basis: Callable[[Array], Array],
    highest_mm_s: float,
) -> Group:
    """Return sense(direction) · basis(|v|), less what of it the law says."""
    speeds = _even_speeds(highest_mm_s)
    both = np.concatenate([-speeds, speeds])
    grid = {"velocity": both, "direction": np.sign(both)}
    smooth = sense(grid["direction"])[:, None] * basis(both)
    taken = np.linalg.lstsq(columns(law, grid), smooth, rcond=1e-10)[0]

    def made(inputs: Inputs) -> Array:
        turned = sense(inputs["direction"])[:, None] * basis(inputs["velocity"])
        return np.asarray(turned - columns(law, inputs) @ taken, dtype=np.float64)

    return Group(made, over_speed=True)


def _along_travel(
    basis: Callable[[Array], Array], highest_mm_s: float, travel_mm: tuple[float, float]
) -> Group:
    """Return direction · basis(|v|) · place, place −1 to 1 along the travel, 0 on the mean."""
    mean = basis(_even_speeds(highest_mm_s)).mean(axis=0)
    low, high = travel_mm

    def made(inputs: Inputs) -> Array:
        place = 2.0 * (inputs["position"] - low) / (high - low) - 1.0
        turned = (inputs["direction"] * place)[:, None]
        return np.asarray(turned * (basis(inputs["velocity"]) - mean), dtype=np.float64)

    return Group(made, over_speed=False)


def _harmonics(part: Part) -> Group:
    flips = "direction" in part.term.inputs

    def made(inputs: Inputs) -> Array:
        waves = [cogging(inputs["position"], period_mm=part.shape["period"] / k) for k in HARMONICS]
        sense = inputs["direction"] if flips else np.ones_like(inputs["position"])
        return np.column_stack(waves) * sense[:, None]

    return Group(made, over_speed=False)


def _even_speeds(highest_mm_s: float) -> Array:
    return np.linspace(highest_mm_s / EVEN_SPEEDS, highest_mm_s, EVEN_SPEEDS)


def _fine(highest_mm_s: float) -> Callable[[Array], Array]:
    top = float(np.log1p(highest_mm_s / FINE_MM_S))
    return lambda v: _spline(np.log1p(np.abs(v) / FINE_MM_S), top, FINE_COLUMNS)


def _even(highest_mm_s: float) -> Callable[[Array], Array]:
    return lambda v: _spline(np.abs(v), highest_mm_s, EVEN_COLUMNS)


def _spline(values: Array, high: float, count: int) -> Array:
    """Return ``count`` cubic B-splines over 0 to ``high`` with even knots, (n, count)."""
    inner = np.linspace(0.0, high, count - 2)[1:-1]
    knots = np.concatenate([[0.0] * 4, inner, [high] * 4])
    inside = np.clip(values, 0.0, high)
    return np.asarray(BSpline.design_matrix(inside, knots, 3).toarray(), dtype=np.float64)
