"""How friction and ripples may deviate from their laws: groups of smooth columns beside the model.

Each group is free of what the laws say already, so that a law's parameters are those of its best
approximation over even speeds, whatever time was spent at which: two recordings agree on them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.terms.channel import ChannelPart, changed_inputs, channel_columns, factors
from autodb.terms.drive import COGGING, FRICTION_RIPPLE, cogging
from autodb.terms.friction import COULOMB
from autodb.terms.term import Contribution, Term

Array = NDArray[np.float64]
Inputs = Mapping[str, Array]

SPEED = frozenset({"velocity", "direction"})
"""Inputs of friction that speed and direction alone tell."""
FINE_MM_S = 0.1
"""Speed below which the fine columns are even in speed, above in its logarithm."""
FINE_COLUMNS, EVEN_COLUMNS = 12, 16
TRAVEL_COLUMNS = 40
"""Columns along the travel: friction may bend a dozen times. Chosen."""
EVEN_SPEEDS = 200
"""Speeds at which a law is compared with the columns."""
HARMONICS = (2, 3)
"""Harmonics of a ripple that its law, one sinusoid, leaves out."""


@dataclass(frozen=True)
class Group:
    """Columns (n, k) of inputs; ``over_speed``: part of friction over speed; ``rubs``: of friction,
    which warms and turns over a way, unlike a load.
    """

    columns: Callable[[Inputs], Array]
    over_speed: bool
    rubs: bool = True


def follows(term: Term, inputs: frozenset[str]) -> bool:
    """Say whether a term adds what some of these inputs are at the moment, and nothing else."""
    return isinstance(term, Contribution) and not term.remembers and inputs.issuperset(term.inputs)


def deviation_groups(
    parts: tuple[ChannelPart, ...], *, highest_mm_s: float, travel_mm: tuple[float, float]
) -> list[Group]:
    """Return the groups by which an axis of these parts may deviate; none without a friction law.

    Friction over speed, alike in both directions; by direction where the model has that; where
    friction changes along the travel, how that differs by speed, and bends; harmonics of a ripple.
    """
    law = tuple(part for part in parts if follows(part.term, SPEED))
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
            groups.append(_bent(travel_mm))
        elif part.term in (COGGING, FRICTION_RIPPLE):
            groups.append(_harmonics(part))
    return groups


def deviating(
    groups: Sequence[Group], parts: tuple[ChannelPart, ...], inputs: Inputs
) -> list[Array]:
    """Return the columns (n, k) of each group for a model of these parts.

    What turns over a way, warms or lags, does so with what friction deviates by.
    """
    now = changed_inputs(parts, inputs)
    warm = np.ones((1, 1))
    for factor in factors(parts, COULOMB, now):
        warm = warm * factor[:, None]
    return [group.columns(now) * (warm if group.rubs else 1.0) for group in groups]


def _over_speed(
    law: tuple[ChannelPart, ...],
    sense: Callable[[Array], Array],
    basis: Callable[[Array], Array],
    highest_mm_s: float,
) -> Group:
    """Return sense(direction) · basis(|v|), less what of it the law says."""
    speeds = _even_speeds(highest_mm_s)
    both = np.concatenate([-speeds, speeds])
    grid = {"velocity": both, "direction": np.sign(both)}
    smooth = sense(grid["direction"])[:, None] * basis(both)
    taken = np.linalg.lstsq(channel_columns(law, grid), smooth, rcond=1e-10)[0]

    def made(inputs: Inputs) -> Array:
        turned = sense(inputs["direction"])[:, None] * basis(inputs["velocity"])
        return np.asarray(turned - channel_columns(law, inputs) @ taken, dtype=np.float64)

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


def _bent(travel_mm: tuple[float, float]) -> Group:
    """Return direction · basis(place), less its straight line over even places."""
    low, high = travel_mm

    def basis(place: Array) -> Array:
        return _spline(place - low, high - low, TRAVEL_COLUMNS)

    even = np.linspace(low, high, EVEN_SPEEDS)
    line = np.polyfit(even, basis(even), 1)

    def made(inputs: Inputs) -> Array:
        place = inputs["position"]
        straight = np.multiply.outer(place, line[0]) + line[1]
        turned = inputs["direction"][:, None] * (basis(place) - straight)
        return np.asarray(turned, dtype=np.float64)

    return Group(made, over_speed=False)


def _harmonics(part: ChannelPart) -> Group:
    flips = "direction" in part.term.inputs

    def made(inputs: Inputs) -> Array:
        waves = [cogging(inputs["position"], period_mm=part.shape["period"] / k) for k in HARMONICS]
        sense = inputs["direction"] if flips else np.ones_like(inputs["position"])
        return np.column_stack(waves) * sense[:, None]

    return Group(made, over_speed=False, rubs=flips)


def _even_speeds(highest_mm_s: float) -> Array:
    return np.linspace(highest_mm_s / EVEN_SPEEDS, highest_mm_s, EVEN_SPEEDS)


def _fine(highest_mm_s: float) -> Callable[[Array], Array]:
    top = float(np.log1p(highest_mm_s / FINE_MM_S))
    return lambda v: _spline(np.log1p(np.abs(v) / FINE_MM_S), top, FINE_COLUMNS)


def _even(highest_mm_s: float) -> Callable[[Array], Array]:
    return lambda v: _spline(np.abs(v), highest_mm_s, EVEN_COLUMNS)


def _spline(values: Array, high: float, count: int) -> Array:
    """Return ``count`` cubic B-splines over 0 to ``high`` with even knots, (n, count)."""
    from scipy.interpolate import BSpline

    inner = np.linspace(0.0, high, count - 2)[1:-1]
    knots = np.concatenate([[0.0] * 4, inner, [high] * 4])
    inside = np.clip(values, 0.0, high)
    return np.asarray(BSpline.design_matrix(inside, knots, 3).toarray(), dtype=np.float64)
