"""An axis whose friction is other in each run: laws of Coulomb and viscosity, trapezoidal moves.

It shares no code with the package, and its laws are those of plain least squares: what intervals of
Coulomb and viscous friction miss here, they miss for the wander alone. Sizes chosen.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RATE_HZ = 200.0
RAMP_MM_S2 = 1000.0
SPEEDS_MM_S = (5.0, 12.0, 25.0, 50.0, 90.0, 140.0)


@dataclass(frozen=True)
class WanderingAxis:
    """The truth in N, s and mm; ``channels`` is a recording of it."""

    coulomb: float
    viscous: float
    inertia: float
    weight: float
    channels: dict[str, Array]


def wandering_axis(
    seed: int, *, share: float, repeats: int = 2, slow_s: float = 0.0
) -> WanderingAxis:
    """Return an axis whose friction is (1 + share · N(0, 1)) times its law's in each run.

    With ``slow_s`` the shares of runs are alike as exp(−Δt/slow_s).
    """
    rng = np.random.default_rng([seed, 4711])
    t, v = _moves(rng, repeats)
    still = np.abs(v) < 1e-9
    a = np.gradient(v, 1.0 / RATE_HZ)
    x = 50.0 + np.cumsum(v) / RATE_HZ
    run = np.cumsum(np.diff(still.astype(int), prepend=1) == -1)
    own = rng.standard_normal(run[-1] + 1)
    if slow_s:
        when = np.bincount(run, t) / np.bincount(run)
        alike = np.exp(-np.abs(np.subtract.outer(when, when)) / slow_s)
        own = np.linalg.cholesky(alike + 1e-12 * np.eye(len(own))) @ own
    coulomb, viscous = float(rng.uniform(30.0, 90.0)), float(rng.uniform(0.1, 0.5))
    inertia, weight = float(rng.uniform(0.05, 0.2)), float(rng.uniform(-30.0, 30.0))
    rubs = np.sign(v) * (coulomb + viscous * np.abs(v)) * ~still
    force = rubs * (1.0 + share * own[run]) + inertia * a + weight
    force = force + 0.02 * coulomb * rng.standard_normal(len(t))
    channels = {
        "t": t, "x.position": x, "x.velocity": v, "x.acceleration": a, "x.drive_force": force,
    }  # fmt: skip
    return WanderingAxis(coulomb, viscous, inertia, weight, channels)


def _moves(rng: np.random.Generator, repeats: int) -> tuple[Array, Array]:
    """Return time and velocity of moves out and back at every speed, in drawn order."""
    pieces = [np.zeros(200)]
    for _ in range(repeats):
        for speed in rng.permutation(SPEEDS_MM_S):
            ramp = np.linspace(0.0, 1.0, max(int(speed / RAMP_MM_S2 * RATE_HZ), 2))
            cruise = np.ones(int(rng.uniform(1.5, 2.5) * RATE_HZ))
            stroke = np.concatenate([ramp, cruise, ramp[::-1]]) * speed
            for sense in (1.0, -1.0):
                pieces += [sense * stroke, np.zeros(int(rng.uniform(0.2, 0.5) * RATE_HZ))]
    v = np.concatenate(pieces)
    return np.arange(len(v)) / RATE_HZ, v
