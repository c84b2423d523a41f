"""What was felt of cuts: force x, y, z, torque, power, chip thickness, any of them, with errors."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import shear
from autodb.cutting.elements import Elements, force_gradient, force_parts, forces
from autodb.cutting.shear import Edge, Values
from autodb.pairs.belief import Shared

Array = NDArray[np.float64]

X, Y, Z, TORQUE, POWER, CHIP = range(6)
UNITS = ("N", "N", "N", "N·m", "W", "mm")


@dataclass(frozen=True)
class Cuts:
    """Cuts of one pair in one operation, as elements of the edge."""

    operation: str
    elements: Elements


@dataclass(frozen=True)
class Observed:
    """Readings (m,) of cuts: batches of ``cuts``, numbered on through all of them.

    ``cut`` and ``quantity`` (m,): what each reading is of; ``value`` and ``sd`` in the quantity's
    unit. ``common`` (m, k): by which share of what is expected the errors of the calibrations
    ``shared``, in their order, move the readings: 1 for a gain's. Of what is expected, not of what
    was read: noise that is read too low would say that the gain is low, and many noisy readings
    would together pull the force down (Peelle's puzzle).
    """

    cuts: tuple[Cuts, ...]
    cut: NDArray[np.intp]
    quantity: NDArray[np.intp]
    value: Array
    sd: Array
    common: Array
    shared: tuple[Shared, ...] = ()

    @property
    def operations(self) -> tuple[str, ...]:
        """The operations of the cuts, each once."""
        return tuple(dict.fromkeys(one.operation for one in self.cuts))

    def expected(self, theta: Array) -> Array:
        """Return the readings (m,) that the law's coordinates expect."""
        return _stacked(self.cuts, partial(_expected, theta))[self.cut, self.quantity]

    def slopes(self, theta: Array) -> Array:
        """Return their derivatives (m, p) by the coordinates (p,)."""
        return _stacked(self.cuts, partial(_slopes, theta))[self.cut, self.quantity]

    def parts(self, theta: Array) -> Array:
        """Return the parts (m, 2) of the readings along and across the cutting speed."""
        return _stacked(self.cuts, partial(_parts, theta))[self.cut, self.quantity]

    def within(self, operation: str) -> NDArray[np.bool_]:
        """Say which readings (m,) are of an operation."""
        are = [np.full(one.elements.count, one.operation == operation) for one in self.cuts]
        return np.asarray(np.concatenate(are)[self.cut])


def _stacked(cuts: tuple[Cuts, ...], of: "partial[Array]") -> Array:
    return np.concatenate([of(one.elements) for one in cuts])


def _expected(theta: Array, elements: Elements) -> Array:
    """Return force x, y, z, torque, power and thickness of the chip of cuts: (n, 6)."""
    return np.column_stack([forces(theta, elements).all, _chip_mm(theta, elements=elements)])


def _slopes(theta: Array, elements: Elements) -> Array:
    """Return their derivatives by the law's coordinates: (n, 6, p)."""
    chip = shear.gradient(partial(_chip_mm, elements=elements), theta, axes=1).T
    return np.asarray(np.concatenate([force_gradient(theta, elements), chip[:, None]], axis=1))


def _parts(theta: Array, elements: Elements) -> Array:
    """Return their parts along and across the cutting speed; a chip has none: (n, 6, 2)."""
    return np.asarray(np.pad(force_parts(theta, elements), ((0, 0), (0, 1), (0, 0))))


def _chip_mm(theta: Values, *, elements: Elements) -> Values:
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
    thickness: Values = at.thickness_mm / shear.chip_ratio(theta, at)
    return thickness
