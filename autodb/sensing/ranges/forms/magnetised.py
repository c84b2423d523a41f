"""Torque or force where an induction motor also carries a magnetising current.

The range is what the motor's field takes, a(n), and what its load takes, at right angles: range² =
a(n)² + ((T + T_air(n))/k(n))², in air as in cut (P1 section 8; induction motors: Bose 2002, Modern
power electronics and AC drives, chapter 8). Of both ranges the field goes out,

    T = √(k² (I_c² − I_a²) + T_air²) − T_air

and near no torque the rise says far less than beyond. k falls as n_b/n above the base speed n_b,
where the field is weakened; T_air, what turns the idle spindle, grows with the speed n. Of a slide
T_air is friction less the weight that helps, a force, which may be below 0: beyond the fold.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.linear import Undetermined
from autodb.sensing.ranges.forms.form import FittedForm, MeasuredCuts, form_moves, varies
from autodb.sensing.ranges.forms.noisy import fit_curved
from autodb.wording import amount_words, localized, phrase, stored_msgid

Array = NDArray[np.float64]

FEWEST = 6
"""Cuts with a torque that it is fitted to at least."""
STARTS = np.linspace(0.1, 0.9, 9)
"""Quantiles of the spindle speeds that are tried as the base speed to start from."""


class Magnetised:
    """Coefficients ln k, k in N·m/A, and T_air, N·m: one base speed, one idle torque."""

    kind = "magnetised"
    margin = 2.0  # a straight line is one of them
    label = stored_msgid("load beside a magnetising current")

    def fits(self, sensed: MeasuredCuts) -> bool:
        """Say whether the range in air is known of every cut, beside its rise."""
        known = sensed.air is not None and bool(np.isfinite(sensed.air).all())
        return known and bool(np.isfinite(sensed.current).all())

    def fit(self, sensed: MeasuredCuts, target: Array) -> FittedForm:
        """Fit by least squares on the torque, freed of the currents' errors where these are known.

        Raises Undetermined where the cuts do not hold it.
        """
        return fit_curved(self, self._start(sensed, target), sensed, target)

    def _start(self, sensed: MeasuredCuts, target: Array) -> Array:
        """Return the line of T over (I_c² − I_a²)/T: slope k², and -2 T_air where that is 0."""
        _, k_squared, idle = _line(_squares(sensed), target, least=-np.inf)
        return np.array([0.5 * np.log(k_squared), idle])

    def value(self, coefficients: Array, sensed: MeasuredCuts) -> Array:
        """Return the torque (n,): 0 where the current does not rise, NaN without a range in air."""
        gained, idle = self._gained(coefficients, sensed), self._idle(coefficients, sensed)
        return np.asarray(np.sqrt(np.maximum(gained, 0.0) + idle**2) - idle)

    def _gained(self, coefficients: Array, sensed: MeasuredCuts) -> Array:
        """Return k² (I_c² − I_a²), (n,)."""
        return np.asarray(np.exp(2.0 * coefficients[0]) * _squares(sensed))

    def _idle(self, coefficients: Array, sensed: MeasuredCuts) -> Array:
        """Return T_air (n,)."""
        return np.full_like(sensed.current, coefficients[1])

    def slopes(self, coefficients: Array, sensed: MeasuredCuts) -> Array:
        """Return the torque's derivatives by the coefficients, (n, p)."""
        by_gain, by_idle = self._by_parts(coefficients, sensed)
        return np.column_stack([2.0 * by_gain, by_idle])

    def _by_parts(self, coefficients: Array, sensed: MeasuredCuts) -> tuple[Array, Array]:
        """Return the derivatives (n,) by ln k² and by T_air."""
        gained, idle = self._gained(coefficients, sensed), self._idle(coefficients, sensed)
        root = np.sqrt(np.maximum(gained, 0.0) + idle**2)
        held = root > 0.0
        whole = np.where(held, root, 1.0)
        return np.maximum(gained, 0.0) / (2.0 * whole), np.where(held, idle / whole - 1.0, 0.0)

    def scaling(self, coefficients: Array) -> Array:
        """Return the change of ln k and of T_air: both scale."""
        return np.array([1.0, coefficients[1]])

    def moves(self, coefficients: Array, slopes: Array, value: Array) -> tuple[Array, Array]:  # noqa: ARG002
        """Return shift and share (n, p): without a rise there is nothing, so all is a share."""
        return form_moves(slopes, value, idle=np.zeros_like(value), first=0)

    def beyond(self, sensed: MeasuredCuts) -> Array:
        """Return zeros: a law holds as far as it goes."""
        return np.zeros_like(sensed.current)

    def parameters(self) -> dict[str, Any] | None:
        """Return None: the coefficients say all."""
        return None

    def equation(self, coefficients: Array, unit: str, current_unit: str) -> str:
        """Return it as people write it; I_c and I_a are the ranges in cut and in air."""
        k = f"{localized(f'{np.exp(coefficients[0]):.4g}')} {unit}/{current_unit}"
        idle = f"{localized(f'{coefficients[1]:.3g}')} {unit}"
        return f"√(({k})² · (I_c² − I_a²) + T_air²) − T_air, T_air {idle}"


class MagnetisedOfSpeed(Magnetised):
    """The same with T_air = t0 + t1 n/1000 rpm, and k that falls as n_b/n: ln k, t0, t1, ln n_b."""

    kind = "magnetised-of-speed"
    margin = 1.0
    label = stored_msgid("load beside a magnetising current, by speed")

    def fits(self, sensed: MeasuredCuts) -> bool:
        """Say whether the range in air is known, and speeds are and differ."""
        return super().fits(sensed) and varies(sensed.speed_rpm)

    def _start(self, sensed: MeasuredCuts, target: Array) -> Array:
        """Return the best line over base speeds among those of the cuts."""
        found = []
        for base_rpm in np.quantile(sensed.speed_rpm, STARTS):
            falls = np.minimum(1.0, base_rpm / sensed.speed_rpm)
            left, k_squared, idle = _line(falls**2 * _squares(sensed), target, least=0.0)
            found.append((left, 0.5 * np.log(k_squared), idle, 0.0, np.log(base_rpm)))
        return np.array(min(found)[1:])

    def _gained(self, coefficients: Array, sensed: MeasuredCuts) -> Array:
        falls = np.minimum(1.0, np.exp(coefficients[3]) / sensed.speed_rpm)
        return np.asarray(super()._gained(coefficients, sensed) * falls**2)

    def _idle(self, coefficients: Array, sensed: MeasuredCuts) -> Array:
        rises = coefficients[1] + coefficients[2] * sensed.speed_rpm / 1000.0
        return np.asarray(np.maximum(rises, 0.0))

    def slopes(self, coefficients: Array, sensed: MeasuredCuts) -> Array:
        """Return the torque's derivatives by the coefficients, (n, p)."""
        by_gain, by_idle = self._by_parts(coefficients, sensed)
        above = sensed.speed_rpm > np.exp(coefficients[3])
        krpm = sensed.speed_rpm / 1000.0
        return np.column_stack([2.0 * by_gain, by_idle, by_idle * krpm, 2.0 * by_gain * above])

    def scaling(self, coefficients: Array) -> Array:
        """Return the change of ln k and of both parts of T_air: n_b does not scale."""
        return np.array([1.0, coefficients[1], coefficients[2], 0.0])

    def equation(self, coefficients: Array, unit: str, current_unit: str) -> str:
        """Return it as people write it; n is the spindle speed."""
        _, t0, t1, ln_base = coefficients
        base_rpm = np.exp(ln_base)
        plain = super().equation(coefficients, unit, current_unit).rsplit(", ", 1)[0]
        idle = f"T_air {localized(f'{t0:.3g} {t1:+.2g}')} · n/1000 rpm {unit}"
        return phrase(
            "{plain}, {idle}, above {speed} k times ({base}/n)",
            plain=plain,
            idle=idle,
            speed=amount_words(base_rpm, "rpm", ".0f"),
            base=f"{base_rpm:.0f}",
        )


def _squares(sensed: MeasuredCuts) -> Array:
    """Return I_c² − I_a² (n,), A²; NaN where the range in air is not known."""
    if sensed.air is None:
        return np.full_like(sensed.current, np.nan)
    return np.asarray(sensed.current * (sensed.current + 2.0 * sensed.air))


def _line(squares: Array, target: Array, *, least: float) -> tuple[float, float, float]:
    """Return what T² + 2 T T_air = k² X leaves by least squares on T, k², and T_air ≥ ``least``.

    Raises Undetermined where too few cuts have a torque, or it does not rise with X.
    """
    held = (squares > 0) & (target > 0)
    if held.sum() < FEWEST:
        raise Undetermined([0])
    torque, x = target[held], squares[held] / target[held]
    columns = np.column_stack([x, np.ones_like(x)])
    (k_squared, minus_twice), *_ = np.linalg.lstsq(columns, torque, rcond=None)
    idle = max(least, -0.5 * float(minus_twice))
    if idle == least:
        k_squared = float(x @ (torque + 2.0 * least) / (x @ x))
    if k_squared <= 0.0:
        raise Undetermined([0])
    left = torque - columns @ np.array([k_squared, -2.0 * idle])
    return float(left @ left), float(k_squared), idle
