"""Milling with an end mill: teeth through the work, moment by moment or averaged over a turn.

With φ the angle of a tooth's slice at height z, from the normal left of the feed (Y) towards the
feed (X), κ its entering angle, 90° but on the corner's radius r,

    h = f (sin φ sin κ cos ρ + cos κ sin ρ) + run-out    lag z tan(helix)/R
    width dz on the flank, r dκ on the corner

f the feed of that tooth at that height (unequal pitch and helix share it unequally), ρ the angle of
a ramp. A tooth that runs in cuts what those before it left. A slice cuts where its point lies
within the band across the feed that the operation engages (contract: slot, side-up, side-down).
Edges on the face of a square mill are not in it. Source: Budak, Altintas and Armarego 1996.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.elements import CutForces, Elements, cut_forces
from autodb.cutting.shear import Edge

Array = NDArray[np.float64]
Rule = tuple[Array, Array]
"""Nodes and weights (k,) of a sum that is an integral over 0 to 1."""

TURN = 2.0 * np.pi
SLICE_MM = 0.1
MOMENTS = 512
"""Moments that are computed together: what they take stays near the processor."""
NODES = 16
"""Nodes over the engaged arc, the corner and the flank: means are off by less than 0.1 %."""


@dataclass(frozen=True)
class EndMill:
    """An end mill: ``corner_radius_mm`` up to half the diameter (a ball).

    ``helix_deg`` one for all teeth or one each; ``pitch_deg``: angle from the tooth before to each,
    None: equal. ``runout_mm``: offset of the tool's axis from the spindle's, towards
    ``runout_deg``, counted from tooth 0 to tooth 1.
    """

    diameter_mm: float
    teeth: int
    helix_deg: float | tuple[float, ...] = 0.0
    pitch_deg: tuple[float, ...] | None = None
    corner_radius_mm: float = 0.0
    rake_deg: float = 0.0
    runout_mm: float = 0.0
    runout_deg: float = 0.0

    @property
    def radius_mm(self) -> float:
        """Half the diameter."""
        return 0.5 * self.diameter_mm

    @property
    def helices_rad(self) -> Array:
        """Helix of each tooth (teeth,)."""
        return np.broadcast_to(np.radians(self.helix_deg), (self.teeth,))

    @property
    def pitches_rad(self) -> Array:
        """Angle from the tooth before to each (teeth,)."""
        if self.pitch_deg is None:
            return np.full(self.teeth, TURN / self.teeth)
        return np.asarray(np.radians(self.pitch_deg), dtype=np.float64)

    @property
    def teeth_differ(self) -> bool:
        """Whether what one tooth cuts is not what another does."""
        uneven = np.ptp(self.pitches_rad) > 1e-9 or np.ptp(self.helices_rad) > 1e-9
        return bool(uneven) or self.runout_mm != 0.0


@dataclass(frozen=True)
class Milled:
    """Cuts of one mill: arrays (n,).

    ``low_mm`` and ``high_mm``: the band across the feed that is engaged, Y from the tool's axis;
    ``direction_rad`` of the feed from machine x towards y; ``ramp_rad``: how steeply it goes down.
    """

    feed_mm: Array
    depth_mm: Array
    speed_rpm: Array
    low_mm: Array
    high_mm: Array
    direction_rad: Array
    ramp_rad: Array


def up(diameter_mm: float, width_mm: Array) -> tuple[Array, Array]:
    """Return the band of side milling against the feed: chips begin thin."""
    radius = 0.5 * diameter_mm
    return radius - width_mm, np.full_like(width_mm, radius)


def down(diameter_mm: float, width_mm: Array) -> tuple[Array, Array]:
    """Return the band of side milling with the feed: chips end thin."""
    radius = 0.5 * diameter_mm
    return np.full_like(width_mm, -radius), width_mm - radius


def pocket(diameter_mm: float, *, hole_mm: Array, path_mm: Array) -> tuple[Array, Array]:
    """Return the band of widening a round hole along a circle, the work on the right of the feed.

    The tool's circle leaves the hole's at γ from the outward radial, cos γ = (W² - ρ² - R²)/(2ρR)
    for radii W of the hole, ρ of the path, R of the tool: engaged from π - γ to π, more than along
    a straight wall of the same width.
    """
    radius = 0.5 * diameter_mm
    cos = (hole_mm**2 - path_mm**2 - radius**2) / (2.0 * path_mm * radius)
    return np.full_like(cos, -radius), -radius * np.clip(cos, -1.0, 1.0)


def waveform(
    theta: Array, mill: EndMill, cut: Milled, angle_rad: Array, *, slice_mm: float = SLICE_MM
) -> CutForces:
    """Return the forces of one cut at angles (n,) of tooth 0's tip."""
    parts = [
        cut_forces(
            theta, at_angles(mill, cut, angle_rad[begin : begin + MOMENTS], slice_mm=slice_mm)
        )
        for begin in range(0, len(angle_rad), MOMENTS)
    ]
    return CutForces(
        np.concatenate([one.force_N for one in parts]),
        np.concatenate([one.torque_N_m for one in parts]),
        np.concatenate([one.power_W for one in parts]),
    )


@dataclass(frozen=True)
class Turn:
    """Forces of one turn at ``angle_rad`` (n,) of tooth 0: their waveform, mean and peak.

    ``mean`` and ``peak`` (5,): force x, y, z, torque, power, the peak by size with its sign;
    ``amplitude`` (k, 5): of each harmonic of the spindle's turn, the mean first.
    """

    angle_rad: Array
    forces: CutForces
    mean: Array
    peak: Array
    amplitude: Array


def turn(
    theta: Array, mill: EndMill, cut: Milled, *, steps: int = 720, slice_mm: float = SLICE_MM
) -> Turn:
    """Return the forces of one cut over one turn of the spindle, in even steps."""
    angle = np.arange(steps) * TURN / steps
    made = waveform(theta, mill, cut, angle, slice_mm=slice_mm)
    values = made.all
    largest = np.argmax(np.abs(values), axis=0)
    amplitude = np.abs(np.fft.rfft(values, axis=0)) / steps
    amplitude[1:] *= 2.0
    return Turn(
        angle, made, values.mean(axis=0), values[largest, np.arange(values.shape[1])], amplitude
    )


def at_angles(
    mill: EndMill, cut: Milled, angle_rad: Array, *, slice_mm: float = SLICE_MM
) -> Elements:
    """Return the elements of one cut at angles (n,) of tooth 0's tip: those within the band."""
    corner = min(float(cut.depth_mm[0]), mill.corner_radius_mm)
    flank = float(cut.depth_mm[0]) - corner
    slices = _levels(mill, cut.depth_mm, _middles(corner / slice_mm), _middles(flank / slice_mm))
    begins, ends = _arc(cut, slices.radius_mm)
    through = angle_rad[:, None, None] - _lags(mill, slices.height_mm)[0]
    through -= TURN * np.floor(through / TURN)
    inside = np.flatnonzero((through >= begins) & (through <= ends))
    moment, tooth, level = np.unravel_index(inside, through.shape)

    phi = through.ravel()[inside]
    sin_phi, cos_phi = np.sin(phi), np.cos(phi)
    sin_kappa, cos_kappa = _at(level, slices.sin_kappa), _at(level, slices.cos_kappa)
    left = [
        (fed[0, tooth, level], out[0, tooth, level])
        for fed, out in _found(mill, cut.feed_mm, slices.height_mm)
    ]
    thick = _thickness_mm(left, cut.ramp_rad[0], sin_phi, (sin_kappa, cos_kappa))
    radius = _at(level, slices.radius_mm)
    return Elements(
        count=len(angle_rad),
        of=moment,
        edge=Edge(
            np.maximum(thick, 0.0),
            TURN / 1000.0 * radius * cut.speed_rpm[0],
            np.full(1, np.radians(mill.rake_deg)),
            _at(tooth, mill.helices_rad[None]),
        ),
        width_mm=np.where(thick > 0.0, _at(level, slices.width_mm), 0.0),
        kappa=(sin_kappa, cos_kappa),
        phi=(sin_phi, cos_phi),
        radius_mm=radius,
        speed_rpm=cut.speed_rpm,
        frames=_frames(cut.direction_rad),
    )


def averaged(mill: EndMill, cuts: Milled) -> Elements:
    """Return elements of cuts (n,) whose sums are means over a turn.

    The mean does not know where along the turn a slice cuts, so it has no lag: the engaged arc of
    each slice is integrated, of each tooth where they differ.
    """
    node, weight = np.polynomial.legendre.leggauss(NODES)
    rule = (0.5 * (node + 1.0), 0.5 * weight)
    along_flank = rule if mill.teeth_differ else _middles(1)
    slices = _levels(mill, cuts.depth_mm, rule, along_flank)
    teeth = mill.teeth if mill.teeth_differ else 1

    # Cuts, teeth, slices, places along the arc
    begins, ends = _arc(cuts, slices.radius_mm)
    arc = _placed(ends - begins)
    phi = _placed(begins) + arc * rule[0]
    kappa = _placed(slices.sin_kappa), _placed(slices.cos_kappa)
    left = [
        (fed[:, :teeth, :, None], out[:, :teeth, :, None])
        for fed, out in _found(mill, cuts.feed_mm, slices.height_mm)
    ]
    thick = _thickness_mm(left, cuts.ramp_rad[:, None, None, None], np.sin(phi), kappa)
    share = mill.teeth / teeth / TURN * arc * rule[1] * _placed(slices.width_mm)
    speed = TURN / 1000.0 * slices.radius_mm * cuts.speed_rpm[:, None]

    def flat(values: Array) -> Array:
        return np.broadcast_to(values, thick.shape).reshape(len(thick), -1)

    return Elements(
        count=len(thick),
        of=None,
        edge=Edge(
            flat(np.maximum(thick, 0.0)),
            flat(_placed(speed)),
            np.full((1, 1), np.radians(mill.rake_deg)),
            flat(mill.helices_rad[:teeth, None, None]),
        ),
        width_mm=flat(np.where(thick > 0.0, share, 0.0)),
        kappa=(flat(kappa[0]), flat(kappa[1])),
        phi=(flat(np.sin(phi)), flat(np.cos(phi))),
        radius_mm=flat(_placed(slices.radius_mm)),
        speed_rpm=cuts.speed_rpm,
        frames=_frames(cuts.direction_rad),
    )


@dataclass(frozen=True)
class _Levels:
    """Slices of the edges of cuts (n, s)."""

    height_mm: Array
    width_mm: Array
    sin_kappa: Array
    cos_kappa: Array
    radius_mm: Array


def _levels(mill: EndMill, depth_mm: Array, corner: Rule, flank: Rule) -> _Levels:
    """Return slices of depths (n,): by one rule over κ on the corner, by one over z above it."""
    nose = mill.corner_radius_mm
    in_corner = np.minimum(depth_mm, nose)[:, None]
    above = depth_mm[:, None] - in_corner
    straight = np.zeros_like(above) * flank[0]
    if nose == 0.0:
        corner = (corner[0][:0], corner[1][:0])
    reach = np.arccos(1.0 - in_corner / nose) if nose > 0.0 else in_corner
    kappa = reach * corner[0]
    return _Levels(
        height_mm=np.column_stack([nose * (1.0 - np.cos(kappa)), in_corner + above * flank[0]]),
        width_mm=np.column_stack([nose * reach * corner[1], above * flank[1]]),
        sin_kappa=np.column_stack([np.sin(kappa), straight + 1.0]),
        cos_kappa=np.column_stack([np.cos(kappa), straight]),
        radius_mm=mill.radius_mm - np.column_stack([nose * (1.0 - np.sin(kappa)), straight]),
    )


def _middles(slices: float) -> Rule:
    """Return the rule of as many slices of one size."""
    count = max(1, round(slices))
    return (np.arange(count) + 0.5) / count, np.full(count, 1.0 / count)


def _at(which: NDArray[np.intp], values: Array) -> Array:
    """Return values (1, k) of a cut's slices or teeth at some; one for all where they are alike."""
    alike = bool(np.all(values == values[:, :1]))
    return values[0, :1] if alike else values[0][which]


def _placed(values: Array) -> Array:
    """Return values of cuts and slices (n, s) among teeth and places: (n, 1, s, 1)."""
    return values[:, None, :, None]


def _lags(mill: EndMill, height_mm: Array) -> Array:
    """Return how far teeth follow the tip of tooth 0 at heights (n, s): (n, teeth, s), rad."""
    pitches = mill.pitches_rad
    at_tip = np.cumsum(pitches) - pitches[0]
    twist = np.tan(mill.helices_rad) / mill.radius_mm
    return np.asarray(at_tip[:, None] + height_mm[:, None, :] * twist[:, None])


def _found(mill: EndMill, feed_mm: Array, height_mm: Array) -> Iterable[tuple[Array, Array]]:
    """Return what was fed since each of the teeth before, and how far a tooth stands out beyond it.

    Each (n, teeth, s), of the tooth before first. Without run-out that one left what there is.
    """
    lag = _lags(mill, height_mm)
    turn = (feed_mm * mill.teeth)[:, None, None]
    behind = np.diff(lag, axis=1, prepend=lag[:, -1:] - TURN) / TURN * turn
    out = mill.runout_mm * np.cos(np.radians(mill.runout_deg) - lag)
    fed = np.zeros_like(behind)
    for back in range(mill.teeth if mill.runout_mm != 0.0 else 1):
        fed = fed + np.roll(behind, back, axis=1)
        yield fed, out - np.roll(out, back + 1, axis=1)


def _thickness_mm(
    left: Iterable[tuple[Array, Array]],
    ramp_rad: Array,
    sin_phi: Array,
    kappa: tuple[Array, Array],
) -> Array:
    """Return the uncut chip: what the teeth before left, each of them; <= 0: there is none."""
    sin_kappa, cos_kappa = kappa
    way = np.cos(ramp_rad) * sin_kappa * sin_phi + np.sin(ramp_rad) * cos_kappa
    found = [fed * way + out * sin_kappa for fed, out in left]
    return np.minimum.reduce(found) if len(found) > 1 else found[0]


def _arc(cuts: Milled, radius_mm: Array) -> tuple[Array, Array]:
    """Return φ (n, s) at which a point at radii (n, s) enters and leaves the band."""
    begins = np.arccos(np.clip(cuts.high_mm[:, None] / radius_mm, -1.0, 1.0))
    ends = np.arccos(np.clip(cuts.low_mm[:, None] / radius_mm, -1.0, 1.0))
    return begins, np.maximum(begins, ends)


def _frames(direction_rad: Array) -> Array:
    """Return feed, the normal to its left and the tool's axis in machine axes: (n, 3, 3)."""
    sin, cos, zero = np.sin(direction_rad), np.cos(direction_rad), np.zeros_like(direction_rad)
    rows = [[cos, sin, zero], [-sin, cos, zero], [zero, zero, zero + 1.0]]
    return np.moveaxis(np.array(rows), -1, 0)
