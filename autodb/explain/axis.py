"""Columns that an axis effort can be made of: named terms, and shapes for what has no name."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from autodb.channels import axis_of
from autodb.records import Recording
from autodb.sensing.axis_model import term_called
from autodb.sensing.motion import term_inputs
from autodb.sensing.protocol import default_protocol
from autodb.terms.channel import Inputs, Part, columns

Array = NDArray[np.float64]

NAMED = ("coulomb", "viscous", "inertia", "gravity")
FINER = 40
"""Columns of the finer version of a smooth family."""


@dataclass(frozen=True)
class Shape:
    """A family of smooth columns without a name of its own: what an `unknown` can be made of.

    ``finer`` are columns of the same kind with more detail: once the family is found, they take up
    what its smooth shape gets wrong.
    """

    key: str
    columns: Array
    variables: tuple[str, ...]
    tries: int = 1
    finer: Array | None = None


@dataclass(frozen=True)
class AxisColumns:
    """All columns of one axis at every row."""

    named: dict[str, Array]
    shapes: list[Shape]
    finer: dict[str, Array]
    signals: dict[str, Array] = field(default_factory=dict)


def axis_columns(recording: Recording, channel: str) -> AxisColumns:
    """Return named columns and shapes (n, p) of the axis that ``channel`` belongs to."""
    axis = axis_of(channel)
    cutoff_hz = default_protocol(recording.rate_hz).cutoff_hz
    inputs = term_inputs(recording, axis, cutoff_hz=cutoff_hz)
    named = {name: term_column(name, inputs) for name in NAMED}
    position, velocity, t = inputs["position"], inputs["velocity"], recording.t_s
    sense = inputs["direction"]
    place, way, speed = f"{axis}.position", f"{axis}.direction", f"{axis}.velocity"
    along = _spline(position, 12)
    over = _spline(t, 12)
    fine_along = _spline(position, FINER)

    def turned(columns: Array) -> Array:
        return sense[:, None] * columns

    shapes = [
        Shape("position", along, (place,), finer=fine_along),
        Shape("direction × position", turned(along), (way, place), finer=turned(fine_along)),
        Shape("time", over, ("t",), finer=_spline(t, FINER)),
        Shape("direction × time", turned(over), (way, "t"), finer=turned(_spline(t, FINER))),
        Shape("speed", turned(_spline(np.abs(velocity), 8)), (speed,)),
        Shape("direction × speed", _spline(np.abs(velocity), 8)[:, 1:], (way, speed)),
        Shape("way since reversal", _since_reversal(position, sense), (way, place)),
        *_other_axes(recording, axis),
    ]
    finer = {shape.key: shape.finer for shape in shapes if shape.finer is not None}
    finer["coulomb"] = _around_standstill(sense, velocity)
    return AxisColumns(named, shapes, finer, {place: position, speed: velocity})


def term_column(name: str, inputs: Inputs) -> Array:
    """Return the column (n,) of a term with one coefficient and no shape."""
    return columns((Part(term_called(name)),), inputs)[:, 0]


def _around_standstill(sense: Array, velocity: Array) -> Array:
    """Return columns (n, 6) for what sgn(v) gets wrong where a move starts, turns or stops.

    One row earlier or later, starts and stops apart, and friction that needs some speed to rise to
    its level.
    """
    columns = [np.tanh(velocity / width) - sense for width in (0.5, 2.0)]
    for neighbour in (np.roll(sense, -1), np.roll(sense, 1)):
        step = neighbour - sense
        gains = np.abs(neighbour) > np.abs(sense)
        columns += [step * gains, step * ~gains]
    return np.column_stack(columns)


def _spline(values: Array, count: int) -> Array:
    """Return ``count`` cubic B-splines over the values' range with knots at quantiles, (n, count).

    Quantile knots put the columns where the data are; a stationary signal gives one constant.
    """
    low, high = float(values.min()), float(values.max())
    if high - low <= 0:
        return np.ones((len(values), 1))
    inner = np.unique(np.quantile(values, np.linspace(0, 1, count - 2)[1:-1]))
    inner = inner[(inner > low + 1e-6 * (high - low)) & (inner < high - 1e-6 * (high - low))]
    knots = np.concatenate([[low] * 4, inner, [high] * 4])
    return np.asarray(BSpline.design_matrix(values, knots, 3).toarray(), dtype=np.float64)


def _since_reversal(position: Array, sense: Array) -> Array:
    """Return s·exp(−way/scale) for the way run since the last reversal at four scales, (n, 4)."""
    moving = np.where(np.abs(sense) >= 1.0, np.sign(sense), 0.0)
    last = np.arange(len(moving))
    last[moving == 0] = 0
    sign = moving[np.maximum.accumulate(last)]
    turns = np.flatnonzero(np.diff(sign) != 0) + 1
    start = np.zeros(len(sign), dtype=np.intp)
    start[turns] = turns
    run = np.abs(position - position[np.maximum.accumulate(start)])
    scales_mm = (0.02, 0.1, 0.5, 2.0)
    return np.column_stack([sign * np.exp(-run / scale) for scale in scales_mm])


def _other_axes(recording: Recording, axis: str) -> list[Shape]:
    """Return one column for each velocity and acceleration of the other axes."""
    return [
        Shape(name, recording[name][:, None], (name,))
        for name in recording.channels
        if name.endswith((".velocity", ".acceleration")) and axis_of(name) != axis
    ]


def ripple(position: Array, residual: Array) -> Shape | None:
    """Return cosine and sine of the strongest period in position of a residual, (n, 2).

    The residual is binned over position and its spectrum taken; periods from 4 bins to a third of
    the travel are searched. None when the travel holds fewer than 64 bins.
    """
    travel = float(np.ptp(position))
    bins = int(min(4096, len(position) // 4))
    if travel <= 0 or bins < 64:
        return None
    place = np.minimum((position - position.min()) / travel * bins, bins - 1).astype(np.intp)
    count = np.bincount(place, minlength=bins)
    mean = np.bincount(place, weights=residual, minlength=bins) / np.maximum(count, 1)
    padded = 4 * bins
    spectrum = np.abs(np.fft.rfft(mean * np.sqrt(count), n=padded))
    waves = np.arange(len(spectrum)) * bins / padded
    searched = (waves >= 3) & (waves <= bins / 4)
    best = float(waves[searched][np.argmax(spectrum[searched])])
    phase = 2 * np.pi * best * (position - position.min()) / travel
    columns = np.column_stack([np.cos(phase), np.sin(phase)])
    return Shape("ripple", columns, (), tries=int(searched.sum()))


def simulation_terms(simulation: Array, columns: dict[str, Array]) -> dict[str, float]:
    """Read the simulation's own terms off it: coefficients whose share of it is above 0.5 %.

    A simulation has no noise, so what its output contains can be read by regression.
    """
    names = list(columns)
    matrix = np.column_stack([columns[name] for name in names])
    coefficients = np.linalg.lstsq(matrix, simulation, rcond=None)[0]
    level = 0.005 * float(np.sqrt(np.mean(simulation**2)))
    return {
        name: float(c)
        for name, c, column in zip(names, coefficients, matrix.T, strict=True)
        if abs(c) * np.sqrt(np.mean(column**2)) > level
    }
