"""Two cuts whose known forces are exchanged: the currents say which of them was which."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from autodb.records.tables import CutTable
from autodb.sensing.ranges.faults.check import DataCheck
from autodb.sensing.ranges.feeding import moving, torque_arm_mm
from autodb.sensing.ranges.points import COMPONENT_OF_AXIS, current_signal
from autodb.wording import phrase

Array = NDArray[np.float64]
Line = tuple[Array, Array, Array]
"""Current, force and arm of the cuts (m,) that an axis senses."""

LEAST_CUTS = 8
"""Cuts of one operation, before two are said to be exchanged. Chosen."""
LEAST_AXES = 2
"""Axes that must all fit better: on one axis a single outlying current looks like an exchange."""
CHANCE = 0.001
"""Probability that sound cuts look exchanged, over all pairs of a table together."""
MOST_CUTS = 300
"""Pairs are searched for among this many cuts furthest off the lines, where exchanged ones lie."""
ROUNDING = 1e-12
CLOSE = 20.0
"""Another pair is a candidate too where its likelihood is within this factor of the best one's."""


def exchanged(
    table: CutTable, forces: Mapping[str, Array], axes: Sequence[str], names: Sequence[str]
) -> list[DataCheck]:
    """Return, for each operation, whether two of its cuts have each other's known forces.

    ``forces``: known forces (n,), N, by component; ``names`` (n,) of the cuts, for the sentence. Of
    each axis the current is a line over its force (or torque), with normal scatter. Exchanging the
    forces of cuts i and j changes the log likelihood by g = (m − 2)/2 · ln(SSE/SSE_ij) on m cuts.
    A likelihood ratio exceeds c by chance with probability 1/c at most (Markov), so the largest sum
    over axes is beyond chance where it exceeds ln(pairs/CHANCE). Two are tried of each pair: that
    the forces are exchanged, and that the torque's arm is with them (all that a plan says of a
    cut). Every axis must gain, and each of the two cuts by itself, beyond 1/CHANCE: where only one
    does, its current is an outlier, not exchanged.
    """
    checks = []
    for rows, lines in _operations(table, forces, axes):
        outlying = _furthest(lines)
        first, second = np.triu_indices(len(outlying), 1)
        whole = [(current, force * arm, np.ones_like(arm)) for current, force, arm in lines]
        gain = np.maximum(_joint_gain(lines, outlying), _joint_gain(whole, outlying))[first, second]
        best = float(gain.max())
        near = np.flatnonzero(gain > max(best - np.log(CLOSE), 0.0))
        pairs = [(names[rows[outlying[first[k]]]], names[rows[outlying[second[k]]]]) for k in near]
        count = len(rows) * (len(rows) - 1)  # of pairs, each tried in two ways
        threshold = float(np.log(count / CHANCE))
        checks.append(DataCheck("cuts exchanged", best, "<=", threshold, _sentence(pairs)))
    return checks


def _joint_gain(lines: list[Line], outlying: NDArray[np.intp]) -> Array:
    """Return the gain (k, k) over all axes; 0 where an axis or one of the cuts gains none."""
    made = [_gains(*line, outlying) for line in lines]
    gains, own = (np.array(parts) for parts in zip(*made, strict=True))
    each = own.sum(axis=0) > -np.log(CHANCE)
    sound = (gains > 0).all(axis=0) & each & each.T
    joint: Array = np.where(sound, gains.sum(axis=0), 0.0)
    return joint


def _operations(
    table: CutTable, forces: Mapping[str, Array], axes: Sequence[str]
) -> Iterator[tuple[NDArray[np.intp], list[Line]]]:
    """Yield the cuts (m,) of an operation that all its axes sense: current, force, arm (m,)
    each."""
    operations = np.array(table.texts.get("operation", [""] * len(table)))
    arm = torque_arm_mm(table)
    for operation in np.unique(operations):
        sensed = []
        rows = operations == operation
        for axis in axes:
            signal, force = current_signal(table, axis), forces.get(COMPONENT_OF_AXIS[axis])
            if signal is None or force is None or not moving(table, axis)[rows].all():
                continue
            own_arm = arm if axis == "spindle" and arm is not None else np.ones(len(table))
            sensed.append((signal[1], force, own_arm))
        for parts in sensed:
            rows &= np.isfinite(np.array(parts)).all(axis=0)
        if len(sensed) >= LEAST_AXES and rows.sum() >= LEAST_CUTS:
            chosen = np.flatnonzero(rows)
            yield chosen, [(i[chosen], f[chosen], r[chosen]) for i, f, r in sensed]


def _furthest(lines: list[Line]) -> NDArray[np.intp]:
    """Return the cuts furthest off the lines of all axes, in their order."""
    off = np.zeros(len(lines[0][0]))
    for current, force, arm in lines:
        left = _off_line(force * arm, current)
        off += left**2 / max(float(np.mean(left**2)), ROUNDING)
    return np.sort(np.argsort(off)[-MOST_CUTS:])


def _off_line(x: Array, y: Array) -> Array:
    """Return y less its least-squares line over x, (m,)."""
    x, y = x - x.mean(), y - y.mean()
    left: Array = y - (x @ y) / max(float(x @ x), ROUNDING) * x
    return left


def _gains(
    current: Array, force: Array, arm: Array, outlying: NDArray[np.intp]
) -> tuple[Array, Array]:
    """Return the gain (k, k) in log likelihood of exchanging the forces of cuts i and j of
    ``outlying``.

    The second (k, k) is what cut i gains by itself, at the scatter after the exchange.
    """
    m, x, y = len(force), force * arm, current - current.mean()
    total, squares, product = x.sum(), x @ x, x @ y
    before = _off_line(x, y)
    left_before = max(float(before @ before), ROUNDING * float(y @ y))
    force, arm, x, y, before = (
        force[outlying],
        arm[outlying],
        x[outlying],
        y[outlying],
        before[outlying],
    )
    step = force[None, :] - force[:, None]  # force of j put to i; cut j gets the opposite
    at_i, at_j = x[:, None] + step * arm[:, None], x[None, :] - step * arm[None, :]

    # Sums over all cuts after the exchange, about the mean of x
    x_mean = (total + at_i + at_j - x[:, None] - x[None, :]) / m
    sxx = squares + at_i**2 + at_j**2 - x[:, None] ** 2 - x[None, :] ** 2 - m * x_mean**2
    sxy = product + (at_i - x[:, None]) * y[:, None] + (at_j - x[None, :]) * y[None, :]
    slope = sxy / np.maximum(sxx, ROUNDING * squares)
    spread = float(np.sum((current - current.mean()) ** 2))
    left = np.maximum(spread - slope * sxy, ROUNDING * spread)

    # Cut i alone, before and after
    after = y[:, None] - slope * (at_i - x_mean)
    own: Array = 0.5 * (m - 2) * (before[:, None] ** 2 - after**2) / left
    gain: Array = 0.5 * (m - 2) * np.log(left_before / left)
    return gain, own


def _sentence(pairs: list[tuple[str, str]]) -> str:
    if not pairs:
        return ""
    either = " or ".join(f"{a} and {b}" for a, b in pairs[:4])
    more = phrase(" or one of {n} more pairs", n=len(pairs) - 4) if len(pairs) > 4 else ""
    return phrase(
        "{either}{more} look exchanged (with each other's force every axis' current "
        "fits better than chance allows); put the cuts in the order in which they were "
        "made",
        either=either,
        more=more,
    )
