"""Forces from drive models and networks that learn what they leave (grey box).

F = −load + r: the load of each axis is what its drive model gives of the effort, nothing filtered;
r, and how far off the sum is (a standard deviation), is told by LSTM networks that see loads,
motion and spindle. They hear LATER rows more than they tell of, so that the drive's lag can be
undone, and nothing is told where loads and forces are not coherent. P0 section 4 names what a black
box lacks: it invents oscillations, and is not sure of anything. The loss is Gaussian with the
weight of Seitzer et al. 2022 (β = 0.5).

Trained on moves in air, whose force is 0, networks see motion and places alone: with the load they
would learn to take away every load.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.sensing.network.drive_loads import AxisLoad, AxisTables, LoadedDrive, SeenAxis
from autodb.sensing.network.network import Stacked

Array = NDArray[np.float64]
Channels = Mapping[str, Array]

LATER = 8
"""Rows that networks hear beyond the one that they tell of. Chosen: 32 ms at 250 Hz."""
LEAST_SD = 0.02
"""Least standard deviation that a network tells, in shares of the force's size. Chosen."""
LOG_SD = (-6.0, 4.0)
"""From where to where the logarithm of a standard deviation is taken as told. Chosen."""
SPINDLE = ("spindle.speed", "spindle.current")
MOTION = ("velocity", "acceleration")


@dataclass(frozen=True)
class KnownForceRecording:
    """A recording with known forces: channels (n,) by name, and force (n,) N by component."""

    channels: Channels
    force_N: Channels


@dataclass(frozen=True)
class NetworkScaling:
    """What networks see (k,) and tell (m,): middle and size of each."""

    middle: Array
    size: Array
    told_N: Array


@dataclass(frozen=True)
class GreyBox:
    """Forces of a machine's cuts from its drives.

    ``rate_hz`` of recordings; ``axes``: how each moved; ``hears``: whether networks see loads;
    ``seen``: the channels beside them; ``low`` and ``high`` (k,): from where to where all of what
    they see was in training; ``components``: x, y, z, each that of an axis; ``cutoff_hz`` (m,): up
    to where loads and forces are coherent; ``wider`` (m,): by what the told standard deviations are
    multiplied so that 95 % of recordings that were left out are within 1.96 of them.
    """

    rate_hz: float
    axes: tuple[SeenAxis, ...]
    hears: bool
    seen: tuple[str, ...]
    low: Array
    high: Array
    components: tuple[str, ...]
    scaled: NetworkScaling
    members: tuple[Stacked, ...]
    cutoff_hz: Array
    wider: Array

    def tables(self, drives: Mapping[str, LoadedDrive]) -> dict[str, AxisTables]:
        """Return the tables of its axes, of the drive models that hold now."""
        return {axis.name: AxisTables(drives[axis.name], axis) for axis in self.axes}

    def shown(self, loads: Channels, channels: Channels) -> Array:
        """Return what networks see (n, k)."""
        heard = [*loads.values()] if self.hears else []
        return np.column_stack([*heard, *(channels[name] for name in self.seen)])


def seen_of(axes: Sequence[str], channels: Channels, *, hears: bool) -> tuple[str, ...]:
    """Return the channels that networks see beside the loads of axes."""
    motion = MOTION if hears else ("position", *MOTION)
    moved = [f"{axis}.{name}" for axis in axes for name in motion]
    return (*moved, *(name for name in SPINDLE if name in channels))


def loads_of(tables: Mapping[str, AxisTables], channels: Channels) -> dict[str, Array]:
    """Return the load (n,) of each axis over a whole recording, N."""
    return {name: AxisLoad(one).step(channels) for name, one in tables.items()}
