"""A recording of a real axis: its channels, and the moves that its own physics needs."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rows = NDArray[np.intp] | NDArray[np.bool_] | slice
TOP_SPEED = 0.95
"""Quantile of |v| that stands for the fastest moves; single spikes of a derivative do not."""
SIGN_WIDTH = 0.02
"""Share of the top speed below which a direction fades out, where a recording has no own one."""


@dataclass(frozen=True)
class RealAxis:
    """One axis over time: t (n,) s, position (n,) mm, effort (n,) in the unit of its channel.

    ``velocity`` mm/s and ``acceleration`` mm/s² are None where they were not recorded; moves are
    then derived below ``cutoff_hz``. ``other`` holds channels of another axis that moved at the
    same time. ``load`` is a known load (n,) that was applied, 1 where it acts in full.
    """

    name: str
    machine: str
    axis: str
    channel: str
    t: Array
    position: Array
    effort: Array
    cutoff_hz: float
    velocity: Array | None = None
    acceleration: Array | None = None
    other: dict[str, Array] = field(default_factory=dict)
    load: Array | None = None
    width: float = SIGN_WIDTH

    def __len__(self) -> int:
        """Return how many rows there are."""
        return len(self.t)

    @cached_property
    def rate_hz(self) -> float:
        """Return rows per second."""
        return float(1.0 / np.median(np.diff(self.t)))

    @cached_property
    def v(self) -> Array:
        """Return velocity (n,), mm/s: recorded, else derived from the position."""
        if self.velocity is not None:
            return self.velocity
        return np.gradient(smoothed(self.position, self.rate_hz, self.cutoff_hz), self.t)

    @cached_property
    def a(self) -> Array:
        """Return acceleration (n,), mm/s²: recorded, else derived from the velocity."""
        if self.acceleration is not None:
            return self.acceleration
        return np.gradient(smoothed(self.v, self.rate_hz, self.cutoff_hz), self.t)

    @cached_property
    def other_a(self) -> Array | None:
        """Return the acceleration (n,) of the other axis, None where none was recorded."""
        if not self.other:
            return None
        ends = {name.split(".")[1]: values for name, values in self.other.items()}
        axis = replace(
            self, position=ends["position"], velocity=ends.get("velocity"),
            acceleration=ends.get("acceleration"), other={}, load=None,
        )  # fmt: skip
        return axis.a

    @cached_property
    def top_speed(self) -> float:
        """Return the speed of the fastest moves, mm/s."""
        return max(float(np.quantile(np.abs(self.v), TOP_SPEED)), 1e-9)

    @cached_property
    def direction(self) -> Array:
        """Return the direction of motion (n,), −1 to 1; it fades out at standstill."""
        return np.asarray(np.tanh(self.v / (self.width * self.top_speed)), dtype=np.float64)

    @property
    def channels(self) -> dict[str, Array]:
        """Return the recorded channels by name, time first."""
        found = {"t": self.t, f"{self.axis}.position": self.position}
        if self.velocity is not None:
            found[f"{self.axis}.velocity"] = self.velocity
        if self.acceleration is not None:
            found[f"{self.axis}.acceleration"] = self.acceleration
        return found | self.other | {self.channel: self.effort}

    def rows(self, kept: Rows) -> "RealAxis":
        """Return some rows of it; derived moves stay those of the whole recording."""

        def cut(values: Array | None) -> Array | None:
            return None if values is None else values[kept]

        part = replace(
            self, t=self.t[kept], position=self.position[kept], effort=self.effort[kept],
            velocity=cut(self.velocity), acceleration=cut(self.acceleration),
            other={name: values[kept] for name, values in self.other.items()}, load=cut(self.load),
        )  # fmt: skip
        for name in ("v", "a", "direction", "top_speed"):
            value = getattr(self, name)
            part.__dict__[name] = value[kept] if isinstance(value, np.ndarray) else value
        part.__dict__["other_a"] = cut(self.other_a)
        return part

    def with_effort(self, effort: Array) -> "RealAxis":
        """Return the same moves with another effort (n,)."""
        moved = replace(self, effort=effort)
        for name in ("v", "a", "direction", "top_speed", "other_a"):
            moved.__dict__[name] = getattr(self, name)
        return moved


def smoothed(values: Array, rate_hz: float, cutoff_hz: float) -> Array:
    """Return values (n,) below a cutoff: Butterworth of second order, forwards and backwards."""
    from scipy.signal import butter, sosfiltfilt

    if cutoff_hz >= 0.45 * rate_hz:
        return values
    sos = butter(2, cutoff_hz, fs=rate_hz, output="sos")
    return np.asarray(sosfiltfilt(sos, values), dtype=np.float64)
