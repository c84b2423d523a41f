"""Proof: the published way from current to force, on virtual lathes, lands on the published errors.

P1's own calibration (sections 9, 10): a straight line of force over the range in cut for X and Z;
for the spindle T = a(n) ΔI^b(n), a and b cubic in the speed, apart below and above the base speed.
Where it lands on P1's errors the lathes are as hard as P1's, and other ways may be judged on them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter
from scipy.optimize import least_squares

from autodb.prove import lathe_oracle
from autodb.prove.found import Table, ratio
from autodb.prove.lathe_cuts import Cuts, cuts_of
from autodb.prove.runs import Finished, Origin
from autodb.virtual import reference_lathe

Array = NDArray[np.float64]

PUBLISHED_RMSE_N = {"x": 29.0, "spindle": 36.0, "z": 27.0}
"""P1, table 1, prediction by regression: 16, 113 and 180 test cuts."""
WITHIN = 0.2
"""Share by which the median of the machines may differ from the published error."""
BASE_RPM = 1570.0
"""P1, section 6."""
CUBIC = 4
"""Coefficients of a and of b."""


@dataclass(frozen=True)
class AxisError:
    """Root mean square errors of an axis' force on test cuts, N: as published, and the oracle's."""

    axis: str
    cuts: int
    rmse_N: float
    oracle_N: float


def run(seed: int) -> list[AxisError]:
    """Calibrate the machine of a seed as published, and test it."""
    made = reference_lathe.campaign(seed)
    errors = []
    for axis in PUBLISHED_RMSE_N:
        known, tested = cuts_of(made, axis)
        sensed = (_spindle_N if axis == "spindle" else _feed_N)(known, tested)
        best = lathe_oracle.force_N(axis, known, tested)
        errors.append(
            AxisError(axis, len(tested.force_N), _rmse(sensed, tested), _rmse(best, tested))
        )
    return errors


def _rmse(force_N: Array, tested: Cuts) -> float:
    return float(np.sqrt(np.mean((force_N - tested.force_N) ** 2)))


def _feed_N(known: Cuts, tested: Cuts) -> Array:
    line = np.polyfit(known.range_A, known.force_N, 1)
    return np.asarray(np.polyval(line, tested.range_A), dtype=np.float64)


def _spindle_N(known: Cuts, tested: Cuts) -> Array:
    law = SpindleLaw.fitted(known.speed_rpm, known.rise_A, known.torque_Nm)
    return 1000.0 * law(tested.speed_rpm, tested.rise_A) / tested.radius_mm


@dataclass(frozen=True)
class SpindleLaw:
    """T = a(n) ΔI^b(n): coefficients of a, then of b, below and above the base speed."""

    below: Array
    above: Array

    @classmethod
    def fitted(cls, rpm: Array, rise_A: Array, torque_Nm: Array) -> "SpindleLaw":
        """Fit both ranges of speed by least squares on the torque."""
        slow = rpm <= BASE_RPM
        return cls(
            *(_power_law(rpm[part], rise_A[part], torque_Nm[part]) for part in (slow, ~slow))
        )

    def __call__(self, rpm: Array, rise_A: Array) -> Array:
        """Return torque (n,); none where the range does not rise."""
        slow = rpm <= BASE_RPM
        return np.where(slow, _torque(self.below, rpm, rise_A), _torque(self.above, rpm, rise_A))


def _torque(law: Array, rpm: Array, rise_A: Array) -> Array:
    krpm = rpm / 1000.0 - BASE_RPM / 1000.0
    scale, exponent = np.polyval(law[:CUBIC], krpm), np.polyval(law[CUBIC:], krpm)
    rise = np.maximum(rise_A, 0.0)
    return np.asarray(scale * np.where(rise > 0, np.maximum(rise, 1e-9) ** exponent, 0.0))


def _power_law(rpm: Array, rise_A: Array, torque_Nm: Array) -> Array:
    b, ln_a = np.polyfit(np.log(rise_A), np.log(torque_Nm), 1)
    start = np.zeros(2 * CUBIC)
    start[CUBIC - 1], start[-1] = np.exp(ln_a), b

    def error(law: Array) -> Array:
        return _torque(law, rpm, rise_A) - torque_Nm

    return np.asarray(least_squares(error, start, x_scale=0.1).x, dtype=np.float64)


@dataclass(frozen=True)
class Row:
    """An axis: median, lowest and highest error of the machines, the oracle's median, the published
    one, N.
    """

    axis: str
    cuts: int
    rmse_N: float
    lowest_N: float
    highest_N: float
    oracle_N: float
    published_N: float

    @property
    def ratio(self) -> float:
        """The median over the published error."""
        return self.rmse_N / self.published_N

    @property
    def passed(self) -> bool:
        """Whether the median is near the published error."""
        return abs(self.ratio - 1.0) <= WITHIN


@dataclass(frozen=True)
class Summary:
    """The gate: a row an axis."""

    origin: Origin
    seeds: tuple[int, int]
    rows: tuple[Row, ...]

    @property
    def passed(self) -> bool:
        """Say whether every axis lands on the published error."""
        return all(row.passed for row in self.rows)

    def tables(self) -> tuple[Table, ...]:
        """Return the only table."""
        heads = (
            "axis", ">test cuts", ">rmse, median", ">lowest to highest", ">oracle's", ">published",
            f">× published (1 ± {WITHIN:g})", "",
        )  # fmt: skip
        rows = tuple(
            (
                row.axis,
                str(row.cuts),
                f"{row.rmse_N:.1f} N",
                f"{row.lowest_N:.1f} to {row.highest_N:.1f} N",
                f"{row.oracle_N:.1f} N",
                f"{row.published_N:.0f} N",
                ratio(row.ratio),
                "passed" if row.passed else "FAILED",
            )
            for row in self.rows
        )
        return (Table("The published calibration on virtual lathes", heads, rows),)

    def to_json(self) -> str:
        """Return the summary as JSON, as ``from_json`` reads it."""
        return SUMMARY.dump_json(self, indent=1).decode() + "\n"

    @staticmethod
    def from_json(text: str) -> "Summary":
        """Return a summary that was written; raises pydantic's ValidationError on any other."""
        return SUMMARY.validate_json(text)


SUMMARY: TypeAdapter[Summary] = TypeAdapter(Summary)


def summary_of(runs: Sequence[Finished[AxisError]], origin: Origin) -> Summary:
    """Return the gate of finished runs in the order of their seeds."""
    rows = []
    for axis, published_N in PUBLISHED_RMSE_N.items():
        errors = [one for run in runs for one in run.judged if one.axis == axis]
        sizes = [one.rmse_N for one in errors]
        best_N = float(np.median([one.oracle_N for one in errors]))
        rows.append(
            Row(
                axis, errors[0].cuts, float(np.median(sizes)), min(sizes), max(sizes), best_N,
                published_N,
            )
        )  # fmt: skip
    return Summary(origin, (runs[0].seed, runs[-1].seed), tuple(rows))
