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
rest across each element; what rubs, the edge's part, pushes across each. How large λ is, is fitted
to cuts. Source of the rest: Budak, Altintas and
Armarego 1996.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import shear, steepness
from autodb.cutting.shear import Edge

Array = NDArray[np.float64]

BLOCK, STEEP = 10_000, 4_000
"""Elements that are summed together, and of which derivatives are: those of 500 and 200 turned
cuts, and of few milled ones. What they take stays near the processor."""
BEHIND = (*steepness.ORDER, shear.FLOW)
"""Coordinates of the law in the order that derivatives are worked out in, behind three parts."""
RAD_S_A_RPM = 2.0 * np.pi / 60.0


@dataclass(frozen=True)
class Elements:
    """Elements of the edges in n cuts, or at n moments of one.

    All broadcast to (n, e), the same number in each cut, or with ``of`` (m,), the cut of each, to
    (m,). ``width_mm``: 0 where an element does not cut; ``kappa`` and ``phi``: sine and cosine;
    ``radius_mm``: the arm of the tangential force; ``speed_rpm`` (n,) or (1,): of the spindle, so
    that power is torque times angular speed. ``frames`` (n, 3, 3) or (1, 3, 3): rows X, Y, Z of the
    tool in machine axes. ``flow``: sine and cosine of κ that the whole chip has; None: each
    element's own.
    """

    count: int
    of: NDArray[np.intp] | None
    edge: Edge
    width_mm: Array
    kappa: tuple[Array, Array]
    phi: tuple[Array, Array]
    radius_mm: Array
    speed_rpm: Array
    frames: Array
    flow: tuple[Array, Array] | None = None

    @cached_property
    def in_steep_blocks(self) -> tuple["Elements", ...]:
        """Return some cuts after the others, as derivatives are worked out: cut up once."""
        return tuple(_blocks(self, STEEP))


@dataclass(frozen=True)
class CutForces:
    """Of n cuts: force on the tool in machine axes (n, 3) N, torque (n,) N·m, power (n,) W."""

    force_N: Array
    torque_N_m: Array
    power_W: Array

    @property
    def all(self) -> Array:
        """Force x, y, z, torque, power: (n, 5)."""
        return np.column_stack([self.force_N, self.torque_N_m, self.power_W])


def cut_forces(theta: Array, elements: Elements) -> CutForces:
    """Return the forces of cuts for the law's coordinates (p,)."""
    whole = np.concatenate(
        [
            summed_forces(block, _gathered(block)(element_forces(theta, block)[:, None]))
            for block in _blocks(elements, BLOCK)
        ]
    )[..., 0]
    return CutForces(whole[:, :3], whole[:, 3], whole[:, 4])


def forces_by_laws(thetas: Array, elements: Elements) -> Array:
    """Return force x, y, z, torque and power of cuts (n, 5), each by a law of its own (p, n)."""
    theta = thetas[..., None] if elements.of is None else thetas[:, elements.of]
    return summed_forces(elements, _gathered(elements)(element_forces(theta, elements)[:, None]))[
        ..., 0
    ]


def _blocks(elements: Elements, size: int) -> Iterator[Elements]:
    """Return some cuts after the others, of about so many elements."""
    wide = max(elements.edge.thickness_mm.shape[-1], elements.width_mm.shape[-1])
    most = max(size // wide, 1)
    if elements.of is not None or elements.count <= most:
        yield elements
        return
    for begin in range(0, elements.count, most):
        rows = slice(begin, min(begin + most, elements.count))

        def some(arrays: Sequence[Array], rows: slice = rows) -> Array:
            return arrays[0] if len(arrays[0]) == 1 else arrays[0][rows]

        yield _made(rows.stop - begin, None, [elements], some, some)


def joined_elements(several: Sequence[Elements]) -> Elements:
    """Return the elements of cuts, or of moments, behind each other; as many in each cut."""
    if len(several) == 1:
        return several[0]
    counts = [one.count for one in several]
    moments = [one.of for one in several if one.of is not None]
    rows = [len(of) for of in moments] or counts
    begins = np.cumsum([0, *counts[:-1]])
    of = [one + begin for one, begin in zip(moments, begins, strict=False)]

    def behind(arrays: Sequence[Array], lengths: Sequence[int] = rows) -> Array:
        if len(arrays[0]) == 1 and all(one is arrays[0] for one in arrays):
            return arrays[0]
        return np.concatenate(
            [
                one if len(one) == length else np.repeat(one, length, axis=0)
                for one, length in zip(arrays, lengths, strict=True)
            ]
        )

    return _made(
        sum(counts), np.concatenate(of) if of else None, several, behind,
        lambda frames: behind(frames, counts),
    )  # fmt: skip


def _made(
    count: int,
    of: NDArray[np.intp] | None,
    several: Sequence[Elements],
    made: Callable[[Sequence[Array]], Array],
    framed: Callable[[Sequence[Array]], Array],
) -> Elements:
    """Return elements each of whose arrays is made of the same array of several elements."""
    edges = [one.edge for one in several]
    flows = [one.flow for one in several if one.flow is not None]
    return Elements(
        count=count,
        of=of,
        edge=Edge(
            made([one.thickness_mm for one in edges]),
            made([one.speed_m_min for one in edges]),
            made([one.rake_rad for one in edges]),
            made([one.inclination_rad for one in edges]),
        ),
        width_mm=made([one.width_mm for one in several]),
        kappa=(made([one.kappa[0] for one in several]), made([one.kappa[1] for one in several])),
        phi=(made([one.phi[0] for one in several]), made([one.phi[1] for one in several])),
        radius_mm=made([one.radius_mm for one in several]),
        speed_rpm=framed([one.speed_rpm for one in several]),
        frames=framed([one.frames for one in several]),
        flow=(made([sin for sin, _ in flows]), made([cos for _, cos in flows])) if flows else None,
    )


def force_gradient(theta: Array, elements: Elements) -> Array:
    """Return derivatives (n, 5, p) of force x, y, z, torque and power by the coordinates."""
    return linearised_forces(theta, elements)[2]


def force_parts(theta: Array, elements: Elements) -> Array:
    """Return what the tangential forces of elements make of the sums, and what is across them.

    (n, 5, 3), in forces' columns: what a law that is off by a share in either is off by; and, last,
    one that is off in the direction of what is across, by a radian from the radial up the tool's
    axis.
    """
    return summed_forces(elements, _parts(_gathered(elements)(element_forces(theta, elements))))


def linearised_forces(
    theta: Array, elements: Elements, off: Array | None = None
) -> tuple[Array, Array, Array]:
    """Return forces (n, 5), their ``force_parts`` and ``force_gradient``, worked out together.

    With ``off`` (n, 3), what the law is off by in each part (``force_parts``), the derivatives of
    what that adds stand behind those of the forces: (n, 5, 2 p).
    """
    whole = np.concatenate(
        [
            summed_forces(block, _steep(theta, block, some))
            for block, some in _off_blocks(elements, off)
        ]
    )
    parts, slopes = whole[..., :3], [whole[..., 3:][..., k] for k in _columns(off)]
    return whole[..., 0] + whole[..., 1], parts, np.concatenate(slopes, axis=-1)


def _columns(off: Array | None) -> list[NDArray[np.intp]]:
    """Return where behind the parts the derivatives by the coordinates stand, in their order."""
    order = np.argsort(BEHIND)
    return [order] if off is None else [order, len(BEHIND) + order]


def _off_blocks(elements: Elements, off: Array | None) -> Iterator[tuple[Elements, Array | None]]:
    """Return some cuts after the others, with what the law is off by in them."""
    begin = 0
    for block in elements.in_steep_blocks:
        end = begin + block.count
        yield block, None if off is None else off[begin:end]
        begin = end


@cache
def _ones(count: int) -> Array:
    """Return ones, which are not to be changed."""
    ones = np.ones(count)
    ones.flags.writeable = False
    return ones


def _steep(theta: Array, elements: Elements, off: Array | None) -> Array:
    """Return forces of the elements' parts, as ``_parts`` has them, and behind them derivatives.

    Tangential, radial and up (3, 3 + p, …), gathered; the derivatives in the order of BEHIND.
    """
    edge, width = elements.edge, elements.width_mm
    sheared = steepness.sheared(theta, edge, edge.thickness_mm * width)
    rubbed = steepness.rubbed(theta, edge, width)
    gather, made = _gathered(elements), []
    for part, thrust in ((sheared, _flowing(theta, elements)), (rubbed, elements.kappa)):
        turned = _turned(elements, part.by, thrust)
        gathered = gather(turned)
        for one in part.drives:
            if one.factor.shape[-1] == 1:
                made.append(gathered[:, one.which] * one.factor)
            else:
                made.append(gather(turned[:, one.which], one.factor))
    flow = np.zeros_like(gathered[:, :1])
    if elements.flow is not None:
        across = sheared.by[1][steepness.STRESS]
        flow[1, 0] = gather(across * (elements.kappa[0] - elements.flow[0]))
        flow[2, 0] = gather(across * (elements.flow[1] - elements.kappa[1]))
    rubs = gathered[:, 0] + gathered[:, 1] + theta[shear.EDGE_A] * gathered[:, 2]
    slopes = np.concatenate([*made, flow], axis=1)
    behind = [] if off is None else [_off_by(slopes, elements, off)]
    return np.concatenate([_parts(made[0][:, 0] + rubs), slopes, *behind], axis=1)


def _off_by(pushed: Array, elements: Elements, off: Array) -> Array:
    """Return what a law that is off by shares and a direction (n, 3) adds to forces (3, k, …)."""
    along, across, turned = off.T[:, elements.of] if elements.of is not None else off.T[..., None]
    _, radial, up = pushed
    return np.stack(
        [along * pushed[0], across * radial - turned * up, across * up + turned * radial]
    )


def _gathered(elements: Elements) -> Callable[..., Array]:
    """Return what sums forces (…, n, e) of elements to (…, n, 1) where that may come first.

    Each times a factor, if there is one. It may where all elements of a cut stand and move alike;
    else it leaves them.
    """
    like = *elements.phi, elements.radius_mm
    if elements.of is not None or any(one.shape[-1] > 1 for one in like):
        return lambda values, factor=None: values if factor is None else values * factor
    return lambda values, factor=None: _of_cuts(elements, values, factor)[..., None]


def _parts(pushed: Array) -> Array:
    """Return forces (3, 3, …) of the parts that may be off alone, of all of them (3, …)."""
    _, radial, up = pushed
    parts = np.zeros((3, 3, *pushed.shape[1:]))
    parts[0, 0] = pushed[0]
    parts[1:, 1] = pushed[1:]
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
    pushed = np.zeros((3, 3, *shape))
    pushed[0, 0] = width
    pushed[1, 1], pushed[2, 1] = -sin * width, cos * width
    pushed[1, 2], pushed[2, 2] = -pushed[2, 1], pushed[1, 1]
    return summed_forces(elements, pushed)


def engaged_mm(elements: Elements) -> Array:
    """Return the length of the engaged edge of each cut, or at each moment, mm (n,)."""
    return _of_cuts(elements, elements.width_mm * np.ones(elements.edge.thickness_mm.shape))


def chip_area_mm2(elements: Elements) -> Array:
    """Return the cross-section of the chips of each cut, or at each moment, mm² (n,)."""
    return _of_cuts(elements, elements.width_mm * elements.edge.thickness_mm)


def mean_speed_m_min(elements: Elements) -> Array:
    """Return the cutting speed of each cut, or at each moment, m/min (n,), over its engaged edge;
    0 where nothing is engaged.
    """
    length = engaged_mm(elements)
    ones = np.ones(elements.edge.thickness_mm.shape)
    moment = _of_cuts(elements, elements.width_mm * elements.edge.speed_m_min * ones)
    return np.divide(moment, length, out=np.zeros_like(length), where=length > 0.0)


def removal_mm3_min(elements: Elements) -> Array:
    """Return what chips of each cut take off the work in a minute, mm³/min (n,).

    Their cross-section goes around at the arm of its force.
    """
    area_mm2 = elements.width_mm * elements.edge.thickness_mm
    swept = _of_cuts(elements, area_mm2 * elements.radius_mm)
    return np.asarray(2.0 * np.pi * elements.speed_rpm * swept)


def element_forces(theta: Array, elements: Elements) -> Array:
    """Return the elements' forces, N: tangential, radial and up the tool's axis (3, …)."""
    edge, width = elements.edge, elements.width_mm
    sheared, rubbed = shear.chip_coefficients(theta, edge), shear.edge_coefficients(theta, edge)
    whole = _turned(elements, sheared, _flowing(theta, elements)) * edge.thickness_mm
    whole += _turned(elements, rubbed, elements.kappa)
    return np.asarray(whole * width)


def _turned(
    elements: Elements, pushing: Sequence[Array] | Array, thrust: tuple[Array, Array]
) -> Array:
    """Return tangential, radial and up (3, …) what pushes tangential, across and along the edge.

    ``thrust``: sine and cosine of κ of what is across it.
    """
    sin, cos = elements.kappa
    tangential, across, along = pushing
    radial = cos * along - thrust[0] * across
    whole = np.empty((3, *radial.shape))
    whole[0], whole[1] = tangential, radial
    np.add(thrust[1] * across, sin * along, out=whole[2])
    return whole


def _flowing(theta: Array, elements: Elements) -> tuple[Array, Array]:
    """Return sine and cosine of κ, of a chip that is one piece its share of the whole one's."""
    if elements.flow is None:
        return elements.kappa
    share, (sin, cos), whole = theta[shear.FLOW], elements.kappa, elements.flow
    return sin + share * (whole[0] - sin), cos + share * (whole[1] - cos)


def summed_forces(elements: Elements, pushed: Array) -> Array:
    """Return force x, y, z in machine axes, torque and power, summed over each cut: (n, 5, k).

    ``pushed`` (3, k, …): tangential, radial and up, k of them; gathered or not.
    """
    (sin, cos), (tangential, radial, up) = elements.phi, pushed
    shape = elements.count, 3, pushed.shape[1]
    tool = np.empty(shape)
    tool[:, 0] = _of_cuts(elements, sin * radial - cos * tangential).T
    tool[:, 1] = _of_cuts(elements, cos * radial + sin * tangential).T
    tool[:, 2] = _of_cuts(elements, up).T
    whole = np.empty((shape[0], 5, shape[2]))
    np.add.reduce(elements.frames[..., None] * tool[:, :, None], axis=1, out=whole[:, :3])
    whole[:, 3] = _of_cuts(elements, tangential * (elements.radius_mm / 1000.0)).T
    whole[:, 4] = whole[:, 3] * (RAD_S_A_RPM * elements.speed_rpm)[:, None]
    return whole


def _of_cuts(elements: Elements, values: Array, factor: Array | None = None) -> Array:
    """Return the sums (…, n) of values of the elements, each times a factor if there is one."""
    if elements.of is None and factor is None and values.shape[-1] == 1:
        return values[..., 0]
    if elements.of is None:
        return np.asarray(np.vecdot(values, _ones(values.shape[-1]) if factor is None else factor))
    values = values if factor is None else values * factor
    rows = values.reshape(-1, values.shape[-1])
    summed = np.array([np.bincount(elements.of, row, elements.count) for row in rows])
    return summed.reshape(*values.shape[:-1], elements.count)
