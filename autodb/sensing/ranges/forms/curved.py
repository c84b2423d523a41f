"""Laws that are not linear in their coefficients, fitted by least squares on the target."""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from autodb import fitting
from autodb.sensing.ranges.forms.form import CurrentForm, FittedForm, MeasuredCuts
from autodb.sensing.ranges.forms.noisy import freed

Array = NDArray[np.float64]


def fit_curved(form: CurrentForm, start: Array, felt: MeasuredCuts, target: Array) -> FittedForm:
    """Return the law of a form from a start (p,), freed of the currents' errors where known.

    Raises Undetermined where the cuts (n,) do not hold it.
    """

    def error(values: Array) -> Array:
        return form.value(values, felt) - target

    def slopes(values: Array) -> Array:
        return form.slopes(values, felt)

    found = least_squares(error, start, jac=slopes, x_scale="jac")
    at_end = slopes(found.x)
    fitting.check_rank(fitting.triangle(at_end, target))
    variance = 2.0 * float(found.cost) / max(1, len(target) - len(found.x))
    law = FittedForm(found.x, np.asarray(np.linalg.inv(at_end.T @ at_end) * variance), form)
    return freed(law, felt, target)
