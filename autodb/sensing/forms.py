"""Forms in which an axis' current tells force or torque, the plainest first.

Feed axes (P1 section 9): F = c0 + c1 I; a screw that loses more at creep changes the slope with the
feed speed v, F = c0 + (c1 + c2 ln v) I. Spindle: T = a(n) ΔI^b(n), a constant below the base speed
n_b (constant torque) and falling above it (constant power). P1 takes cubics of the speed n for a
and b, eight coefficients below and eight above n_b; here a falls as (n_b/n)^g and b is linear in n.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from autodb import fitting

Array = NDArray[np.float64]

MIDDLE_RPM = 1500.0
"""Speed at which the exponent b is said."""
STARTS = np.linspace(0.1, 0.9, 9)
"""Quantiles of the spindle speeds that are tried as the base speed to start from."""
NARROWEST = 1.15
"""Ratio of highest to lowest speed from which on a dependence on it is looked for."""
FEWEST = 6
"""Cuts with a torque that a power law is fitted to at least."""
LARGEST = 50.0
"""Logarithm of a torque that no spindle has: trial steps of a fit end there."""


@dataclass(frozen=True)
class Felt:
    """What an axis felt in cuts (n,): current, A; feed speed, mm/s, spindle speed, rpm (NaN: not
    known).
    """

    current: Array
    feed_mm_s: Array
    speed_rpm: Array

    def at(self, rows: NDArray[np.bool_] | NDArray[np.intp]) -> "Felt":
        """Return some of the cuts, or all in another order."""
        return Felt(self.current[rows], self.feed_mm_s[rows], self.speed_rpm[rows])


@dataclass(frozen=True)
class Law:
    """Coefficients (p,) of a form and their covariance (p, p)."""

    coefficients: Array
    covariance: Array


class Form(Protocol):
    """One form; ``kind`` is what it is stored as, ``steady`` how many coefficients, the first ones,
    have slopes without the current.
    """

    kind: str
    steady: int

    def fits(self, felt: Felt) -> bool:
        """Say whether the cuts have what the form depends on, and vary in it."""

    def fit(self, felt: Felt, target: Array) -> Law:
        """Fit it to a target (n,); raises Undetermined where the cuts do not hold it."""

    def value(self, coefficients: Array, felt: Felt) -> Array:
        """Return the target (n,)."""

    def slopes(self, coefficients: Array, felt: Felt) -> Array:
        """Return the target's derivatives by the coefficients, (n, p)."""

    def scaling(self, coefficients: Array) -> Array:
        """Return how the coefficients (p,) change, per share, when the whole target is scaled."""

    def equation(self, coefficients: Array, unit: str, current_unit: str) -> str:
        """Return it as people write it; I is the current."""


class _Linear:
    """A form that is linear in its coefficients."""

    kind = "line"
    steady = 1

    def columns(self, felt: Felt) -> Array:
        """Return the columns (n, p)."""
        return np.column_stack([np.ones_like(felt.current), felt.current])

    def fits(self, felt: Felt) -> bool:
        """Say whether there is a current."""
        return bool(np.isfinite(felt.current).all())

    def fit(self, felt: Felt, target: Array) -> Law:
        """Fit by least squares."""
        found = fitting.least_squares(self.columns(felt), target)
        return Law(found.coefficients, found.covariance)

    def value(self, coefficients: Array, felt: Felt) -> Array:
        """Return the target (n,)."""
        return np.asarray(self.columns(felt) @ coefficients)

    def slopes(self, coefficients: Array, felt: Felt) -> Array:  # noqa: ARG002 - it is linear
        """Return the columns."""
        return self.columns(felt)

    def scaling(self, coefficients: Array) -> Array:
        """Return the coefficients: all of them scale."""
        return coefficients

    def equation(self, coefficients: Array, unit: str, current_unit: str) -> str:
        """Return it as people write it; I is the current."""
        c0, c1 = coefficients[:2]
        return f"{c0:.4g} {unit} {c1:+.4g} {unit}/{current_unit} · I"


class _LineOfSpeed(_Linear):
    """A line whose slope follows the logarithm of the feed speed."""

    kind = "line-of-speed"

    def columns(self, felt: Felt) -> Array:
        """Return the columns (n, 3)."""
        return np.column_stack([super().columns(felt), felt.current * np.log(felt.feed_mm_s)])

    def fits(self, felt: Felt) -> bool:
        """Say whether feed speeds are known and differ."""
        return super().fits(felt) and _varies(felt.feed_mm_s)

    def equation(self, coefficients: Array, unit: str, current_unit: str) -> str:
        """Return it as people write it; v is the feed speed."""
        c0, c1, c2 = coefficients
        slope = f"({c1:.4g} {c2:+.4g} · ln v) {unit}/{current_unit}"
        return f"{c0:.4g} {unit} + {slope} · I, v in mm/s"


def _varies(speed: Array) -> bool:
    known = bool(np.isfinite(speed).all()) and bool(np.all(speed > 0))
    return known and float(speed.max()) > NARROWEST * float(speed.min())


class _Power:
    """ln T = ln a0 + b ln ΔI − g·max(0, ln n/n_b): coefficients ln a0, b, and ln n_b; g is 1."""

    kind = "power"
    steady = 0

    def fits(self, felt: Felt) -> bool:
        """Say whether speeds are known and differ."""
        return bool(np.isfinite(felt.current).all()) and _varies(felt.speed_rpm)

    def fit(self, felt: Felt, target: Array) -> Law:
        """Fit by least squares on the torque; raises Undetermined where the cuts hold no n_b."""

        def error(values: Array) -> Array:
            return self.value(values, felt) - target

        def slopes(values: Array) -> Array:
            return self.slopes(values, felt)

        found = least_squares(error, self._start(felt, target), jac=slopes, x_scale="jac")
        at_end = slopes(found.x)
        fitting.check_rank(fitting.triangle(at_end, target))
        variance = 2.0 * float(found.cost) / max(1, len(target) - len(found.x))
        return Law(found.x, np.asarray(np.linalg.inv(at_end.T @ at_end) * variance))

    def _start(self, felt: Felt, target: Array) -> Array:
        """Return the best line of ln T over ln ΔI over base speeds among those of the cuts."""
        held = (felt.current > 0) & (target > 0)
        if held.sum() < FEWEST:
            raise fitting.Undetermined([0])
        rise, torque, rpm = np.log(felt.current[held]), np.log(target[held]), felt.speed_rpm[held]
        found = []
        for base_rpm in np.quantile(rpm, STARTS):
            level = torque + np.maximum(np.log(rpm / base_rpm), 0.0)
            (b, ln_a), squares, *_ = np.polyfit(rise, level, 1, full=True)
            found.append((float(squares.sum()), ln_a, b, np.log(base_rpm)))
        return np.array(min(found)[1:])

    def value(self, coefficients: Array, felt: Felt) -> Array:
        """Return the torque (n,); a current that does not rise tells none (P1 section 9)."""
        still = felt.current <= 0
        logarithm = self._parts(coefficients, felt) @ self._weights(coefficients)
        return np.where(still, 0.0, np.exp(np.minimum(np.where(still, 0.0, logarithm), LARGEST)))

    def _weights(self, coefficients: Array) -> Array:
        return np.array([coefficients[0], coefficients[1], -1.0])

    def _parts(self, coefficients: Array, felt: Felt) -> Array:
        """Return the columns of ln T (n, 3): one, ln ΔI, and how far above the base speed."""
        above = np.maximum(np.log(felt.speed_rpm) - coefficients[2], 0.0)
        return np.column_stack([np.ones_like(above), _ln(felt.current), above])

    def slopes(self, coefficients: Array, felt: Felt) -> Array:
        """Return the torque's derivatives by the coefficients, (n, p)."""
        parts = self._parts(coefficients, felt)
        by_logarithm = self._of_logarithm(coefficients, parts)
        return np.asarray(self.value(coefficients, felt)[:, None] * by_logarithm)

    def _of_logarithm(self, coefficients: Array, parts: Array) -> Array:  # noqa: ARG002 - g is 1
        return np.column_stack([parts[:, 0], parts[:, 1], (parts[:, 2] > 0).astype(np.float64)])

    def scaling(self, coefficients: Array) -> Array:
        """Return the change of ln a0: it alone scales."""
        return np.asarray(np.eye(len(coefficients))[0])

    def equation(self, coefficients: Array, unit: str, current_unit: str) -> str:
        """Return it as people write it."""
        return self._written(coefficients, unit, current_unit, f"{coefficients[1]:.3g}", "")

    def _written(
        self, coefficients: Array, unit: str, current_unit: str, exponent: str, falls: str
    ) -> str:
        scale, base_rpm = np.exp(coefficients[0]), np.exp(coefficients[2])
        power = f"{scale:.4g} {unit} · (I/{current_unit})^{exponent}"
        return f"{power}, above {base_rpm:.0f} rpm times ({base_rpm:.0f}/n){falls}"


def _ln(current: Array) -> Array:
    return np.log(np.where(current <= 0, 1.0, current))


class _PowerOfSpeed(_Power):
    """The same with b = b0 + b1·(n − MIDDLE_RPM)/1000 rpm, and g free."""

    kind = "power-of-speed"

    def _start(self, felt: Felt, target: Array) -> Array:
        return np.append(super()._start(felt, target), [0.0, 1.0])

    def _weights(self, coefficients: Array) -> Array:
        ln_a, b, _, change, falls = coefficients
        return np.array([ln_a, b, -falls, change])

    def _parts(self, coefficients: Array, felt: Felt) -> Array:
        krpm = (felt.speed_rpm - MIDDLE_RPM) / 1000.0
        return np.column_stack([super()._parts(coefficients, felt), krpm * _ln(felt.current)])

    def _of_logarithm(self, coefficients: Array, parts: Array) -> Array:
        plain = super()._of_logarithm(coefficients, parts)
        plain[:, 2] *= coefficients[4]
        return np.column_stack([plain, parts[:, 3], -parts[:, 2]])

    def equation(self, coefficients: Array, unit: str, current_unit: str) -> str:
        """Return it as people write it; n is the spindle speed."""
        _, b, _, change, falls = coefficients
        exponent = f"({b:.3g} {change:+.2g} · (n − {MIDDLE_RPM:.0f})/1000 rpm)"
        return self._written(coefficients, unit, current_unit, exponent, f"^{falls:.3g}")


LINE, LINE_OF_SPEED = _Linear(), _LineOfSpeed()
POWER, POWER_OF_SPEED = _Power(), _PowerOfSpeed()
FEED_FORMS: tuple[Form, ...] = (LINE, LINE_OF_SPEED)
SPINDLE_FORMS: tuple[Form, ...] = (LINE, POWER, POWER_OF_SPEED)
"""Forms of the torque; of a tangential force without its arm only the line."""
KINDS: dict[str, Form] = {form.kind: form for form in (*FEED_FORMS, *SPINDLE_FORMS)}
