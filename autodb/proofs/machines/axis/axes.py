"""Feed axes drawn at random, for proofs: a slide whose sizes and whose laws are both drawn.

effort = sum of coefficient x column + noise, exactly; current A, position mm, speed mm/s, 250 Hz.
With direction d = v/sqrt(v^2 + w^2), curves c and s of `curves.py`, phase p = 2 pi x/P:

    coulomb d, viscous d c(|v|), stribeck d s(|v|), asymmetry d^2 and d^2 c(|v|), inertia a,
    gravity 1, cogging sin p + h sin 2p, position_friction d (x - 250 mm)

Noise is first-order autoregressive. Its ranges surround what is left of a real ball-screw axis, the
EMPS recording (Janot, Gautier, Brunot 2019; Coulomb friction 20.3 N), at 250 Hz through low-passes
of 100 to 450 Hz: after its four-term model rms 0.106 to 0.132 of Coulomb friction, correlation from
one 4 ms step to the next 0.61 to 0.81, and 0.2 still after 0.25 s; with direction, position and
screw turn in the model too 0.071 to 0.095 and 0.38 to 0.67; of that, at steady speed, 0.038 to
0.067. So sd 0.03 to 0.13 of Coulomb friction, correlation 0 to 0.99. Asymmetry (EMPS: Coulomb 1 %,
viscous 18 %) and cogging (EMPS: 5 %) surround its figures too; every other range is *chosen*.
"""

import math
from dataclasses import dataclass

import numpy as np

from autodb.proofs.machines.axis.curves import (
    ExponentialDip,
    FrictionCurve,
    GaussianDip,
    LogCurve,
    PowerCurve,
    RationalCurve,
    RationalDip,
    TableCurve,
    reversal,
)
from autodb.proofs.machines.axis.motion import (
    HIGH_MM,
    LOW_MM,
    TrueMotion,
    coloured,
    moves_motion,
    plan_moves,
)
from autodb.proofs.machines.lathe.process import Array

RATE_HZ = 250.0
SECONDS = (40.0, 50.0, 60.0, 75.0, 90.0)  # lengths of a recording; chosen
SECONDS_A_SPEED = 8.0  # one speed out and back takes about so long: a recording has all its speeds
SPEEDS_MM_S = (2.5, 185.0)  # slowest and fastest feed
SECOND_HARMONIC = 0.15  # h of the cogging
MIDDLE_MM = 0.5 * (LOW_MM + HIGH_MM)
FRICTION = ("coulomb", "viscous", "stribeck", "asymmetry", "position_friction")


@dataclass(frozen=True)
class DrawnAxis:
    """The truth of one drawn axis, in amperes."""

    coulomb_A: float
    reversal_mm_s: float  # half the friction is back at 0.58 of this speed
    viscous_A: float  # at 150 mm/s
    viscous_curve: FrictionCurve
    dip_A: float
    dip_curve: FrictionCurve
    coulomb_asymmetry_A: float  # half of what + takes more than -
    viscous_asymmetry_A: float  # the same of the viscous level
    inertia_A_s2_mm: float
    weight_A: float
    cogging_A: float  # amplitude of the first harmonic; 0: none
    cogging_mm: float
    cogging_rad: float
    position_A_mm: float  # friction gained a millimetre; 0: none
    noise_A: float  # sd
    noise_rho: float  # correlation from one sample to the next


@dataclass(frozen=True)
class EffortColumn:
    """One column of the effort: the term it belongs to, its coefficient, values (n,).

    A coefficient of 0 stands for a derivative: by the phase, by the period.
    """

    term: str
    coefficient: float
    values: Array


@dataclass(frozen=True)
class AxisRun:
    """One recording of an axis: its motion and its channels, noise included."""

    axis: DrawnAxis
    motion: TrueMotion
    channels: dict[str, Array]


def draw_log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """Draw evenly over the logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def draw_axis(seed: int) -> DrawnAxis:
    """The axis of a seed: its levels, its laws, and whether cogging and position friction act."""
    rng = np.random.default_rng([seed, 21])
    coulomb_A = draw_log_uniform(rng, 0.25, 1.2)
    viscous_A = coulomb_A * rng.uniform(0.15, 0.6)
    return DrawnAxis(
        coulomb_A=coulomb_A,
        reversal_mm_s=draw_log_uniform(rng, 0.05, 0.5),
        viscous_A=viscous_A,
        viscous_curve=_viscous_curve(rng),
        dip_A=coulomb_A * rng.uniform(0.08, 0.4),
        dip_curve=_dip_curve(rng),
        coulomb_asymmetry_A=coulomb_A * rng.uniform(-0.05, 0.05),
        viscous_asymmetry_A=viscous_A * rng.uniform(-0.25, 0.25),
        inertia_A_s2_mm=draw_log_uniform(rng, 0.0003, 0.0012),
        weight_A=_perhaps(rng, rng.choice([-1.0, 1.0]) * draw_log_uniform(rng, 0.3, 2.0)),
        cogging_A=_perhaps(rng, coulomb_A * draw_log_uniform(rng, 0.03, 0.15)),
        cogging_mm=draw_log_uniform(rng, 6.0, 40.0),
        cogging_rad=rng.uniform(-math.pi, math.pi),
        position_A_mm=_perhaps(rng, rng.choice([-1.0, 1.0]) * coulomb_A * rng.uniform(0.05, 0.25))
        / (0.5 * (HIGH_MM - LOW_MM)),
        noise_A=coulomb_A * draw_log_uniform(rng, 0.03, 0.13),
        noise_rho=1.0 - draw_log_uniform(rng, 0.01, 1.0),
    )


def _perhaps(rng: np.random.Generator, value: float) -> float:
    """The value on every second axis, else nothing."""
    return value if rng.random() < 0.5 else 0.0


def _viscous_curve(rng: np.random.Generator) -> FrictionCurve:
    curves: tuple[FrictionCurve, ...] = (
        _table(rng),
        RationalCurve(draw_log_uniform(rng, 80.0, 400.0)),
        LogCurve(draw_log_uniform(rng, 5.0, 40.0)),
        PowerCurve(rng.uniform(0.45, 0.85)),
    )
    return curves[rng.integers(len(curves))]


def _table(rng: np.random.Generator) -> TableCurve:
    """Five pieces up to 250 mm/s, each at 0.4 to 0.95 of the slope before it."""
    inner = np.geomspace(8.0, 130.0, 4) * np.exp(rng.uniform(-0.25, 0.25, 4))
    points = np.concatenate([[0.0], inner, [250.0]])
    slopes = np.cumprod(np.concatenate([[1.0], rng.uniform(0.4, 0.95, 4)]))
    values = np.concatenate([[0.0], np.cumsum(slopes * np.diff(points))])
    return TableCurve(tuple(points.tolist()), tuple(values.tolist()))


def _dip_curve(rng: np.random.Generator) -> FrictionCurve:
    fade_mm_s = draw_log_uniform(rng, 3.0, 12.0)
    curves: tuple[FrictionCurve, ...] = (
        GaussianDip(fade_mm_s),
        RationalDip(fade_mm_s),
        ExponentialDip(fade_mm_s),
    )
    return curves[rng.integers(len(curves))]


def axis_columns(
    axis: DrawnAxis, *, x_mm: Array, v_mm_s: Array, a_mm_s2: Array
) -> list[EffortColumn]:
    """Columns of the axis at samples (n,) of its motion; with cogging, its two derivatives too."""
    d = reversal(v_mm_s, axis.reversal_mm_s)
    speed = np.abs(v_mm_s)
    curve, dip = axis.viscous_curve.share(speed), axis.dip_curve.share(speed)
    made = [
        EffortColumn("coulomb", axis.coulomb_A, d),
        EffortColumn("viscous", axis.viscous_A, d * curve),
        EffortColumn("stribeck", axis.dip_A, d * dip),
        EffortColumn("asymmetry", axis.coulomb_asymmetry_A, d**2),
        EffortColumn("asymmetry", axis.viscous_asymmetry_A, d**2 * curve),
        EffortColumn("inertia", axis.inertia_A_s2_mm, a_mm_s2),
        EffortColumn("gravity", axis.weight_A, np.ones_like(x_mm)),
    ]
    if axis.cogging_A:
        made += _cogging(axis, x_mm)
    if axis.position_A_mm:
        made.append(EffortColumn("position_friction", axis.position_A_mm, d * (x_mm - MIDDLE_MM)))
    return made


def _cogging(axis: DrawnAxis, x_mm: Array) -> list[EffortColumn]:
    """The ripple, and its derivatives by phase (rad) and by period (mm)."""
    p = 2.0 * np.pi * x_mm / axis.cogging_mm + axis.cogging_rad
    by_phase = axis.cogging_A * (np.cos(p) + 2.0 * SECOND_HARMONIC * np.cos(2.0 * p))
    by_period = -2.0 * np.pi * x_mm / axis.cogging_mm**2 * by_phase
    return [
        EffortColumn("cogging", axis.cogging_A, np.sin(p) + SECOND_HARMONIC * np.sin(2.0 * p)),
        EffortColumn("cogging", 0.0, by_phase),
        EffortColumn("cogging", 0.0, by_period),
    ]


def parts_A(axis: DrawnAxis, motion: TrueMotion) -> dict[str, Array]:
    """Contribution of every term at every sample, A, keyed by term identifier."""
    parts: dict[str, Array] = {}
    for column in axis_columns(axis, x_mm=motion.x, v_mm_s=motion.v, a_mm_s2=motion.a):
        before = parts.get(column.term, np.zeros_like(motion.t))
        parts[column.term] = before + column.coefficient * column.values
    return parts


def draw_motion(seed: int) -> TrueMotion:
    """Air moves of a seed: 40 to 90 s, all over the travel, speeds drawn from 2.5 to 185 mm/s.

    One speed is drawn from each of as many even parts of the logarithm as the time allows.
    """
    rng = np.random.default_rng([seed, 22])
    seconds = float(rng.choice(SECONDS))
    count = int(seconds / SECONDS_A_SPEED)
    edges = np.geomspace(*SPEEDS_MM_S, count + 1)
    speeds = tuple(draw_log_uniform(rng, *edges[i : i + 2].tolist()) for i in range(count))
    moves = plan_moves(rng, seconds, speeds_mm_s=speeds, rapid_mm_s=rng.uniform(155.0, 200.0))
    return moves_motion(moves, np.arange(round(seconds * RATE_HZ)) / RATE_HZ)


def draw_run(seed: int) -> AxisRun:
    """The recording of a seed: t, position, velocity, acceleration, current of axis x, in air.

    Axis, motion and noise have streams of their own; the same seed gives the same bytes.
    """
    axis, motion = draw_axis(seed), draw_motion(seed)
    rng = np.random.default_rng([seed, 23])
    noise_A = coloured(rng, motion.t.size, axis.noise_A, axis.noise_rho)
    channels = {
        "t": motion.t,
        "x.position": motion.x,
        "x.velocity": motion.v,
        "x.acceleration": motion.a,
        "x.current": sum(parts_A(axis, motion).values(), start=noise_A),
    }
    return AxisRun(axis, motion, channels)
