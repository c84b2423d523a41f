"""Positions with the velocities and accelerations that are their slopes, found in the numbers."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from autodb.records.proposed.motion import Array, SlopeOf, share_followed, slope_of
from autodb.records.proposed.names import NameSays

PLACES, RATES, ACCELERATIONS = ("position", "angle", ""), ("velocity", ""), ("acceleration", "")
CLEARLY, OF_FRICTION = 0.8, 0.02
"""Share of a nameless effort that a motion explains, and of it friction alone. Chosen."""
FEWEST_LEVELS = 10
"""Different values below which a column is a switch or a counter of parts. Chosen."""


@dataclass(frozen=True)
class Chain:
    """A place, its velocity and the acceleration, by column; ``links``: how one follows another."""

    place: str
    velocity: str = ""
    acceleration: str = ""
    links: Mapping[str, tuple[str, SlopeOf]] = field(default_factory=dict)

    @property
    def columns(self) -> tuple[str, ...]:
        """Its columns."""
        return tuple(filter(None, (self.place, self.velocity, self.acceleration)))


def chains(columns: Mapping[str, Array], said: Mapping[str, NameSays], t_s: Array) -> list[Chain]:
    """Return the chains among columns (n,), those whose names say what they are first."""
    moving = [name for name, values in columns.items() if _moves(values)]
    measured = [name for name in moving if not said[name].commanded]
    moving = measured or moving
    slopes = {
        (place, rate): link
        for place, rate in _pairs(moving, said)
        if (link := _link(columns, said, t_s, place, rate)) is not None
    }
    found: list[Chain] = []
    taken: set[str] = set()
    for place in sorted(moving, key=lambda name: _rank(said[name])):
        is_rate = any(rate == place for _, rate in slopes) and not said[place].quantity
        if place in taken or said[place].quantity not in PLACES or is_rate:
            continue
        velocity = _steepest(slopes, place, RATES, said, taken | {place})
        if not velocity and not said[place].quantity:
            continue
        further = _steepest(slopes, velocity, ACCELERATIONS, said, taken | {place, velocity})
        links = {one: (of, slopes[of, one]) for of, one in ((place, velocity), (velocity, further))
                 if one}  # fmt: skip
        found.append(Chain(place, velocity, further, links))
        taken |= {place, velocity, further}
    return found


def nameless(columns: Mapping[str, Array], t_s: Array) -> tuple[Chain, str] | None:
    """Return a position without a name, and the effort that follows its motion, or None.

    Friction must show, that turns round with the direction: acceleration and velocity alone follow
    any ripple.
    """
    best: tuple[float, Chain, str] | None = None
    moving = [name for name, values in columns.items() if _moves(values)]
    for place in moving:
        with np.errstate(divide="ignore", invalid="ignore"):
            velocity = np.asarray(np.gradient(columns[place], t_s), dtype=np.float64)
        for effort in moving:
            if effort == place:
                continue
            share = share_followed(columns[effort], velocity, t_s)
            if share < CLEARLY or (best is not None and share <= best[0]):
                continue
            smooth = share_followed(columns[effort], velocity, t_s, with_direction=False)
            if share - smooth >= OF_FRICTION:
                best = share, Chain(place), effort
    return None if best is None else best[1:]


def _link(
    columns: Mapping[str, Array], said: Mapping[str, NameSays], t_s: Array, place: str, rate: str
) -> SlopeOf | None:
    named = bool(said[place].quantity and said[rate].quantity)
    return slope_of(columns[rate], columns[place], t_s, varying=not named)


def _moves(values: Array) -> bool:
    return bool(np.isfinite(values).all()) and len(np.unique(values[:20_000])) >= FEWEST_LEVELS


def _rank(said: NameSays) -> tuple[bool, bool]:
    return (said.commanded, not said.quantity)


def _pairs(names: list[str], said: Mapping[str, NameSays]) -> Iterator[tuple[str, str]]:
    """Yield columns of which the second may be the slope of the first, as far as names say."""
    for place in names:
        for rate in names:
            one, other = said[place], said[rate]
            axes = {one.axis, other.axis} - {""}
            kinds = (one.quantity in PLACES and other.quantity in RATES) or (
                one.quantity in RATES and other.quantity in ACCELERATIONS
            )
            if place != rate and kinds and len(axes) < 2 and one.commanded == other.commanded:
                yield place, rate


def _steepest(
    slopes: Mapping[tuple[str, str], SlopeOf],
    place: str,
    kinds: tuple[str, ...],
    said: Mapping[str, NameSays],
    taken: set[str],
) -> str:
    """Return the column that is the slope of ``place`` most clearly; empty where none is."""
    able = {
        rate: abs(found.correlation)
        for (of, rate), found in slopes.items()
        if of == place and rate not in taken and said[rate].quantity in kinds
    }
    return max(able, key=lambda rate: able[rate], default="")
