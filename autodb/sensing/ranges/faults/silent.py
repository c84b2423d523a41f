"""A current sensor that gives nothing: the same in air, in light and in heavy cuts."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from autodb.records.tables import CutTable
from autodb.sensing.ranges.faults.check import DataCheck
from autodb.sensing.ranges.feeding import moving
from autodb.sensing.ranges.points import COMPONENT_OF_AXIS, current_signal
from autodb.wording import listed, phrase

Array = NDArray[np.float64]

LEAST_CUTS = 6
"""Cuts in which an axis moves, before its silence is judged: with fewer, a sensor that is merely
noisy could look silent. Chosen."""
CHANCE = 0.001
"""Probability at which a sensor without a signal seems to have one, or the other way round."""
FAINT = 0.02
"""Without air ranges a silent sensor shows no more than this share of what any other axis shows:
its level is noise. Chosen."""


def silent_axes(
    table: CutTable, forces: Mapping[str, Array], axes: Sequence[str]
) -> dict[str, DataCheck]:
    """Return, of each axis that can be judged, whether its current responds to the load.

    The statistic is that of ``responses``; without air ranges the axis must be faint as well. Only
    judged where another axis responds to these cuts: a passive axis, and a table in which nothing
    was cut, give no check.
    """
    found = responses(table, forces, axes)
    heard = {axis for axis, (t, limit) in found.items() if t > limit}
    return {
        axis: DataCheck(
            name=f"{axis}.current responds",
            statistic=t,
            operator=">",
            threshold=limit,
            sentence=_sentence(table, axis, sorted(heard - {axis})),
        )
        for axis, (t, limit) in found.items()
        if heard - {axis} and (axis in heard or _at_noise(table, axis, heard))
    }


def responses(
    table: CutTable, forces: Mapping[str, Array], axes: Sequence[str]
) -> dict[str, tuple[float, float]]:
    """Return |t| of each axis' current over the load, and what chance gives it.

    ``forces``: known forces (n,), N, by component; where an axis' own is not known, depth · feed is
    the load. t is that of the slope b of rise = b · load over the cuts in which the axis moves: the
    rise over air is zero without load. Without air ranges the line has an intercept. Both are free
    of the units. Axes with fewer than LEAST_CUTS such cuts are left out.
    """
    from scipy import stats

    found = {}
    for axis in axes:
        known = _rise_and_load(table, forces, axis)
        if known is not None:
            t, dof = _slope_t(*known)
            found[axis] = t, float(stats.t.isf(CHANCE / 2.0, dof))
    return found


def _rise_and_load(
    table: CutTable, forces: Mapping[str, Array], axis: str
) -> tuple[Array, Array, bool] | None:
    """Return current (m,), load (m,) of the cuts in which an axis moves, and whether air is off."""
    signal = current_signal(table, axis)
    load = forces.get(COMPONENT_OF_AXIS[axis])
    if load is None and "cutting.feed" in table and "cutting.depth" in table:
        load = table["cutting.feed"] * table["cutting.depth"]
    if signal is None or load is None:
        return None
    rows = moving(table, axis) & np.isfinite(signal[1]) & np.isfinite(load)
    if rows.sum() < LEAST_CUTS or np.ptp(load[rows]) == 0:
        return None
    return signal[1][rows], load[rows], _has_air(table, axis)


def _has_air(table: CutTable, axis: str) -> bool:
    return f"{axis}.current.air" in table and f"{axis}.current.range" in table


def _slope_t(current: Array, load: Array, through_zero: bool) -> tuple[float, int]:
    """Return |t| of a current's slope over the load, and its degrees of freedom."""
    dof = len(load) - (1 if through_zero else 2)
    if not through_zero:
        current, load = current - current.mean(), load - load.mean()
    slope = float(load @ current) / float(load @ load)
    left = float(np.sum((current - slope * load) ** 2)) / dof
    if slope == 0.0:
        return 0.0, dof
    return (abs(slope) * float(np.sqrt((load @ load) / left)) if left > 0 else np.inf), dof


def _at_noise(table: CutTable, axis: str, heard: set[str]) -> bool:
    """Say whether a silent axis' level shows that it is noise; with air ranges it need not."""
    if _has_air(table, axis):
        return True
    return _level(table, axis) < FAINT * min(_level(table, other) for other in heard)


def _level(table: CutTable, axis: str) -> float:
    signal = current_signal(table, axis)
    assert signal is not None  # a response was found in it
    return float(np.nanmedian(np.abs(signal[1][moving(table, axis)])))


def _sentence(table: CutTable, axis: str, others: list[str]) -> str:
    where = phrase("in air, in light and") if _has_air(table, axis) else phrase("in light and")
    stated = any(table.texts.get("operation", ()))
    stands = (
        ""
        if stated
        else phrase("; if {axis} stands still in these cuts, state it by 'operation'", axis=axis)
    )
    return phrase(
        "{axis}.current: the same {where} in heavy cuts, while {names} respond: the "
        "sensor gives nothing; check its plug{stands}",
        axis=axis,
        where=where,
        names=listed(others, phrase(" and ")),
        stands=stands,
    )
