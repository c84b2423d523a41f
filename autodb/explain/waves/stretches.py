"""Where a stretch of other material begins and ends, fitted to white rows beside all else."""

from itertools import product

import numpy as np

from autodb.explain.engine.candidates import Candidate, Choice
from autodb.explain.engine.search import FoundSet
from autodb.explain.waves.bench import WhitenedNoise, WhiteWaves
from autodb.explain.waves.fit import BesideWaves
from autodb.explain.waves.scans import BINS, LONGEST, SHORTEST, hard_spot_of_waves, harder_stretch
from autodb.explain.waves.world import SimulatedWaves

MOVED = 0.2
"""Share of a stretch by which its ends are moved at first, either way; halved down to a bin."""


def sharpened(
    world: SimulatedWaves, bench: WhiteWaves, found: FoundSet, quiet: WhitenedNoise
) -> dict[str, Candidate]:
    """Return the stretches that were found, by key, with the ends that explain most.

    A scan sees steps, in a grid; ends that rise slowly are elsewhere.
    """
    return {
        choice.candidate.key: _sharpened(world, BesideWaves(bench, others, quiet), choice)
        for choice in found.choices
        if choice.candidate.term == "hard_spot" and choice.candidate.interval is not None
        for others in [found.without(choice.candidate.key)]
    }


def _sharpened(world: SimulatedWaves, beside: BesideWaves, choice: Choice) -> Candidate:
    inside = world.waves.t_s[world.engaged > 0.0]
    whole = float(inside[-1] - inside[0])
    interval = choice.candidate.interval
    assert interval is not None
    start, end = interval
    best, reach = _stretch_gain(world, beside, start, end, choice.form), MOVED * (end - start)
    while reach > whole / BINS:
        tried = [
            (start + a * reach, end + b * reach) for a, b in product((-1, 0, 1), repeat=2) if a or b
        ]
        tried = [
            (a, b) for a, b in tried if SHORTEST * whole < b - a < LONGEST * whole
            and a >= inside[0] - reach and b <= inside[-1] + reach
        ]  # fmt: skip
        gains = [_stretch_gain(world, beside, a, b, choice.form) for a, b in tried]
        at = int(np.argmax(gains)) if gains else -1
        if at >= 0 and gains[at] > best:
            best, (start, end) = gains[at], tried[at]
        else:
            reach *= 0.5
    return hard_spot_of_waves(world, start, end, choice.candidate.key)


def _stretch_gain(
    world: SimulatedWaves, beside: BesideWaves, start_s: float, end_s: float, number: int
) -> float:
    return beside.gain(harder_stretch(world, start_s, end_s, number))
