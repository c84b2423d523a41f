"""The spindle's torque as a power of the rise of its current: T = a(n) ΔI^b(n) (P1 section 9).

Constant torque below the base speed n_b, constant power above it. P1 takes cubics of the speed n
for a and b, eight coefficients below and eight above n_b; here a falls as (n_b/n)^g and b is linear
in n.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.linear import Undetermined
from autodb.sensing.ranges.forms.form import FittedForm, MeasuredCuts, form_moves, varies
from autodb.sensing.ranges.forms.noisy import fit_curved
from autodb.wording import amount_words, localized, phrase, stored_msgid

Array = NDArray[np.float64]

MIDDLE_RPM = 1500.0
"""Speed at which the exponent b is said."""
STARTS = np.linspace(0.1, 0.9, 9)
"""Quantiles of the spindle speeds that are tried as the base speed to start from."""
FEWEST = 6
"""Cuts with a torque that a power law is fitted to at least."""
LARGEST = 50.0
"""Logarithm of a torque that no spindle has: trial steps of a fit end there."""


class Power:
    """ln T = ln a0 + b ln ΔI − g·max(0, ln n/n_b): coefficients ln a0, b, and ln n_b; g is 1."""

    kind = "power"
    margin = 1.0
    label = stored_msgid("power of the current")

    def fits(self, sensed: MeasuredCuts) -> bool:
        """Say whether speeds are known and differ."""
        return bool(np.isfinite(sensed.current).all()) and varies(sensed.speed_rpm)

    def fit(self, sensed: MeasuredCuts, target: Array) -> FittedForm:
        """Fit by least squares on the torque, freed of the currents' errors where these are known.

        Raises Undetermined where the cuts hold no n_b.
        """
        return fit_curved(self, self._start(sensed, target), sensed, target)

    def _start(self, sensed: MeasuredCuts, target: Array) -> Array:
        """Return the best line of ln T over ln ΔI over base speeds among those of the cuts."""
        held = (sensed.current > 0) & (target > 0)
        if held.sum() < FEWEST:
            raise Undetermined([0])
        rise, torque, rpm = (
            np.log(sensed.current[held]),
            np.log(target[held]),
            sensed.speed_rpm[held],
        )
        found = []
        for base_rpm in np.quantile(rpm, STARTS):
            level = torque + np.maximum(np.log(rpm / base_rpm), 0.0)
            (b, ln_a), squares, *_ = np.polyfit(rise, level, 1, full=True)
            found.append((float(squares.sum()), ln_a, b, np.log(base_rpm)))
        return np.array(min(found)[1:])

    def value(self, coefficients: Array, sensed: MeasuredCuts) -> Array:
        """Return the torque (n,); a current that does not rise gives none (P1 section 9)."""
        still = sensed.current <= 0
        logarithm = self._parts(coefficients, sensed) @ self._weights(coefficients)
        return np.where(still, 0.0, np.exp(np.minimum(np.where(still, 0.0, logarithm), LARGEST)))

    def _weights(self, coefficients: Array) -> Array:
        return np.array([coefficients[0], coefficients[1], -1.0])

    def _parts(self, coefficients: Array, sensed: MeasuredCuts) -> Array:
        """Return the columns of ln T (n, 3): one, ln ΔI, and how far above the base speed."""
        above = np.maximum(np.log(sensed.speed_rpm) - coefficients[2], 0.0)
        return np.column_stack([np.ones_like(above), _ln(sensed.current), above])

    def slopes(self, coefficients: Array, sensed: MeasuredCuts) -> Array:
        """Return the torque's derivatives by the coefficients, (n, p)."""
        parts = self._parts(coefficients, sensed)
        by_logarithm = self._of_logarithm(coefficients, parts)
        return np.asarray(self.value(coefficients, sensed)[:, None] * by_logarithm)

    def _of_logarithm(self, coefficients: Array, parts: Array) -> Array:  # noqa: ARG002 - g is 1
        return np.column_stack([parts[:, 0], parts[:, 1], (parts[:, 2] > 0).astype(np.float64)])

    def scaling(self, coefficients: Array) -> Array:
        """Return the change of ln a0: it alone scales."""
        return np.asarray(np.eye(len(coefficients))[0])

    def moves(self, coefficients: Array, slopes: Array, value: Array) -> tuple[Array, Array]:  # noqa: ARG002
        """Return shift and share (n, p): without a current there is nothing, so all is a share."""
        return form_moves(slopes, value, idle=np.zeros_like(value), first=0)

    def beyond(self, sensed: MeasuredCuts) -> Array:
        """Return zeros: a law holds as far as it goes."""
        return np.zeros_like(sensed.current)

    def parameters(self) -> dict[str, Any] | None:
        """Return None: the coefficients say all."""
        return None

    def equation(self, coefficients: Array, unit: str, current_unit: str) -> str:
        """Return it as people write it."""
        exponent = localized(f"{coefficients[1]:.3g}")
        return self._written(coefficients, unit, current_unit, exponent, "")

    def _written(
        self, coefficients: Array, unit: str, current_unit: str, exponent: str, falls: str
    ) -> str:
        scale, base_rpm = np.exp(coefficients[0]), np.exp(coefficients[2])
        power = f"{localized(f'{scale:.4g}')} {unit} · (I/{current_unit})^{exponent}"
        return phrase(
            "{power}, above {speed} times ({base}/n){falls}",
            power=power,
            speed=amount_words(base_rpm, "rpm", ".0f"),
            base=f"{base_rpm:.0f}",
            falls=falls,
        )


def _ln(current: Array) -> Array:
    return np.log(np.where(current <= 0, 1.0, current))


class PowerOfSpeed(Power):
    """The same with b = b0 + b1·(n − MIDDLE_RPM)/1000 rpm, and g free."""

    kind = "power-of-speed"
    label = stored_msgid("power of the current, exponent by speed")

    def _start(self, sensed: MeasuredCuts, target: Array) -> Array:
        return np.append(super()._start(sensed, target), [0.0, 1.0])

    def _weights(self, coefficients: Array) -> Array:
        ln_a, b, _, change, falls = coefficients
        return np.array([ln_a, b, -falls, change])

    def _parts(self, coefficients: Array, sensed: MeasuredCuts) -> Array:
        krpm = (sensed.speed_rpm - MIDDLE_RPM) / 1000.0
        return np.column_stack([super()._parts(coefficients, sensed), krpm * _ln(sensed.current)])

    def _of_logarithm(self, coefficients: Array, parts: Array) -> Array:
        plain = super()._of_logarithm(coefficients, parts)
        plain[:, 2] *= coefficients[4]
        return np.column_stack([plain, parts[:, 3], -parts[:, 2]])

    def equation(self, coefficients: Array, unit: str, current_unit: str) -> str:
        """Return it as people write it; n is the spindle speed."""
        _, b, _, change, falls = coefficients
        rises = localized(f"{b:.3g} {change:+.2g}")
        exponent = f"({rises} · (n − {MIDDLE_RPM:.0f})/1000 rpm)"
        falling = localized(f"^{falls:.3g}")
        return self._written(coefficients, unit, current_unit, exponent, falling)
