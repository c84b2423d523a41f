"""The wear that a simulation of a cut table has, read off cuts that differ by nothing else.

A simulation has no noise: cuts of the same conditions at different times of an edge differ by its
wear alone, whatever law the chip follows.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from autodb.explain.cuts.stack import Conditions

Array = NDArray[np.float64]

POWERS = (0.5, 1.0, 2.0)
"""Powers of the cutting time whose sums, none negative, follow a wear that never falls."""
MOST_EDGES = 40
"""Edges that are read each with a course of its own; with more, one course for all."""
READ = 0.99
"""Share of the variation among cuts of the same conditions that must be read. Chosen: as much as of
an axis' own terms."""
REPEATED = 3
"""Cuts for each set of conditions, on the mean, that a table must have to be read. Chosen."""


@dataclass(frozen=True)
class SimulatedWear:
    """Force [N/mm] that each component gains with the cutting time of each edge.

    ``gained`` (C, E, P): by the powers of the time over ``longest_s``; ``edges`` (E,), of another
    edge their mean.
    """

    gained: Array
    edges: Array
    longest_s: float

    def force(self, known: Conditions) -> Array:
        """Return what wear adds to cuts, (C, n) [N]."""
        columns = _columns(known, self.edges, self.longest_s)
        flat = self.gained.reshape(len(self.gained), -1)
        return np.asarray(flat @ columns.T)

    def rate(self, known: Conditions) -> Array:
        """Return the force gained by depth and time as a straight line, (C,) [N/(mm·s)]."""
        assert known.cutting_time_s is not None
        line = known.depth_mm * known.cutting_time_s
        return np.asarray(self.force(known) @ line / (line @ line))


def wear_read_off(simulation: Array, known: Conditions) -> SimulatedWear | None:
    """Return the wear of a simulation (C, n).

    None where cuts of the same conditions are few, do not differ, or differ by something else, and
    where the flank wear stands for the cutting time.
    """
    time = known.cutting_time_s
    if known.by_land or time is None or known.edge is None or np.ptp(time) == 0:
        return None
    group = _same_conditions(known)
    if len(known) < REPEATED * (int(group.max()) + 1):
        return None
    edges = known.edges if len(known.edges) <= MOST_EDGES else np.array([np.nan])
    longest_s = float(time.max())
    columns = _without_means(_columns(known, edges, longest_s), group)
    signs = np.where(simulation.sum(axis=1) < 0, -1.0, 1.0)
    gained = []
    for sign, force in zip(signs, simulation, strict=True):
        varied = _without_means(force[:, None], group)[:, 0]
        if np.linalg.norm(varied) <= 1e-6 * np.linalg.norm(force):
            return None
        found, left = nnls(columns, sign * varied)
        if left**2 > (1.0 - READ) * float(varied @ varied):
            return None
        gained.append(sign * found.reshape(len(edges), len(POWERS)))
    return SimulatedWear(np.array(gained), edges, longest_s)


def _columns(known: Conditions, edges: Array, longest_s: float) -> Array:
    """Return the columns (n, E·P): depth times powers of the time, of each edge."""
    assert known.edge is not None
    assert known.cutting_time_s is not None
    member = np.asarray(known.edge[:, None] == edges[None, :], dtype=np.float64)
    member[~member.any(axis=1)] = 1.0 / len(edges)
    spent = known.cutting_time_s / longest_s
    powers = known.depth_mm[:, None] * spent[:, None] ** np.array(POWERS)
    return np.asarray((member[:, :, None] * powers[:, None, :]).reshape(len(spent), -1))


def _same_conditions(known: Conditions) -> NDArray[np.intp]:
    """Return the number of the set of conditions that each cut has, (n,)."""
    varied = [values for name, values in known.other.items() if name != "tool.cutting_time"]
    if not varied:
        return np.zeros(len(known), dtype=np.intp)
    _, number = np.unique(np.column_stack(varied), axis=0, return_inverse=True)
    return np.asarray(number.reshape(-1), dtype=np.intp)


def _without_means(values: Array, group: NDArray[np.intp]) -> Array:
    """Return columns (n, p) without their mean in each group."""
    count = np.bincount(group)
    means = [np.bincount(group, weights=column) / count for column in values.T]
    return np.asarray(values - np.column_stack(means)[group])
