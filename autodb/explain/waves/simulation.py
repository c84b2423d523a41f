"""What a simulated waveform says of its teeth: their phase, where they cut, and the law it follows.

The angle of the spindle, where it was recorded, counts from tooth 0 at φ = 0 (contract); where it
was not, or where that does not fit, the simulation itself tells it. Its law is then read off: a sum
of powers of the chip's thickness and an edge's force (``law``).
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from autodb.explain.waves.law import (
    DRAWN,
    NOTHING,
    POWERS,
    UNIT_MM,
    ReadLaw,
    chip_functions,
    in_ways,
    read_off,
    rubbing,
)
from autodb.explain.waves.plain_rows import GOLDEN
from autodb.explain.waves.teeth import TURN, Mill, Teeth, contrasts, machine_and_table
from autodb.explain.waves.waves import Waves, heard, mill_of
from autodb.files.channels import FORCES
from autodb.records.tables import Recording

Array = NDArray[np.float64]

FITS = 0.98
"""Share of a simulation's squares that its waves must give with the angle as it was recorded."""
LOOKED = 600
"""Rows by which angle and slices are chosen."""
READ = 3000
"""Rows, the last in the work, that a law is read off."""
SLICES = (*range(3, 41), 50, 60, 64, 80, 100)
SLICE_MM = (0.05, 0.1, 0.2, 0.25)
"""Numbers and heights of slices that simulations cut an edge into."""
LIKELY = 6
"""Of these the best by LOOKED rows, which are looked at by READ rows again."""
IN_STEP = (2, 4, 6, 9, 13)
"""Coefficients of what an angle that was not recorded is off by, one after the other, …"""
STEPS = 4
"""… and steps to find them."""
STEPPED = 2000
"""Rows by which this is found at most; twice as many where teeth come in and go out."""
NUDGE_RAD = 1e-3
JUMP = 4.0
"""Rows of which so many times as much as of the median one is left are those of a tooth that comes
in or goes out: they say nothing of how the angle drifts. Chosen."""
SHARES = (0.3, 0.1, 0.03)
"""Shares of the angle between two rows over which slopes are then taken: how many teeth come in or
go out at another row than the simulation's says what is off by less than a row. Chosen."""
ROUNDS = 3
FINER = 4
"""Times that a grid gets four times as fine."""
REACH = 0.15
"""By how much of the radius the mill may come in earlier or later than its first force says."""
SILENT = 1e-6
"""Share of its largest value below which a simulated force is none."""


def waves_of(
    recording: Recording, simulation: Mapping[str, Array], includes: Collection[str] | None = None
) -> Waves:
    """Return a simulation of force components (n,) as waves of the teeth of its side file's mill.

    ``includes``: the terms it may have; None: any.

    Raises UnusableInput where the side file says too little of tool and cut, or where the waves of
    its mill are not those of the simulation.
    """
    mill = mill_of(recording)
    names = tuple(name for name in FORCES if name in simulation)
    forces = np.array([simulation[name] for name in names])
    engaged = _engaged(forces)
    started = [
        Waves(
            names,
            recording.t_s,
            Teeth(mill, _angle(recording, mill, forces, engaged, reach), engaged, reach),
            frames,
            NOTHING,
            forces,
            0.0,
        )
        for reach in _reaches(recording, mill, engaged)
        for frames in machine_and_table(recording, mill, names)
    ]
    found = [
        [replace(one, uneven=uneven) for one in started] for uneven in _teeth_may_be(mill, includes)
    ]
    recorded = recording.get("spindle.angle") is not None
    ways = (_as_recorded, _elsewhere) if recorded else (_heard,)
    best = _first_that_fits(way(some) for way in ways for some in found)
    return _read(best, edged=includes is None or "edge_force" in includes)


def _teeth_may_be(mill: Mill, includes: Collection[str] | None) -> list[Array | None]:
    """Return how teeth may differ in a simulation, to begin with: not at all, or in any way."""
    differ = np.zeros((mill.teeth - 1, 3))
    if mill.teeth == 1:
        return [None]
    if includes is None:
        return [None, differ]
    return [differ if "runout" in includes else None]


def _first_that_fits(found: Iterable[Waves]) -> Waves:
    """Return the first of waves that give their simulation; if none does, those that do it best."""
    tried: list[Waves] = []
    for one in found:
        tried.append(one)
        if one.fits >= FITS:
            return one
    return max(tried, key=lambda waves: waves.fits)


def _as_recorded(found: Sequence[Waves]) -> Waves:
    """Return the best of waves with the angle as it was recorded."""
    best = _sliced(max(map(_seen_in_some, found), key=lambda waves: waves.fits))
    return _seen_in_some(_entered(best))


def _elsewhere(found: Sequence[Waves]) -> Waves:
    """Return the best of waves with tooth 0 where the simulation has it."""
    best = max(map(_seen_in_some, found), key=lambda waves: waves.fits)
    return _seen_in_some(_entered(_sliced(_turned(_sliced(best)))))


def _heard(found: Sequence[Waves]) -> Waves:
    """Return the best of waves whose angle, which was not recorded, is what the simulation's teeth
    tell: the frame by teeth that are in the work, the way into it by all, then all the rest.
    """
    steady = _steady(found[-1])
    inside = np.flatnonzero(found[0].teeth.engaged > 0.0)
    entering = [one for one in found if one.teeth.reach is found[-1].teeth.reach]
    begun = [_in_step(_turned(one, steady), steady, IN_STEP[0]) for one in entering]
    fits = [_seen_in_some(one, steady).fits for one in begun]
    frame = int(np.argmax(fits))
    angle = begun[frame].teeth.angle_rad
    turned = [
        replace(one, teeth=replace(one.teeth, angle_rad=angle))
        for one in found[frame :: len(entering)]
    ]
    tried = sorted((_seen_in_some(one, inside) for one in turned), key=lambda one: -one.fits)
    return _first_that_fits(
        _followed(_sliced(one, steady), inside, reach) for reach in (None, REACH) for one in tried
    )


def _engaged(forces: Array) -> Array:
    """Return 1 from the first to the last row at which something is cut, 0 outside."""
    some = np.flatnonzero(np.max(np.abs(forces), axis=0) > SILENT * np.max(np.abs(forces)))
    engaged = np.zeros(forces.shape[1])
    engaged[some[0] : some[-1] + 1] = 1.0
    return engaged


def _angle(recording: Recording, mill: Mill, forces: Array, engaged: Array, reach: Array) -> Array:
    """Return the angle of tooth 0 (n,), rad, as recorded; else as the simulation's teeth pass."""
    recorded = recording.get("spindle.angle")
    if recorded is not None:
        return np.radians(recorded)
    return heard(recording, mill, forces, engaged, reach)


def _reaches(recording: Recording, mill: Mill, engaged: Array) -> list[Array]:
    """Return ways into the work over the radius: in it at once, or coming in from its edge."""
    at_once = np.ones(len(engaged))
    cut, tool = recording.side.cut, recording.side.tool
    speed = recording.get("spindle.speed")
    rpm = cut.speed_rpm or (None if speed is None else float(np.median(speed)))
    if rpm is None or tool.diameter_mm is None:
        return [at_once]
    fed = mill.feed_mm * mill.teeth * rpm / 60.0
    first = recording.t_s[int(np.argmax(engaged))]
    way = np.maximum(recording.t_s - first, 0.0) * fed / (0.5 * tool.diameter_mm)
    low, high = mill.arc
    furthest = 1.0 if low < 0.5 * np.pi < high else max(np.sin(low), np.sin(high))
    return [at_once, 1.0 - furthest + way]


def _fitted(waves: Waves) -> Waves:
    """Return waves with a sum of powers of the chip that fits their simulation (C, n) best."""
    forces = waves.simulation
    design = waves.seen(in_ways(waves.teeth.moments(_powers)))
    if waves.uneven is not None:
        design = np.concatenate([design, waves.between_teeth(contrasts(waves.teeth.mill.teeth))])
    design = design.reshape(3 * len(design), -1)
    inner, right = design @ design.T, design @ forces.ravel()
    norm = np.sqrt(np.maximum(np.diag(inner), 1e-300))
    scaled = inner / np.outer(norm, norm) + DRAWN * np.eye(len(norm))
    sizes = (np.linalg.solve(scaled, right / norm) / norm).reshape(-1, 3)
    left = forces.ravel() - sizes.ravel() @ design
    _, powers, uneven = np.split(sizes, (1, 1 + len(POWERS)))
    law = ReadLaw(powers.T, np.tile(POWERS, (3, 1)), sizes[0], 0.0)
    return replace(
        waves,
        law=law,
        fits=_share(left, forces),
        uneven=None if waves.uneven is None else uneven,
    )


def _share(left: Array, forces: Array) -> float:
    """Return the share of squares of forces (C, n) about their means that is not left."""
    whole = float(np.sum((forces - forces.mean(axis=1)[:, None]) ** 2))
    return 1.0 - float(np.sum(left**2)) / max(whole, 1e-300)


def _powers(chip_mm: Array) -> Array:
    """Return a sharp edge and powers of the chip (1 + powers, m)."""
    u = np.maximum(chip_mm, 0.0) / UNIT_MM
    return np.array([rubbing(chip_mm, 0.0), *(u**power for power in POWERS)])


def _read(waves: Waves, *, edged: bool) -> Waves:
    """Return waves with the law that their simulation follows, with an edge force or not."""
    some = _fitted(waves.at(np.flatnonzero(waves.teeth.engaged > 0.0)[-READ:]))
    columns = some.seen(in_ways(some.teeth.moments(chip_functions)))
    forces = some.simulation - some.runout
    law = read_off(columns.reshape(*columns.shape[:2], -1), forces.ravel(), edged=edged)
    read = replace(waves, law=law, uneven=some.uneven)
    return replace(read, fits=_share(waves.simulation - read.made, waves.simulation))


def _some(waves: Waves, rows: NDArray[np.intp] | None, most: int) -> Waves:
    """Return the same at so many rows, of all where something is cut or of some."""
    rows = np.flatnonzero(waves.teeth.engaged > 0.0) if rows is None else rows
    return waves.at(_spread(rows, most))


def _spread(rows: NDArray[np.intp], most: int) -> NDArray[np.intp]:
    """Return so many of rows, or all, in no even steps: those may be in step with the spindle."""
    if len(rows) <= most:
        return rows
    steps = np.arange(most) + np.mod(np.arange(most) * GOLDEN, 1.0)
    at = np.minimum((steps * len(rows) / most).astype(np.intp), len(rows) - 1)
    return np.asarray(rows[at], dtype=np.intp)


def _seen_in_some(
    waves: Waves, rows: NDArray[np.intp] | None = None, *, most: int = LOOKED
) -> Waves:
    """Return waves with how well some rows fit."""
    some = _fitted(_some(waves, rows, most))
    return replace(waves, law=some.law, fits=some.fits, uneven=some.uneven)


def _sliced(waves: Waves, rows: NDArray[np.intp] | None = None) -> Waves:
    """Return waves with as many slices as the simulation's edge has, by all or some rows."""
    mill = waves.teeth.mill
    if mill.twist_rad == 0.0:
        return waves
    counts = {*SLICES, *(max(2, round(mill.depth_mm / height)) for height in SLICE_MM)}
    every = [
        replace(waves, teeth=replace(waves.teeth, mill=replace(mill, slices=count)))
        for count in sorted(counts)
    ]
    likely = sorted((_seen_in_some(one, rows) for one in every), key=lambda one: -one.fits)
    again = [_seen_in_some(one, rows, most=READ) for one in likely[:LIKELY]]
    return max(again, key=lambda one: one.fits)


def _followed(waves: Waves, inside: NDArray[np.intp], reach: float | None) -> Waves:
    """Return waves whose angle follows finer and finer curves, and slices and the way into the work
    that fit then; ``reach``: by how much of the radius this may be off, None: two teeth pass.
    """
    if reach is not None:
        waves = _entered(waves, reach)
    for curve in IN_STEP:
        waves = _in_step(waves, inside, curve)
    for _ in range(ROUNDS):
        waves = _in_step(_sliced(_entered(waves, _passes(waves))), inside, IN_STEP[-1])
        for share in SHARES:
            waves = _in_step(waves, inside, IN_STEP[-1], share)
    return _fitted(waves)


def _passes(waves: Waves) -> float:
    """Return the way over the radius in which two teeth pass."""
    coming = np.flatnonzero((waves.teeth.reach < 1.0) & (waves.teeth.engaged > 0.0))
    if len(coming) < 2:
        return 0.0
    fed = float(np.max(np.diff(waves.teeth.reach[coming])))
    turned = float(np.median(np.abs(np.diff(waves.teeth.angle_rad[coming]))))
    return 2.0 * fed * TURN / waves.teeth.mill.teeth / max(turned, 1e-9)


def _steady(waves: Waves) -> NDArray[np.intp]:
    """Return the rows where all of the arc is in the work; where they are few, the last third."""
    inside = np.flatnonzero(waves.teeth.engaged > 0.0)
    steady = inside[waves.teeth.reach[inside] >= 1.0]
    return steady if len(steady) >= LOOKED else inside[2 * len(inside) // 3 :]


def _in_step(
    waves: Waves, rows: NDArray[np.intp], coefficients: int, share: float | None = None
) -> Waves:
    """Return waves whose angle, put right by a curve, is in step with the simulation at rows.

    ``share``: of the angle between two rows over which slopes are taken, teeth that come in or go
    out among them; None: what teeth do that are in the work, once or STEPS times.
    """
    t = waves.t_s
    u = 2.0 * (t - t[0]) / (t[-1] - t[0]) - 1.0
    course = np.polynomial.legendre.legvander(u, coefficients - 1)
    turned = float(np.median(np.abs(np.diff(waves.teeth.angle_rad[rows]))))
    rows = _spread(rows, STEPPED if share is None else 2 * STEPPED)
    for _ in range(STEPS if share is None else 1):
        some = _fitted(waves.at(rows))
        left = some.simulation - some.made
        if share is None:
            slope = (_turned_by(some, NUDGE_RAD) - some.made) / NUDGE_RAD
            used = _without_jumps(left)
        else:
            by = share * turned
            slope = (_turned_by(some, by) - _turned_by(some, -by)) / (2.0 * by)
            used = np.ones(len(rows), dtype=np.bool_)
        columns = (slope[:, used, None] * course[rows[used]]).reshape(-1, coefficients)
        off = np.linalg.lstsq(columns, left[:, used].ravel(), rcond=1e-6)[0]
        angle = waves.teeth.angle_rad + course @ off
        teeth = replace(waves.teeth, angle_rad=angle)
        waves = replace(waves, law=some.law, uneven=some.uneven, teeth=teeth)
    return waves


def _turned_by(waves: Waves, by_rad: float) -> Array:
    """Return what teeth make that are further by an angle (C, n)."""
    teeth = replace(waves.teeth, angle_rad=waves.teeth.angle_rad + by_rad)
    return replace(waves, teeth=teeth).made


def _without_jumps(left: Array) -> NDArray[np.bool_]:
    """Return at which rows what is left (C, n) is no tooth that comes in a row early or late."""
    squares = np.sum(left**2, axis=0)
    return np.asarray(squares <= JUMP**2 * np.median(squares))


def _entered(waves: Waves, most: float = REACH) -> Waves:
    """Return waves whose mill comes into the work when the simulation's does."""
    reach = waves.teeth.reach
    rows = np.flatnonzero((reach < 1.0) & (waves.teeth.engaged > 0.0))
    if not len(rows):
        return waves
    known = _fitted(waves.at(_steady(waves)))
    waves = replace(waves, law=known.law, uneven=known.uneven)

    def left(by: float) -> float:
        moved = replace(waves.teeth, reach=reach + by)
        some = replace(waves, teeth=moved).at(rows)
        return float(np.sum((some.simulation - some.made) ** 2))

    best, step = float(min(np.linspace(-most, most, 33), key=left)), most / 16.0
    for _ in range(FINER):
        best = float(min(best + np.linspace(-1.0, 1.0, 9) * step, key=left))
        step /= 4.0
    return replace(waves, teeth=replace(waves.teeth, reach=reach + best))


def _turned(waves: Waves, rows: NDArray[np.intp] | None = None) -> Waves:
    """Return waves with tooth 0 where the simulation has it at some rows, turning either way."""
    best = replace(waves, fits=-np.inf)
    pitch = TURN / waves.teeth.mill.teeth
    for sense in (1.0, -1.0):
        angle = sense * waves.teeth.angle_rad
        step = pitch / 48.0
        offsets = np.arange(48) * step
        for _ in range(4):
            turned = [
                replace(waves, teeth=replace(waves.teeth, angle_rad=angle + offset))
                for offset in offsets
            ]
            tried = [_seen_in_some(one, rows) for one in turned]
            now = max(tried, key=lambda one: one.fits)
            best = max([best, now], key=lambda one: one.fits)
            middle = float(offsets[int(np.argmax([one.fits for one in tried]))])
            offsets, step = middle + step * np.linspace(-1.0, 1.0, 9), step / 4.0
    return best
