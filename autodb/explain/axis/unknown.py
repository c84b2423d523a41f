"""Smooth families over what was recorded: what an effect without a name can depend on."""

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from autodb.explain.axis.signals import AxisSignals
from autodb.explain.engine.candidates import UNKNOWN, Candidate, CandidateForm, product, spline

Array = NDArray[np.float64]

BAR = 14.0
"""Further evidence asked of a family without a name: a name says more. Chosen."""


def unknown_candidates(s: AxisSignals) -> list[Candidate]:
    """Return families over position, speed, time and the other axes, alone and in pairs."""
    speed, sense = np.abs(s.velocity), s.sense
    place, way, v = s.channel("position"), s.channel("direction"), s.channel("velocity")
    made = [
        _family("position", (place,), partial(spline, s.position, 10)),
        _family("direction × time", (way, "t"), lambda: sense[:, None] * spline(s.t_s, 8)),
        _family("speed", (v,), lambda: sense[:, None] * spline(speed, 7)),
        _family("acceleration", (s.channel("acceleration"),), partial(spline, s.acceleration, 7)),
        _family(
            "direction × position × speed",
            (way, place, v),
            partial(over_place_and_speed, s, turned=True),
        ),
        _family("position × speed", (place, v), partial(over_place_and_speed, s, turned=False)),
        _family(
            "direction × position × time",
            (way, place, "t"),
            lambda: sense[:, None] * product(spline(s.position, 5), spline(s.t_s, 5)),
        ),
    ]
    return [*made, *_over_other_axes(s)]


def over_place_and_speed(s: AxisSignals, *, turned: bool) -> Array:
    """Return products of splines over position and speed, (n, p); turned: times the direction."""
    grid = product(spline(s.position, 7), spline(np.abs(s.velocity), 5))
    return s.sense[:, None] * grid if turned else grid


def _turned_spline(sense: Array, values: Array) -> Array:
    return np.asarray(sense[:, None] * spline(values, 6))


def _family(key: str, variables: tuple[str, ...], law: Callable[[], Array]) -> Candidate:
    return Candidate(key, UNKNOWN, (CandidateForm(law),), variables, bar=BAR)


def _over_other_axes(s: AxisSignals) -> list[Candidate]:
    """Return families over the other axes' position and velocity, and friction over them."""
    made = []
    for name, values in s.others.items():
        if name.endswith(".acceleration"):
            continue
        made += [
            _family(name, (name,), partial(spline, values, 6)),
            _family(
                f"direction × {name}",
                (s.channel("direction"), name),
                partial(_turned_spline, s.sense, values),
            ),
        ]
    return made
