"""Effects of a mass on the tilted table that feels a milled cut; sizes are kg, parts (3, n), N."""

from dataclasses import dataclass

import numpy as np

from autodb.proofs.cases.base.case import Array
from autodb.proofs.cases.mill.mill_effects import MillEffect, Three
from autodb.proofs.cases.mill.milling import MillWorld, table_rotations

GRAVITY_M_S2 = 9.81


@dataclass(frozen=True)
class Weighs(MillEffect):
    """A weight on the tilted table that was tared flat; the size is kg."""

    term = "table_gravity"

    def most(self, world: MillWorld) -> float:
        """60 kg."""
        del world
        return 60.0

    def columns(self, world: MillWorld, total: Array) -> Array:
        """The weight of 1 kg turned, less as tared."""
        del total
        down = np.array([0.0, 0.0, GRAVITY_M_S2])
        return np.asarray(np.einsum("ijn,j->in", table_rotations(world.cut), down) - down[:, None])[
            None
        ]


@dataclass(frozen=True)
class Swings(MillEffect):
    """A mass off the table's axes is swung, F = m (ω x (ω x r) + ω' x r); the size is kg."""

    at_m: Three
    term = "table_inertia"

    def most(self, world: MillWorld) -> float:
        """100 kg."""
        del world
        return 100.0

    def columns(self, world: MillWorld, total: Array) -> Array:
        """Forces of 1 kg at 1 m along x, y and z."""
        del total
        return np.array([swung(world, at) for at in np.eye(3)])

    def part(self, world: MillWorld, total: Array, size: float) -> Array:
        """Forces of the mass where it is."""
        return np.asarray(size * np.tensordot(self.at_m, self.columns(world, total), axes=1))


def swung(world: MillWorld, at_m: Array) -> Array:
    """Return the force (3, n) of 1 kg at a place fixed to the table, in the table's frame.

    ω = -a' about the machine's x seen by the table, -c' about its own z: ``table_rotations`` turn
    components by +a and +c.
    """
    cut = world.cut
    step = float(cut.t_s[1] - cut.t_s[0])
    tilting, turning = np.gradient(cut.a_rad, step), np.gradient(cut.c_rad, step)
    about_x = np.array([np.cos(cut.c_rad), np.sin(cut.c_rad), np.zeros_like(cut.c_rad)])
    omega = -tilting * about_x - turning * np.array([[0.0], [0.0], [1.0]])
    faster = np.gradient(omega, step, axis=1)
    place = np.broadcast_to(at_m[:, None], omega.shape)
    central = np.cross(omega, np.cross(omega, place, axis=0), axis=0)
    return np.asarray(central + np.cross(faster, place, axis=0))
