"""Moves that a shop can run in minutes, scaled to what an axis did in a recording.

Each is a path of legs with a trapezoidal speed; the library is one plain tuple.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.drives.moves.motion import STILL_SHARE
from autodb.terms.friction import direction
from autodb.wording import significant, stored_msgid

Array = NDArray[np.float64]
Stop = tuple[float, float]
"""A place and the speed that it is gone to with, in the axis' unit and this a second."""

STAND_S = 20.0
SLOW = 0.05
"""A slow pass runs at this share of the top speed, unless it would take longer than SLOW_S."""
SLOW_S = 60.0
FIVE_SPEEDS = (0.06, 0.12, 0.25, 0.5, 1.0)
SHORT_OF_TRAVEL = (5e-5, 1.2e-4, 2.5e-4, 5e-4, 1.2e-3, 2.5e-3)
"""Short ways as shares of the travel: 0.02 to 1 mm of 400 mm."""
SHORT_S = 5.0
"""Time that the longest of the short ways takes."""
TURNS = 4
WARMING_S = 120.0
WARMINGS = 3
"""Running and resting by turns of WARMING_S: ten minutes with two rests."""
COLD_S = 600.0
"""Rest after which an axis is cold again. Chosen. The clock is taken to stand meanwhile: no law is
carried over a time that it was not recorded in."""
PROGRAMME_S = 300.0
"""The recording's programme is run again for so long at most."""


@dataclass(frozen=True)
class Reach:
    """Travel, top speed and acceleration of an axis in a recording: mm and s, of a rotary axis deg
    and s; ``still``: the speed below which it stands.
    """

    low_mm: float
    high_mm: float
    top_mm_s: float
    top_mm_s2: float
    unit: str = "mm"
    still: float | None = None

    @property
    def standstill(self) -> float:
        """Speed below which the direction fades out."""
        return STILL_SHARE * self.top_mm_s if self.still is None else self.still

    @property
    def short(self) -> tuple[float, ...]:
        """Short ways, to reverse over."""
        return tuple(share * (self.high_mm - self.low_mm) for share in SHORT_OF_TRAVEL)

    @property
    def short_speed(self) -> float:
        """Speed over short ways."""
        return min(self.short[-1] / SHORT_S, self.top_mm_s)

    @property
    def middle_mm(self) -> float:
        """Middle of the travel."""
        return 0.5 * (self.low_mm + self.high_mm)

    @property
    def slow_mm_s(self) -> float:
        """Speed of a slow pass."""
        return max(SLOW * self.top_mm_s, (self.high_mm - self.low_mm) / SLOW_S)

    @property
    def moves(self) -> bool:
        """Whether the axis moved, so that moves can be scaled to it."""
        return self.high_mm > self.low_mm and self.top_mm_s > self.standstill


@dataclass(frozen=True)
class AxisPath:
    """Position, velocity, acceleration and direction of an axis, (n,), evenly over t [s]."""

    t_s: Array
    position: Array
    velocity: Array
    acceleration: Array
    direction: Array


@dataclass(frozen=True)
class AxisMove:
    """One move: ``words`` say it in the imperative, ``path`` gives it at a rate in Hz.

    It is run right after the recording, or ``cold`` after a rest. ``scaled``: only of an axis that
    moved; ``of_other``: another axis runs it, this one stands.
    """

    words: Callable[[Reach], str]
    path: Callable[[Reach, float], AxisPath]
    scaled: bool = True
    cold: bool = False
    of_other: bool = False


def reach(
    position: Array, velocity: Array, acceleration: Array, *, unit: str, still: float
) -> Reach:
    """Return what an axis did, (n,) each; single rows of noise set neither speed nor acceleration.

    The acceleration is at least such that the top speed is reached in a second.
    """
    top = float(np.quantile(np.abs(velocity), 0.999))
    sharpest = float(np.quantile(np.abs(acceleration), 0.999))
    low, high = float(position.min()), float(position.max())
    return Reach(low, high, top, max(sharpest, top), unit, still)


def along(
    start_mm: float, stops: Iterable[Stop], r: Reach, rate_hz: float, rest_s: float
) -> AxisPath:
    """Return the path over stops, each followed by a rest, after a rest at ``start_mm``."""
    parts, here = [_rest(start_mm, rest_s, rate_hz)], start_mm
    for place, speed in stops:
        parts += [_leg(here, place, speed, r.top_mm_s2, rate_hz), _rest(place, rest_s, rate_hz)]
        here = place
    position, velocity, acceleration = np.concatenate(parts, axis=1)
    t_s = np.arange(len(position)) / rate_hz
    sense = direction(velocity, standstill_mm_s=r.standstill)
    return AxisPath(t_s, position, velocity, acceleration, sense)


def _rest(place_mm: float, rest_s: float, rate_hz: float) -> Array:
    rows = max(1, round(rest_s * rate_hz))
    return np.stack([np.full(rows, place_mm), np.zeros(rows), np.zeros(rows)])


def _leg(start_mm: float, end_mm: float, speed: float, rise: float, rate_hz: float) -> Array:
    """Return position, velocity and acceleration (3, n) of v = min(a·t, v₀, a·(T − t))."""
    way, sign = abs(end_mm - start_mm), float(np.sign(end_mm - start_mm))
    top = min(speed, float(np.sqrt(rise * way)))
    ramp = top / rise
    whole = way / top + ramp
    t = np.arange(1, max(2, int(np.ceil(whole * rate_hz)))) / rate_hz
    t = np.minimum(t, whole)
    run = np.where(t < ramp, 0.5 * rise * t**2, top * (t - 0.5 * ramp))
    run = np.where(t > whole - ramp, way - 0.5 * rise * (whole - t) ** 2, run)
    velocity = np.minimum(np.minimum(rise * t, top), rise * (whole - t))
    acceleration = rise * ((t < ramp) * 1.0 - (t > whole - ramp))
    return np.stack([start_mm + sign * run, sign * velocity, sign * acceleration])


def _passes(r: Reach, speeds: Iterable[float]) -> list[Stop]:
    """Return one pass of the whole travel there and back at each speed."""
    return [(place, speed) for speed in speeds for place in (r.high_mm, r.low_mm)]


def _stand(r: Reach, rate_hz: float) -> AxisPath:
    return along(r.middle_mm, [], r, rate_hz, STAND_S)


def _slow(r: Reach, rate_hz: float) -> AxisPath:
    return along(r.low_mm, _passes(r, [r.slow_mm_s]), r, rate_hz, 1.0)


def _fast(r: Reach, rate_hz: float) -> AxisPath:
    return along(r.low_mm, _passes(r, [r.top_mm_s] * TURNS), r, rate_hz, 0.2)


def _five_speeds(r: Reach, rate_hz: float) -> AxisPath:
    speeds = [max(share * r.top_mm_s, r.slow_mm_s) for share in FIVE_SPEEDS]
    return along(r.low_mm, _passes(r, speeds), r, rate_hz, 1.0)


def _sharp(r: Reach, rate_hz: float) -> AxisPath:
    third = (r.high_mm - r.low_mm) / 3.0
    places = [r.low_mm + third, r.low_mm + 2 * third, r.high_mm, r.low_mm]
    return along(r.low_mm, [(p, r.top_mm_s) for p in places * TURNS], r, rate_hz, 1.0)


def _short(r: Reach, rate_hz: float) -> AxisPath:
    middle = r.middle_mm
    turns = [middle + way * on for way in r.short for _ in range(TURNS) for on in (1, 0)]
    return along(middle, [(place, r.short_speed) for place in turns], r, rate_hz, 0.1)


def _warming(r: Reach, rate_hz: float) -> AxisPath:
    speed = 0.5 * r.top_mm_s
    one_s = (r.high_mm - r.low_mm) / speed + speed / r.top_mm_s2
    turns = max(1, int(0.5 * WARMING_S / one_s))
    stops = _passes(r, [speed] * turns)
    runs = along(r.low_mm, stops, r, rate_hz, 1.0 / rate_hz)
    rest = along(r.low_mm, [], r, rate_hz, WARMING_S)
    return joined_paths([runs, *[rest, runs] * (WARMINGS - 1)], rate_hz)


def joined_paths(paths: Iterable[AxisPath], rate_hz: float) -> AxisPath:
    """Return paths one after the other."""
    parts = [np.stack([p.position, p.velocity, p.acceleration, p.direction]) for p in paths]
    rows = np.concatenate(parts, axis=1)
    return AxisPath(np.arange(rows.shape[1]) / rate_hz, *rows)


def _travel(r: Reach) -> dict[str, str]:
    """Return the ends of the travel, in words."""
    return {"travel_low": f"{r.low_mm:.4g}", "travel": f"{r.high_mm:.4g} {r.unit}"}


def _feed(r: Reach, speed: float) -> str:
    return f"{float(f'{60.0 * speed:.3g}'):g} {r.unit}/min"


def _sharply(r: Reach) -> dict[str, str]:
    """Return the highest speed and acceleration, in words."""
    return {
        "speed": _feed(r, r.top_mm_s), "acceleration": f"{significant(r.top_mm_s2)} {r.unit}/s²"
    }  # fmt: skip


LIBRARY: tuple[AxisMove, ...] = (
    AxisMove(
        lambda _: stored_msgid("Stand still under control for {time}").format(
            time=f"{STAND_S:g} s"
        ),
        _stand, scaled=False,
    ),
    AxisMove(
        lambda r: stored_msgid(
            "Pass the travel from {travel_low} to {travel} there and back at {speed}"
        ).format(**_travel(r), speed=_feed(r, r.slow_mm_s)),
        _slow,
    ),
    AxisMove(
        lambda r: stored_msgid(
            "Pass the travel from {travel_low} to {travel} there and back {count} times at {speed}"
        ).format(**_travel(r), count=TURNS, speed=_feed(r, r.top_mm_s)),
        _fast,
    ),
    AxisMove(
        lambda r: stored_msgid(
            "Pass the travel from {travel_low} to {travel} there and back at five feeds from "
            "{slowest} to {fastest}"
        ).format(
            **_travel(r), slowest=_feed(r, max(FIVE_SPEEDS[0] * r.top_mm_s, r.slow_mm_s)),
            fastest=_feed(r, r.top_mm_s),
        ),
        _five_speeds,
    ),
    AxisMove(
        lambda r: stored_msgid(
            "Go over the travel from {travel_low} to {travel} in thirds at {speed}, {count} times, "
            "accelerating with {acceleration} and standing {time} after each move"
        ).format(**_travel(r), **_sharply(r), count=TURNS, time="1 s"),
        _sharp,
    ),
    AxisMove(
        lambda r: stored_msgid(
            "Reverse slowly, at {speed}, about {place}, {count} times each over {way_low} to {way}"
        ).format(
            speed=_feed(r, r.short_speed), place=f"{r.middle_mm:.4g} {r.unit}", count=TURNS,
            way_low=significant(r.short[0], 2), way=f"{significant(r.short[-1], 2)} {r.unit}",
        ),
        _short,
    ),
    AxisMove(
        lambda r: stored_msgid(
            "Let the axis rest for {pause}, then pass the travel from {travel_low} to {travel} "
            "there and back at {speed} for {time}, {count} times with rests of {rest}"
        ).format(
            **_travel(r), pause=f"{COLD_S / 60.0:g} min", speed=_feed(r, 0.5 * r.top_mm_s),
            time=f"{WARMING_S:g} s", count=WARMINGS, rest=f"{WARMING_S:g} s",
        ),
        _warming,
        cold=True,
    ),
    AxisMove(
        lambda r: stored_msgid(
            "Let this axis stand and pass another axis over the travel from {travel_low} to "
            "{travel} in thirds at {speed}, accelerating with {acceleration}"
        ).format(**_travel(r), **_sharply(r)),
        _sharp,
        of_other=True,
    ),
)  # fmt: skip
"""What a shop can run in ten minutes at most; the recording's own programme comes beside it."""


def again(programme: AxisPath) -> AxisMove:
    """Return the recording's programme, run once more after a rest."""
    rows = programme.t_s - programme.t_s[0] <= PROGRAMME_S
    cut = AxisPath(*(values[rows] for values in vars(programme).values()))
    cut = replace(cut, t_s=cut.t_s - cut.t_s[0])
    words = stored_msgid(
        "Let the axis rest for {pause} and run the first {time} of the recording's programme once "
        "more"
    ).format(pause=f"{COLD_S / 60.0:g} min", time=f"{cut.t_s[-1]:.0f} s")
    return AxisMove(lambda _: words, lambda _r, _hz: cut, scaled=False, cold=True)


def still(path: AxisPath, place_mm: float) -> AxisPath:
    """Return standing at a place for as long as a path takes."""
    zero = np.zeros_like(path.t_s)
    return AxisPath(path.t_s, zero + place_mm, zero, zero, zero)
