"""The parameters that each effect is described by, of one component, named as its term names them.

The shape of an unnamed effect in words.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from autodb.explain.answer import IntervalValue
from autodb.explain.cuts.candidates.cutting import bell, normal_force, nose_columns
from autodb.explain.cuts.candidates.laws import (
    LawColumns,
    SpreadLaw,
    added,
    alike,
    chip_factor,
    each,
    only,
    per_depth,
    relative,
    values_of,
)
from autodb.explain.cuts.candidates.over_time import TIMES_S, warming_columns
from autodb.explain.cuts.fit import BesideEffect
from autodb.explain.cuts.stack import Stack
from autodb.explain.engine.candidates import Choice
from autodb.fitting.gaussian import NORMAL_95
from autodb.terms.chip import size_effect, speed_softening
from autodb.wording import significant

Array = NDArray[np.float64]


@dataclass(frozen=True)
class EffectInCuts:
    """One effect of a set with what stands beside it."""

    stack: Stack
    own: dict[str, LawColumns]
    choice: Choice
    others: tuple[Choice, ...]

    @cached_property
    def beside(self) -> BesideEffect:
        """White rows without own terms and the other effects."""
        return BesideEffect.others(self.stack, self.own, self.others)


Read = Callable[[EffectInCuts, int], dict[str, IntervalValue]]
Shape = Callable[[float], Array]

LATER = 4
"""Cuts by which an end of a run is moved at most to see how well it is known."""


def effect_parameters(effect: EffectInCuts, component: int) -> dict[str, IntervalValue]:
    """Return the effect's own parameters in one component, beside the other effects."""
    return READ[effect.choice.candidate.term](effect, component)


def _one(
    beside: BesideEffect, columns: LawColumns, at: int, unit: str, *, scale: float = 1.0
) -> IntervalValue:
    found, sd = beside.coefficients(columns)
    return IntervalValue.around(
        scale * float(found[at]), abs(scale) * NORMAL_95 * float(sd[at]), unit
    )


def _edge_force(effect: EffectInCuts, component: int) -> dict[str, IntervalValue]:
    stack = effect.stack
    columns = each(stack, per_depth(stack, values_of(np.ones(len(stack.known)))))
    sign = float(stack.sign[component])
    return {"coefficient": _one(effect.beside, columns, component, "N/mm", scale=sign)}


def _size_effect(effect: EffectInCuts, _component: int) -> dict[str, IntervalValue]:
    thickness = effect.stack.known.thickness_mm
    assert thickness is not None
    return {"exponent": _power(effect, lambda m: size_effect(thickness, exponent=m), 0.01, 0.9)}


def _speed(effect: EffectInCuts, _component: int) -> dict[str, IntervalValue]:
    speed = effect.stack.known.speed_m_min
    assert speed is not None
    return {"exponent": _power(effect, lambda e: speed_softening(speed, exponent=e), -0.5, 1.0)}


def _power(effect: EffectInCuts, x: Shape, low: float, high: float) -> IntervalValue:
    """Return the exponent for which chip · x(exponent) takes the place of the chip best.

    The chip's own factor is free: the recording is (1 + k) · chip · x beside the others.
    """
    own = {name: columns for name, columns in effect.own.items() if name != "shear"}
    beside = BesideEffect.others(effect.stack, own, effect.others, plus=effect.stack.chip)
    mix = effect.own["shear"].mix

    def make(exponent: float) -> LawColumns:
        return LawColumns(effect.stack, chip_factor(effect.stack, values_of(x(exponent))), mix)

    return beside.profile(make, low, high, "1")


def _band(effect: EffectInCuts, component: int) -> dict[str, IntervalValue]:
    stack, speed = effect.stack, effect.stack.known.speed_m_min
    assert speed is not None
    width, at = effect.choice.shape.shape["width"], effect.choice.shape.shape["centre"]

    def make(log_centre: float) -> LawColumns:
        inside = bell(speed, float(np.exp(log_centre)), width)
        return alike(stack, chip_factor(stack, values_of(inside)))

    log = effect.beside.profile(make, np.log(at) - width, np.log(at) + width, "1")
    law = chip_factor(stack, values_of(bell(speed, float(np.exp(log.value)), width)))
    low, middle, high = (float(np.exp(v)) for v in (log.low, log.value, log.high))
    return {
        "change": _one(effect.beside, each(stack, law), component, "1"),
        "centre": IntervalValue(value=middle, low=low, high=high, unit="m/min"),
        "width": IntervalValue(value=width, low=0.7 * width, high=1.4 * width, unit="1"),
    }


def _wear(effect: EffectInCuts, component: int) -> dict[str, IntervalValue]:
    """Return the mean rate and each edge's own, at the mean depth, as straight lines; by mm of
    flank wear where that was measured and no cutting time recorded.
    """
    stack, known = effect.stack, effect.stack.known
    if known.by_land and known.land_mm is not None:
        scale = float(known.depth_mm.mean()) * float(stack.sign[component])
        line = only(stack, per_depth(stack, values_of(known.land_mm)), component)
        return {"rate": _one(effect.beside, line, 0, "N/mm", scale=scale)}
    assert known.edge is not None
    assert known.cutting_time_s is not None
    time, scale = known.cutting_time_s, float(known.depth_mm.mean()) * float(stack.sign[component])
    line = only(stack, per_depth(stack, values_of(time)), component)
    rates = {"rate": _one(effect.beside, line, 0, "N/s", scale=scale)}
    usable = [e for e in known.edges if np.ptp(time[known.edge == e]) > 0]
    if 1 < len(usable) <= 200:
        own = time[:, None] * (known.edge[:, None] == np.array(usable)[None, :])
        law = per_depth(stack, values_of(own), len(usable))
        found, sd = effect.beside.coefficients(only(stack, law, component))
        for edge, rate, half in zip(usable, found, NORMAL_95 * sd, strict=True):
            label = f"rate edge {known.edge_label[float(edge)]}"
            rates[label] = _none_at_least(float(rate) * scale, float(half) * abs(scale), "N/s")
    return rates


def _none_at_least(middle: float, half: float, unit: str) -> IntervalValue:
    """Return a value of something that is never negative, measured as a middle ± half of 95 %.

    The upper end is that of a normal distribution that begins at nothing.
    """
    sd = half / NORMAL_95
    beyond = 0.025 * ndtr(middle / sd) if sd > 0.0 else 0.0
    high = middle - sd * float(ndtri(beyond)) if beyond > 0.0 else max(middle, 0.0)
    return IntervalValue(value=max(middle, 0.0), low=max(middle - half, 0.0), high=high, unit=unit)


def _hard_spot(effect: EffectInCuts, component: int) -> dict[str, IntervalValue]:
    stack = effect.stack
    change = _one(effect.beside, each(stack, _run(stack, *_rows_of_run(effect))), component, "1")
    factor = IntervalValue(
        value=1.0 + change.value, low=1.0 + change.low, high=1.0 + change.high, unit="1"
    )
    ends = _ends_of_run(effect, lambda start, end: alike(stack, _run(stack, start, end)))
    return {"factor": factor} | ends


def _rows_of_run(effect: EffectInCuts) -> tuple[int, int]:
    cuts, shape = effect.stack.known.number, effect.choice.shape.shape
    return int(np.argmax(cuts == shape["first"])), int(np.argmax(cuts == shape["last"]))


def _ends_of_run(
    effect: EffectInCuts, columns: Callable[[int, int], LawColumns]
) -> dict[str, IntervalValue]:
    """Return the first and the last cut of a run, each with those that do nearly as well.

    ``columns``: those of a run from a row to a row.
    """
    cuts = effect.stack.known.number
    start, end = _rows_of_run(effect)
    starts = range(max(0, start - LATER), min(end, start + LATER) + 1)
    ends = range(max(start, end - LATER), min(len(cuts) - 1, end + LATER) + 1)
    near_start = {s: effect.beside.gain(columns(s, end)) for s in starts}
    near_end = {e: effect.beside.gain(columns(start, e)) for e in ends}
    return {"first": _place(cuts, near_start, start), "last": _place(cuts, near_end, end)}


def _run(stack: Stack, start: int, end: int) -> SpreadLaw:
    inside = np.zeros(len(stack.known))
    inside[start : end + 1] = 1.0
    return relative(stack, values_of(inside))


def _place(cuts: Array, gains: dict[int, float], at: int) -> IntervalValue:
    kept = [row for row, gain in gains.items() if gain >= max(gains.values()) - NORMAL_95**2]
    low, high = min([*kept, at]), max([*kept, at])
    return IntervalValue(
        value=float(cuts[at]), low=float(cuts[low]), high=float(cuts[high]), unit="1"
    )


def _depth_error(effect: EffectInCuts, _component: int) -> dict[str, IntervalValue]:
    stack = effect.stack
    columns = alike(stack, relative(stack, values_of(1.0 / stack.known.depth_mm)))
    return {"error": _one(effect.beside, columns, 0, "mm")}


def _nose(effect: EffectInCuts, _component: int) -> dict[str, IntervalValue]:
    def make(radius: float) -> LawColumns:
        return nose_columns(effect.stack, radius, longer=False)

    return {"radius": effect.beside.profile(make, 0.1, 3.0, "mm")}


def _deflection(effect: EffectInCuts, _component: int) -> dict[str, IntervalValue]:
    stack = effect.stack
    pressed = normal_force(stack) / stack.known.depth_mm
    columns = alike(stack, relative(stack, values_of(-pressed)))
    return {"compliance": _one(effect.beside, columns, 0, "mm/N")}


def _drift(effect: EffectInCuts, component: int) -> dict[str, IntervalValue]:
    """Return how fast a zero point moves; of a step how far and when."""
    stack, shape = effect.stack, effect.choice.shape
    if "at" in shape.shape:
        assert isinstance(shape.law, LawColumns)
        return {"step": _one(effect.beside, shape.law, 0, "N"), "start": _start(effect)}
    since = stack.known.t_s - stack.known.t_s[0]
    columns = only(stack, added(stack, values_of(since)), component)
    return {"rate": _one(effect.beside, columns, 0, "N/s")}


def _gain(effect: EffectInCuts, component: int) -> dict[str, IntervalValue]:
    """Return the factor where it is furthest from 1, by the shape that was found."""
    columns = effect.choice.shape.law
    assert isinstance(columns, LawColumns)
    found, sd = effect.beside.coefficients(columns)
    stack = effect.stack
    factor = columns.raw()[component] / stack.simulation[component][:, None]
    change = factor @ found
    at = int(np.argmax(np.abs(change)))
    half = NORMAL_95 * float(np.sqrt(np.sum((factor[at] * sd) ** 2)))
    made = {"factor": IntervalValue.around(1.0 + float(change[at]), half, "1")}
    if "at" in effect.choice.shape.shape:
        made["start"] = _start(effect)
    if "first" in effect.choice.shape.shape:
        made |= _ends_of_run(
            effect, lambda start, end: only(stack, _run(stack, start, end), component)
        )
    return made


def _start(effect: EffectInCuts) -> IntervalValue:
    """Return when a step was."""
    t = effect.stack.known.t_s
    start = float(t[0] + effect.choice.shape.shape["at"] * (t[-1] - t[0]))
    return IntervalValue.around(start, 0.1 * float(t[-1] - t[0]), "s")


def _warmup(effect: EffectInCuts, component: int) -> dict[str, IntervalValue]:
    """Return the share of a cut's force that is sensed too much where that is most, and the time.

    The time constant is of heating in cuts and cooling in pauses alike.
    """
    stack, choice = effect.stack, effect.choice
    columns = choice.shape.law
    assert isinstance(columns, LawColumns)
    found, sd = effect.beside.coefficients(columns)
    share = columns.raw()[component] / np.abs(stack.simulation[component])[:, None]
    at = int(np.argmax(np.abs(share @ found)))
    half = NORMAL_95 * float(np.sqrt(np.sum((share[at] * sd) ** 2)))

    def make(log_time: float) -> LawColumns:
        return warming_columns(stack, choice.form, float(np.exp(log_time)))

    low, high = np.log(TIMES_S[0] / 3.0), np.log(TIMES_S[-1] * 3.0)
    log = effect.beside.profile(make, low, high, "1")
    time_s = {key: float(np.exp(getattr(log, key))) for key in ("value", "low", "high")}
    sign = float(stack.sign[component])
    return {
        "drop": IntervalValue.around(sign * float(share[at] @ found), half, "1"),
        "time_constant": IntervalValue(**time_s, unit="s"),
    }


READ: dict[str, Read] = {
    "edge_force": _edge_force, "size_effect": _size_effect, "speed_softening": _speed,
    "built_up_edge": _band, "tool_wear": _wear, "hard_spot": _hard_spot,
    "depth_error": _depth_error, "nose_radius": _nose, "deflection": _deflection,
    "sensor_drift": _drift, "gain": _gain, "warmup": _warmup,
}  # fmt: skip


BINS = 8
ONE_WAY = 0.85
"""Rank correlation from which a dependence is called one of rising or falling."""


def shape_words(stack: Stack, choice: Choice, part: Array, component: int) -> str:
    """Return how a contribution (n,) goes with what it depends on, one sentence."""
    shape = choice.shape.shape
    if "period" in shape:
        return f"it comes round every {significant(shape['period'])} of it."
    variable = choice.candidate.variables[0]
    values = {**stack.known.other, "cut": stack.known.number, "t": stack.known.t_s}[variable]
    if "every" in shape:
        return f"it differs from cut to cut and comes back after {shape['every']:.0f}."
    share = part / np.maximum(np.abs(stack.simulation[component]), 1e-12)
    return _along(values, share - share.mean())


def _along(values: Array, share: Array) -> str:
    rank = np.argsort(np.argsort(values, kind="stable"), kind="stable")
    order = np.argsort(np.argsort(share, kind="stable"), kind="stable")
    together = float(np.corrcoef(rank, order)[0, 1]) if np.ptp(share) > 0 else 0.0
    if abs(together) > ONE_WAY:
        return f"it {'rises' if together > 0 else 'falls'} with it."
    edges = np.quantile(values, np.linspace(0, 1, BINS + 1))
    place = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, BINS - 1)
    mean = np.array([share[place == b].mean() if np.any(place == b) else 0.0 for b in range(BINS)])
    middle = 0.5 * (edges[1:] + edges[:-1])
    top, bottom = middle[np.argmax(mean)], middle[np.argmin(mean)]
    return f"it is highest near {significant(top)} and lowest near {significant(bottom)}."
