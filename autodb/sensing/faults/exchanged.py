"""Two cuts whose known forces are exchanged: the currents say which of them was which."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from autodb.records import CutTable
from autodb.sensing.faults.arm import torque_arm_mm
from autodb.sensing.faults.check import Check
from autodb.sensing.ranges import COMPONENT_OF_AXIS, current_signal, moving

Array = NDArray[np.float64]

LEAST_CUTS = 8
"""Cuts of one operation, before two are said to be exchanged. Chosen."""
LEAST_AXES = 2
"""Axes that must all fit better: on one axis a single odd current looks like an exchange."""
CHANCE = 0.001
"""Probability that sound cuts look exchanged, over all pairs of a table together."""
CLOSE = 20.0
"""Another pair is a candidate too where its likelihood is within this factor of the best one's."""


def exchanged(
    table: CutTable, forces: Mapping[str, Array], axes: Sequence[str], names: Sequence[str]
) -> list[Check]:
    """Return, for each operation, whether two of its cuts have each other's known forces.

    ``forces``: known forces (n,), N, by component; ``names`` (n,) of the cuts, for the sentence. Of
    each axis the current is a line over its force (or torque), with normal scatter. Exchanging the
    forces of cuts i and j changes the log likelihood by g = (m − 2)/2 · ln(SSE/SSE_ij) on m cuts.
    A likelihood ratio exceeds c by chance with probability 1/c at most (Markov), so the largest sum
    over axes is beyond chance where it exceeds ln(pairs/CHANCE); every axis must gain.
    """
    checks = []
    for rows, lines in _operations(table, forces, axes):
        gains = np.array([_gains(*line) for line in lines])
        total = np.where((gains > 0).all(axis=0), gains.sum(axis=0), 0.0)
        first, second = np.triu_indices(len(rows), 1)
        of_pair = total[first, second]
        best = float(of_pair.max())
        near = np.flatnonzero(of_pair > max(best - np.log(CLOSE), 0.0))
        pairs = [(names[rows[first[k]]], names[rows[second[k]]]) for k in near]
        threshold = float(np.log(len(of_pair) / CHANCE))
        checks.append(Check("cuts exchanged", best, "<=", threshold, _sentence(pairs)))
    return checks


def _operations(
    table: CutTable, forces: Mapping[str, Array], axes: Sequence[str]
) -> Iterator[tuple[NDArray[np.intp], list[tuple[Array, Array, Array]]]]:
    """Yield the cuts (m,) of an operation that all its axes feel: current, force, arm (m,) each."""
    operations = np.array(table.texts.get("operation", [""] * len(table)))
    arm = torque_arm_mm(table)
    for operation in np.unique(operations):
        felt = []
        rows = operations == operation
        for axis in axes:
            signal, force = current_signal(table, axis), forces.get(COMPONENT_OF_AXIS[axis])
            if signal is None or force is None or not moving(table, axis)[rows].all():
                continue
            own_arm = arm if axis == "spindle" and arm is not None else np.ones(len(table))
            felt.append((signal[1], force, own_arm))
        for parts in felt:
            rows &= np.isfinite(np.array(parts)).all(axis=0)
        if len(felt) >= LEAST_AXES and rows.sum() >= LEAST_CUTS:
            chosen = np.flatnonzero(rows)
            yield chosen, [(i[chosen], f[chosen], r[chosen]) for i, f, r in felt]


def _gains(current: Array, force: Array, arm: Array) -> Array:
    """Return the gain (m, m) in log likelihood of exchanging the forces of cuts i and j."""
    m, x, y = len(force), force * arm, current - current.mean()
    step = force[None, :] - force[:, None]  # force of j put to i; cut j gets the opposite
    at_i, at_j = x[:, None] + step * arm[:, None], x[None, :] - step * arm[None, :]

    # Sums over all cuts after the exchange
    x_sum = x.sum() + at_i + at_j - x[:, None] - x[None, :]
    xx = (x @ x) + at_i**2 + at_j**2 - x[:, None] ** 2 - x[None, :] ** 2
    xy = (x @ y) + (at_i - x[:, None]) * y[:, None] + (at_j - x[None, :]) * y[None, :]
    sxx = np.maximum(xx - x_sum**2 / m, 1e-12 * xx)
    left = np.maximum((y @ y) - xy**2 / sxx, 1e-12 * (y @ y))
    gain: Array = 0.5 * (m - 2) * np.log(left[0, 0] / left)
    return gain


def _sentence(pairs: list[tuple[str, str]]) -> str:
    either = " or ".join(f"{a} and {b}" for a, b in pairs[:4])
    more = f" or one of {len(pairs) - 4} more pairs" if len(pairs) > 4 else ""
    return (
        f"{either}{more} look exchanged: with each other's force every axis' current fits better "
        "than chance allows; the cuts in the order in which they were made would work"
    )
