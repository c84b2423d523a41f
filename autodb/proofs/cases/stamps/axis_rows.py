"""One known axis, sampled: its law, the noise of its channels, the rows that a logger has to write.

The axis is that of `shared/failures/README.md`: inertia 0.002 A/(mm/s²), viscous 0.01 A/(mm/s),
Coulomb 1.2 A, gravity 0.3 A. The noise is that of `logs/ms.csv` and `logs/gap.csv` there, by the
median of second differences: 0.020 A (white: no correlation from row to row) and 1.0 µm.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.cases.base.moves import log_uniform
from autodb.proofs.cases.stamps.programme import (
    CORNERS_S,
    Array,
    Programme,
    draw_programme,
)

Picked = NDArray[np.intp] | NDArray[np.bool_]
LAW = {"inertia": 0.002, "viscous": 0.01, "coulomb": 1.2}
"""What is judged; A, mm (deg on a rotary axis), s."""
GRAVITY_A = 0.3
"""Not on a rotary axis: a table that is balanced bears no weight, whatever its angle."""
NOISE_A = 0.020
STEPS_MM = (1e-4, 1e-3)
"""Resolution of an encoder: 0.1 to 1 µm. Chosen; rounding to 1 µm has a sd of 0.3 µm."""
STEPS_A = (5e-4, 5e-3)
"""Resolution of a logged current. Chosen: 12 to 16 bits of ± 10 A."""
SECONDS = (10.0, 30.0)
SHARP_FROM_HZ = 500.0
"""Slower sampling of trapezoids aliases their steps of acceleration. Chosen."""
MOST_ROWS = 20_000
"""Chosen: an explanation of more takes too long for 200 of them."""
TRAVEL = (150.0, 400.0)
ROTARY_TRAVEL = (800.0, 1500.0)
RATES_HZ = (200.0, 250.0, 300.0, 400.0, 500.0, 800.0, 1000.0, 1600.0, 2000.0)
LEFT_OUT = ("coulomb", "viscous", "inertia", "")
"""What a simulation lacks; nothing where it is empty."""


@dataclass(frozen=True)
class SampledRows:
    """Rows (n,): the instant of each, s; position and current, and when each value was taken."""

    true_s: Array
    position: Array
    current: Array
    position_s: Array
    current_s: Array

    def __len__(self) -> int:
        """Return how many rows there are."""
        return len(self.true_s)

    def picked(
        self, rows: "np.typing.NDArray[np.intp] | np.typing.NDArray[np.bool_]"
    ) -> "SampledRows":
        """Return some rows, in the order that is given; a row may stand twice."""
        return SampledRows(
            self.true_s[rows], self.position[rows], self.current[rows],
            self.position_s[rows], self.current_s[rows],
        )  # fmt: skip

    def then(self, more: "SampledRows") -> "SampledRows":
        """Return these rows and more below them."""
        both = zip(self._columns(), more._columns(), strict=True)
        return SampledRows(*(np.concatenate(pair) for pair in both))

    def _columns(self) -> tuple[Array, ...]:
        return self.true_s, self.position, self.current, self.position_s, self.current_s


@dataclass(frozen=True)
class AxisDraw:
    """A drawn recording before anybody has stamped it; ``left_out``: what its simulation lacks."""

    seed: int
    rate_hz: float
    rotary: bool
    programme: Programme
    left_out: str
    step: float
    step_A: float

    @cached_property
    def grid_s(self) -> Array:
        """Return the instants of even sampling, s."""
        return np.arange(round(self.programme.seconds * self.rate_hz)) / self.rate_hz

    def rows(self, true_s: Array, run: int = 0) -> SampledRows:
        """Return what is measured at the instants ``true_s`` (n,); each run has its own noise."""
        noisy = np.random.default_rng([self.seed, 42, run])
        x = self.programme.motion(true_s).x
        current = self.law_A(true_s) + NOISE_A * noisy.standard_normal(len(true_s))
        return SampledRows(
            true_s,
            np.round(x / self.step) * self.step,
            np.round(current / self.step_A) * self.step_A,
            true_s,
            true_s,
        )

    def law_A(self, true_s: Array, without: str = "") -> Array:
        """Return the current without noise, A, less one term where one is named."""
        moved = self.programme.motion(true_s)
        shapes = {"inertia": moved.a, "viscous": moved.v, "coulomb": np.sign(moved.v)}
        parts = (LAW[term] * shapes[term] for term in LAW if term != without)
        weight_A = 0.0 if self.rotary else GRAVITY_A
        return np.asarray(sum(parts, start=np.full_like(true_s, weight_A)), dtype=np.float64)


def draw_known_axis(seed: int, rates_hz: tuple[float, ...], *, rotary: bool) -> AxisDraw:
    """Draw the recording of a seed, at one of the rates."""
    rng = np.random.default_rng([seed, 41])
    rate_hz = float(rng.choice(rates_hz))
    seconds = min(rng.uniform(*SECONDS), MOST_ROWS / rate_hz)
    travel = rng.uniform(*(ROTARY_TRAVEL if rotary else TRAVEL))
    sharp = rate_hz >= SHARP_FROM_HZ and rng.random() < 0.5
    corner_s = 0.0 if sharp else rng.uniform(*CORNERS_S)
    return AxisDraw(
        seed=seed,
        rate_hz=rate_hz,
        rotary=rotary,
        programme=draw_programme(rng, seconds, travel=travel, corner_s=corner_s),
        left_out=str(rng.choice(LEFT_OUT)),
        step=log_uniform(rng, *STEPS_MM),
        step_A=log_uniform(rng, *STEPS_A),
    )
