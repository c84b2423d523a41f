"""Intervals of a predicted cut with their ends farther from the value, each side by its factor."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, TypeVar

from autodb.forward.limits import QUANTITIES
from autodb.forward.prediction import Interval, Moment, Peaks, PredictedCut

Reach = tuple[float, float]
"""Factors on the distances of an interval's low and high end from its value."""

_Predicted = TypeVar("_Predicted", PredictedCut, Moment, Peaks)


def stretched(one: _Predicted, reach: Mapping[str, Reach]) -> _Predicted:
    """Return what is predicted with the ends of its intervals so much farther off."""
    changes: dict[str, Any] = {
        each.field: _farther(getattr(one, each.field), *reach[each.field])
        for each in QUANTITIES
        if each.field in reach
    }
    if isinstance(one, PredictedCut):
        changes |= {
            "peaks": None if one.peaks is None else stretched(one.peaks, reach),
            "start": None if one.start is None else stretched(one.start, reach),
            "end": None if one.end is None else stretched(one.end, reach),
        }
    return replace(one, **changes)


def _farther(own: Interval, low: float, high: float) -> Interval:
    return Interval(
        own.value,
        own.value - low * (own.value - own.low),
        own.value + high * (own.high - own.value),
    )
