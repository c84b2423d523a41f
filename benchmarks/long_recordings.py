"""What an hour of three axes at 500 Hz costs: 5.4 million samples, ten columns.

`python -m benchmarks.long_recordings`: seconds and peak memory of building ten columns, of fitting
them with correlated-noise standard deviations, of NumPy's ``lstsq`` on the same, and of the whole
`identify`; each in a process of its own, at two lengths.
"""

import resource
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RATE_HZ = 500.0
AXES = 3
HOUR_S = 3600.0
TEN = ("inertia", "viscous", "coulomb", "gravity", "asymmetry", "position_friction", "spring")


def moves(seconds: float, seed: int) -> dict[str, Array]:
    """Return t, position, velocity, acceleration and current of an axis that goes to and fro."""
    t = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    v = 120.0 * np.sin(0.9 * t) * np.sin(0.031 * t)
    x = np.cumsum(v) / RATE_HZ
    a = np.gradient(v, 1.0 / RATE_HZ)
    noise = np.random.default_rng(seed).normal(0.0, 0.02, t.size)
    current = 0.6 * np.tanh(v / 0.1) + 8e-4 * v + 6e-4 * a + 0.3 + 0.03 * np.sin(x) + noise
    return {"t": t, "position": x, "velocity": v, "acceleration": a, "current": current}


def fit(seconds: float) -> None:
    """Build ten columns of each axis and fit them, with standard deviations over 0.2 s."""
    from autodb.fitting.linear import least_squares

    for axis in range(AXES):
        design, values = columns(seconds, axis)
        least_squares(design, values, lags=round(0.2 * RATE_HZ))


def peer(seconds: float) -> None:
    """Build the same columns and fit them by NumPy's ``lstsq``."""
    for axis in range(AXES):
        design, values = columns(seconds, axis)
        np.linalg.lstsq(design, values, rcond=None)


def build(seconds: float) -> None:
    """Build the columns only."""
    for axis in range(AXES):
        columns(seconds, axis)


def identify(seconds: float) -> None:
    """Identify each axis: the command's own path, from a recording in memory."""
    from autodb.records.tables import Recording
    from autodb.sensing.drives import feed_axis

    for axis in range(AXES):
        made = moves(seconds, axis)
        named = {n: made[n] for n in ("position", "velocity", "acceleration", "current")}
        channels = {"t": made["t"], **{f"x.{n}": values for n, values in named.items()}}
        recording = Recording(path=Path("hour"), channels=channels)
        feed_axis.identify(
            recording, terms=(*feed_axis.default_terms("axis"), "asymmetry", "position_friction")
        )


def columns(seconds: float, axis: int) -> tuple[Array, Array]:
    """Return ten columns (n, 10) of the terms on an axis' moves, and its current (n,)."""
    from autodb.terms.channel import ChannelPart, channel_columns
    from autodb.terms.friction import direction
    from autodb.terms.vocabulary import term_called

    inputs = moves(seconds, axis)
    current = inputs.pop("current")
    inputs["direction"] = direction(inputs["velocity"])
    shapes = {"position_friction": {"middle": 0.0}, "spring": {"rest": 0.0}}
    parts = [ChannelPart(term_called(name), shapes.get(name, {})) for name in TEN]
    parts.append(ChannelPart(term_called("cogging"), {"period": 6.28}))
    return channel_columns(parts, inputs), current


STEPS: tuple[Callable[[float], None], ...] = (build, fit, peer, identify)


def main() -> None:
    """Run every step at half an hour and at an hour, each in its own process."""
    for step in STEPS:
        for seconds in (0.5 * HOUR_S, HOUR_S):
            command = [sys.executable, "-m", "benchmarks.long_recordings", step.__name__]
            subprocess.run([*command, f"{seconds:g}"], check=True)


if __name__ == "__main__":
    if len(sys.argv) == 1:
        main()
    else:
        chosen = next(step for step in STEPS if step.__name__ == sys.argv[1])
        start = time.perf_counter()
        chosen(float(sys.argv[2]))
        took = time.perf_counter() - start
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
        samples = AXES * float(sys.argv[2]) * RATE_HZ / 1e6
        print(f"{chosen.__name__}: {samples:.1f} million samples: {took:.1f} s, {memory:.2f} GiB")
