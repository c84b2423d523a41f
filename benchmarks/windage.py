"""Whether a spindle's windage, about as its speed squared, asks for a form of its own.

    python -m benchmarks.windage

40 spindles of induction motors with fields of 0 to 14 A of range, idle torques of 1 to 4 N·m at no
speed, windage of 1 to 12 N·m at the highest speed, growing as its 1.8th to 2.2nd power, and 85 to
95 % efficiency. 60 cuts each calibrate, 200 others are sensed; root mean square errors, N·m, of the
form whose idle torque is linear in the speed, of that with the speed's square in its place, and of
the spindle's own law with all sizes known, which leaves the scatter alone.
"""

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.ranges.forms import MAGNETISED_OF_SPEED, MeasuredCuts
from autodb.sensing.ranges.forms.magnetised import MagnetisedOfSpeed

Array = NDArray[np.float64]

TOP_RPM = (2400.0, 6000.0)
SCATTER, NOISE_A = 0.02, 0.1


class OfSquare(MagnetisedOfSpeed):
    """T_air = t0 + t2 (n/1000 rpm)² in place of t0 + t1 n/1000 rpm."""

    kind = "of-square"

    def _idle(self, coefficients: Array, sensed: MeasuredCuts) -> Array:
        rises = coefficients[1] + coefficients[2] * (sensed.speed_rpm / 1000.0) ** 2
        return np.asarray(np.maximum(rises, 0.0))

    def slopes(self, coefficients: Array, sensed: MeasuredCuts) -> Array:
        """Return the torque's derivatives by the coefficients, (n, p)."""
        whole = super().slopes(coefficients, sensed)
        whole[:, 2] *= sensed.speed_rpm / 1000.0
        return whole


def spindle(seed: int) -> tuple[MeasuredCuts, Array, Array]:
    """Return cuts of a spindle, the torque of each, and what its own law makes of their ranges."""
    rng = np.random.default_rng([seed, 555])
    top, count = float(rng.choice(TOP_RPM)), 260
    rpm = rng.uniform(0.15, 1.0, count) * top
    torque = rng.uniform(2.0, 60.0, count)
    field_A, k = float(rng.choice([0.0, 7.0, 14.0])), float(rng.uniform(0.8, 1.6))
    base, well = 0.6 * top, float(rng.uniform(0.85, 0.95))
    weak = np.minimum(1.0, base / rpm)
    power = float(rng.uniform(1.8, 2.2))
    idle = rng.uniform(1.0, 4.0) + rng.uniform(1.0, 12.0) * (rpm / top) ** power
    load = torque * (1.0 + SCATTER * rng.standard_normal(count))
    cut, air = (
        np.hypot(field_A * weak, (one / well + idle) / (k * weak))
        + NOISE_A * rng.standard_normal(count)
        for one in (load, np.zeros(count))
    )
    none = np.full(count, np.nan)
    sensed = MeasuredCuts(cut - air, none, rpm, none, none, none, air=air)
    square = np.maximum((cut**2 - air**2) * (k * weak) ** 2 + idle**2, 0.0)
    return sensed, torque, well * (np.sqrt(square) - idle)


def main() -> None:
    """Print the errors."""
    found: dict[str, list[float]] = {"linear": [], "square": [], "own law": []}
    for seed in range(40):
        sensed, torque, own = spindle(seed)
        known, asked = np.arange(60), np.arange(60, 260)
        for name, form in (("linear", MAGNETISED_OF_SPEED), ("square", OfSquare())):
            law = form.fit(sensed.at(known), torque[known])
            value = form.value(law.coefficients, sensed.at(asked))
            found[name].append(_rms(value - torque[asked]))
        found["own law"].append(_rms((own - torque)[asked]))
    for name, errors in found.items():
        print(f"{name:8} median {np.median(errors):.2f} N·m, worst {np.max(errors):.2f} N·m")


def _rms(errors: Array) -> float:
    return float(np.sqrt(np.mean(errors**2)))


if __name__ == "__main__":
    main()
