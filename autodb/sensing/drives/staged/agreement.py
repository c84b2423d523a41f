"""P2's stages and the joint fit beside each other: friction at named places and speeds, not
parameters, because friction's parameters are nearly degenerate (P2, Table II).
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.drives.fit.axis_model import Identified
from autodb.sensing.drives.fit.steady import SteadyMotion
from autodb.sensing.drives.staged.compared import (
    Agreement,
    ComparedQuantity,
    compared_inertia,
    compared_warmth,
    linear,
    speeds_named,
)
from autodb.sensing.drives.staged.routine import Staged
from autodb.wording import localized, phrase

Array = NDArray[np.float64]

PLACES = (0.25, 0.5, 0.75)
"""Parts of the travel at which friction is compared."""
TURN_POINTS = 6
"""Places over one turn of the screw that a named place is the mean of: neither routine is asked
where in a turn a ripple stands."""


def screw_agreement(found: Staged, model: Identified, inputs: Mapping[str, Array]) -> Agreement:
    """Compare the staged routine with the joint fit of the same recording.

    The errors of both come from the same passes, so that their difference is surer than the root of
    their squares says: what differs here does so for sure.
    """
    warm, said = compared_warmth(found, model, inputs)
    rows = [*compared_inertia(found, model), *warm]
    if model.steady is None:
        said.append(
            phrase(
                "friction and weight: the joint fit has no friction over speed; add viscous "
                "and coulomb to --terms"
            )
        )
    else:
        rows = [*_friction(found, model, model.steady), *rows]
    return Agreement(tuple(rows), tuple(said))


def _friction(found: Staged, model: Identified, steady: SteadyMotion) -> list[ComparedQuantity]:
    """Compare the weight, and friction at places and speeds in both directions.

    Both count as weight what effort is amid the directions, at the levels that told it.
    """
    level_speeds = np.array([found.levels[k] for k in found.weight.levels])
    top = steady.off_law.highest_mm_s
    named = _named(found, top)
    points = [_turn(place, found.length.period_mm) for place, _, _ in named]
    speeds = np.minimum(level_speeds, top)
    x = np.concatenate([found.weight.x_mm, found.weight.x_mm, *points])
    v = np.concatenate(
        [speeds, -speeds, *(np.full(len(p), s * q) for p, (_, s, q) in zip(points, named,
                                                                           strict=True))]
    )  # fmt: skip
    take = _takes(len(speeds), [len(p) for p in points], [q for _, _, q in named])
    value, sd = linear(steady, x, v, take)
    told = [(found.weight.value, found.weight.sd)]
    for place, speed, sense in named:
        size, size_sd = found.friction(np.array([place]), np.array([speed]), sense)
        told.append((float(size[0]), float(size_sd[0])))
    names = ["weight"] + [
        phrase(
            "friction at {place} mm, {speed} mm/min",
            place=localized(f"{place:.0f}"),
            speed=localized(f"{sense * speed * 60.0:+.4g}"),
        )
        for place, speed, sense in named
    ]
    return [
        ComparedQuantity(name, model.unit, *one, float(a), float(b))
        for name, one, a, b in zip(names, told, value, sd, strict=True)
    ]


def _named(found: Staged, top_mm_s: float) -> list[tuple[float, float, int]]:
    """Return places mm, speeds mm/s and directions at which friction is compared.

    Speeds that pass the middle both ways and do not stick, and places that they passed.
    """
    low = min(p.low_mm for p in found.passes)
    high = max(p.high_mm for p in found.passes)
    half = 0.5 * (found.length.period_mm or 0.0)
    centre = float(found.along.middle_mm.mean())
    places = [centre if share == 0.5 else low + share * (high - low) for share in PLACES]
    return [
        (place, speed, sense)
        for level, speed in speeds_named(found, top_mm_s)
        for place in places
        for sense in (1, -1)
        if place == centre or _passed(found, level, place - half, place + half)
    ]


def _passed(found: Staged, level: int, low_mm: float, high_mm: float) -> bool:
    own = [p for p in found.passes if p.level == level]
    return any(p.low_mm <= low_mm and high_mm <= p.high_mm for p in own)


def _turn(place_mm: float, period_mm: float | None) -> Array:
    """Return places over one turn of the screw about a place."""
    if period_mm is None:
        return np.array([place_mm])
    return np.asarray(place_mm + period_mm * ((np.arange(TURN_POINTS) + 0.5) / TURN_POINTS - 0.5))


def _takes(levels: int, counts: list[int], senses: list[int]) -> Array:
    """Return how weight and frictions are made of efforts: (quantities, points)."""
    total = 2 * levels + sum(counts)
    take = np.zeros((1 + len(counts), total))
    take[0, : 2 * levels] = 0.5 / levels
    begin = 2 * levels
    for i, (count, sense) in enumerate(zip(counts, senses, strict=True), start=1):
        take[i, begin : begin + count] = sense / count
        take[i] -= sense * take[0]
        begin += count
    return take
