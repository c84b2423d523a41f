"""What a calibration was made with, and how far forms nearly as good disagree beyond it.

Within the range of its cuts the forms that were tried agree, or one was better on groups left out.
Beyond it nothing tells them apart, so that an interval grows there by the spread of their
estimates about the one taken, weighed by how well each did on groups left out (a model average:
pseudo-BMA+ of Yao, Vehtari, Simpson and Gelman 2018, Bayesian Analysis 13:917, with groups for
points):

    s² = Σ w_k (f_k − f)²,  w_k = mean over draws of  exp(−G/2 ln m_k) / Σ exp(−G/2 ln m)

m_k mean squared error of a form, groups weighed anew in each draw (Bayesian bootstrap), G groups.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.linear import Undetermined
from autodb.sensing.ranges.choosing import TriedForm
from autodb.sensing.ranges.folding import Fold
from autodb.sensing.ranges.forms import CurrentForm, FittedForm, MeasuredCuts, of_one_way
from autodb.wording import stored_msgid

Array = NDArray[np.float64]

DRAWS = 400
"""Draws of the groups' weights; their mean is off by less than 0.02. Chosen."""
LEAST_WEIGHT = 0.01
"""Weight below which a form is left out. Chosen."""
BESIDE = 0.02
"""Share of a range's span by which a cut may lie beside it. Chosen: conditions are rounded."""


@dataclass(frozen=True)
class Quantity:
    """A quantity of cuts that a calibration has a range of: its name, its unit per one of ours."""

    name: str
    said: str
    unit: str
    per: float = 1.0

    def of(self, sensed: MeasuredCuts) -> Array:
        """Return it of each cut (n,)."""
        return np.asarray(getattr(sensed, self.name))

    def words(self, ends: tuple[float, float]) -> str:
        """Return a range of it in words."""
        return _words(self.said, (self.per * ends[0], self.per * ends[1]), self.unit)


def _words(said: str, ends: tuple[float, float], unit: str) -> str:
    return said.format(range_low=f"{ends[0]:.4g}", range=f"{ends[1]:.4g} {unit}")


OF_FEED = (
    Quantity("feed_mm_s", stored_msgid("feed speed {range_low} to {range}"), "mm/min", per=60.0),
)
OF_SPINDLE = (
    Quantity("speed_rpm", stored_msgid("spindle speed {range_low} to {range}"), "rpm"),
    Quantity("temperature_C", stored_msgid("spindle temperature {range_low} to {range}"), "°C"),
)
CONDITIONS = (*OF_FEED, *OF_SPINDLE)
"""What laws of a feed axis, and of the spindle, depend on beside the current."""
CURRENT = Quantity("current", stored_msgid("current {range_low} to {range}"), "A")
FORCE = stored_msgid("force {range_low} to {range}")
TORQUE = stored_msgid("torque {range_low} to {range}")


def ranged(current_unit: str) -> tuple[Quantity, ...]:
    """Return what a calibration has ranges of, its current in the unit that it is recorded in."""
    return (*CONDITIONS, replace(CURRENT, unit=current_unit))


@dataclass(frozen=True)
class NearForm:
    """A form that was nearly as good, as it was fitted to all cuts, and its weight."""

    form: CurrentForm
    coefficients: Array
    weight: float


@dataclass(frozen=True)
class Domain:
    """What a calibration's cuts were: lowest and highest of each quantity that is known of them.

    ``target``: of the force or torque, in its unit. ``fold``: up to where two forces show one
    range, where there is such.
    """

    ranges: dict[str, tuple[float, float]]
    target: tuple[float, float]
    rivals: tuple[NearForm, ...] = ()
    fold: Fold | None = None

    def beyond(self, law: FittedForm, sensed: MeasuredCuts) -> Array:
        """Return the sd (n,) that the choice of the form gives the target, 0 within the range.

        The law that stays beyond it as it was at its end is as good as the one taken: no cut tells
        them apart. A form is off by as much as the target is, or any was, at most: powers run away.
        """
        taken = law.form.value(law.coefficients, sensed)
        most = np.maximum(np.abs(taken), np.abs(self.target).max())
        own = 1.0 - sum(one.weight for one in self.rivals)
        stays = law.form.value(law.coefficients, self._held(sensed))
        others = [(own, stays)]
        others += [(r.weight, r.form.value(r.coefficients, sensed)) for r in self.rivals]
        square = np.zeros_like(taken)
        for weight, value in others:
            off = np.minimum(np.abs(np.nan_to_num(value - taken)), most)
            square += weight / (1.0 + own) * off**2
        return np.where(self.outside(law, sensed), np.sqrt(square), 0.0)

    def _held(self, sensed: MeasuredCuts) -> MeasuredCuts:
        """Return cuts with conditions that go no further than those of the calibration."""
        held = {
            one.name: np.clip(one.of(sensed), *self.ranges[one.name])
            for one in CONDITIONS
            if one.name in self.ranges
        }
        return replace(sensed, **held)

    def outside(self, law: FittedForm, sensed: MeasuredCuts) -> NDArray[np.bool_]:
        """Return which cuts (n,) lie outside."""
        out = _outside(law.form.value(law.coefficients, sensed), self.target)
        for one in (*CONDITIONS, CURRENT):
            if one.name in self.ranges:
                out |= _outside(one.of(sensed), self.ranges[one.name])
        return out

    def left(
        self, law: FittedForm, sensed: MeasuredCuts, unit: str, current_unit: str
    ) -> list[str]:
        """Return the ranges that some cut lies outside of, in words; ``unit`` of the target."""
        said = [
            one.words(self.ranges[one.name])
            for one in ranged(current_unit)
            if one.name in self.ranges and _outside(one.of(sensed), self.ranges[one.name]).any()
        ]
        if _outside(law.form.value(law.coefficients, sensed), self.target).any():
            said.append(_words(TORQUE if unit == "N·m" else FORCE, self.target, unit))
        return said

    def each(self, unit: str, current_unit: str) -> list[str]:
        """Return each range in words; ``unit`` of the target."""
        known = [
            one.words(self.ranges[one.name])
            for one in ranged(current_unit)
            if one.name in self.ranges
        ]
        return [*known, _words(TORQUE if unit == "N·m" else FORCE, self.target, unit)]


def _outside(values: Array, ends: tuple[float, float]) -> NDArray[np.bool_]:
    low, high = ends
    beside = BESIDE * (high - low) + 1e-9 * max(abs(low), abs(high))
    return (values < low - beside) | (values > high + beside)


def domain_of(
    law: FittedForm,
    sensed: MeasuredCuts,
    target: Array,
    rivals: Sequence[NearForm],
    *,
    conditions: tuple[Quantity, ...],
    fold: Fold | None = None,
) -> Domain:
    """Return the range of cuts (n,) that a law was fitted to; of the target as known and sensed.

    ``conditions``: what laws of its axis depend on; ``fold``: below which there are none.
    """
    ranges = {}
    for one in (*conditions, CURRENT):
        values = one.of(sensed)
        if np.isfinite(values).all():
            ranges[one.name] = (float(values.min()), float(values.max()))
    both = np.append(target, law.form.value(law.coefficients, sensed))
    return Domain(ranges, (float(both.min()), float(both.max())), tuple(rivals), fold)


def near_forms(
    trials: Sequence[TriedForm],
    taken: CurrentForm,
    sensed: MeasuredCuts,
    target: Array,
    groups: NDArray[np.generic],
) -> list[NearForm]:
    """Return the laws among the trials beside the one taken, fitted to all cuts (n,).

    Rules say themselves how far off they may be beyond their cuts.
    """
    found = []
    for trial, weight in zip(trials, form_weights(trials, groups).tolist(), strict=True):
        if trial.form is taken or weight < LEAST_WEIGHT:
            continue
        try:
            law = of_one_way(trial.form.fit(sensed, target))
        except Undetermined:
            continue
        if law.form.parameters() is None:
            found.append(NearForm(law.form, law.coefficients, weight))
    return found


def form_weights(trials: Sequence[TriedForm], groups: NDArray[np.generic]) -> Array:
    """Return the weight of each trial, summing to 1; 0 of a form that the cuts do not hold."""
    _, of = np.unique(groups, return_inverse=True)
    count = int(of.max()) + 1
    draws = np.random.default_rng(0).dirichlet(np.ones(count), DRAWS)
    score = np.full((len(trials), DRAWS), -np.inf)
    size = np.bincount(of.ravel())
    for k, trial in enumerate(trials):
        if trial.errors is not None:
            squares = np.bincount(of.ravel(), weights=trial.errors**2)
            mean = (draws @ squares) / (draws @ size)
            score[k] = -0.5 * count * np.log(mean + np.finfo(float).tiny)
    share = np.exp(score - score.max(axis=0))
    return np.asarray(np.mean(share / share.sum(axis=0), axis=1))
