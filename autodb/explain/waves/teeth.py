"""The teeth of a mill in the work: which slices of them cut at each row, and what a law makes.

A law is three functions of the uncut chip: tangential, radial and axial force a millimetre of edge.
What it makes is sensed in frames: the machine's, and a tilted table's.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from autodb.files.channels import FORCES
from autodb.records.tables import Recording
from autodb.sensing.table.kinematics import Kinematics

Array = NDArray[np.float64]
Law = Callable[[Array], tuple[Array, Array, Array]]
"""Force a mm of edge, tangential, radial, axial (m,) of chips (m,) mm."""

TURN = 2.0 * np.pi
SLICES = 24
"""Slices of a helical edge, before a simulation says how many it has; a straight one is one."""
TABLE = Kinematics(("a", "c"))
"""How the table turns that recordings with a.angle and c.angle are of."""


@dataclass(frozen=True)
class Mill:
    """A mill and its cut.

    ``twist_rad``: how far the top of the engaged edge lags behind its tip; ``arc``: the angles at
    which a tooth comes into the work and leaves it; ``slices`` of the engaged edge.
    """

    teeth: int
    twist_rad: float
    depth_mm: float
    feed_mm: float
    arc: tuple[float, float]
    direction_rad: float = 0.0
    slices: int = SLICES


@dataclass(frozen=True)
class StandsOut:
    """How far each tooth stands out; ``missed``: where one cuts nothing the next finds its chip.

    Simulations leave that out; teeth do not.
    """

    mm: tuple[float, ...]
    missed: bool = True


@dataclass(frozen=True)
class Slices:
    """Slices (m,) of one tooth that cut: ``row`` of each among ``rows``, φ, and their width."""

    rows: int
    row: NDArray[np.intp]
    sin: Array
    cos: Array
    width_mm: float

    def forces(self, made: tuple[Array, Array, Array]) -> Array:
        """Return x, y, z in the feed's frame (3, n) of forces a mm: tangential, radial, axial."""
        t, r, a = (self.width_mm * one for one in made)
        return np.array(
            [
                self._summed(-t * self.cos - r * self.sin),
                self._summed(t * self.sin - r * self.cos),
                self._summed(a),
            ]
        )

    def ways(self, made: tuple[Array, Array, Array]) -> Array:
        """Return the same of each way alone, tangential, radial and axial (3, 3, n)."""
        t, r, a = (self.width_mm * one for one in made)
        none = np.zeros(self.rows)
        return np.array(
            [
                [self._summed(-t * self.cos), self._summed(t * self.sin), none],
                [self._summed(-r * self.sin), self._summed(-r * self.cos), none],
                [none, none, self._summed(a)],
            ]
        )

    def _summed(self, values: Array) -> Array:
        return np.asarray(np.bincount(self.row, values, self.rows), dtype=np.float64)


@dataclass(frozen=True)
class Teeth:
    """A mill at rows (n,): the angle of tooth 0, which of them cut, and how far it is in the work.

    ``engaged`` (n,): 0 outside the work; ``reach`` (n,): way into the work over the radius: below 1
    a tooth cuts only where it has reached the work.
    """

    mill: Mill
    angle_rad: Array
    engaged: Array
    reach: Array

    @cached_property
    def _slices(self) -> list[Slices]:
        count = self.mill.slices
        height = (np.arange(count) + 0.5) / count
        return [self._cutting(j, height, self.mill.depth_mm / count) for j in self._each]

    @cached_property
    def _top(self) -> list[Slices]:
        return [self._cutting(j, np.ones(1), 1.0) for j in self._each]

    @property
    def _each(self) -> range:
        return range(self.mill.teeth)

    def _cutting(self, tooth: int, height: Array, width_mm: float) -> Slices:
        """Return the slices of a tooth at shares of the depth that cut."""
        mill, rows = self.mill, np.flatnonzero(self.engaged > 0.0)
        tip = self.angle_rad[rows] - tooth * TURN / mill.teeth
        phi = np.mod(tip[:, None] - mill.twist_rad * height, TURN)
        sin = np.sin(phi)
        inside = (phi >= mill.arc[0]) & (phi <= mill.arc[1])
        inside &= sin >= 1.0 - self.reach[rows, None]
        row = rows[np.nonzero(inside)[0]]
        return Slices(len(self.engaged), row, sin[inside], np.cos(phi[inside]), width_mm)

    def chips(self, out: StandsOut | None = None) -> list[Array]:
        """Return the uncut chip of each tooth's slices (m,) mm: 0 where none is left to cut."""
        return [self._chip(slices, j, out) for j, slices in enumerate(self._slices)]

    def moments(
        self, of_chip: Callable[[Array], Array], chips: Sequence[Array] | None = None
    ) -> Array:
        """Return sums over all slices (k, 3, n) of functions of the chip (k, m) times its width.

        Times cos φ, sin φ and 1: what forces of any law that is a sum of them are made of.
        ``chips``: those of teeth that stand out.
        """
        found: Array | float = 0.0
        for slices, chip in zip(self._slices, chips or self.chips(), strict=True):
            values = slices.width_mm * of_chip(chip) * (chip > 0.0)
            ways = (slices.cos, slices.sin, np.ones(len(slices.sin)))
            found = found + np.array(
                [
                    [np.bincount(slices.row, one * way, slices.rows) for way in ways]
                    for one in values
                ]
            )
        return np.asarray(found)

    def forces(self, law: Law, out: StandsOut | None = None) -> Array:
        """Return forces (3, n) in the feed's frame; ``out``: how far each tooth stands out."""
        return self.forces_at(law, self.chips(out))

    def forces_at(self, law: Law, chips: Sequence[Array]) -> Array:
        """Return forces (3, n) of teeth that cut chips."""
        pairs = zip(self._slices, chips, strict=True)
        return np.asarray(
            np.sum([slices.forces(_made(law, chip)) for slices, chip in pairs], axis=0)
        )

    def ways_at(self, law: Law, chips: Sequence[Array]) -> Array:
        """Return the same of each way alone, tangential, radial and axial (3, 3, n)."""
        pairs = zip(self._slices, chips, strict=True)
        return np.asarray(np.sum([slices.ways(_made(law, chip)) for slices, chip in pairs], axis=0))

    def between_teeth(self, shape: Array) -> Array:
        """Return forces (k, 3, 3, n) of edges that differ from tooth to tooth, each way alone.

        ``shape`` (z, k): N/mm of each tooth, whatever its chip.
        """
        pairs = zip(self._slices, self.chips(), strict=True)
        each = np.array([slices.ways(_made(_one, chip)) for slices, chip in pairs])
        return np.asarray(np.einsum("jk,jwxn->kwxn", shape, each))

    def deeper(self, error_mm: float) -> "Teeth":
        """Return the same teeth at another depth, in as many slices."""
        mill = self.mill
        by = 1.0 + error_mm / mill.depth_mm
        deeper = replace(mill, depth_mm=mill.depth_mm * by, twist_rad=mill.twist_rad * by)
        return Teeth(deeper, self.angle_rad, self.engaged, self.reach)

    def of_tooth(self, tooth: int, law: Law, out: StandsOut | None = None) -> Array:
        """Return the forces of one tooth (3, n)."""
        slices = self._slices[tooth]
        return slices.forces(_made(law, self._chip(slices, tooth, out)))

    def top(self, law: Law, out: StandsOut | None = None) -> Array:
        """Return what a millimetre more of depth adds (3, n)."""
        added = [s.forces(_made(law, self._chip(s, j, out))) for j, s in enumerate(self._top)]
        return np.asarray(np.sum(added, axis=0))

    def _chip(self, slices: Slices, tooth: int, out: StandsOut | None) -> Array:
        """Return the chips of a tooth (m,): 0 where the teeth before left none."""
        way = self.mill.feed_mm * slices.sin
        if out is None:
            return np.maximum(way, 0.0)
        left = [
            k * way + out.mm[tooth] - out.mm[(tooth - k) % self.mill.teeth]
            for k in range(1, 1 + (self.mill.teeth if out.missed else 1))
        ]
        return np.asarray(np.maximum(np.minimum.reduce(left), 0.0))


def contrasts(teeth: int) -> Array:
    """Return directions (z, z - 1) in which teeth may differ, their mean aside."""
    return np.asarray(np.linalg.svd(np.eye(teeth) - 1.0 / teeth)[0][:, : teeth - 1])


def _one(chip: Array) -> tuple[Array, Array, Array]:
    one = np.ones_like(chip)
    return one, one, one


def _made(law: Law, chip: Array) -> tuple[Array, Array, Array]:
    """Return forces a mm of slices: none of no chip."""
    t, r, a = law(chip)
    cuts = chip > 0.0
    return t * cuts, r * cuts, a * cuts


def machine_and_table(recording: Recording, mill: Mill, names: tuple[str, ...]) -> list[Array]:
    """Return frames (C, 3, n): machine axes, and where a table tilts also as it sees them."""
    sin, cos = np.sin(mill.direction_rad), np.cos(mill.direction_rad)
    machine = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    kept = [FORCES.index(name) for name in names]
    n = len(recording)
    found = [np.broadcast_to(machine[kept][:, :, None], (len(kept), 3, n))]
    angles = table_angles(recording)
    if is_tilted(angles):
        found.append(np.einsum("ijn,jk->ikn", TABLE.rotation(angles), machine)[kept])
    return found


def table_angles(recording: Recording) -> dict[str, Array]:
    """Return by which angles a table is tilted and turned (n,) rad, 0 where it is not recorded."""
    still = np.zeros(len(recording))
    found = {axis: recording.get(f"{axis}.angle") for axis in TABLE.order}
    return {axis: still if one is None else np.radians(one) for axis, one in found.items()}


def is_tilted(angles_rad: Mapping[str, Array]) -> bool:
    """Return whether a table moves."""
    return any(np.ptp(one) > 0.0 for one in angles_rad.values())
