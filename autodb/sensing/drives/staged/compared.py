"""What two routines say of one axis, side by side: quantities with uncertainty, and who differs."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.drives.fit.axis_model import Identified
from autodb.sensing.drives.fit.steady import SteadyMotion
from autodb.sensing.drives.fit.thermal import lost
from autodb.sensing.drives.staged.stages import Stages
from autodb.wording import phrase

Array = NDArray[np.float64]

FAR_SDS = 2.6
"""Joint standard deviations beyond which two numbers differ: 1 in 100 by chance."""
MAY_DIFFER = 20
"""One in so many may differ where the routines agree. Chosen: five times what chance gives alone,
because what two neighbouring speeds or places tell is alike and goes astray together."""
MOST_SPEEDS = 5
"""Speeds of those passed, in equal ratios, at which friction is compared."""
STEP = 1e-4
"""Relative step of a derivative, or in standard deviations: effort is linear but in its shape."""


@dataclass(frozen=True)
class ComparedQuantity:
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

    rows: tuple[ComparedQuantity, ...]
    left_out: tuple[str, ...]

    @property
    def differing(self) -> list[ComparedQuantity]:
        """What differs."""
        return [row for row in self.rows if row.differs]

    @property
    def agrees(self) -> bool:
        """Whether no more than one in MAY_DIFFER differs."""
        return MAY_DIFFER * len(self.differing) <= len(self.rows)


def speeds_named(found: Stages, top_mm_s: float) -> list[tuple[int, float]]:
    """Return levels and speeds mm/s at which friction is compared: they do not stick, and pass the
    middle both ways.
    """
    smooth = [
        k for k in found.compared if not found.verdicts[k].sticks and found.levels[k] <= top_mm_s
    ]
    speed = np.array([found.levels[k] for k in smooth])
    if not len(speed):
        return []
    wanted = np.geomspace(speed[0], speed[-1], MOST_SPEEDS)
    chosen = sorted({int(np.argmin(np.abs(np.log(speed / one)))) for one in wanted})
    return [(smooth[i], float(speed[i])) for i in chosen]


def linear(steady: SteadyMotion, x: Array, v: Array, take: Array) -> tuple[Array, Array]:
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


def compared_inertia(found: Stages, model: Identified) -> list[ComparedQuantity]:
    """Compare inertia, where both have one."""
    term = next((t for t in model.fitted if t.term == "inertia"), None)
    if found.inertia is None or term is None:
        return []
    return [
        ComparedQuantity("inertia", term.unit, found.inertia.value, found.inertia.sd, term.value,
                 term.sd or 0.0)
    ]  # fmt: skip


def compared_warmth(
    found: Stages, model: Identified, inputs: Mapping[str, Array]
) -> tuple[list[ComparedQuantity], list[str]]:
    """Compare the share of friction that was lost when the axis was warmest."""
    names = ("drop", "time_constant", "levelling")
    by_name = {t.parameter: t for t in model.terms if t.term == "warmup"}
    free = [i for i, t in enumerate(model.fitted) if t.term == "warmup"]
    if found.warming is None:
        return [], [phrase("warm-up loss: too few passes were repeated at one speed")]
    if not free or set(by_name) != set(names):
        return [], [phrase(
"warm-up loss: the joint fit has no warmup, its friction is of these moves; "
"add warmup to --terms"
)]  # fmt: skip

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
    return [ComparedQuantity(phrase("warm-up loss when warmest"), "1", *own, *joint)], []


def _slope(function: Callable[[Array], float], at: Array) -> Array:
    """Return the derivatives (p,) of a function."""
    steps = np.diag(STEP * np.maximum(np.abs(at), STEP))
    return np.array([(function(at + s) - function(at - s)) / (2.0 * s.sum()) for s in steps])
