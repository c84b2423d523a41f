"""Effects that a milled waveform may hold beside its simulation, each with its ladder of shapes.

All are built from the simulation's own waves: the law that it follows, the teeth it has. Columns
are (C, n, p), of the recording's components.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from autodb.explain.engine.candidates import Candidate, has_positive_first, negative, spline
from autodb.explain.waves.sensors import SENSING
from autodb.explain.waves.teeth import Law, StandsOut, contrasts
from autodb.explain.waves.world import SimulatedWaves, form, keep_shape, on_each

Array = NDArray[np.float64]

OWN_WAYS, OVER_TURN = "shear ways", "unknown spindle.angle"
COURSE = "course"
"""Which of the courses over the turn a shape is."""
WAYS_OFF = ((0,), (1,), (2,), (0, 2))
"""Ways that may be off beside the others of a term: one, or all of them."""
THIN_MM = (0.006, 0.012, 0.025, 0.05)
"""Chips at which what thin ones take more has fallen to a third, or to half. Chosen."""
GROWTHS = (1.0, 0.5, 2.0)
"""Powers of the time in the work that wear goes with. Chosen."""
DEEPER_MM = (0.003, 0.01, 0.03, 0.1, 0.3)
"""Errors of depth whose waves are worked out, less and more. Chosen."""
GIVES = (None, 0.3, 1.0)
"""Shares of the largest force at which giving way levels off; None: it does not. Chosen."""
NUDGE_MM = 2e-4
"""By how much a tooth is moved to see what that changes."""
UNKNOWN_BAR = 6.0
"""Evidence asked of an effect without a name beyond that of a named one. Chosen."""


def candidates_of_waves(world: SimulatedWaves) -> list[Candidate]:
    """Return every candidate but those that scans find."""
    return [one for build in BUILDERS.values() for one in build(world)]


def candidates_by_key(world: SimulatedWaves, keys: Iterable[str]) -> dict[str, Candidate]:
    """Return the candidates of some keys, and others that are built with them."""
    words = dict.fromkeys(key.split(" ")[0] for key in keys)
    return {one.key: one for word in words if word in BUILDERS for one in BUILDERS[word](world)}


def _own_ways(world: SimulatedWaves) -> Iterator[Candidate]:
    """The simulation's own terms are off by another factor one way than the others.

    It is a choice of the search, not always free: most simulations have the ways of a term in
    proportion, and an effect as small as a wrong depth hides behind factors that are all free.
    ``shape`` says how many columns are of which term.
    """
    ways = (world.shear_ways, world.edge_ways)
    of: list[tuple[tuple[int, ...], tuple[int, ...]]] = [(kept, ()) for kept in WAYS_OFF]
    if world.has_edge:
        of += [((), kept) for kept in WAYS_OFF] + [(WAYS_OFF[-1], WAYS_OFF[-1])]
    forms = [
        form(
            np.concatenate([ways[0][..., list(shear)], ways[1][..., list(edge)]], axis=-1),
            {"shear": len(shear), "edge_force": len(edge)},
            tries=len(of),
        )
        for shear, edge in of
    ]
    yield Candidate(OWN_WAYS, "shear", tuple(forms))


def _edge_force(world: SimulatedWaves) -> Iterator[Candidate]:
    if world.has_edge:
        return
    names = ("coefficient", "radial", "axial")
    forms = [
        form(ways, names=names, tries=len(world.edges), allowed=has_positive_first)
        for ways in world.edges
    ]
    yield Candidate("edge_force", "edge_force", tuple(forms), ("spindle.angle",), static=True)


def _size_effect(world: SimulatedWaves) -> Iterator[Candidate]:
    """Thin chips take more: by a plain law, by the logarithm of the chip, by any smooth curve.

    A plain law takes more in each way by its own share, as conventional exponents have it, or in
    all by the same.
    """
    law = world.shear
    laws = [
        partial(_thin, law=law, thin_mm=thin, fades=fades)
        for thin in THIN_MM
        for fades in (True, False)
    ]
    forms = [
        form(world.cut(one)[:, :, None], tries=2 * len(laws), allowed=has_positive_first)
        for one in laws
    ]
    forms += [
        form(
            world.cut_each_way(one),
            names=("size", "radial", "axial"),
            tries=2 * len(laws),
            allowed=has_positive_first,
        )
        for one in laws
    ]
    forms += [
        form(
            world.cut(partial(_logarithm, law=law))[:, :, None],
            names=("exponent",),
            allowed=negative,
        ),
        form(world.bumps),
    ]
    yield Candidate(
        "size_effect",
        "size_effect",
        tuple(forms),
        ("spindle.angle",),
        detail=keep_shape(world.bumps),
        static=True,
    )


def _thin(chip_mm: Array, *, law: Law, thin_mm: float, fades: bool) -> tuple[Array, Array, Array]:
    u = chip_mm / thin_mm
    more = np.exp(-u) if fades else 1.0 / (1.0 + u)
    t, r, a = law(chip_mm)
    return t * more, r * more, a * more


def _logarithm(chip_mm: Array, *, law: Law) -> tuple[Array, Array, Array]:
    grown = np.log(np.maximum(chip_mm, 1e-4) / 0.05)
    t, r, a = law(chip_mm)
    return t * grown, r * grown, a * grown


def _wear(world: SimulatedWaves) -> Iterator[Candidate]:
    """The edge's force grows while the mill cuts: evenly, faster at first, or at last."""
    names, tries = ("rate", "radial", "axial"), len(world.edges) * len(GROWTHS)
    forms = [
        form(
            ways * (world.worn**power)[:, None],
            {"power": power},
            names=names,
            tries=tries,
            allowed=has_positive_first,
        )
        for ways in world.edges
        for power in GROWTHS
    ]
    curve = spline(world.worn, 4)[:, 1:]
    for ways in world.edges:
        grown = (ways[..., None] * curve[:, None, :]).reshape(*world.simulated.shape, -1)
        forms.append(form(grown, tries=len(world.edges)))
    yield Candidate(
        "tool_wear",
        "tool_wear",
        tuple(forms),
        ("t", "spindle.angle"),
        detail=keep_shape(world.bumps * world.worn[:, None]),
    )


def _runout(world: SimulatedWaves) -> Iterator[Candidate]:
    """How far teeth stand out: an axis that is off, or each tooth by itself.

    A tooth that stands out takes from the one behind it what it cuts itself. Where some is known
    already, columns are what a little more changes, and what is known itself. What a chip's growth
    changes is the slope of the law, which real ones have otherwise in each way, above all where
    the chip is thin: the ways may differ.
    """
    teeth = world.waves.teeth
    z = teeth.mill.teeth
    if z < 2 or world.waves.uneven is not None:
        return
    if world.out is None:
        slope = world.waves.law.slope
        tooth = np.array([world.waves.seen(teeth.of_tooth(j, slope)) for j in range(z)])
        more, known = np.moveaxis(tooth - np.roll(tooth, -1, axis=0), 0, -1), []
    else:
        more, known = nudged(world, world.out), [world.stands_out[:, :, None]]
    shapes = [shape for shape in (off_axis(z), contrasts(z)) if shape.shape[1] <= z - 1]
    freely = [np.moveaxis(world.waves.between_teeth(shape), (0, 1), (2, 3)) for shape in shapes]
    each = [more @ shape for shape in shapes]
    each += [one.reshape(*one.shape[:2], -1) for one in freely]
    forms = [
        form(
            np.concatenate([*known, columns], axis=-1),
            tries=len(each),
            names=tuple(f"difference {k}" for k in range(len(known) + columns.shape[-1])),
        )
        for columns in each
    ]
    yield Candidate("runout", "runout", tuple(forms), ("spindle.angle",), static=True)


def off_axis(teeth: int) -> Array:
    """Return how far teeth stand out of a mill whose axis is off by 1 along, and across (z, 2).

    Of two teeth across alone shows nothing (z, 1).
    """
    angle = 2.0 * np.pi * np.arange(teeth) / teeth
    return np.column_stack([np.cos(angle), np.sin(angle)])[:, : 1 if teeth == 2 else 2]


def nudged(world: SimulatedWaves, out: StandsOut) -> Array:
    """Return what a mm more of each tooth changes (C, n, teeth) beside what is known."""
    teeth, law = world.waves.teeth, world.waves.law.whole
    base = teeth.forces(law, out)
    made = []
    for j in range(teeth.mill.teeth):
        mm = tuple(one + NUDGE_MM * (k == j) for k, one in enumerate(out.mm))
        made.append(world.waves.seen(teeth.forces(law, replace(out, mm=mm)) - base) / NUDGE_MM)
    return np.stack(made, axis=-1)


def _depth(world: SimulatedWaves) -> Iterator[Candidate]:
    """Another depth: what a little more adds at the top, and what the slices of one much off do.

    Slices that a simulation cuts an edge into come into the work and leave it one by one.
    """
    top = world.waves.seen(world.waves.teeth.top(world.waves.law.whole, world.out))
    depth_mm = world.waves.teeth.mill.depth_mm
    errors = [e for one in DEEPER_MM for e in (-one, one) if abs(e) < 0.5 * depth_mm]
    errors += [] if world.deeper_mm is None else [world.deeper_mm]
    forms = [form(top[:, :, None], names=("error",), tries=len(errors))]
    for error in errors:
        column = deeper(world, error)[:, :, None] / error
        forms.append(form(column, {"error": error}, names=("error",), tries=len(errors)))
    yield Candidate("depth_error", "depth_error", tuple(forms), ("spindle.angle",), static=True)


def deeper(world: SimulatedWaves, error_mm: float) -> Array:
    """Return what a depth that is off changes (C, n)."""
    teeth, law = world.waves.teeth, world.waves.law.whole
    more = teeth.deeper(error_mm)
    return world.waves.seen(more.forces(law, world.out)) - world.cut(law)


def _deflection(world: SimulatedWaves) -> Iterator[Candidate]:
    """The mill gives way: the relative error grows with the force across it."""
    force = world.made
    across = np.sqrt(np.sum(force[:2] ** 2, axis=0))
    u = across / max(float(np.max(across)), 1e-300)
    forms = tuple(
        form(
            (force * (u if half is None else u / (u + half)))[:, :, None],
            tries=len(GIVES),
            names=("share",),
            allowed=negative,
        )
        for half in GIVES
    )
    yield Candidate("deflection", "deflection", forms, world.waves.names)


def _unknown(world: SimulatedWaves) -> Iterator[Candidate]:
    """The force depends smoothly on time; something turns with the spindle, slowly or anyhow."""
    angle, z = world.waves.teeth.angle_rad, world.waves.teeth.mill.teeth
    slow, all_ = (1, 2), [*range(1, 3 * z + 1), 4 * z]
    turns, whole = (
        np.column_stack([f(k * angle) for k in orders for f in (np.cos, np.sin)])
        for orders in (slow, all_)
    )
    courses = (turns, turns * world.engaged[:, None], whole * world.engaged[:, None])
    with_spindle = [
        form(on_each(world, course), {COURSE: number}) for number, course in enumerate(courses)
    ]
    over_time = world.simulated[:, :, None] * spline(world.worn, 9)[:, 1:]
    yield Candidate(OVER_TURN, "unknown", tuple(with_spindle), ("spindle.angle",), bar=UNKNOWN_BAR)
    yield Candidate("unknown t", "unknown", (form(over_time),), ("t",), bar=2.0 * UNKNOWN_BAR)


BUILDERS: dict[str, Callable[[SimulatedWaves], Iterable[Candidate]]] = {
    "shear": _own_ways, "edge_force": _edge_force, "size_effect": _size_effect, "tool_wear": _wear,
    "runout": _runout, "depth_error": _depth, "deflection": _deflection, **SENSING,
    "unknown": _unknown,
}  # fmt: skip
"""What builds candidates, by the first word of their keys, in the order in which they are tried."""
