"""Straight lines of force over current, the slope constant or by the feed speed.

F = c0 + c1 I (P1 section 9); a screw that loses more at creep changes the slope with the feed speed
v, F = c0 + (c1 + c2 ln v) I.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.linear import least_squares
from autodb.sensing.ranges.forms.form import FittedForm, MeasuredCuts, form_moves, varies
from autodb.sensing.ranges.forms.noisy import freed
from autodb.wording import localized, stored_msgid

Array = NDArray[np.float64]


class StraightLine:
    """A form that is linear in its coefficients."""

    kind = "line"
    margin = 1.0
    label = stored_msgid("line")

    def columns(self, sensed: MeasuredCuts) -> Array:
        """Return the columns (n, p)."""
        return np.column_stack([np.ones_like(sensed.current), sensed.current])

    def fits(self, sensed: MeasuredCuts) -> bool:
        """Say whether there is a current."""
        return bool(np.isfinite(sensed.current).all())

    def fit(self, sensed: MeasuredCuts, target: Array) -> FittedForm:
        """Fit by least squares, freed of the currents' errors where these are known."""
        found = least_squares(self.columns(sensed), target)
        return freed(FittedForm(found.coefficients, found.covariance, self), sensed, target)

    def value(self, coefficients: Array, sensed: MeasuredCuts) -> Array:
        """Return the target (n,)."""
        return np.asarray(self.columns(sensed) @ coefficients)

    def slopes(self, coefficients: Array, sensed: MeasuredCuts) -> Array:  # noqa: ARG002 - it is linear
        """Return the columns."""
        return self.columns(sensed)

    def scaling(self, coefficients: Array) -> Array:
        """Return the coefficients: all of them scale."""
        return coefficients

    def moves(self, coefficients: Array, slopes: Array, value: Array) -> tuple[Array, Array]:
        """Return shift and share (n, p): the constant shifts, what the current makes is a share."""
        return form_moves(slopes, value, idle=coefficients[0] * slopes[:, 0], first=1)

    def beyond(self, sensed: MeasuredCuts) -> Array:
        """Return zeros: a law holds as far as it goes."""
        return np.zeros_like(sensed.current)

    def parameters(self) -> dict[str, Any] | None:
        """Return None: the coefficients say all."""
        return None

    def equation(self, coefficients: Array, unit: str, current_unit: str) -> str:
        """Return it as people write it; I is the current."""
        c0, c1 = coefficients[:2]
        return f"{localized(f'{c0:.4g}')} {unit} {_added(c1)} {unit}/{current_unit} · I"


class LineOfSpeed(StraightLine):
    """A line whose slope follows the logarithm of the feed speed."""

    kind = "line-of-speed"
    label = stored_msgid("line, slope by feed speed")

    def columns(self, sensed: MeasuredCuts) -> Array:
        """Return the columns (n, 3)."""
        return np.column_stack([super().columns(sensed), sensed.current * np.log(sensed.feed_mm_s)])

    def fits(self, sensed: MeasuredCuts) -> bool:
        """Say whether feed speeds are known and differ."""
        return super().fits(sensed) and varies(sensed.feed_mm_s)

    def equation(self, coefficients: Array, unit: str, current_unit: str) -> str:
        """Return it as people write it; v is the feed speed."""
        c0, c1, c2 = coefficients
        level, rise = localized(f"{c0:.4g}"), localized(f"{c1:.4g}")
        slope = f"({rise} {_added(c2)} · ln v) {unit}/{current_unit}"
        return f"{level} {unit} + {slope} · I, v in mm/s"


def _added(coefficient: float) -> str:
    """Return a summand behind another one, its sign apart from it."""
    return f"{'−' if coefficient < 0 else '+'} {localized(f'{abs(coefficient):.4g}')}"
