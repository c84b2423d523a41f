"""Sense cuts with several calibrations of one axis: each cut with the one that holds for it.

A calibration turned round: the current that a force would show as.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.records.tables import CutTable
from autodb.sensing.ranges.calibration import Calibration
from autodb.sensing.ranges.feeding import moving
from autodb.sensing.ranges.forms import CurrentForm, MeasuredCuts
from autodb.sensing.ranges.sensed_force import sense, stands_still
from autodb.sensing.ranges.validity import holds_of, which
from autodb.wording import stored_msgid

Array = NDArray[np.float64]

NOT_FOR_IT = stored_msgid("{axis} was {said}")
OF_AXIS = stored_msgid("{axis}: {verdict}")


@dataclass(frozen=True)
class SensedCut:
    """One cut: force and its own sd, N, the derivatives ``common`` (p,), or the reason why none.

    ``by``: which calibration sensed it.
    """

    by: int | None
    force_N: float | None
    sd_N: float | None
    common: list[float] | None
    reason: str | None


def sense_each(table: CutTable, calibrations: Sequence[Calibration]) -> list[SensedCut]:
    """Return what an axis senses in each cut of a table, with the calibration that holds for it.

    Of the calibrations, of one axis, no two hold for the same cut; one that is not usable senses
    nothing.
    """
    axis = calibrations[0].axis
    sensed = [sense(table, one) for one in calibrations]
    chosen, moves = choose(table, calibrations), moving(table, axis)
    measured = []
    for row, by in enumerate(chosen):
        reason = None if isinstance(by, str) else sensed[by].not_sensed[row]
        if isinstance(by, str):
            why = NOT_FOR_IT.format(axis=axis, said=by) if moves[row] else stands_still(axis)
            measured.append(_none(why))
        elif not calibrations[by].offered:
            one_of = calibrations[by]
            measured.append(_none(OF_AXIS.format(axis=one_of.called, verdict=one_of.verdict)))
        elif reason is not None:
            measured.append(SensedCut(by, None, None, None, reason))
        else:
            one = sensed[by]
            force_N, sd_N = float(one.force_N[row]), float(one.sd_N[row])
            measured.append(SensedCut(by, force_N, sd_N, one.common[row].tolist(), None))
    return measured


def _none(why: str) -> SensedCut:
    return SensedCut(None, None, None, None, why)


def choose(table: CutTable, calibrations: Sequence[Calibration]) -> list[int | str]:
    """Return which calibration holds for each cut (n,), or why none does."""
    known = [one.holds for one in calibrations]
    return [which(known, cut) for cut in holds_of(table, calibrations[0].axis)]


BEYOND = 0.5
"""Share of the currents' span by which a current may lie beyond them. Chosen."""
HALVINGS = 50


def current_of(
    form: CurrentForm, coefficients: Array, sensed: MeasuredCuts, target: Array
) -> Array:
    """Return the current (n,) at which a form gives ``target`` (n,), all else as ``sensed`` has it.

    Every form goes one way in the current (``ranges.forms``), so that halving finds it. A target
    that no current within the span of ``sensed`` and half of it to either side gives has the end.
    """
    span = float(np.ptp(sensed.current))
    low = np.full_like(target, sensed.current.min() - BEYOND * span)
    high = np.full_like(target, sensed.current.max() + BEYOND * span)

    def at(current: Array) -> Array:
        return form.value(coefficients, replace(sensed, current=current))

    rising = at(high) > at(low)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        above = (at(middle) > target) == rising
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return np.asarray(0.5 * (low + high))
