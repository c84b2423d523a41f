"""Frames that forces of a mill may be in: the machine's, and a tilted table's."""

import numpy as np
from numpy.typing import NDArray

from autodb.explain.waves.teeth import Mill
from autodb.files.channels import FORCES
from autodb.records import Recording

Array = NDArray[np.float64]


def machine_and_table(recording: Recording, mill: Mill, names: tuple[str, ...]) -> list[Array]:
    """Return frames (C, 3, n): machine axes, and where a table tilts also as it sees them."""
    sin, cos = np.sin(mill.direction_rad), np.cos(mill.direction_rad)
    machine = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    kept = [FORCES.index(name) for name in names]
    n = len(recording)
    found = [np.broadcast_to(machine[kept][:, :, None], (len(kept), 3, n))]
    a, c = recording.get("a.angle"), recording.get("c.angle")
    zero = np.zeros(n)
    tilt, turn = np.radians(zero if a is None else a), np.radians(zero if c is None else c)
    if np.ptp(tilt) > 0.0 or np.ptp(turn) > 0.0:
        found.append(np.einsum("ijn,jk->ikn", tilted_table(tilt, turn), machine)[kept])
    return found


def tilted_table(tilt_rad: Array, turn_rad: Array) -> Array:
    """Return T_z(θ_z) T_x(θ_x), from the machine to a tilted table's frame, (3, 3, n).

    Source: rotations about x, then about z.
    """
    one, zero = np.ones_like(tilt_rad), np.zeros_like(tilt_rad)
    sx, cx, sz, cz = np.sin(tilt_rad), np.cos(tilt_rad), np.sin(turn_rad), np.cos(turn_rad)
    about_x = np.array([[one, zero, zero], [zero, cx, -sx], [zero, sx, cx]])
    about_z = np.array([[cz, -sz, zero], [sz, cz, zero], [zero, zero, one]])
    return np.asarray(np.einsum("ijn,jkn->ikn", about_z, about_x))
