"""A form whose gain follows the spindle's temperature, where that is recorded.

A warm spindle's current reads low (P1 table 2: 465.2 N sensed for 485.8 N). The temperature shows
how warm it is: target = what the form says, times exp(k (θ − 20 °C)).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.ranges.forms.form import CurrentForm, FittedForm, MeasuredCuts, form_moves
from autodb.sensing.ranges.forms.noisy import fit_curved
from autodb.wording import localized, stored_msgid

Array = NDArray[np.float64]

REFERENCE_C = 20.0
"""Temperature at which the plain form holds (ISO 1)."""
LEAST_SPAN_C = 3.0
"""Span of the temperature from which on a gain that follows it is tried. Chosen."""
BY_TEMPERATURE = stored_msgid("{kind}, gain by temperature")


class Warmed:
    """Coefficients of ``form`` at 20 °C, then k, 1/K."""

    margin = 1.0

    def __init__(self, form: CurrentForm) -> None:
        self.form = form
        self.kind = f"{form.kind}-warmed"
        self.label = BY_TEMPERATURE.format(kind=form.label)

    def fits(self, sensed: MeasuredCuts) -> bool:
        """Say whether the temperature is known and differs."""
        known = bool(np.isfinite(sensed.temperature_C).all())
        return (
            known and float(np.ptp(sensed.temperature_C)) > LEAST_SPAN_C and self.form.fits(sensed)
        )

    def fit(self, sensed: MeasuredCuts, target: Array) -> FittedForm:
        """Fit by least squares, freed of the currents' errors where these are known.

        Raises Undetermined where the cuts do not hold it.
        """
        start = np.append(self.form.fit(sensed, target).coefficients, 0.0)
        return fit_curved(self, start, sensed, target)

    def value(self, coefficients: Array, sensed: MeasuredCuts) -> Array:
        """Return the target (n,); NaN where the temperature is not known."""
        return self.form.value(coefficients[:-1], sensed) * _gain(coefficients, sensed)

    def slopes(self, coefficients: Array, sensed: MeasuredCuts) -> Array:
        """Return the target's derivatives by the coefficients, (n, p)."""
        gain = _gain(coefficients, sensed)[:, None]
        by_k = self.value(coefficients, sensed) * (sensed.temperature_C - REFERENCE_C)
        return np.column_stack([self.form.slopes(coefficients[:-1], sensed) * gain, by_k])

    def scaling(self, coefficients: Array) -> Array:
        """Return how the form's coefficients scale; k does not."""
        return np.append(self.form.scaling(coefficients[:-1]), 0.0)

    def moves(self, coefficients: Array, slopes: Array, value: Array) -> tuple[Array, Array]:
        """Return shift and share (n, p) as the form has them; k's is a share of the whole."""
        shift, share = self.form.moves(coefficients[:-1], slopes[:, :-1], value)
        of_k = form_moves(slopes[:, -1:], value, idle=np.zeros_like(value), first=0)
        return np.column_stack([shift, of_k[0]]), np.column_stack([share, of_k[1]])

    def beyond(self, sensed: MeasuredCuts) -> Array:
        """Return what the form adds where the cuts never were."""
        return self.form.beyond(sensed)

    def parameters(self) -> dict[str, Any] | None:
        """Return None: the coefficients say all."""
        return None

    def equation(self, coefficients: Array, unit: str, current_unit: str) -> str:
        """Return it as people write it; θ is the spindle's temperature."""
        plain = self.form.equation(coefficients[:-1], unit, current_unit)
        percent = localized(f"{100.0 * coefficients[-1]:+.2g}")
        return f"({plain}) · exp({percent} %/K · (θ − {REFERENCE_C:.0f} °C))"


def _gain(coefficients: Array, sensed: MeasuredCuts) -> Array:
    return np.asarray(np.exp(coefficients[-1] * (sensed.temperature_C - REFERENCE_C)))
