"""How far off a drive model is, by what the axis does and up to which frequency.

A model that is right in steady motion may be wrong after a reversal, while the axis speeds up, and
at standstill, where friction holds any load up to breakaway. Counted on blocks of motion that the
terms were not fitted to, it is what a reconstructed load is unsure by.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autodb import signals

Array = NDArray[np.float64]
Labels = NDArray[np.int_]

STEADY, SPEEDING, TURNED, STANDING = range(4)
MOVING = (STEADY, SPEEDING, TURNED)
"""What an axis does in motion: at constant speed, changing it, and shortly after a reversal."""
BANDWIDTHS_HZ = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
TURN_S, TURN_MM = 0.1, 1.0
"""An axis has just turned for so long, or so far (degrees of a rotary axis). Chosen: pre-sliding of
published axes ends within 0.1 mm, what a drive does about it within 0.1 s.
"""
SPEEDING_SHARE = 0.05
"""Share of the highest acceleration above which an axis changes its speed. Chosen."""
FEWEST_ROWS = 30
"""Rows in a state that tell its error; fewer take the worst of the other states."""


@dataclass(frozen=True)
class DriveErrors:
    """Root mean square of what a model leaves, (bandwidths, states in motion), in its unit.

    ``breakaway``: friction that may hold at standstill. ``highest_mm_s``, ``highest_mm_s2`` and
    ``travel_mm``: where the axis was moved; of a rotary axis in degrees.
    """

    rms: tuple[tuple[float, ...], ...]
    breakaway: float
    highest_mm_s: float
    highest_mm_s2: float
    travel_mm: tuple[float, float]

    @classmethod
    def of(cls, kept: Mapping[str, Any]) -> "DriveErrors":
        """Return errors as ``dataclasses.asdict`` made them and JSON kept them."""
        low, high = kept["travel_mm"]
        return cls(
            **{
                **kept,
                "rms": tuple(tuple(row) for row in kept["rms"]),
                "travel_mm": (float(low), float(high)),
            }
        )

    def sd(self, inputs: Mapping[str, Array], *, rate_hz: float, bandwidth_hz: float) -> Array:
        """Return the model's standard deviation (n,) up to a bandwidth, row by row.

        At standstill friction is anywhere within ± breakaway. What a row is unsure of, its
        neighbours within half a period of the bandwidth are.
        """
        from scipy.ndimage import maximum_filter1d

        labels = states(inputs, highest_mm_s2=self.highest_mm_s2)
        held = self.breakaway / np.sqrt(3.0)
        by_state = np.append(self._at(bandwidth_hz), held)
        sd = by_state[labels]
        reach = max(1, round(0.5 * rate_hz / bandwidth_hz))
        return np.asarray(maximum_filter1d(sd, 2 * reach + 1, mode="nearest"))

    def _at(self, bandwidth_hz: float) -> Array:
        """Return the error of each state at a bandwidth, between those counted by logarithms."""
        at = np.log(np.clip(bandwidth_hz, BANDWIDTHS_HZ[0], BANDWIDTHS_HZ[-1]))
        rows = np.array(self.rms)
        return np.array([np.interp(at, np.log(BANDWIDTHS_HZ), column) for column in rows.T])

    def beyond(self, inputs: Mapping[str, Array]) -> Array:
        """Return how far (n,) a row is outside what the axis was moved at, in parts of that."""
        low, high = self.travel_mm
        place = inputs["position"]
        outside = np.maximum(low - place, place - high) / max(high - low, np.finfo(float).tiny)
        fast = np.abs(inputs["velocity"]) / self.highest_mm_s - 1.0
        hard = np.abs(inputs["acceleration"]) / self.highest_mm_s2 - 1.0
        return np.asarray(np.maximum(np.maximum(outside, fast), np.maximum(hard, 0.0)))


def drive_errors(
    inputs: Mapping[str, Array], left: Array, *, rate_hz: float, breakaway: float
) -> DriveErrors:
    """Count what a model leaves on rows (n,) that it was not fitted to, by state and bandwidth."""
    highest = np.quantile(np.abs(inputs["acceleration"]), 0.999)
    labels = states(inputs, highest_mm_s2=float(highest))
    rows = []
    for bandwidth_hz in BANDWIDTHS_HZ:
        smooth = signals.lowpass(left, rate_hz=rate_hz, cutoff_hz=bandwidth_hz)
        rows.append(_rms_by_state(smooth, labels))
    return DriveErrors(
        rms=tuple(rows),
        breakaway=breakaway,
        highest_mm_s=float(np.max(np.abs(inputs["velocity"]))),
        highest_mm_s2=float(np.max(np.abs(inputs["acceleration"]))),
        travel_mm=(float(inputs["position"].min()), float(inputs["position"].max())),
    )


def _rms_by_state(left: Array, labels: Labels) -> tuple[float, ...]:
    known = {
        state: float(np.sqrt(np.mean(left[labels == state] ** 2)))
        for state in MOVING
        if np.sum(labels == state) >= FEWEST_ROWS
    }
    worst = max(known.values(), default=float(np.sqrt(np.mean(left**2))))
    return tuple(known.get(state, worst) for state in MOVING)


def states(inputs: Mapping[str, Array], *, highest_mm_s2: float) -> Labels:
    """Return what the axis does in each row (n,)."""
    moving = np.abs(inputs["direction"]) >= 1.0
    sense = np.where(moving, np.sign(inputs["direction"]), 0.0)
    row = np.arange(len(sense))
    began = np.maximum.accumulate(np.where(np.diff(sense, prepend=np.nan) != 0, row, 0))
    lasted_s = inputs["t"] - inputs["t"][began]
    gone_mm = np.abs(inputs["position"] - inputs["position"][began])
    turned = (lasted_s < TURN_S) | (gone_mm < TURN_MM)
    speeding = np.abs(inputs["acceleration"]) > SPEEDING_SHARE * highest_mm_s2
    labels = np.where(turned, TURNED, np.where(speeding, SPEEDING, STEADY))
    return np.where(moving, labels, STANDING)
