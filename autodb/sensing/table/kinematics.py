"""How a table turns: from the machine's frame into that of the dynamometer on it, and how fast.

A force F in machine axes is T F for the dynamometer, T = R_k … R_1 with the rotations of the rotary
axes from the machine's bed to the table, R_i about the axis' own direction by its angle, in the
sense of P4 equation 2: for axes a, c T = T_z(θ_z) T_x(θ_x), equation 1. What turns a force's
components by +θ belongs to a table that turns by -θ: the angular velocity in the dynamometer's
frame follows from T alone, [ω]× = T dTᵀ/dt, which is ω = -Σ θ'_i R_k … R_{i+1} e_i. Machines count
an angle one way or the other: its sense, 1 as above or -1, is the machine's.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.wording import phrase

Array = NDArray[np.float64]

DIRECTIONS = {"a": 0, "b": 1, "c": 2}
"""Which machine axis each rotary axis turns about (ISO 841)."""


@dataclass(frozen=True)
class Kinematics:
    """The rotary axes that carry the work, in order from the bed to the table.

    ``senses``: 1 or -1 of each, by which its angle counts; none: 1.
    """

    order: tuple[str, ...] = ("a", "c")
    senses: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "senses", self.senses or (1,) * len(self.order))
        if (
            not self.order
            or set(self.order) - set(DIRECTIONS)
            or len(set(self.order)) < len(self.order)
        ):
            raise UnusableInput(
                phrase(
                    "rotary axes {names}: name some of a, b, c, each once, in order from the bed "
                    "to the table",
                    names=", ".join(self.order) or phrase("none"),
                )
            )

    def rotation(self, angles_rad: Mapping[str, Array]) -> Array:
        """Return T (3, 3, n) of angles (n,) by axis."""
        turned = self._identity(angles_rad)
        for axis, sense in zip(self.order, self.senses, strict=True):
            turned = np.einsum("ijn,jkn->ikn", about(axis, sense * angles_rad[axis]), turned)
        return np.asarray(turned)

    def omega(self, angles_rad: Mapping[str, Array], rates_rad_s: Mapping[str, Array]) -> Array:
        """Return ω (3, n), rad/s, of angles and their rates (n,)."""
        return np.asarray(sum(self._each(angles_rad, rates_rad_s)))

    def omega_dot(
        self,
        angles_rad: Mapping[str, Array],
        rates_rad_s: Mapping[str, Array],
        accelerations_rad_s2: Mapping[str, Array],
    ) -> Array:
        """Return dω/dt (3, n), rad/s², of angles, their rates and accelerations (n,)."""
        found = self.omega(angles_rad, accelerations_rad_s2)
        nearer = np.zeros_like(found)
        for alone in reversed(self._each(angles_rad, rates_rad_s)):
            # Axes nearer the table turn it, and with it what it sees of this one's direction
            found = found - np.cross(nearer, alone, axis=0)
            nearer = nearer + alone
        return found

    def _each(
        self, angles_rad: Mapping[str, Array], rates_rad_s: Mapping[str, Array]
    ) -> list[Array]:
        """Return what each axis adds to ω (3, n), in their order."""
        after, found = self._identity(angles_rad), []
        for axis, sense in zip(reversed(self.order), reversed(self.senses), strict=True):
            found.append(-sense * after[:, DIRECTIONS[axis]] * rates_rad_s[axis])
            after = np.einsum("ijn,jkn->ikn", after, about(axis, sense * angles_rad[axis]))
        return found[::-1]

    def _identity(self, angles_rad: Mapping[str, Array]) -> Array:
        count = len(angles_rad[self.order[0]])
        return np.repeat(np.eye(3)[:, :, None], count, axis=2)


def about(axis: str, angle_rad: Array) -> Array:
    """Return the rotation (3, 3, n) about a rotary axis' direction, P4 equation 2."""
    one, zero = np.ones_like(angle_rad), np.zeros_like(angle_rad)
    sin, cos = np.sin(angle_rad), np.cos(angle_rad)
    first = DIRECTIONS[axis]
    second, third = (first + 1) % 3, (first + 2) % 3
    turned = np.stack([np.stack([zero] * 3)] * 3)
    turned[first, first] = one
    turned[second, second] = turned[third, third] = cos
    turned[second, third], turned[third, second] = -sin, sin
    return turned


def order_of(carried_by: Mapping[str, str | None]) -> tuple[str, ...]:
    """Return the order of rotary axes that carry the work, from the bed on.

    ``carried_by``: of each such axis the axis it rides on, None or a linear one where it rides on
    no rotary one. Raises UnusableInput where they are no chain.
    """
    rotary = {axis: by if by in carried_by else None for axis, by in carried_by.items()}
    found: list[str] = []
    while len(found) < len(rotary):
        last = found[-1] if found else None
        following = [axis for axis, by in rotary.items() if by == last and axis not in found]
        if len(following) != 1:
            said: Sequence[str] = [f"{axis} by {by or 'the bed'}" for axis, by in rotary.items()]
            raise UnusableInput(
                phrase(
                    "rotary axes carried {names}: no chain from the bed to the table; state "
                    "carried_by in the machine's file",
                    names=", ".join(said),
                )
            )
        found += following
    return tuple(found)
