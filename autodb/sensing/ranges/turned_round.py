"""A calibration turned round: the current that a force would show as."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.ranges.forms import CurrentForm, MeasuredCuts

Array = NDArray[np.float64]

BEYOND = 0.5
"""Share of the currents' span by which a current is looked for beyond them. Chosen."""
HALVINGS = 50


def current_of(form: CurrentForm, coefficients: Array, felt: MeasuredCuts, target: Array) -> Array:
    """Return the current (n,) at which a form gives ``target`` (n,), all else as ``felt`` has it.

    Every form goes one way in the current (``sensing.forms``), so that halving finds it. A target
    that no current within the span of ``felt`` and half of it to either side gives has the end.
    """
    span = float(np.ptp(felt.current))
    low = np.full_like(target, felt.current.min() - BEYOND * span)
    high = np.full_like(target, felt.current.max() + BEYOND * span)

    def at(current: Array) -> Array:
        return form.value(coefficients, replace(felt, current=current))

    rising = at(high) > at(low)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        above = (at(middle) > target) == rising
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return np.asarray(0.5 * (low + high))
