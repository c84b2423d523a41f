"""Moves in air that identify an axis: a ladder of speeds, or the shortest that is sure enough.

A pass runs a stretch there and back at one feed. What a pass tells of the terms follows from their
own columns, ∫ x xᵀ dt over the noise's spectral density; passes are taken one by one, each time the
one that tells most a second of what is not known well enough yet.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.gaussian import NORMAL_95
from autodb.sensing.drives.fit.drive_errors import BANDWIDTHS_HZ, STEADY
from autodb.sensing.drives.reconstruct import DriveModel, term_slopes
from autodb.terms.friction import direction

Array = NDArray[np.float64]

ACCELERATION_MM_S2 = 1000.0
"""How fast a pass is taken to speed up: 0.1 g, which most machine tools do. Chosen."""
REST_S = 0.5
"""Rest between passes, so that each begins at standstill. Chosen."""
STEP_S = 0.01
"""Time step in which a pass is computed."""
SLOWEST_MM_MIN, FASTEST_MM_MIN = 10.0, 10_000.0
"""Feeds of a sweep: P2's passes run from 10 to 9000 mm/min."""
LADDER = 12
"""Speeds of the ladder that is run where nothing is known of the axis."""
SPEEDS = 27
"""Speeds that a design chooses from: as many as P2's."""
LEAST_DEVIATION = 0.01
"""Share of Coulomb friction by which friction at a speed is off any law, at least. Chosen."""
LONGEST_PASS_S = 30.0
"""Time of one way of a pass: slow ones run a part of the stretch only. Chosen."""
LEAST_SPEEDS, LEAST_ROUNDS = 5, 2
"""Speeds that every design runs, and how often: a law that fits at two speeds was not tested at
either. Chosen.
"""
BEST_KNOWN_HZ = 5.0
"""Bandwidth at which the noise is taken: of what is left of moves, friction changes slowly."""


@dataclass(frozen=True)
class SweepPass:
    """There and back at a feed, from one place to another, mm of the axis' travel."""

    start_mm: float
    end_mm: float
    feed_mm_min: float

    @property
    def seconds(self) -> float:
        """Time that it takes, both ways and both rests."""
        speed = self.feed_mm_min / 60.0
        way_s = abs(self.end_mm - self.start_mm) / speed + speed / ACCELERATION_MM_S2
        return 2.0 * (way_s + REST_S)


@dataclass(frozen=True)
class Design:
    """Passes that are to be run, and what they leave open.

    ``reached``: of each parameter wanted its name, the half width of its 95 % interval that is to
    be expected, and the one asked for, in the parameter's unit.
    """

    passes: tuple[SweepPass, ...]
    reached: tuple[tuple[str, float, float], ...]

    @property
    def seconds(self) -> float:
        """Time of all passes."""
        return float(sum(one.seconds for one in self.passes))

    @property
    def enough(self) -> bool:
        """Whether every interval asked for is reached."""
        return all(half <= wanted for _, half, wanted in self.reached)


def feeds(fastest_mm_min: float, count: int) -> Array:
    """Return feeds in equal ratios, mm/min, up to the fastest that there is."""
    top = min(fastest_mm_min, FASTEST_MM_MIN)
    return np.floor(10.0 * np.geomspace(min(SLOWEST_MM_MIN, top), top, count)) / 10.0


def speed_ladder(low_mm: float, high_mm: float, *, fastest_mm_min: float) -> tuple[SweepPass, ...]:
    """Return the passes of a ladder of speeds, each in two rounds."""
    speeds = feeds(fastest_mm_min, LADDER)
    return _in_rounds([_pass(low_mm, high_mm, float(feed)) for feed in speeds] * LEAST_ROUNDS)


def _pass(low_mm: float, high_mm: float, feed_mm_min: float) -> SweepPass:
    way_mm = min(high_mm - low_mm, feed_mm_min / 60.0 * LONGEST_PASS_S)
    return SweepPass(low_mm, round(low_mm + way_mm, 3), feed_mm_min)


def candidates(low_mm: float, high_mm: float, *, fastest_mm_min: float) -> tuple[SweepPass, ...]:
    """Return the passes a design chooses from: every speed, over its whole way and a quarter."""
    found = []
    for feed in feeds(fastest_mm_min, SPEEDS):
        whole = _pass(low_mm, high_mm, float(feed))
        quarter = low_mm + 0.25 * (whole.end_mm - low_mm)
        found += [whole, SweepPass(low_mm, round(quarter, 3), float(feed))]
    return tuple(found)


def shortest_sweep(
    model: DriveModel, choices: Sequence[SweepPass], *, within: float, longest_s: float
) -> Design:
    """Return the passes that tell every parameter to ± ``within`` of itself, 95 %.

    Of one that adds less than Coulomb friction it is ± ``within`` of that. Ends before
    ``longest_s``, reached or not.
    """
    told = [_told(model, one) for one in choices]
    values = np.array([t.value for t in model.terms[: len(model.covariance)]])
    largest = np.max([one.largest for one in told], axis=0)
    least = model.errors.breakaway / np.where(largest > 0, largest, np.inf)
    wanted = within * np.maximum(np.abs(values), least)
    sought = wanted > 0
    chosen = LEAST_ROUNDS * _at_several_speeds(choices)
    believed = np.diag(1.0 / np.where(sought, 1e3 * np.maximum(wanted, 1e-300), 1.0) ** 2)
    deviates = _deviates(model)
    while True:
        half = NORMAL_95 * _sd(believed, [told[i] for i in chosen], deviates)
        short = sought & (half > wanted)
        spent_s = sum(choices[i].seconds for i in chosen)
        fits = [i for i, one in enumerate(choices) if spent_s + one.seconds <= longest_s]
        if not short.any() or not fits:
            break

        def gain(i: int, half: Array = half, short: NDArray[np.bool_] = short) -> float:
            after = NORMAL_95 * _sd(believed, [told[k] for k in (*chosen, i)], deviates)
            return float(np.sum(np.log(half[short] / after[short]))) / choices[i].seconds

        chosen.append(max(fits, key=gain))
    taken = [choices[i] for i in chosen]
    names = [f"{t.key} {t.parameter}" for t in model.terms[: len(values)]]
    reached = tuple(
        (names[i], float(half[i]), float(wanted[i])) for i in range(len(values)) if sought[i]
    )
    return Design(_in_rounds(taken), reached)


def _in_rounds(taken: Sequence[SweepPass]) -> tuple[SweepPass, ...]:
    """Return passes in rounds, each from fast to slow, the second of a kind in the next round.

    What is fitted is tried on blocks of motion left out: no speed may be in one block only.
    """
    seen: dict[SweepPass, int] = {}
    numbered = []
    for one in taken:
        seen[one] = seen.get(one, 0) + 1
        numbered.append((seen[one], -one.feed_mm_min, -one.end_mm, one))
    return tuple(one for *_, one in sorted(numbered, key=lambda item: item[:3]))


def _at_several_speeds(choices: Sequence[SweepPass]) -> list[int]:
    """Return the shortest pass at each of ``LEAST_SPEEDS`` speeds, spread over those there are."""
    known = sorted({one.feed_mm_min for one in choices})
    spread = np.linspace(len(known) // 3, len(known) - 1, LEAST_SPEEDS).round().astype(int)
    return [
        min(
            (i for i, one in enumerate(choices) if one.feed_mm_min == known[at]),
            key=lambda i: choices[i].seconds,
        )
        for at in dict.fromkeys(spread.tolist())
    ]


@dataclass(frozen=True)
class _Told:
    """What a pass tells: XᵀX (k, k), Xᵀd (k,) and dᵀd over the noise's spectral density.

    X are the terms' columns, d the direction; ``largest`` (k,) of |X|.
    """

    feed_mm_min: float
    own: Array
    with_direction: Array
    direction: float
    largest: Array


def _told(model: DriveModel, one: SweepPass) -> _Told:
    inputs = pass_motion(one)
    columns = term_slopes(model.terms, model.covariance, inputs)
    at = BANDWIDTHS_HZ.index(BEST_KNOWN_HZ)
    density = max(model.errors.rms[at]) ** 2 / (2.0 * BEST_KNOWN_HZ)
    share, sense = STEP_S / density, inputs["direction"]
    return _Told(
        one.feed_mm_min,
        columns.T @ columns * share,
        columns.T @ sense * share,
        float(sense @ sense) * share,
        np.max(np.abs(columns), axis=0),
    )


def _deviates(model: DriveModel) -> float:
    """Return by how much friction at one speed is off its law (sd): what moves leave slowly."""
    return max(model.errors.rms[0][STEADY], LEAST_DEVIATION * model.errors.breakaway)


def _sd(believed: Array, told: Sequence[_Told], deviates: float) -> Array:
    """Return the parameters' sd (k,) after passes.

    Friction at each speed has an error of its own, d·b, b ~ N(0, deviates²), which all passes at
    that speed share: more of the same tell less than another speed.
    """
    information = believed.copy()
    for feed in {one.feed_mm_min for one in told}:
        same = [one for one in told if one.feed_mm_min == feed]
        both = np.sum([one.with_direction for one in same], axis=0)
        alone = sum(one.direction for one in same) + 1.0 / deviates**2
        information += np.sum([one.own for one in same], axis=0) - np.outer(both, both) / alone
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(information))))


def pass_motion(one: SweepPass) -> dict[str, Array]:
    """Return what the terms take of a pass: t, position, velocity, acceleration, direction, (n,).

    Speed rises and falls at ``ACCELERATION_MM_S2``; a way too short for its feed stays below it.
    """
    way_mm = abs(one.end_mm - one.start_mm)
    top = min(one.feed_mm_min / 60.0, float(np.sqrt(way_mm * ACCELERATION_MM_S2)))
    ramp_s = top / ACCELERATION_MM_S2
    run_s = way_mm / top - ramp_s
    corners = np.cumsum([0.0, ramp_s, run_s, ramp_s, REST_S, ramp_s, run_s, ramp_s, REST_S])
    t = np.arange(0.0, corners[-1], STEP_S)
    velocity = np.interp(t, corners, [0.0, top, top, 0.0, 0.0, -top, -top, 0.0, 0.0])
    velocity *= np.sign(one.end_mm - one.start_mm)
    return {
        "t": t,
        "position": one.start_mm + np.cumsum(velocity) * STEP_S,
        "velocity": velocity,
        "acceleration": np.gradient(velocity, STEP_S),
        "direction": direction(velocity),
    }
