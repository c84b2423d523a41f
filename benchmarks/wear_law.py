"""The law by which edges wear, as a table shows it: one bend for all, a rate for each edge."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.cut_search import FoundInCuts
from autodb.explain.cuts.fit import fit_cuts
from autodb.explain.engine.candidates import UNKNOWN

Array = NDArray[np.float64]

BENDS = (0.3, 3.0)
"""Powers of cutting time that are tried."""
SLOW = ("tool_wear", "sensor_drift", "gain", UNKNOWN)
"""Effects whose curves over time would take up part of the law."""


@dataclass(frozen=True)
class WearLaw:
    """Force [N] = sign · rate of the edge · a_p · T^power, beside the simulation of a fresh edge.

    T cutting time [s], a_p depth [mm]; ``rates`` [N/(mm·s^power)] by edge code.
    """

    power: float
    rates: dict[float, float]
    sign: float

    def force(self, *, depth_mm: Array, cutting_time_s: Array, edge: Array) -> Array:
        """Return the force that wear adds, (n,); an edge that was not seen raises KeyError."""
        rate = np.array([self.rates[float(e)] for e in edge])
        return np.asarray(self.sign * rate * depth_mm * cutting_time_s**self.power)


def wear_law(result: FoundInCuts, component: int) -> WearLaw:
    """Return the law of one component, whatever curve the search has found for it.

    The simulation is taken for the force of a fresh edge as it is: a factor on it would take up the
    beginning of the law. So would effects without a name and those that follow the clock, which are
    left out beside it; the parts of all others are taken off first.

    Raises ValueError where the table has no cutting time.
    """
    stack, known = result.stack, result.stack.known
    if known.cutting_time_s is None or known.edge is None:
        raise ValueError("a law of wear needs tool.edge and tool.cutting_time")
    sd, time_s, depth_mm = stack.sd[component], known.cutting_time_s, known.depth_mm
    longest = float(time_s.max())
    grown = (_without_others(result)[component] / sd) * float(stack.sign[component])
    member = known.edge[:, None] == known.edges[None, :]

    def rates(power: float) -> tuple[Array, float]:
        course = depth_mm * (time_s / longest) ** power / sd
        up = member.T @ (course * grown)
        down = np.maximum(member.T @ course**2, 1e-300)
        return up / down, float(np.sum(up**2 / down))

    powers = np.linspace(*BENDS, 109)
    power = float(powers[np.argmax([rates(float(p))[1] for p in powers])])
    found = dict(zip(known.edges.tolist(), rates(power)[0] / longest**power, strict=True))
    return WearLaw(power, found, float(stack.sign[component]))


def _without_others(result: FoundInCuts) -> Array:
    """Return the difference without the parts of effects that no course of time is put down to."""
    stack, choices = result.stack, result.found.choices
    parts = fit_cuts(stack, result.own, choices).parts[len(result.own) :]
    taken = [p for p, c in zip(parts, choices, strict=True) if c.candidate.term not in SLOW]
    return np.asarray(stack.recording - stack.simulation - np.sum(taken, axis=0))
