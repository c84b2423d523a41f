"""The staged routine and the joint fit beside each other: friction at named places and speeds, not
parameters, because friction's parameters are nearly degenerate (P2, Table II).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.axis_model import Identified
from autodb.sensing.staged.routine import Staged
from autodb.sensing.steady import SteadyMotion
from autodb.sensing.thermal import lost

Array = NDArray[np.float64]

FAR_SDS = 2.6
"""Joint standard deviations beyond which two numbers differ: 1 in 100 by chance."""
MAY_DIFFER = 20
"""One in so many may differ where the routines agree. Chosen: five times what chance gives alone,
because what two neighbouring speeds or places tell is alike and goes astray together."""
PLACES = (0.25, 0.5, 0.75)
"""Parts of the travel at which friction is compared."""
MOST_SPEEDS = 5
"""Speeds of those passed, in equal ratios, at which it is compared."""
TURN_POINTS = 6
"""Places over one turn of the screw that a named place is the mean of: neither routine is asked
where in a turn a ripple stands."""
STEP = 1e-4
"""Relative step of a derivative, or in standard deviations: effort is linear but in its shape."""


@dataclass(frozen=True)
class Compared:
    """One quantity, as each routine tells it, with standard deviations."""

    name: str
    unit: str
    staged: float
    staged_sd: float
    joint: float
    joint_sd: float

    @property
    def difference_sds(self) -> float:
        """Staged less joint, in joint standard deviations: √ of the sum of squares."""
        return (self.staged - self.joint) / max(float(np.hypot(self.staged_sd, self.joint_sd)),
                                                1e-300)  # fmt: skip

    @property
    def differs(self) -> bool:
        """Whether the two are farther apart than both their errors explain."""
        return abs(self.difference_sds) > FAR_SDS


@dataclass(frozen=True)
class Agreement:
    """What was compared: ``rows``, and what could not be, with the reason."""

    rows: tuple[Compared, ...]
    left_out: tuple[str, ...]

    @property
    def differing(self) -> list[Compared]:
        """What differs."""
        return [row for row in self.rows if row.differs]

    @property
    def agrees(self) -> bool:
        """Whether no more than one in MAY_DIFFER differs."""
        return MAY_DIFFER * len(self.differing) <= len(self.rows)


def agreement(found: Staged, model: Identified, inputs: Mapping[str, Array]) -> Agreement:
    """Compare the staged routine with the joint fit of the same recording.

    The errors of both come from the same passes, so that their difference is surer than the root of
    their squares says: what differs here does so for sure.
    """
    warm, said = _warmth(found, model, inputs)
    rows = [*_inertia(found, model), *warm]
    if model.steady is None:
        said.append("friction and weight: the joint fit has no friction over speed; --terms with "
                    "viscous and coulomb would tell")  # fmt: skip
    else:
        rows = [*_friction(found, model, model.steady), *rows]
    return Agreement(tuple(rows), tuple(said))


def _friction(found: Staged, model: Identified, steady: SteadyMotion) -> list[Compared]:
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
    value, sd = _linear(steady, x, v, take)
    told = [(found.weight.value, found.weight.sd)]
    for place, speed, sense in named:
        size, size_sd = found.friction(np.array([place]), np.array([speed]), sense)
        told.append((float(size[0]), float(size_sd[0])))
    names = ["weight"] + [
        f"friction at {place:.0f} mm, {sense * speed * 60.0:+.4g} mm/min"
        for place, speed, sense in named
    ]
    return [
        Compared(name, model.unit, *one, float(a), float(b))
        for name, one, a, b in zip(names, told, value, sd, strict=True)
    ]


def _named(found: Staged, top_mm_s: float) -> list[tuple[float, float, int]]:
    """Return places mm, speeds mm/s and directions at which friction is compared.

    Speeds that pass the middle both ways and do not stick, and places that they passed.
    """
    smooth = [
        k for k in found.compared if not found.verdicts[k].sticks and found.levels[k] <= top_mm_s
    ]
    speed = np.array([found.levels[k] for k in smooth])
    if not len(speed):
        return []
    wanted = np.geomspace(speed[0], speed[-1], MOST_SPEEDS)
    chosen = sorted({int(np.argmin(np.abs(np.log(speed / one)))) for one in wanted})
    low = min(p.low_mm for p in found.passes)
    high = max(p.high_mm for p in found.passes)
    half = 0.5 * (found.length.period_mm or 0.0)
    centre = float(found.along.middle_mm.mean())
    places = [centre if share == 0.5 else low + share * (high - low) for share in PLACES]
    return [
        (place, float(speed[i]), sense)
        for i in chosen
        for place in places
        for sense in (1, -1)
        if place == centre or _passed(found, smooth[i], place - half, place + half)
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


def _linear(steady: SteadyMotion, x: Array, v: Array, take: Array) -> tuple[Array, Array]:
    """Return sums ``take`` (q, n) of the joint fit's efforts at n points, and their sd."""

    def of(values: Array, weights: Array) -> Array:
        off_law = replace(steady.off_law, weights=weights)
        return take @ replace(steady, values=values, off_law=off_law).effort(x, v)[0]

    known = steady.off_law.weights
    both = np.concatenate([steady.values, known])
    count = len(steady.values)
    sd = np.sqrt(np.maximum(np.diag(steady.covariance), 0.0))
    here = of(steady.values, known)
    slopes = [
        (of(*np.split(both + step, [count])) - here) / step.sum() if step.any() else 0.0 * here
        for step in np.diag(STEP * sd)
    ]
    jacobian = np.column_stack(slopes)
    variance = np.einsum("ij,jk,ik->i", jacobian, steady.covariance, jacobian)
    return here, np.sqrt(np.maximum(variance, 0.0))


def _inertia(found: Staged, model: Identified) -> list[Compared]:
    term = next((t for t in model.fitted if t.term == "inertia"), None)
    if found.inertia is None or term is None:
        return []
    return [
        Compared("inertia", term.unit, found.inertia.value, found.inertia.sd, term.value,
                 term.sd or 0.0)
    ]  # fmt: skip


def _warmth(
    found: Staged, model: Identified, inputs: Mapping[str, Array]
) -> tuple[list[Compared], list[str]]:
    """Compare the share of friction that was lost when the axis was warmest."""
    names = ("drop", "time_constant", "levelling")
    by_name = {t.parameter: t for t in model.terms if t.term == "warmup"}
    free = [i for i, t in enumerate(model.fitted) if t.term == "warmup"]
    if found.warming is None:
        return [], ["warm-up loss: too few passes were repeated at one speed"]
    if not free or set(by_name) != set(names):
        return [], ["warm-up loss: the joint fit has no warmup, its friction is of these moves; "
                    "--terms with warmup would tell"]  # fmt: skip

    def most(values: Array) -> float:
        at = dict(zip((model.fitted[i].parameter for i in free), values, strict=True))
        shape = {name: at.get(name, by_name[name].value) for name in names}
        return float(lost(shape, inputs).max())

    here = np.array([model.fitted[i].value for i in free])
    slope = _slope(most, here)
    variance = float(slope @ model.covariance[np.ix_(free, free)] @ slope)
    joint = (most(here), float(np.sqrt(max(0.0, variance))))
    share, slopes = found.warming.lost(inputs), found.warming.slopes(inputs)
    warmest = int(np.argmax(share))
    own = (float(share[warmest]), float(found.warming.sd(slopes[[warmest]])[0]))
    return [Compared("warm-up loss when warmest", "1", *own, *joint)], []


def _slope(function: Callable[[Array], float], at: Array) -> Array:
    """Return the derivatives (p,) of a function."""
    steps = np.diag(STEP * np.maximum(np.abs(at), STEP))
    return np.array([(function(at + s) - function(at - s)) / (2.0 * s.sum()) for s in steps])
