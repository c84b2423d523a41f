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
IN_STEP = (2, 4, 6)
"""Coefficients of what an angle that was not recorded is off by, one after the other, …"""
STEPS = 4
"""… and rounds to find them."""
STEPPED = 2000
"""Rows, at most about twice as many, by which this is found."""
NUDGE_RAD = 1e-3
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
    return _entered(best)


def _elsewhere(found: Sequence[Waves]) -> Waves:
    """Return the best of waves with tooth 0 where the simulation has it."""
    best = max(map(_seen_in_some, found), key=lambda waves: waves.fits)
    return _entered(_sliced(_turned(_sliced(best))))


def _heard(found: Sequence[Waves]) -> Waves:
    """Return the best of waves whose angle the simulation's own teeth tell."""
    return max(map(_listened, found), key=lambda waves: waves.fits)


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


def _some(waves: Waves, rows: NDArray[np.intp] | None) -> Waves:
    """Return the same at LOOKED rows, of all where something is cut or of some."""
    rows = np.flatnonzero(waves.teeth.engaged > 0.0) if rows is None else rows
    return waves.at(rows[:: max(1, len(rows) // LOOKED)])


def _seen_in_some(waves: Waves, rows: NDArray[np.intp] | None = None) -> Waves:
    """Return waves with how well some rows fit."""
    some = _fitted(_some(waves, rows))
    return replace(waves, law=some.law, fits=some.fits, uneven=some.uneven)


def _sliced(waves: Waves, rows: NDArray[np.intp] | None = None) -> Waves:
    """Return waves with as many slices as the simulation's edge has, by all or some rows."""
    mill = waves.teeth.mill
    if mill.twist_rad == 0.0:
        return waves
    counts = {*SLICES, *(max(2, round(mill.depth_mm / height)) for height in SLICE_MM)}
    tried = (
        replace(waves, teeth=replace(waves.teeth, mill=replace(mill, slices=count)))
        for count in sorted(counts)
    )
    return max((_seen_in_some(one, rows) for one in tried), key=lambda one: one.fits)


def _listened(waves: Waves) -> Waves:
    """Return waves whose angle, which was not recorded, is what the simulation's teeth tell.

    First of all teeth in the work, then also while the mill comes in: what is off by little there
    may be off by much where nothing has been looked at yet, so that a line comes before a curve.
    """
    inside = np.flatnonzero(waves.teeth.engaged > 0.0)
    steady = _steady(waves)
    line, *curves = IN_STEP
    found = _sliced(_in_step(_turned(waves, steady), steady, line), steady)
    found = _entered(_in_step(found, steady, line))
    for curve in (line, *curves):
        found = _in_step(found, inside, curve)
    return _fitted(found)


def _steady(waves: Waves) -> NDArray[np.intp]:
    """Return the rows where all of the arc is in the work; where they are few, the last third."""
    inside = np.flatnonzero(waves.teeth.engaged > 0.0)
    steady = inside[waves.teeth.reach[inside] >= 1.0]
    return steady if len(steady) >= LOOKED else inside[2 * len(inside) // 3 :]


def _in_step(waves: Waves, rows: NDArray[np.intp], coefficients: int) -> Waves:
    """Return waves whose angle, put right by a curve, is in step with the simulation at rows."""
    t = waves.t_s
    u = 2.0 * (t - t[0]) / (t[-1] - t[0]) - 1.0
    course = np.polynomial.legendre.legvander(u, coefficients - 1)
    rows = rows[:: max(1, len(rows) // STEPPED)]
    for _ in range(STEPS):
        some = _fitted(waves.at(rows))
        now, teeth = some.made, some.teeth
        nudged = replace(teeth, angle_rad=teeth.angle_rad + NUDGE_RAD)
        slope = (replace(some, teeth=nudged).made - now) / NUDGE_RAD
        columns = (slope[:, :, None] * course[rows]).reshape(-1, coefficients)
        off = np.linalg.lstsq(columns, (some.simulation - now).ravel(), rcond=1e-6)[0]
        angle = waves.teeth.angle_rad + course @ off
        teeth = replace(waves.teeth, angle_rad=angle)
        waves = replace(waves, law=some.law, uneven=some.uneven, teeth=teeth)
    return waves


def _entered(waves: Waves) -> Waves:
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

    steps = np.linspace(-REACH, REACH, 33)
    best = float(min(steps, key=left))
    fine = best + np.linspace(-1.0, 1.0, 9) * (steps[1] - steps[0])
    return replace(waves, teeth=replace(waves.teeth, reach=reach + float(min(fine, key=left))))


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
