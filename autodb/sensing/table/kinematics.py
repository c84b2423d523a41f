"""How a table turns: from the machine's frame into that of the dynamometer on it, and how fast.

A force F in machine axes is T F for the dynamometer, T = R_k … R_1 with the rotations of the rotary
axes from the machine's bed to the table, R_i about the axis' own direction by its angle, in the
sense of P4 equation 2: for axes a, c T = T_z(θ_z) T_x(θ_x), equation 1. The angular velocity that
goes with it in the dynamometer's frame is ω = Σ θ'_i R_k … R_{i+1} e_i.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput

Array = NDArray[np.float64]

DIRECTIONS = {"a": 0, "b": 1, "c": 2}
"""Which machine axis each rotary axis turns about (ISO 841)."""


@dataclass(frozen=True)
class Kinematics:
    """The rotary axes that carry the work, in order from the bed to the table."""

    order: tuple[str, ...] = ("a", "c")

    def __post_init__(self) -> None:
        if (
            not self.order
            or set(self.order) - set(DIRECTIONS)
            or len(set(self.order)) < len(self.order)
        ):
            raise UnusableInput(
                f"rotary axes {', '.join(self.order) or 'none'}: name some of a, b, c, each "
                "once, in order from the bed to the table"
            )

    def rotation(self, angles_rad: Mapping[str, Array]) -> Array:
        """Return T (3, 3, n) of angles (n,) by axis."""
        turned = self._identity(angles_rad)
        for axis in self.order:
            turned = np.einsum("ijn,jkn->ikn", about(axis, angles_rad[axis]), turned)
        return np.asarray(turned)

    def omega(self, angles_rad: Mapping[str, Array], rates_rad_s: Mapping[str, Array]) -> Array:
        """Return ω (3, n), rad/s, of angles and their rates (n,)."""
        after = self._identity(angles_rad)
        found = np.zeros(after.shape[1:])
        for axis in reversed(self.order):
            found = found + after[:, DIRECTIONS[axis]] * rates_rad_s[axis]
            after = np.einsum("ijn,jkn->ikn", after, about(axis, angles_rad[axis]))
        return np.asarray(found)

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
                f"rotary axes carried {', '.join(said)}: no chain from the bed to the table; "
                "state carried_by in the machine's file"
            )
        found += following
    return tuple(found)
