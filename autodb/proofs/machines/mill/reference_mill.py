"""Reference mills: machines of P0's kind, with linear drives on axes that carry each other.

P0: LSTM and model-based force reconstruction on a five-axis mill, section 2. K_m I = F_co(s) +
k (s - s_r) + F_fr + M s'' + F_ext; z rides on x, and x on y, so that x moves m_x + m_z and y moves
all three. Currents are sampled 250 times a second without an anti-alias filter; forces are low-
passed forwards and backwards at 120 Hz (section 2.3). Friction has several forms, none of them the
Stribeck law of P0; it changes along the travel, and Maxwell sliders turn it. What P0 does not print
is *chosen*, and was set so that P0's own four steps land on P0's errors.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from autodb.proofs.machines.axis.motion import TrueMotion, coloured
from autodb.proofs.machines.axis.reference_friction import (
    SLIDERS,
    TrueFriction,
    draw_friction,
    slid_state,
)
from autodb.proofs.machines.lathe.process import Array
from autodb.proofs.machines.mill.reference_cogging import MotorCogging, draw_cogging
from autodb.proofs.machines.mill.reference_cuts import PLAN, PLUNGE_MM_MIN, MillCut
from autodb.proofs.machines.mill.reference_mill_moves import (
    AXES,
    ENDS_MM,
    PITCH_MM,
    RATE_HZ,
    MillPath,
    approach,
    mill_sweep_motion,
    travelled,
)
from autodb.proofs.machines.mill.reference_milling import (
    C45,
    DRILL_N,
    ORDERS,
    RADIUS_MM,
    Complex,
    MillEngagement,
    TeethLaw,
    orders,
    waves,
)

CARRIES = {"x": ("x", "z"), "y": ("x", "y", "z"), "z": ("z",)}  # P0 eq. 8 to 10
MASS_KG = {"x": 130.0, "y": 170.0, "z": 90.0}  # of each slide alone; chosen
FORCE_N_A = {"x": 95.0, "y": 110.0, "z": 85.0}  # motor constants; chosen
FRICTION_N = {"x": 200.0, "y": 260.0, "z": 150.0}  # level at medium speed; chosen
COVER = {"x": 0.40, "y": 0.05, "z": 0.10}  # of friction, along the travel; chosen
COGGING_N = {"x": 60.0, "y": 15.0, "z": 20.0}  # rms; chosen
POLES_DIFFER = {"x": 0.35, "y": 0.1, "z": 0.15}  # chosen
SLIDES_MM = {"x": (0.03, 0.8), "y": (0.03, 0.8), "z": (0.01, 0.5)}  # ways of the sliders; chosen
SPRING_N_MM = (0.1, 0.4)  # P0: of essential impact; size chosen
HELD_N = {"x": 0.0, "y": 0.0, "z": 60.0}  # of the weight, beside its balance; chosen
SPREAD = 0.2  # from machine to machine, of every size above; chosen
DAY_SD, CUT_SD = 0.04, 0.02  # friction on the day of cuts, and in each cut; chosen
NOISE_A, NOISE_RHO = 0.03, 0.3  # chosen
VELOCITY_STEP_MM_S, POSITION_STEP_MM = 0.05, 0.0001  # of the control's log; chosen
ACCELERATION_NOISE_MM_S2 = 4.0  # chosen
DRIVE_HZ, DRIVE_DAMPING = (50.0, 80.0), 0.7  # how fast the drive carries a load; chosen
TRUTH_HZ, TRUTH_ORDER = 120.0, 4  # P0 section 2.3; the filter's order is chosen
RUNOUT_MM = (0.001, 0.004)  # chosen
FORCE_SD, FORCE_RHO = 0.03, 0.9  # of the cut, from row to row; chosen
SHAKEN_MM, SHAKEN_HZ = (0.0004, 0.0008), (60.0, 100.0)  # semi-stable: swing of the axis; chosen
IDLE_A, TORQUE_N_M_A = 2.0, 0.6  # of the spindle; chosen


@dataclass(frozen=True)
class MillAxis:
    """The truth of one axis; ``friction`` is in shares of ``friction_N``."""

    name: str
    newtons_per_ampere: float
    moved_kg: float
    spring_N_mm: float
    rest_mm: float
    held_N: float
    friction_N: float
    friction: TrueFriction
    cogging: MotorCogging

    def air_N(self, motion: TrueMotion, rubs: float = 1.0) -> Array:
        """What moving takes (n,), with friction ``rubs`` times that of the sweep."""
        law, speed = self.friction, np.abs(motion.v)
        over_speed = np.where(motion.v >= 0.0, law.plus.share(speed), law.minus.share(speed))
        turned = slid_state(motion.x, law.slides_mm)
        rubbing_N = self.friction_N * turned * (over_speed + law.travel.share(motion.x))
        pulled_N = self.spring_N_mm * (motion.x - self.rest_mm) + self.held_N
        return np.asarray(
            rubs * rubbing_N
            + pulled_N
            + self.cogging.force_N(motion.x)
            + self.moved_kg / 1000.0 * motion.a
        )


@dataclass(frozen=True)
class Logged:
    """What a control logs of an axis: motion, and its current, A, (n,)."""

    motion: TrueMotion
    current_A: Array


@dataclass(frozen=True)
class RecordedMilledCut:
    """A recorded cut: each axis, spindle speed rpm and current A; the load that each axis truly
    sensed from the cut, N, positive where the motor pushes against it in the positive direction;
    and what its drive would take in air if friction were that of the sweep, N; all (n,). The feed
    begins at ``begins_s``, after the approach, and leaves the work at ``ends_s``.
    """

    cut: MillCut
    begins_s: float
    ends_s: float
    t: Array
    axes: dict[str, Logged]
    spindle_rpm: Array
    spindle_A: Array
    load_N: dict[str, Array]
    air_N: dict[str, Array]


def draw_mill(seed: int) -> dict[str, MillAxis]:
    """The axes of the mill of a seed."""
    rng = np.random.default_rng([seed, 81])
    mass = {name: MASS_KG[name] * _spread(rng) for name in AXES}
    return {name: _draw_axis(rng, name, mass) for name in AXES}


def _spread(rng: np.random.Generator) -> float:
    return 1.0 + rng.uniform(-SPREAD, SPREAD)


def _draw_axis(rng: np.random.Generator, name: str, mass: dict[str, float]) -> MillAxis:
    friction = draw_friction(rng, cover=COVER[name], ends_mm=ENDS_MM, pitch_mm=PITCH_MM)
    low, high = (math.log(way_mm) for way_mm in SLIDES_MM[name])
    ways = np.sort(np.exp(rng.uniform(low, high, SLIDERS)))
    return MillAxis(
        name=name,
        newtons_per_ampere=FORCE_N_A[name],
        moved_kg=sum(mass[one] for one in CARRIES[name]),
        spring_N_mm=rng.uniform(*SPRING_N_MM),
        rest_mm=rng.uniform(*ENDS_MM),
        held_N=HELD_N[name] * _spread(rng),
        friction_N=FRICTION_N[name] * _spread(rng),
        # No screw, so none of its turns
        friction=replace(
            friction,
            travel=replace(friction.travel, ripple=0.0),
            slides_mm=tuple(float(one) for one in ways),
        ),
        cogging=draw_cogging(
            rng,
            pitch_mm=PITCH_MM,
            rms_N=COGGING_N[name] * _spread(rng),
            change=POLES_DIFFER[name],
        ),
    )


def swept_axis(seed: int, axis: MillAxis) -> Logged:
    """The sweep of one axis, the others standing."""
    rng = np.random.default_rng([seed, 82, AXES.index(axis.name)])
    motion = mill_sweep_motion()
    return _logged(rng, axis, motion, axis.air_N(motion))


def _logged(
    rng: np.random.Generator, axis: MillAxis, motion: TrueMotion, effort_N: Array
) -> Logged:
    """What the control logs: steps of position and speed, noise of acceleration and current."""
    count = len(motion.t)
    noise_A = coloured(rng, count, NOISE_A, NOISE_RHO)
    seen = TrueMotion(
        motion.t,
        np.round(motion.x / POSITION_STEP_MM) * POSITION_STEP_MM,
        np.round(motion.v / VELOCITY_STEP_MM_S) * VELOCITY_STEP_MM_S,
        motion.a + ACCELERATION_NOISE_MM_S2 * rng.standard_normal(count),
    )
    return Logged(seen, effort_N / axis.newtons_per_ampere + noise_A)


def mill_cut(
    seed: int, mill: dict[str, MillAxis], number: int, cut: MillCut, work: TeethLaw = C45
) -> RecordedMilledCut:
    """Record a cut; its place, the day's friction and the process are of seed and number."""
    rng = np.random.default_rng([seed, 83, number])
    day = np.random.default_rng([seed, 84]).standard_normal(len(AXES))
    begin = rng.uniform(120.0, 210.0, 3)
    home = (begin[0] - 25.0, begin[1] - 25.0, begin[2] + 20.0)
    coming = approach((25.0, 25.0, -20.0))
    begins_s = len(travelled(home, coming).t) / RATE_HZ
    path = travelled(home, [*coming, *cut.legs()])
    ends_s = float(path.t[np.flatnonzero(path.depth > 0.0)[-1]])
    theta, rpm = _turned(rng, cut, path.t)
    varied = 1.0 + coloured(rng, len(path.t), FORCE_SD, FORCE_RHO)
    found = orders(_engagement(rng, cut, work))
    hz = np.arange(float(ORDERS + 1)) * (cut.speed_rpm / 60.0)
    drive = _drive_gain(rng, hz)
    sensed_N, true_N = (
        _loads_N(cut, path, waves(found, theta, gain) * varied) for gain in (drive, _truth_gain(hz))
    )
    motions, swung_N = _shaken(rng, cut, path, mill)
    rubs = 1.0 + DAY_SD * day + CUT_SD * rng.standard_normal(len(AXES))
    axes, loads, air = {}, {}, {}
    for k, name in enumerate(AXES):
        axis, motion = mill[name], motions[name]
        swing_N = swung_N.get(name, 0.0)
        effort_N = axis.air_N(motion, float(rubs[k])) + sensed_N[k] + swing_N
        axes[name] = _logged(rng, axis, motion, effort_N)
        loads[name] = np.asarray(true_N[k] + swing_N)
        air[name] = axis.air_N(motion)
    torque_N_m = np.abs(waves(found, theta, drive)[1]) * path.depth * RADIUS_MM / 1000.0
    spindle_A = IDLE_A + torque_N_m / TORQUE_N_M_A + 0.02 * rng.standard_normal(len(path.t))
    return RecordedMilledCut(cut, begins_s, ends_s, path.t, axes, rpm, spindle_A, loads, air)


def milled_cuts(
    seed: int, mill: dict[str, MillAxis], cuts: tuple[MillCut, ...] = PLAN
) -> list[RecordedMilledCut]:
    """Record cuts, those of P0's kind if none are given."""
    return [mill_cut(seed, mill, number, cut) for number, cut in enumerate(cuts)]


def _engagement(rng: np.random.Generator, cut: MillCut, work: TeethLaw) -> MillEngagement:
    return MillEngagement(
        depth_mm=cut.depth_mm,
        width_mm=cut.width_mm,
        feed_mm=cut.feed_mm,
        up=cut.up,
        runout_mm=rng.uniform(*RUNOUT_MM),
        runout_rad=rng.uniform(-math.pi, math.pi),
        work=work,
    )


def _turned(rng: np.random.Generator, cut: MillCut, t: Array) -> tuple[Array, Array]:
    """Angle of the spindle rad and its speed rpm, (n,): a control holds it within 0.1 %; chosen."""
    rpm = cut.speed_rpm * (1.0 + coloured(rng, len(t), 0.001, 0.98))
    return np.cumsum(rpm) * 2.0 * math.pi / 60.0 / RATE_HZ, rpm


def _drive_gain(rng: np.random.Generator, hz: Array) -> Complex:
    """How a drive's current follows a load: second order."""
    ratio = hz / rng.uniform(*DRIVE_HZ)
    return np.asarray(1.0 / (1.0 - ratio**2 + 2j * DRIVE_DAMPING * ratio), dtype=np.complex128)


def _truth_gain(hz: Array) -> Complex:
    """Butterworth forwards and backwards."""
    gain = 1.0 / (1.0 + (hz / TRUTH_HZ) ** (2 * TRUTH_ORDER))
    return np.asarray(gain, dtype=np.complex128)


def _loads_N(cut: MillCut, path: MillPath, force_N: Array) -> Array:
    """Load on each axis (3, n) of forces on the tool along feed, normal and axis: against them."""
    cos, sin = np.cos(path.feed_rad), np.sin(path.feed_rad)
    x_N, y_N, z_N = force_N * path.depth
    plunge_N = DRILL_N * _plunges(cut, path)
    return -np.array([cos * x_N - sin * y_N, sin * x_N + cos * y_N, z_N + plunge_N])


def _plunges(cut: MillCut, path: MillPath) -> Array:
    """1 in the rows (n,) in which a pocket is drilled, else 0."""
    level = np.abs(path.axes["x"].v) + np.abs(path.axes["y"].v) < 1e-9
    feed = np.abs(path.axes["z"].v + PLUNGE_MM_MIN / 60.0) < 0.1
    return np.asarray(feed & level & (cut.operation == "pocket"), dtype=np.float64)


def _shaken(
    rng: np.random.Generator, cut: MillCut, path: MillPath, mill: dict[str, MillAxis]
) -> tuple[dict[str, TrueMotion], dict[str, Array]]:
    """Motion of each axis with the swing of a semi-stable cut, and the load that swings it.

    The cut swings the slide, not the motor: the load is what its mass takes, the other way.
    """
    swing_mm, swing_hz = rng.uniform(*SHAKEN_MM), rng.uniform(*SHAKEN_HZ)
    if not cut.shaking:
        return path.axes, {}
    across = "y" if abs(math.cos(math.radians(cut.direction_deg))) > 0.7 else "x"
    size = swing_mm * path.depth * (1.0 + 0.3 * coloured(rng, len(path.t), 1.0, 0.99))
    omega = 2.0 * math.pi * swing_hz
    turn, still = omega * path.t, path.axes[across]
    swung = TrueMotion(
        path.t,
        still.x + size * np.sin(turn),
        still.v + size * omega * np.cos(turn),
        still.a - size * omega**2 * np.sin(turn),
    )
    load_N = mill[across].moved_kg / 1000.0 * size * omega**2 * np.sin(turn)
    return path.axes | {across: swung}, {across: load_N}
