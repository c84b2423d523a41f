"""An axis that moves and rests, at any instants: to be stamped as loggers do."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CYCLE_S, MOVE_S, WAY_MM = 2.0, 1.2, 150.0


def place_mm(t_s: Array) -> Array:
    """Return where the axis is at instants (n,): there in one cycle, back in the next, by 3u² − 2u³
    of each move.
    """
    cycle, into = np.divmod(t_s, CYCLE_S)
    share = np.clip(into / MOVE_S, 0.0, 1.0)
    way = share**2 * (3.0 - 2.0 * share)
    return np.asarray(WAY_MM * np.where(cycle % 2 == 0, way, 1.0 - way), dtype=np.float64)


def written_mm(t_s: Array, resolution_mm: float = 1e-3) -> Array:
    """Return the same as an encoder gives it."""
    return np.asarray(np.round(place_mm(t_s) / resolution_mm) * resolution_mm, dtype=np.float64)


def effort_A(t_s: Array, rng: np.random.Generator, noise_A: float = 0.02) -> Array:
    """Return the current of viscous and Coulomb friction and a weight, with white noise."""
    speed = (place_mm(t_s + 1e-4) - place_mm(t_s - 1e-4)) / 2e-4
    clean = 0.01 * speed + 1.2 * np.tanh(speed / 0.5) + 0.3
    return np.asarray(clean + noise_A * rng.standard_normal(len(t_s)), dtype=np.float64)
