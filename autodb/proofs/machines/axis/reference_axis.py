"""Reference feed axes: machines of P2's kind, its sweep and its contour, recorded in air.

P2: friction and weight of linear feed axes (ball screws), drive currents of x, y and z. Its noise:
three runs of the same passes differ by +- 10 %; z sticks and slips below 500 mm/min, more so
downwards; its weight is 3.234 A. Friction falls as it warms (``reference_friction``). What P2 does
not print is chosen, and was set so that P2's own method lands on P2's errors.
"""

from dataclasses import dataclass

import numpy as np

from autodb.proofs.machines.axis.motion import TrueMotion, coloured
from autodb.proofs.machines.axis.reference_friction import TrueFriction, draw_friction, slid_state
from autodb.proofs.machines.axis.reference_moves import PITCH_MM, axis_sweep_motion, contour_motion
from autodb.proofs.machines.lathe.process import Array

AXES = ("x", "y", "z")
ENDS_MM = (0.0, 500.0)  # of the travel; chosen
COVER = {"x": 0.30, "y": 0.15, "z": 0.15}  # P2: x has a large fold coverage; sizes chosen
WEIGHT_A = 3.234  # P2 section III B
WEIGHT_SPREAD = 0.1  # from machine to machine; chosen
INERTIA_A_S2_MM = (0.0001, 0.0004)  # chosen
NOISE_SHARE, NOISE_RHO = (0.02, 0.04), 0.6  # of Coulomb friction, 4 ms apart: see ``axes.py``

# Runs differ by +- 10 %, taken as two standard deviations; how they share it is chosen
RUN_SD = 0.02  # of a whole run
SLOW_SD, SLOW_S = 0.03, 60.0  # wandering in time
PLACE_SD, PLACE_MM = 0.035, 20.0  # wandering over the way gone

# z below 500 mm/min (P2 section III B); sizes set by the gate
STICK_SD, STICK_MM = 0.50, 4.0  # wandering over the way gone at creep
STICK_DOWN = 1.5  # times as much downwards
STICK_MM_S = 150.0 / 60.0  # speed at which 1/e of it is left: 4 % at 500 mm/min
SAW_SHARE, SAW_MM = 0.1, 0.7  # saw teeth


@dataclass(frozen=True)
class ReferenceAxis:
    """The truth of one axis."""

    name: str
    friction: TrueFriction
    weight_A: float
    inertia_A_s2_mm: float
    noise_A: float
    sticks: bool


@dataclass(frozen=True)
class RecordedRun:
    """A recorded run: its motion, the current (n,) of the drive, and of that the part that would be
    there if every run were like every other, without noise, wander and stick-slip; A.
    """

    motion: TrueMotion
    current_A: Array
    expected_A: Array


@dataclass(frozen=True)
class Traced:
    """An axis, and what was recorded of it: its sweep, when the repeats and the cycles began, s;
    the contour on another day, and the feed that each of its rows is of, -1 in the rapids.
    """

    axis: ReferenceAxis
    sweep: RecordedRun
    began_s: tuple[float, ...]
    contour: RecordedRun
    feed: Array


def draw_reference_axis(seed: int, name: str) -> ReferenceAxis:
    """An axis of the machine of a seed."""
    rng = np.random.default_rng([seed, 71, AXES.index(name)])
    friction = draw_friction(rng, cover=COVER[name], ends_mm=ENDS_MM, pitch_mm=PITCH_MM)
    vertical = name == "z"
    return ReferenceAxis(
        name=name,
        friction=friction,
        weight_A=WEIGHT_A * (1.0 + rng.uniform(-WEIGHT_SPREAD, WEIGHT_SPREAD)) * vertical,
        inertia_A_s2_mm=rng.uniform(*INERTIA_A_S2_MM),
        noise_A=friction.coulomb_A * rng.uniform(*NOISE_SHARE),
        sticks=vertical,
    )


def recorded_axis(seed: int, name: str) -> Traced:
    """An axis of the machine of a seed with its recordings; the same seed gives the same bytes."""
    axis = draw_reference_axis(seed, name)
    sweep, began_s = axis_sweep_motion()
    contour, feed = contour_motion()
    rngs = [np.random.default_rng([seed, 72 + k, AXES.index(name)]) for k in range(2)]
    return Traced(
        axis=axis,
        sweep=_trace(rngs[0], axis, sweep, began_s),
        began_s=began_s,
        contour=_trace(rngs[1], axis, contour, (0.0,)),
        feed=feed,
    )


def _trace(
    rng: np.random.Generator, axis: ReferenceAxis, motion: TrueMotion, began_s: tuple[float, ...]
) -> RecordedRun:
    """Record a motion; each run that began has a level of its own."""
    friction, step_s = axis.friction, float(motion.t[1] - motion.t[0])
    warmth = friction.warming.warmth(friction.power(motion.x, motion.v), step_s)
    turned = slid_state(motion.x, friction.slides_mm)
    rubbing_A = turned * friction.steady_A(motion.x, motion.v)
    rubbing_A *= 1.0 - friction.warming.drop * warmth
    other_A = axis.weight_A + axis.inertia_A_s2_mm * motion.a
    varied = _wander(rng, motion, began_s)
    if axis.sticks:
        varied = varied + _stuck(rng, motion)
    rho = NOISE_RHO ** (step_s / 0.004)
    noise_A = coloured(rng, len(motion.t), axis.noise_A, rho)
    return RecordedRun(motion, rubbing_A * (1.0 + varied) + other_A + noise_A, rubbing_A + other_A)


def _wander(rng: np.random.Generator, motion: TrueMotion, began_s: tuple[float, ...]) -> Array:
    """How friction differs from run to run, share (n,)."""
    runs = RUN_SD * rng.standard_normal(len(began_s))
    run = np.maximum(np.searchsorted(began_s, motion.t, side="right") - 1, 0)
    slow = _drawn_along(rng, motion.t, SLOW_S)
    return runs[run] + SLOW_SD * slow + PLACE_SD * _drawn_along(rng, _gone_mm(motion), PLACE_MM)


def _stuck(rng: np.random.Generator, motion: TrueMotion) -> Array:
    """Stick-slip as the drive's current shows it, share (n,): wander and teeth at creep."""
    gone_mm = _gone_mm(motion)
    tooth = (gone_mm / SAW_MM) % 1.0 - 0.5
    wander = STICK_SD * _drawn_along(rng, gone_mm, STICK_MM)
    return stick_share(motion.v) * (wander + SAW_SHARE * tooth)


def stick_share(v_mm_s: Array) -> Array:
    """How much an axis sticks and slips at velocities (n,), 1 at creep upwards."""
    way = np.where(v_mm_s < 0.0, STICK_DOWN, 1.0)
    return np.asarray(way * np.exp(-np.abs(v_mm_s) / STICK_MM_S))


def _gone_mm(motion: TrueMotion) -> Array:
    """Way gone (n,) since the start, whatever the direction."""
    return np.concatenate([[0.0], np.cumsum(np.abs(np.diff(motion.x)))])


def _drawn_along(rng: np.random.Generator, along: Array, length: float) -> Array:
    """Wander of unit sd (n,) along a rising coordinate, correlated over ``length``."""
    step = 0.05 * length
    count = int((along[-1] - along[0]) / step) + 2
    wander = coloured(rng, count, 1.0, float(np.exp(-step / length)))
    return np.interp(along, along[0] + step * np.arange(count), wander)
