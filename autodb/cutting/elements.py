"""Elements of cutting edges: their forces, turned into machine axes and summed over each cut.

An element lies on the flank of a tool whose axis is Z of the tool's frame. Its cross-section is
seen at the angle φ about Z (from Y towards X), where the radial direction is (sin φ, cos φ, 0) and
the work's force along its velocity points to (-cos φ, sin φ, 0). κ is the angle between the edge
and the Z-normal plane: the work lies towards sin κ radial - cos κ Z. So on the tool

    radial: -sin κ F_r + cos κ F_a    along Z: cos κ F_r + sin κ F_a

A milling tooth goes through φ; an edge that turns is one at φ = 90° that stands still, with X along
its feed and Z off the finished surface.

A chip that comes off a curved edge is one piece: its elements cannot each push their own way. So a
share λ of its thrust points along the mean over the chip's area (Young, Mathew and Oxley 1987), the
rest across each element; what rubs, the edge's part, pushes across each. How large λ is, cuts tell.
Source of the rest: physics reference, section 6.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import shear
from autodb.cutting.shear import Edge, Values

Array = NDArray[np.float64]

BLOCK = 1000
"""Cuts that are summed together."""


@dataclass(frozen=True)
class Elements:
    """Elements of the edges in n cuts, or at n moments of one.

    All broadcast to (n, e), the same number in each cut, or with ``of`` (m,), the cut of each, to
    (m,). ``width_mm``: 0 where an element does not cut; ``kappa`` and ``phi``: sine and cosine;
    ``radius_mm``: the arm of the tangential force. ``frames`` (n, 3, 3) or (1, 3, 3): rows X, Y, Z
    of the tool in machine axes. ``flow``: sine and cosine of κ that the whole chip has; None: each
    element's own.
    """

    count: int
    of: NDArray[np.intp] | None
    edge: Edge
    width_mm: Array
    kappa: tuple[Array, Array]
    phi: tuple[Array, Array]
    radius_mm: Array
    frames: Array
    flow: tuple[Array, Array] | None = None


@dataclass(frozen=True)
class Forces:
    """Of n cuts: force on the tool in machine axes (n, 3) N, torque (n,) N·m, power (n,) W."""

    force_N: Array
    torque_N_m: Array
    power_W: Array

    @property
    def all(self) -> Array:
        """Force x, y, z, torque, power: (n, 5)."""
        return np.column_stack([self.force_N, self.torque_N_m, self.power_W])


def forces(theta: Array, elements: Elements) -> Forces:
    """Return the forces of cuts for the law's coordinates (p,)."""
    summed = np.concatenate(
        [_summed(block, *_across_axis(theta, block)) for block in _blocks(elements)]
    )
    return Forces(summed[:, :3], summed[:, 3], summed[:, 4])


def _blocks(elements: Elements) -> Iterator[Elements]:
    """Return some cuts after the others, so that what they take stays near the processor."""
    if elements.of is not None or elements.count <= BLOCK:
        yield elements
        return
    for begin in range(0, elements.count, BLOCK):
        rows = slice(begin, begin + BLOCK)

        def some(values: Array, rows: slice = rows) -> Array:
            return values if len(values) == 1 else values[rows]

        def both(pair: tuple[Array, Array], rows: slice = rows) -> tuple[Array, Array]:
            return some(pair[0], rows), some(pair[1], rows)

        edge = elements.edge
        yield Elements(
            count=min(BLOCK, elements.count - begin),
            of=None,
            edge=Edge(
                some(edge.thickness_mm),
                some(edge.speed_m_min),
                some(edge.rake_rad),
                some(edge.inclination_rad),
            ),
            width_mm=some(elements.width_mm),
            kappa=both(elements.kappa),
            phi=both(elements.phi),
            radius_mm=some(elements.radius_mm),
            frames=some(elements.frames),
            flow=None if elements.flow is None else both(elements.flow),
        )


def force_gradient(theta: Array, elements: Elements) -> Array:
    """Return derivatives (n, 5, p) of force x, y, z, torque and power by the coordinates."""
    slopes = (np.imag(one) / shear.STEP for one in _stepped(theta, elements))
    return np.moveaxis(_summed(elements, *slopes), 0, -1)


def force_parts(theta: Array, elements: Elements) -> Array:
    """Return what the tangential forces of elements make of the sums, and what is across them.

    (n, 5, 3), in forces' columns: what a law that is off by a share in either is off by; and, last,
    one that is off in the direction of what is across, by a radian from the radial up the tool's
    axis.
    """
    parts = _parts(*_across_axis(theta, elements))
    return np.moveaxis(_summed(elements, *parts), 0, -1)


def linearised(theta: Array, elements: Elements) -> tuple[Array, Array, Array]:
    """Return forces (n, 5), their ``force_parts`` and ``force_gradient``, worked out together.

    The law is evaluated once, at coordinates stepped along the imaginary axis, whose real part is
    its value.
    """
    stepped = _stepped(theta, elements)
    both = np.empty((3, 3 + len(theta), *stepped[0].shape[1:]))
    both[:, :3] = _parts(*(one[0].real for one in stepped))
    for k in range(3):
        np.divide(stepped[k].imag, shear.STEP, out=both[k, 3:])
    summed = np.moveaxis(_summed(elements, *both), 0, -1)
    return summed[..., 0] + summed[..., 1], summed[..., :3], summed[..., 3:]


def _stepped(theta: Array, elements: Elements) -> tuple[Values, Values, Values]:
    """Return forces across the axis of elements (p, …), each coordinate stepped in turn."""
    axes = 2 if elements.of is None else 1
    return _across_axis(shear.stepped(theta, axes=axes), elements)


def _parts(tangential: Array, radial: Array, up: Array) -> Array:
    """Return tangential, radial and upward forces (3, 3, …) of the parts that may be off alone."""
    parts = np.zeros((3, 3, *tangential.shape))
    parts[0, 0] = tangential
    parts[1, 1], parts[2, 1] = radial, up
    parts[1, 2], parts[2, 2] = -up, radial
    return parts


def edge_parts(elements: Elements) -> Array:
    """Return what 1 N/mm more of the edge's own force makes of force x, y, z, torque, power.

    (n, 5, 3): of its force along the cutting speed, of that across the edge; and, last, what the
    direction of the latter changes, by a radian from the radial up the tool's axis.
    """
    sin, cos = elements.kappa
    shape = np.broadcast_shapes(
        *(one.shape for one in (elements.edge.thickness_mm, elements.width_mm, sin))
    )
    width = np.broadcast_to(elements.width_mm, shape)
    tangential, radial, up = np.zeros((3, 3, *shape))
    tangential[0] = width
    radial[1], up[1] = -sin * width, cos * width
    radial[2], up[2] = -up[1], radial[1]
    return np.moveaxis(_summed(elements, tangential, radial, up), 0, -1)


def engaged_mm(elements: Elements) -> Array:
    """Return the length of the engaged edge of each cut, or at each moment, mm (n,)."""
    shape = np.broadcast_shapes(elements.edge.thickness_mm.shape, elements.width_mm.shape)
    return _of_cuts(elements, np.broadcast_to(elements.width_mm, shape))


def _across_axis(theta: Values, elements: Elements) -> tuple[Values, Values, Values]:
    """Return the elements' forces, N: tangential, radial and along the tool's axis."""
    h, width = elements.edge.thickness_mm, elements.width_mm
    shear_t, shear_r, shear_a = (
        one * h * width for one in shear.coefficients(theta, elements.edge)
    )
    edge_t, edge_r, edge_a = (one * width for one in shear.edge_coefficients(theta, elements.edge))
    sin, cos = elements.kappa
    along = shear_a + edge_a
    radial = cos * along - sin * (shear_r + edge_r)
    up = cos * (shear_r + edge_r) + sin * along
    if elements.flow is not None:
        joined = theta[shear.FLOW] * shear_r
        radial = radial - joined * (elements.flow[0] - sin)
        up = up + joined * (elements.flow[1] - cos)
    return shear_t + edge_t, radial, up


def _summed(elements: Elements, tangential: Array, radial: Array, up: Array) -> Array:
    """Return force x, y, z in machine axes, torque and power, summed over each cut: (…, n, 5)."""
    sin_phi, cos_phi = elements.phi
    across = sin_phi * radial - cos_phi * tangential
    summed = _of_cuts(elements, across)
    whole = np.empty((*summed.shape, 5))
    whole[..., 0] = summed
    whole[..., 1] = _of_cuts(elements, cos_phi * radial + sin_phi * tangential)
    whole[..., 2] = _of_cuts(elements, up)
    whole[..., 3] = _of_cuts(elements, tangential * elements.radius_mm) / 1000.0
    whole[..., 4] = _of_cuts(elements, tangential * elements.edge.speed_m_min) / 60.0
    whole[..., :3] = np.matmul(whole[..., None, :3], elements.frames)[..., 0, :]
    return whole


def _of_cuts(elements: Elements, values: Array) -> Array:
    """Return the sums (…, n) of values of the elements."""
    if elements.of is None:
        return np.asarray(np.add.reduce(values, axis=-1))
    rows = values.reshape(-1, values.shape[-1])
    summed = np.array([np.bincount(elements.of, row, elements.count) for row in rows])
    return summed.reshape(*values.shape[:-1], elements.count)
