"""What was sensed of cuts: any of force x, y, z, torque, power, chip thickness, with errors."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import shear
from autodb.cutting.elements import Elements, engaged_mm, force_gradient, force_parts
from autodb.cutting.shear import Edge, Values
from autodb.pairs.posterior import Shared

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
        """Return what errors of the law change (m, 6), as ``off_law`` does; of a chip nothing."""
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

    def _of(self, what: Callable[[Elements], Array]) -> Array:
        return np.concatenate([what(one.elements) for one in self.cuts])


def off_law(theta: Array, elements: Elements) -> Array:
    """Return what errors of the law change in force x, y, z, torque and power (n, 5, 6).

    Shares of what is along and across the cutting speed, and the direction of what is across, rad;
    then the same by how they grow with the logarithm of the engaged edge over 1 mm: a law that
    leaves out what a nose does is off by another share in a shallow cut than in a deep one.
    """
    return with_growth(force_parts(theta, elements), elements)


def with_growth(parts: Array, elements: Elements) -> Array:
    """Return parts of forces (n, 5, 3), and behind them how they grow with the engaged edge."""
    return np.concatenate([parts, parts * edge_growth(elements)[:, None, None]], axis=-1)


def edge_growth(elements: Elements) -> Array:
    """Return the logarithm of the engaged edge over 1 mm (n,); 0 where nothing is engaged."""
    length = engaged_mm(elements)
    return np.log(np.where(length > 0.0, length, 1.0))


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
