"""The best that can be known of a drawn axis: its own columns, its own noise, least squares.

The oracle knows every law of the axis and the noise's true size and correlation; only the columns'
coefficients are unknown to it. No estimator that must find the laws can be narrower and right.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.axis.axes import AxisRun, axis_columns
from autodb.proofs.machines.axis.quantities import TrueQuantity
from autodb.proofs.runs.score import Z

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Estimate:
    """Coefficients (p,) of a run's columns and their covariance (p, p)."""

    coefficients: Array
    covariance: Array

    def interval(self, quantity: TrueQuantity) -> tuple[float, float]:
        """Return the 95 % interval of a quantity."""
        value = quantity.offset + float(quantity.row @ self.coefficients)
        sd = float(np.sqrt(quantity.row @ self.covariance @ quantity.row))
        return value - Z * sd, value + Z * sd


def oracle(run: AxisRun) -> Estimate:
    """Fit a run by generalised least squares.

    White noise is e_i − ρ e_{i−1} over σ √(1 − ρ²), and e_0 over σ (Prais, Winsten 1954); columns
    and current are changed alike. Laws are linear in their coefficients but for the cogging's phase
    and period, which enter by their derivatives at the truth.
    """
    axis, motion = run.axis, run.motion
    own = axis_columns(axis, x_mm=motion.x, v_mm_s=motion.v, a_mm_s2=motion.a)
    stacked = np.column_stack([*(column.values for column in own), run.channels["x.current"]])
    white = _whitened(stacked, sd=axis.noise_A, rho=axis.noise_rho)
    design, current = white[:, :-1], white[:, -1]
    scale = np.linalg.norm(design, axis=0)
    q, r = np.linalg.qr(design / scale)
    inverse = np.linalg.inv(r) / scale[:, None]
    return Estimate(inverse @ (q.T @ current), inverse @ inverse.T)


def _whitened(values: Array, *, sd: float, rho: float) -> Array:
    steps = (values[1:] - rho * values[:-1]) / np.sqrt(1.0 - rho**2)
    return np.asarray(np.vstack([values[:1], steps]) / sd, dtype=np.float64)
