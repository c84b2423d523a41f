"""What was sensed of cuts: any of force x, y, z, torque, power, chip thickness, with errors."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import shear
from autodb.cutting.elements import (
    Elements,
    chip_area_mm2,
    engaged_mm,
    force_gradient,
    force_parts,
    mean_speed_m_min,
)
from autodb.cutting.shear import SPEED_M_MIN, THICKNESS_MM, THINNEST_MM, Edge, Values
from autodb.pairs.posterior import BENDS_MM, Shared

Array = NDArray[np.float64]

X, Y, Z, TORQUE, POWER, CHIP = range(6)
UNITS = ("N", "N", "N", "N·m", "W", "mm")


@dataclass(frozen=True)
class Variant:
    """Elements as they were if something that is not known, ``key``, were off by its sd."""

    key: str
    elements: Elements


@dataclass(frozen=True)
class PairCuts:
    """Cuts of one pair in one operation, as elements of the edge.

    ``variants``: of each quantity that is assumed, because nobody stated it, what one standard
    deviation of it makes of the elements. ``worn_s`` (n,): how long the edge of each had cut; None:
    fresh edges. ``edges`` and ``lots`` (n,): what the edges, and the lots of material, are called,
    where that is known.
    """

    operation: str
    elements: Elements
    variants: tuple[Variant, ...] = ()
    worn_s: Array | None = None
    edges: tuple[str | None, ...] = ()
    lots: tuple[str | None, ...] = ()

    @property
    def assumed(self) -> tuple[Shared, ...]:
        """Errors of what is assumed, in standard deviations."""
        return tuple(Shared(one.key, np.eye(1)) for one in self.variants)

    def as_if(self, key: str) -> "PairCuts":
        """Return the cuts as they were if an assumed quantity were off by its sd."""
        other = next((one.elements for one in self.variants if one.key == key), self.elements)
        return replace(self, elements=other)


@dataclass(frozen=True)
class Observed:
    """Readings (m,) of cuts: batches of ``cuts``, numbered on through all of them.

    ``cut`` and ``quantity`` (m,): what each reading is of; ``value`` and ``sd`` in the quantity's
    unit. ``common`` (m, k): by which share of what is expected the errors of the calibrations
    ``shared``, in their order, move the readings: 1 for a gain's. Of what is expected, not of what
    was read: noise that is read too low would say that the gain is low, and many noisy readings
    would together pull the force down (Peelle's puzzle). ``shift`` (m, k): by how much, in the
    reading's own unit, they move it beyond that, as an offset's does; None: not at all.
    """

    cuts: tuple[PairCuts, ...]
    cut: NDArray[np.intp]
    quantity: NDArray[np.intp]
    value: Array
    sd: Array
    common: Array
    shared: tuple[Shared, ...] = ()
    shift: Array | None = None

    @property
    def assumed(self) -> tuple[Shared, ...]:
        """Errors of what is assumed of the cuts, each once."""
        found = {error.key: error for one in self.cuts for error in one.assumed}
        return tuple(found.values())

    def as_if(self, key: str) -> "Observed":
        """Return the readings of cuts of which an assumed quantity is off by its sd."""
        return replace(self, cuts=tuple(one.as_if(key) for one in self.cuts))

    @property
    def operations(self) -> tuple[str, ...]:
        """The operations of the cuts, each once."""
        return tuple(dict.fromkeys(one.operation for one in self.cuts))

    def parts(self, theta: Array) -> Array:
        """Return what the law's coordinates expect of the readings (m, 3).

        In parts: force along the cutting speed, force across it, thickness of a chip.
        """
        force = self.quantity != CHIP
        chip = np.zeros(len(self.cut))
        if not force.all():
            chip = self.chips_mm(theta)[self.cut]
        return np.column_stack([self.off(theta)[:, :2], np.where(force, 0.0, chip)])

    def off(self, theta: Array) -> Array:
        """Return what errors of the law change (m, ...), as ``off_law`` does; of a chip nothing."""
        changed = self._of(partial(off_law, theta))[self.cut, self.quantity % CHIP]
        return np.where((self.quantity != CHIP)[:, None], changed, 0.0)

    def slopes(self, theta: Array) -> Array:
        """Return derivatives (m, p) of the readings by the coordinates (p,)."""
        force = self.quantity != CHIP
        slopes = self._of(partial(force_gradient, theta))[self.cut, self.quantity % CHIP]
        if not force.all():
            slopes[~force] = self.chip_slopes(theta)[self.cut[~force]]
        return slopes

    def chips_mm(self, theta: Array) -> Array:
        """Return the thickness of each cut's chip (n,)."""
        return self._of(partial(_chip_mm, theta))

    def chip_slopes(self, theta: Array) -> Array:
        """Return derivatives (n, p) of the thickness of each cut's chip by the coordinates."""
        return self._of(partial(_chip_slopes, theta))

    def within(self, operation: str) -> NDArray[np.bool_]:
        """Say which readings (m,) are of an operation."""
        are = [np.full(one.elements.count, one.operation == operation) for one in self.cuts]
        return np.asarray(np.concatenate(are)[self.cut])

    def off_surface(self) -> Array:
        """Return what share of each reading (m,) of a force is off the surface that is left."""
        normal = self._of(off_surface)[self.cut]
        each = np.take_along_axis(normal, np.minimum(self.quantity, Z)[:, None], axis=1)[:, 0]
        return np.where(self.quantity <= Z, each, 0.0)

    def _of(self, what: Callable[[Elements], Array]) -> Array:
        return np.concatenate([what(one.elements) for one in self.cuts])


def off_law(theta: Array, elements: Elements) -> Array:
    """Return what errors of the law change in force x, y, z, torque, power (n, 5, 12 + 2 k).

    Shares of what is along and across the cutting speed, and the direction of what is across, rad;
    then the same by how they grow with the logarithm of the engaged edge over 1 mm: a law that
    leaves out what a nose does is off by another share in a shallow cut than in a deep one; with
    that of the chip's thickness, and of the cutting speed. Last, by how much the exponents in
    thickness change where chips are thinner.
    """
    return with_growth(force_parts(theta, elements), elements)


def with_growth(parts: Array, elements: Elements) -> Array:
    """Return parts of forces (n, 5, 3), behind them how they grow with the engaged edge, the chip
    and the speed, and how those along and across the cutting speed bend under thin chips
    (n, 5, 12 + 2 k).
    """
    return with_grown(parts, *growth_and_bends(elements))


def with_grown(parts: Array, grown: Array, bends: Array) -> Array:
    """Return parts as ``with_growth`` does, of which the growth and the bends are known."""
    more = grown_parts(parts, grown[:, None])
    bent = parts[..., :2, None] * bends[:, None, None, :]
    return np.concatenate([parts, more, bent.reshape(*bent.shape[:2], -1)], axis=-1)


def chip_bends(elements: Elements) -> Array:
    """Return by how much each cut's chip is thinner than BENDS_MM (n, k), logarithms; not below 0.

    The chip's mean thickness over its width; none where nothing is engaged.
    """
    return growth_and_bends(elements)[1]


def off_surface(elements: Elements) -> Array:
    """Return the direction (n, 3) off the surface that each cut leaves, in machine axes."""
    return np.broadcast_to(elements.frames[:, 2], (elements.count, 3))


def growth(elements: Elements) -> Array:
    """Return what errors of the law grow with (n, 3); 0 where nothing is engaged.

    Logarithms of the engaged edge over 1 mm, and of the chip's mean thickness and the cutting speed
    over those at which the law's own exponents change nothing.
    """
    return growth_and_bends(elements)[0]


def growth_and_bends(elements: Elements) -> tuple[Array, Array]:
    """Return ``growth`` and ``chip_bends`` of cuts, worked out together."""
    length, speed = engaged_mm(elements), mean_speed_m_min(elements)
    thickness = np.maximum(_mean_thickness_mm(elements, length), THINNEST_MM)
    grown = np.column_stack(
        [
            np.log(np.where(length > 0.0, length, 1.0)),
            np.log(thickness / THICKNESS_MM),
            np.log(np.where(speed > 0.0, speed, SPEED_M_MIN) / SPEED_M_MIN),
        ]
    )
    return grown, np.maximum(np.log(BENDS_MM / thickness[:, None]), 0.0)


def grown_parts(parts: Array, by: Array) -> Array:
    """Return parts of forces (..., 3) times each of what they grow with (..., 3): (..., 9)."""
    return (by[..., :, None] * parts[..., None, :]).reshape(*parts.shape[:-1], -1)


def _mean_thickness_mm(elements: Elements, width: Array) -> Array:
    """Return the mean thickness of each cut's chip (n,) over the width (n,) that is engaged.

    THICKNESS_MM where nothing is.
    """
    area = chip_area_mm2(elements)
    return np.divide(area, width, out=np.full_like(area, THICKNESS_MM), where=width > 0.0)


def _chip_slopes(theta: Array, elements: Elements) -> Array:
    """Return derivatives (n, p) of the chip's thickness by the coordinates."""
    return shear.gradient(partial(_chip_mm, elements=elements), theta, axes=1).T


def _chip_mm(theta: Values, elements: Elements) -> Values:
    """Return the thickness h/r of the chip (n,) where it is thickest."""
    if elements.of is not None:
        raise TypeError("a chip's thickness is of a cut's mean, not of a moment")
    edge = elements.edge
    shape = np.broadcast_shapes(edge.thickness_mm.shape, elements.width_mm.shape)
    engaged = np.where(elements.width_mm > 0.0, edge.thickness_mm, 0.0)
    rows = np.arange(elements.count), np.argmax(engaged, axis=1)

    def there(values: Array) -> Array:
        return np.asarray(np.broadcast_to(values, (elements.count, shape[1]))[rows])

    parts = (edge.thickness_mm, edge.speed_m_min, edge.rake_rad, edge.inclination_rad)
    at = Edge(*(there(part) for part in parts))
    return np.asarray(at.thickness_mm / shear.chip_ratio(theta, at))
