"""A sweep of an axis whose friction bends off its laws."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.records.tables import Recording

Array = NDArray[np.float64]

RATE = 50.0
SPEEDS = np.geomspace(0.5, 150.0, 12)
NOISE_A = 0.03
WAVE_MM, WAVE_A = 10.0, 0.05
"""A ripple of the screw's turns, in friction."""


def bent_sweep(seed: int, *, bent_A: float, wave_A: float = 0.0) -> Recording:
    """Return three rounds of passes there and back; friction bends over ln speed by ``bent_A``."""
    velocity = [np.zeros(50)]
    for speed in np.tile(SPEEDS, 3).tolist():
        rows = int(min(max(10.0, 2.0 * speed), 200.0) / speed * RATE)
        ramp = np.linspace(0.0, speed, 5)[1:]
        there = np.concatenate([ramp, np.full(rows, speed), ramp[::-1], np.zeros(10)])
        velocity += [there, -there]
    v = np.concatenate(velocity)
    x = np.cumsum(v) / RATE
    effort = np.sign(v) * (_friction(v, bent_A) + wave_A * np.sin(2.0 * np.pi * x / WAVE_MM))
    effort += 3e-4 * np.gradient(v) * RATE
    effort += NOISE_A * np.random.default_rng(seed).standard_normal(len(v))
    channels = {
        "t": np.arange(len(v)) / RATE, "z.position": x, "z.velocity": v, "z.current": effort,
    }  # fmt: skip
    return Recording(path=Path("sweep.csv"), channels=channels)


def _friction(velocity: Array, bent_A: float) -> Array:
    return 0.8 + 1e-3 * np.abs(velocity) + bent_A * np.log1p(np.abs(velocity))
