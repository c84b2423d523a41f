"""P0's four steps and the joint fit beside each other: line, cogging, friction, inertia."""

from collections.abc import Mapping
from dataclasses import dataclass

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
from autodb.sensing.drives.staged.linear import FourSteps
from autodb.terms.ripple import NODES
from autodb.wording import localized, phrase

Array = NDArray[np.float64]

PLACES = (0.25, 0.5, 0.75)
"""Parts of the travel at which the line is compared."""
PARTS = 6
"""Parts of a pole over which cogging is compared: as many as the joint fit's harmonics tell apart.
"""
PART_POINTS = NODES // PARTS
"""Places in a part, over which it is averaged."""


@dataclass(frozen=True)
class _Asked:
    """Names, units, and sums ``take`` (q, n) of the loads at places ``x_mm`` (n,)."""

    names: list[str]
    units: list[str]
    x_mm: Array
    take: Array


def linear_agreement(found: FourSteps, model: Identified, inputs: Mapping[str, Array]) -> Agreement:
    """Compare the four steps with the joint fit of the same recording.

    The load over the travel is compared as line and table tell it, the mean over a pole and what is
    beyond that; by how much poles differ is in neither. Errors of both come from the same passes.
    """
    warm, said = compared_warmth(found, model, inputs)
    rows = [*compared_inertia(found, model), *warm]
    if model.steady is None:
        said.append(
            phrase(
                "friction and load: the joint fit has no friction over speed; add viscous and "
                "coulomb to --terms"
            )
        )
    else:
        rows = [*_steady(found, model.unit, model.steady), *rows]
    return Agreement(tuple(rows), tuple(said))


def _steady(found: FourSteps, unit: str, steady: SteadyMotion) -> list[ComparedQuantity]:
    """Compare load and friction: the joint fit's load is the mean of both ways, as the steps'."""
    top = steady.off_law.highest_mm_s
    asked = _asked(found, unit)
    middle = found.middle_mm
    x_mm = np.concatenate([asked.x_mm, middle])
    speeds = np.array([min(found.levels[k], top) for k in found.load.level.levels])
    x, v, loads = _both_ways(x_mm, speeds)

    named = [(s, q) for _, s in speeds_named(found, top) for q in (1, -1)]
    x = np.concatenate([x, *(middle for _ in named)])
    v = np.concatenate([v, *(np.full(len(middle), s * q) for s, q in named)])
    count, extra = loads.shape[1], len(middle)
    loads = np.hstack([loads, np.zeros((len(loads), len(named) * extra))])
    take = [asked.take @ loads[: len(asked.x_mm)]]
    amid = loads[len(asked.x_mm) :].mean(axis=0)
    for i, (_, sense) in enumerate(named):
        row = -sense * amid
        row[count + i * extra : count + (i + 1) * extra] = sense / extra
        take.append(row[None])
    value, sd = linear(steady, x, v, np.vstack(take))

    known, known_sd = found.load.told(asked.x_mm, asked.take)
    told = [(float(a), float(b)) for a, b in zip(known, known_sd, strict=True)]
    for speed, sense in named:
        size, size_sd = found.friction(np.array([speed]), sense)
        told.append((float(size[0]), float(size_sd[0])))
    names = [
        *asked.names,
        *(phrase("friction at {q} mm/min", q=localized(f"{s * q * 60.0:+.4g}")) for s, q in named),
    ]
    units = [*asked.units, *(unit for _ in named)]
    return [
        ComparedQuantity(name, its, *one, float(a), float(b))
        for name, its, one, a, b in zip(names, units, told, value, sd, strict=True)
    ]


def _asked(found: FourSteps, unit: str) -> _Asked:
    """Return slope, line and cogging as sums of loads at places."""
    low = min(p.low_mm for p in found.passes)
    high = max(p.high_mm for p in found.passes)
    pole_mm = found.load.pole_mm
    half = 0.5 * (pole_mm or 0.0)
    named = [low + half + share * (high - low - 2.0 * half) for share in PLACES]
    places = [_over(place, pole_mm, NODES) for place in named]
    x, take = np.concatenate(places), _means([len(one) for one in places])
    names = [phrase("line at {place} mm", place=localized(f"{place:.0f}")) for place in named]
    slope = (take[-1] - take[0]) / (named[-1] - named[0])
    asked = _Asked(["k", *names], [f"{unit}/mm", *([unit] * len(names))], x,
                   np.vstack([slope, take]))  # fmt: skip
    return asked if pole_mm is None else _with_cogging(asked, unit, named[1], pole_mm)


def _with_cogging(asked: _Asked, unit: str, centre_mm: float, pole_mm: float) -> _Asked:
    """Return quantities with cogging in the parts of a pole near the centre: off the line there."""
    begin_mm = np.ceil(centre_mm / pole_mm) * pole_mm
    middle = begin_mm + pole_mm * (np.arange(PARTS) + 0.5) / PARTS
    near = [_over(place, pole_mm / PARTS, PART_POINTS) for place in middle]
    known = asked.take.shape[1]
    slope, line = asked.take[0], asked.take[1 + PLACES.index(0.5)]
    take = np.zeros((len(asked.take) + PARTS, known + PARTS * PART_POINTS))
    take[: len(asked.take), :known] = asked.take
    take[len(asked.take) :, :known] = -line - np.multiply.outer(middle - centre_mm, slope)
    take[len(asked.take) :, known:] = _means([len(one) for one in near])
    names = [phrase("cogging, {i}/{parts} of a pole", i=i + 1, parts=PARTS) for i in range(PARTS)]
    return _Asked([*asked.names, *names], [*asked.units, *([unit] * PARTS)],
                  np.concatenate([asked.x_mm, *near]), take)  # fmt: skip


def _over(place_mm: float, way_mm: float | None, count: int) -> Array:
    """Return places evenly over a way about one; the place alone without a way."""
    if way_mm is None:
        return np.array([place_mm])
    return np.asarray(place_mm + way_mm * ((np.arange(count) + 0.5) / count - 0.5))


def _means(counts: list[int]) -> Array:
    """Return how means over groups of places are taken: (groups, places)."""
    of = np.repeat(np.arange(len(counts)), counts)
    inside = of == np.arange(len(counts))[:, None]
    return np.asarray(inside / np.array(counts, dtype=np.float64)[:, None])


def _both_ways(x_mm: Array, speeds: Array) -> tuple[Array, Array, Array]:
    """Return places, velocities (m,), and how loads at places (n,) are sums of efforts, (n, m).

    The mean of both ways, averaged over speeds (k,). What friction differs by direction goes by the
    speed and not by the place, so that it is asked for at the first place alone.
    """
    n, k, middle = len(x_mm), len(speeds), float(np.median(speeds))
    x = np.concatenate([x_mm, x_mm, np.full(2 * k, x_mm[0])])
    v = np.concatenate([np.full(n, middle), np.full(n, -middle), speeds, -speeds])
    take = np.zeros((n, len(x)))
    rows = np.arange(n)
    take[rows, rows] = take[rows, n + rows] = 0.5
    take[:, [0, n]] -= 0.5
    take[:, 2 * n :] += 0.5 / k
    return x, v, take
