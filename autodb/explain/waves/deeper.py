"""How far the depth of a milled cut is off, fitted to a waveform slice by slice."""

import numpy as np

from autodb.explain.engine.search import FoundSet
from autodb.explain.waves.bench import WhitenedNoise, WhiteWaves
from autodb.explain.waves.candidates import deeper
from autodb.explain.waves.fit import BesideWaves
from autodb.explain.waves.world import SimulatedWaves

DEPTH = "depth_error"
REACH = 0.4
"""Share of the error that the search found by which it is looked for to either side."""
STEPS = 20


def fitted_error(
    world: SimulatedWaves, bench: WhiteWaves, found: FoundSet, quiet: WhitenedNoise
) -> float:
    """Return the error of depth, mm, that fits best beside own terms and other effects.

    A simulation's slices come into the work one by one, so that what fits is rough over the error:
    it is tried step by step, then by finer steps about the best.
    """
    beside = BesideWaves(bench, found.without(DEPTH), quiet)
    choice = next(c for c in found.choices if c.suspect.key == DEPTH)
    about = float(beside.fitted(bench.columns(choice.key, choice.shape))[0][0])
    if "error" in choice.shape.shape:
        about = choice.shape.shape["error"]
    reach = REACH * about
    for _ in range(2):
        tried = about + reach * np.linspace(-1.0, 1.0, STEPS + 1)
        gains = [beside.gain(deeper(world, float(e))[:, :, None]) for e in tried]
        about, reach = float(tried[int(np.argmax(gains))]), 2.0 * reach / STEPS
    return about
