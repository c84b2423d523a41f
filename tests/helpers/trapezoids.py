"""Moves of an axis at drawn speeds, and the current of a truth that is written here."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.records.tables import Recording

Array = NDArray[np.float64]
RATE_HZ = 125.0
INERTIA, VISCOUS, COULOMB, WEIGHT, NOISE = 6e-4, 8e-4, 0.7, 0.4, 0.02


def moves(
    seed: int, *, seconds: float = 40.0, rate_hz: float = RATE_HZ, forwards_only: bool = False
) -> dict[str, Array]:
    """Trapezoids of drawn speeds, with dwells; jerk is limited by a moving average of 0.05 s."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, 1.0 / rate_hz)
    speed = np.zeros_like(t)
    at, sign = 0.8, 1.0
    while at < seconds:
        level, long = rng.choice([3.0, 15.0, 40.0, 90.0, 150.0]), rng.uniform(0.8, 1.6)
        speed[(t >= at) & (t < at + long)] = sign * level
        at += long + rng.uniform(0.3, 0.6)
        sign = 1.0 if forwards_only else -sign
    width = round(0.05 * rate_hz)
    for _ in range(3):
        speed = np.convolve(speed, np.full(width, 1.0 / width), mode="same")
    return {
        "t": t,
        "x.position": (np.cumsum(speed) - 0.5 * speed) / rate_hz,
        "x.velocity": speed,
        "x.acceleration": np.gradient(speed, t),
    }


def current(channels: dict[str, Array], seed: int, *, coulomb: float = COULOMB) -> Array:
    """Friction that reverses as tanh, drag that grows a little slower than speed, weight, noise."""
    v, a = channels["x.velocity"], channels["x.acceleration"]
    drag = VISCOUS * v * 150.0 / (150.0 + 0.2 * np.abs(v))
    noise = np.random.default_rng([seed, 1]).normal(0, NOISE, len(v))
    return coulomb * np.tanh(v / 0.1) + drag + INERTIA * a + WEIGHT + noise


def recorded(channels: dict[str, Array], effort: Array) -> Recording:
    return Recording(path=Path("moves.csv"), channels={**channels, "x.current": effort})
