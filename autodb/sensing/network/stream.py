"""What a grey box tells of rows as they come; a whole recording goes through it at once."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput, near
from autodb.sensing.network.coherent import low_pass
from autodb.sensing.network.drive_loads import AxisLoad, AxisTables
from autodb.sensing.network.greybox import LATER, LEAST_SD, LOG_SD, GreyBox, loads_of
from autodb.sensing.network.network import State, ran, side_by_side

Array = NDArray[np.float64]
Channels = Mapping[str, Array]

RATE_OFF = 0.01
"""Share by which the rate may be another than that of training."""
FURTHER = {"load": 1.0, "spindle.current": 1.0}
"""Parts of what was seen in training by which these may go beyond it: other work is harder."""
FURTHER_ELSE = 0.1
ROWS_BEYOND = 0.01
"""Share of rows that may be further off than that."""


@dataclass(frozen=True)
class NetworkForces:
    """Force and its standard deviation (n, m), N; ``drive_N``: what drive models alone tell of it,
    low-passed and late as the force is.
    """

    force_N: Array
    sd_N: Array
    drive_N: Array

    def behind(self, before: "NetworkForces") -> "NetworkForces":
        """Return both, the other first."""
        return NetworkForces(
            np.concatenate([before.force_N, self.force_N]),
            np.concatenate([before.sd_N, self.sd_N]),
            np.concatenate([before.drive_N, self.drive_N]),
        )


def network_forces(
    box: GreyBox, tables: Mapping[str, AxisTables], channels: Channels
) -> NetworkForces:
    """Return the forces of a whole recording."""
    stream = Stream(box, tables)
    told = stream.step(channels)
    return stream.finish().behind(told)


def check(box: GreyBox, tables: Mapping[str, AxisTables], channels: Channels, *, rate_hz: float,
          where: str) -> None:  # fmt: skip
    """Raise UnusableInput, naming ``where``, for channels, a rate or ranges that were not trained.

    What networks say of them would be no more than a guess.
    """
    efforts = [one.channel for one in tables.values()]
    places = [f"{axis.name}.position" for axis in box.axes]
    for name in (*efforts, *places, *box.seen):
        if name not in channels:
            hint = near(name, list(channels))
            raise UnusableInput(
                f"{where}: no channel '{name}'{hint}; the network was trained on it"
            )
    if abs(rate_hz / box.rate_hz - 1.0) > RATE_OFF:
        raise UnusableInput(
            f"{where}: {rate_hz:g} Hz, and the network was trained at {box.rate_hz:g} Hz; "
            "record at that rate"
        )
    loads = loads_of(tables, channels)
    shown = box.shown(loads, channels)
    names = [*(f"load of {name}" for name in loads if box.hears), *box.seen]
    for k, name in enumerate(names):
        low, high = float(box.low[k]), float(box.high[k])
        kind = "load" if name.startswith("load") else name
        further = FURTHER.get(kind, FURTHER_ELSE) * (high - low)
        off = (shown[:, k] < low - further) | (shown[:, k] > high + further)
        if off.mean() > ROWS_BEYOND:
            worst = shown[int(np.argmax(np.abs(shown[:, k] - 0.5 * (low + high)))), k]
            raise UnusableInput(
                f"{where}: {name} goes to {worst:.4g}, and the network was trained from "
                f"{low:.4g} to {high:.4g}; train it with recordings like this one"
            )


class Stream:
    """Rows as they come: what is told is late by LATER rows and half the low-pass' taps."""

    def __init__(self, box: GreyBox, tables: Mapping[str, AxisTables]) -> None:
        self._box = box
        self._loads = {name: AxisLoad(one) for name, one in tables.items()}
        self._network = side_by_side(box.members)
        self._state: State | None = None
        self._last: Array | None = None
        self._passed = low_pass(np.tile(box.cutoff_hz, 2), rate_hz=box.rate_hz)
        self._waiting = np.zeros((0, len(box.components)))
        self._skip = LATER

    def step(self, channels: Channels) -> NetworkForces:
        """Return what can be told now that the next rows of all channels are there."""
        loads = {name: one.step(channels) for name, one in self._loads.items()}
        shown = self._box.shown(loads, channels)
        if not len(shown):
            return self._none()
        self._last = shown[-1:]
        base = -np.column_stack([loads[c] for c in self._box.components])
        return self._tell(shown, base)

    def finish(self) -> NetworkForces:
        """Return the rest, after the last row."""
        if self._last is None:
            return self._none()
        ended = self._tell(np.repeat(self._last, LATER, axis=0), self._waiting[:0])
        return self._told(*self._passed.finish()).behind(ended)

    def _none(self) -> NetworkForces:
        none = np.zeros((0, len(self._box.components)))
        return NetworkForces(none, none, none)

    def _tell(self, shown: Array, base: Array) -> NetworkForces:
        """Run the networks on; the loads wait for what is told of them."""
        box = self._box
        rows = (shown - box.scaled.middle) / box.scaled.size
        made, self._state = ran(self._network, rows, self._state)
        mean, variance = _joined(made.reshape(len(made), len(box.members), -1))
        skipped = min(self._skip, len(mean))
        self._skip -= skipped
        mean, variance = mean[skipped:], variance[skipped:]
        self._waiting = np.concatenate([self._waiting, base])
        now, self._waiting = self._waiting[: len(mean)], self._waiting[len(mean) :]
        force = now + mean * box.scaled.told_N
        sd = np.sqrt(variance) * box.scaled.told_N * box.wider
        return self._told(*self._passed.step(np.hstack([force, now]), np.hstack([sd, sd])))

    def _told(self, passed: Array, beside: Array) -> NetworkForces:
        """Return what was passed: forces, then those of the drive models."""
        count = len(self._box.components)
        return NetworkForces(passed[:, :count], beside[:, :count], passed[:, count:])


def _joined(made: Array) -> tuple[Array, Array]:
    """Return mean and variance (n, m) of networks' means and log sds (n, members, 2 m)."""
    members, told = made.shape[1], made.shape[2] // 2
    each, log_sd = made[..., :told], made[..., told:]
    mean = each.sum(axis=1) / members
    own = (LEAST_SD + np.exp(np.minimum(np.maximum(log_sd, LOG_SD[0]), LOG_SD[1]))) ** 2
    apart = (each - mean[:, None]) ** 2
    return mean, (own + apart).sum(axis=1) / members
