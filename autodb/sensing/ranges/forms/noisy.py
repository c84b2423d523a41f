"""A law fitted to currents that have an error of their own, of known standard deviation.

Least squares takes currents for exact and finds too flat a slope. Here the score is corrected for
what the current's error u adds to it on average (Fuller 1987, Measurement error models, section
3.1; Nakamura 1990, Biometrika 77:127), each cut weighed by the whole variance (effective variance:
York et al. 2004, Am. J. Phys. 72:367), with s the derivatives by the coefficients, ' those by the
current, r = target − T:

    Σ w (s r + u² s' T') = 0,   w = 1/(τ² + u² T'²),   τ² = Σ r²/(n − p) − mean u² T'²

τ² is the scatter of targets about the law beyond the currents' (equation error, Fuller 1987,
section 2.2). Without u this is least squares.

Laws that are not linear in their coefficients, fitted by least squares on the target.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.linear import Undetermined, check_rank, triangle
from autodb.sensing.ranges.forms.form import CurrentForm, FittedForm, MeasuredCuts

Array = NDArray[np.float64]

ROUNDS = 200
SHORTER = 3
"""Rounds after which steps get shorter: cuts near a base speed are now on the one side of it, now
on the other, and the score changes its sign in between.
"""
SETTLED = 0.01
"""Standard deviations of a coefficient by which the last round may move it."""
LONGEST = 2.0
"""The same of one round: further away a power law may not be the straight line it is taken for."""
STEP = 1e-4
"""Share of a current over which derivatives by it are taken."""
LEAST_OWN = 1e-3
"""Share of the variance about the law that is at least the targets' own."""
LEAST_TRUE = 0.2
"""Share of the columns' squares, in every direction, that must not be the current's error."""


@dataclass(frozen=True)
class _Round:
    """Products of the columns less the errors' (p, p), score (p,), covariance (p, p)."""

    products: Array
    score: Array
    covariance: Array


def freed(law: FittedForm, sensed: MeasuredCuts, target: Array) -> FittedForm:
    """Return a law fitted by least squares, fitted anew for the error of the currents (n,).

    Raises Undetermined where the currents hardly vary beyond their error, or no law is settled on.
    """
    if not sensed.current_sd.any():
        return law
    coefficients = law.coefficients
    for k in range(ROUNDS):
        found = _round(law.form, coefficients, sensed, target)
        step = np.linalg.solve(found.products, found.score)
        size = float(np.max(np.abs(step) / np.sqrt(np.diag(found.covariance))))
        part = min(1.0 / (1.0 + k / SHORTER), LONGEST / size) if size else 1.0
        coefficients = coefficients + part * step
        if part * size <= SETTLED:
            return FittedForm(coefficients, found.covariance, law.form)
    raise Undetermined([])


def by_current(form: CurrentForm, coefficients: Array, sensed: MeasuredCuts) -> tuple[Array, Array]:
    """Return the derivatives of target (n,) and of slopes (n, p) by the current, central."""
    step = STEP * (np.abs(sensed.current) + STEP)
    up, down = sensed.moved(step), sensed.moved(-step)
    values = form.value(coefficients, up) - form.value(coefficients, down)
    slopes = form.slopes(coefficients, up) - form.slopes(coefficients, down)
    return values / (2.0 * step), slopes / (2.0 * step)[:, None]


def _round(form: CurrentForm, coefficients: Array, sensed: MeasuredCuts, target: Array) -> _Round:
    slopes, residual = form.slopes(coefficients, sensed), target - form.value(coefficients, sensed)
    rising, bending = by_current(form, coefficients, sensed)
    square = sensed.current_sd**2
    from_current = square * rising**2
    freedom = max(1, len(target) - len(coefficients))
    variance = float(residual @ residual) / freedom
    scatter = max(LEAST_OWN * variance, variance - float(np.mean(from_current)))
    weight = 1.0 / (scatter + from_current)

    # what currents without error would have made of the products, and the score's own scatter
    whole = slopes.T @ (slopes * weight[:, None])
    errors = bending.T @ (bending * (weight * square)[:, None])
    _refuse_noise(whole, errors)
    spread = whole + bending.T @ (bending * (weight * square * weight * from_current)[:, None])
    inverse = np.linalg.inv(whole - errors)
    score = slopes.T @ (weight * residual) + bending.T @ (weight * square * rising)
    return _Round(whole - errors, score, inverse @ spread @ inverse)


def _refuse_noise(whole: Array, errors: Array) -> None:
    """Raise Undetermined where errors make up nearly all of some direction of the columns."""
    from scipy.linalg import eigh

    try:
        largest = float(eigh(errors, whole, eigvals_only=True)[-1])
    except np.linalg.LinAlgError as error:  # the columns do not determine a coefficient
        raise Undetermined([1]) from error
    if largest > 1.0 - LEAST_TRUE:
        raise Undetermined([1])


def fit_curved(form: CurrentForm, start: Array, sensed: MeasuredCuts, target: Array) -> FittedForm:
    """Return the law of a form from a start (p,), freed of the currents' errors where known.

    Raises Undetermined where the cuts (n,) do not hold it.
    """
    from scipy.optimize import least_squares

    def error(values: Array) -> Array:
        return form.value(values, sensed) - target

    def slopes(values: Array) -> Array:
        return form.slopes(values, sensed)

    found = least_squares(error, start, jac=slopes, x_scale="jac")
    at_end = slopes(found.x)
    check_rank(triangle(at_end, target))
    variance = 2.0 * float(found.cost) / max(1, len(target) - len(found.x))
    law = FittedForm(found.x, np.asarray(np.linalg.inv(at_end.T @ at_end) * variance), form)
    return freed(law, sensed, target)
