"""Reference tables: dynamometers on a table that tilts and turns, of P4's kind.

P4: Model-based determination of process force in multi-axis milling. F_M = T F_P + F_G + F_CF + F_E
(equations 1 to 7), T = T_z T_x, tared upright. What its model leaves out is here: shares of one
component in another, a sensor turned a little on the table, a zero that wanders, and a sensor that
chips heat (section 5.2), by two time constants and by as much as chips stay on it in a tilt. How
fast a dynamometer warms is printed nowhere that we found; an amplifier's own drift is within the
zero's: 0.1 pC/s or 25 mN/s at most with quartz (HBM, CMD600, A2781-2.1, section 11.3), 0.7 N over a
cut. Forces of the cut change from run to run as P4's repeats do. What P4 does not print is
*chosen*, and was set so that P4's own model lands on P4's errors.
"""

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import constants, signal

from autodb.proofs.machines.lathe.process import Array

Rows = NDArray[np.bool_]
Stops = tuple[tuple[float, float], ...]

AXIS_HZ, FORCE_HZ = 500.0, 5000.0  # P4 section 3
SENSOR_KG, FIXED_KG, WORK_KG = 20.0, 12.3, 10.1  # P4 sections 4 and 5.1
LEVER_M = (0.02, 0.065, 0.035)  # P4 section 5.1, of sensor and work together
ABOVE_M = 0.10  # of the work's centre over the sensor's; chosen
LEVER_SD_M, MASS_SD = 0.005, 0.03  # from machine to machine; chosen
DRAWN_SD_M = 0.004  # by which a drawing's lever arm is off; chosen
TILTS_DEG = tuple((a, c) for a in (-60.0, -30.0, 30.0) for c in (0.0, 30.0, 60.0, 90.0))  # P4, 4
TILTS_FIXED_DEG = tuple(one for one in TILTS_DEG if one[0] < 0.0)  # P4 section 4
SETUPS_DEG = ((0.0, 0.0), (-20.0, 31.0), (-35.0, -57.0))  # P4 Table 2
REPEATS = 3  # P4 section 5.2, upright
FASTEST_DEG_S = 2000.0 / 60.0  # P4 section 5.1
RAMP_S = 0.09  # of speed; chosen: 2000 deg/min in it pulls as much as P4's Table 1
FOLLOWS_HZ, FOLLOWS_DAMPING = (25.0, 45.0), 0.4  # how the table follows its command; chosen
ANGLE_SD_DEG = 0.02  # of the zero of a rotary axis; chosen
LOG_DEG, LOG_DEG_S, LOG_DEG_S2 = 0.0005, 0.01, 2.0  # noise of the control's log; chosen
SHARE_SD, GAIN_SD = 0.008, 0.003  # of one component in another, and of each; chosen
TURNED_SD_DEG = 0.2  # of the sensor on the table about its z; chosen
NOISE_N = 1.0  # at 5000 Hz; chosen
WANDERS_N, WANDERS_S = (0.7, 0.6, 1.4), 8.0  # zero; sizes from P4's Table 1 and Fig. 3; time chosen
RANGES_N = (388.9, 291.0, 72.0)  # P4 Table 2, of the cut's forces
SPEED_RPM, TEETH, RADIUS_MM, FEED_MM_REV = 2546.0, 2, 5.0, 0.1  # P4 section 3: 80 m/min
HELIX_DEG = 40.0  # chosen
PASSES_MM = ((1.0, 2.0), (1.0, 4.0), (1.5, 2.0), (1.5, 4.0), (2.0, 2.0), (2.0, 3.0))  # chosen
PASS_S, BETWEEN_S, BEFORE_S, AFTER_S, ENTERS_S = 1.6, 1.5, 3.0, 6.0, 0.15  # chosen; 2 g of chips
CHIP_N_MM2, EDGE_N_MM = (2200.0, 900.0, 350.0), (25.0, 25.0, 3.0)  # chosen; ranges are then P4's
RUN_SD = (0.022, 0.018, 0.03)  # of a component's force from run to run; from P4's repeats
TOOTH_SD = 0.03  # of a tooth's pass; chosen
HEAT_N = (15.0, -12.0, 170.0)  # of the sensor in long cutting; from P4's Table 2
HEAT_SD = 0.2  # of each, from machine to machine and run to run; chosen
STAYS = (0.1, 1.0, 0.5)  # share of the chips on the sensor in each set-up; from P4's Table 2
HEATS_S, HEATS_SHARE = ((4.0, 8.0), (30.0, 60.0)), 0.6  # quick and slow, share of the quick; chosen


@dataclass(frozen=True)
class TrueTable:
    """The truth of one: masses kg, lever arms m of sensor and of work, the matrix of the sensor
    (3, 3), offsets of its axes deg, how it follows Hz, heat (3,) N with time constants s.

    ``drawn_m``: what its drawings say of the lever arm of sensor and work together.
    """

    sensor_kg: float
    sensor_m: Array
    work_m: Array
    matrix: Array
    offsets_deg: tuple[float, float]
    follows_hz: float
    heat_N: Array
    heats_s: tuple[float, float]
    drawn_m: Array

    def loaded(self, added_kg: float) -> tuple[float, Array]:
        """Return mass and lever arm (3,) with a mass on the sensor."""
        mass = self.sensor_kg + added_kg
        return mass, (self.sensor_kg * self.sensor_m + added_kg * self.work_m) / mass


@dataclass(frozen=True)
class Log:
    """What a control logs of its rotary axes a and c, (2, n): angle deg, rate, acceleration."""

    t: Array
    angle: Array
    rate: Array
    acceleration: Array


@dataclass(frozen=True)
class RecordedTable:
    """What was recorded: axes, the dynamometer's reading (3, n) N, tared upright.

    ``true_N`` (3, n): the force of the work on the tool in machine axes; ``engaged`` (n,): where
    chips are made; ``whole`` (n,): where a pass is engaged as far as it will be; ``chips`` (n,):
    their volume a second over the mean of the passes; ``heat_N`` (3, n).
    """

    log: Log
    reading_N: Array
    true_N: Array
    engaged: Rows
    whole: Rows
    chips: Array
    heat_N: Array


def draw_table(seed: int) -> TrueTable:
    """Draw the table of a seed."""
    rng = np.random.default_rng([seed, 90])
    sensor_kg = SENSOR_KG * (1.0 + MASS_SD * rng.standard_normal())
    low = WORK_KG / (SENSOR_KG + WORK_KG) * ABOVE_M
    sensor_m = np.array(LEVER_M) - np.array([0.0, 0.0, low]) + LEVER_SD_M * rng.standard_normal(3)
    work_m = sensor_m + np.array([0.0, 0.0, ABOVE_M])
    matrix = np.eye(3) + SHARE_SD * rng.standard_normal((3, 3)) * (1.0 - np.eye(3))
    matrix += np.diag(GAIN_SD * rng.standard_normal(3))
    twist = math.radians(TURNED_SD_DEG * rng.standard_normal())
    turned = _about_z(twist)
    offsets = ANGLE_SD_DEG * rng.standard_normal(2)
    table = TrueTable(
        sensor_kg=sensor_kg,
        sensor_m=sensor_m,
        work_m=work_m,
        matrix=matrix @ turned,
        offsets_deg=(float(offsets[0]), float(offsets[1])),
        follows_hz=float(rng.uniform(*FOLLOWS_HZ)),
        heat_N=np.array(HEAT_N) * (1.0 + HEAT_SD * rng.standard_normal(3)),
        heats_s=(float(rng.uniform(*HEATS_S[0])), float(rng.uniform(*HEATS_S[1]))),
        drawn_m=np.zeros(3),
    )
    drawn = table.loaded(WORK_KG)[1] + DRAWN_SD_M * rng.standard_normal(3)
    return replace(table, drawn_m=drawn)


def record_tilted(
    seed: int, table: TrueTable, *, added_kg: float, stops_deg: Stops = TILTS_DEG
) -> RecordedTable:
    """Record rests in tilts, upright before, between and after, with a mass on the sensor."""
    way = [(0.0, 0.0)]
    for stop in stops_deg:
        way += [stop, (0.0, 0.0)]
    rng = np.random.default_rng([seed, 91, round(10.0 * added_kg), len(stops_deg)])
    return _in_air(rng, table, added_kg, _moves(way, rest_s=3.0))


def turned_in_air(seed: int, table: TrueTable, number: int = 0) -> RecordedTable:
    """Record the table with work on it turning about both axes at several speeds, P4 section 5.1.

    ``number``: of the recording; each turns by other angles.
    """
    rng = np.random.default_rng([seed, 92, number])
    way = [(0.0, 0.0), (-60.0, 0.0), (-60.0, 90.0)]
    way += [(float(rng.uniform(-60.0, 0.0)), float(rng.uniform(0.0, 90.0))) for _ in range(12)]
    speeds = [float(rng.uniform(0.3, 1.0)) for _ in range(len(way))]
    return _in_air(rng, table, WORK_KG, _moves([*way, (0.0, 0.0)], rest_s=0.8, speeds=speeds))


def mill_on_table(seed: int, table: TrueTable, setup: int, repeat: int = 0) -> RecordedTable:
    """Record the passes of P4's work in a set-up, the table at rest in it."""
    rng = np.random.default_rng([seed, 93, setup, repeat])
    count = round(FORCE_HZ * (BEFORE_S + AFTER_S + len(PASSES_MM) * (PASS_S + BETWEEN_S)))
    t = np.arange(count) / FORCE_HZ
    true_N, engaged, whole, chips = passes(rng, t)
    angle = np.repeat(np.array(SETUPS_DEG[setup])[:, None], count, axis=1)
    still = np.zeros_like(angle)
    heat_N = heat(rng, table, STAYS[setup], chips)
    log = Log(t, angle, still, still)
    mass, lever = table.loaded(WORK_KG)
    exact = truth(table, log, mass, lever, true_N, follows=False) + heat_N
    reading_N = noisy(rng, exact, FORCE_HZ)
    return RecordedTable(log, reading_N, true_N, engaged, whole, chips, heat_N)


def _in_air(rng: np.random.Generator, table: TrueTable, added_kg: float, log: Log) -> RecordedTable:
    count = len(log.t)
    none, no = np.zeros((3, count)), np.zeros(count, dtype=np.bool_)
    mass, lever = table.loaded(added_kg)
    read = noisy(rng, truth(table, log, mass, lever, none, follows=True), AXIS_HZ)
    sds = np.array([LOG_DEG, LOG_DEG_S, LOG_DEG_S2])[:, None, None]
    noise = sds * rng.standard_normal((3, 2, count))
    seen = Log(log.t, log.angle + noise[0], log.rate + noise[1], log.acceleration + noise[2])
    return RecordedTable(seen, read, none, no, no, np.zeros(count), none)


def _moves(
    way: list[tuple[float, float]], *, rest_s: float, speeds: list[float] | None = None
) -> Log:
    """Return moves from stop to stop, both axes starting together, with a rest at each."""
    rates = []
    for number, (begin, end) in enumerate(pairwise(way)):
        share = 1.0 if speeds is None else speeds[number]
        both = [_rate(e - b, share * FASTEST_DEG_S) for b, e in zip(begin, end, strict=True)]
        length = max(len(one) for one in both)
        rates.append(np.zeros((2, round(rest_s * AXIS_HZ))))
        rates.append(np.array([np.pad(one, (0, length - len(one))) for one in both]))
    rates.append(np.zeros((2, round(rest_s * AXIS_HZ))))
    rate = np.concatenate(rates, axis=1)
    angle = np.array(way[0])[:, None] + np.cumsum(rate, axis=1) / AXIS_HZ
    return Log(
        np.arange(rate.shape[1]) / AXIS_HZ, angle, rate, np.gradient(rate, 1.0 / AXIS_HZ, axis=1)
    )


def _rate(way_deg: float, speed_deg_s: float) -> Array:
    """Return the rate (n,) of a move that speeds up and slows down smoothly."""
    ramp = round(RAMP_S * AXIS_HZ)
    up = np.sin(0.5 * np.pi * (np.arange(ramp) + 0.5) / ramp) ** 2
    held = max(0, round((abs(way_deg) / speed_deg_s) * AXIS_HZ) - ramp)
    shape = np.concatenate([up, np.ones(held), up[::-1]])
    return np.asarray(shape * way_deg / (shape.sum() / AXIS_HZ))


def truth(
    table: TrueTable, log: Log, mass: float, lever: Array, process_N: Array, *, follows: bool
) -> Array:
    """Return the exact reading (3, n): P4 equations 3 to 7, through the sensor's matrix."""
    angle = log.angle + np.array(table.offsets_deg)[:, None]
    motion = np.radians(np.array([angle, log.rate, log.acceleration]))
    if follows:
        w = 2.0 * np.pi * table.follows_hz
        b, a = signal.bilinear([w**2], [1.0, 2.0 * FOLLOWS_DAMPING * w, w**2], fs=AXIS_HZ)
        at_rest = motion[:, :, :1]
        motion = at_rest + signal.lfilter(b, a, motion - at_rest, axis=2)
    turned = machine_to_table(motion[0])
    weight = constants.g * (turned[:, 2] - np.array([0.0, 0.0, 1.0])[:, None])
    process = np.einsum("ijn,jn->in", turned, process_N)
    return np.asarray(table.matrix @ (process + mass * (weight + carried_m_s2(motion, lever))))


def machine_to_table(angle_rad: Array) -> Array:
    """Return T_z T_x (3, 3, n) of angles (2, n) of axes a and c, P4 equation 1."""
    ax, cz = angle_rad
    sx, cx, sz, cc = np.sin(ax), np.cos(ax), np.sin(cz), np.cos(cz)
    zero = np.zeros_like(ax)
    return np.array([[cc, -sz * cx, sz * sx], [sz, cc * cx, -cc * sx], [zero, sx, cx]])


def carried_m_s2(motion: Array, lever_m: Array) -> Array:
    """Return the acceleration (3, n), in the table's frame, of a point (3,) that it carries.

    ``motion`` (3, 2, n): angles of axes a and c, their rates and accelerations, rad and s. T turns
    components by +angle: the table turns by -angle, about x and, carried, about z.
    """
    (_, cz), (da, dc), (dda, ddc) = motion
    sz, cc = np.sin(cz), np.cos(cz)
    omega = -np.array([da * cc, da * sz, dc])
    faster = -np.array([dda * cc - da * dc * sz, dda * sz + da * dc * cc, ddc])
    arm = np.repeat(lever_m[:, None], len(cz), axis=1)
    central = np.cross(omega, np.cross(omega, arm, axis=0), axis=0)
    return np.asarray(central + np.cross(faster, arm, axis=0))


def noisy(rng: np.random.Generator, exact_N: Array, rate_hz: float) -> Array:
    """Add noise and a zero that wanders, which begins at 0: tared."""
    count = exact_N.shape[1]
    keep = math.exp(-1.0 / (rate_hz * WANDERS_S))
    fresh = rng.standard_normal((3, count)) * math.sqrt(1.0 - keep**2)
    wander = signal.lfilter([1.0], [1.0, -keep], fresh, axis=1)
    white = NOISE_N * math.sqrt(rate_hz / FORCE_HZ) * rng.standard_normal((3, count))
    return np.asarray(exact_N + np.array(WANDERS_N)[:, None] * wander + white)


def passes(
    rng: np.random.Generator, t: Array, passes_mm: Stops = PASSES_MM
) -> tuple[Array, Rows, Rows, Array]:
    """Return forces (3, n), rows engaged, rows as far engaged as they will be, chips (n,)."""
    true_N, chips = np.zeros((3, len(t))), np.zeros(len(t))
    engaged, whole = np.zeros(len(t), dtype=np.bool_), np.zeros(len(t), dtype=np.bool_)
    theta = 2.0 * np.pi * SPEED_RPM / 60.0 * t + rng.uniform(0.0, 2.0 * np.pi)
    tooth = np.floor(theta * TEETH / (2.0 * np.pi)).astype(np.intp)
    scatter = 1.0 + TOOTH_SD * rng.standard_normal(tooth[-1] + 1)[tooth]
    run = 1.0 + np.array(RUN_SD) * rng.standard_normal(3)
    for number, (depth, width) in enumerate(passes_mm):
        begins = BEFORE_S + number * (PASS_S + BETWEEN_S)
        share = np.clip(np.minimum(t - begins, begins + PASS_S - t) / ENTERS_S, 0.0, 1.0)
        inside = share > 0.0
        shape = _revolution(depth, width)
        at = theta[inside] % (2.0 * np.pi) / (2.0 * np.pi) * shape.shape[1]
        low = at.astype(np.intp) % shape.shape[1]
        true_N[:, inside] = shape[:, low] * (share * scatter)[inside] * run[:, None]
        engaged |= inside
        whole |= share >= 1.0
        chips += share * depth * width
    mean = np.mean([depth * width for depth, width in passes_mm])
    return SCALE[:, None] * true_N, engaged, whole, chips / mean


def _revolution(depth_mm: float, width_mm: float) -> Array:
    """Return the force (3, n) over a revolution, feed along x, cutting down; unscaled."""
    theta = 2.0 * np.pi * np.arange(720) / 720.0
    low = math.pi - math.acos(1.0 - width_mm / RADIUS_MM)
    total = np.zeros((3, len(theta)))
    slices = 10
    for tooth in range(TEETH):
        for height in (np.arange(slices) + 0.5) * depth_mm / slices:
            lag = 2.0 * math.pi * tooth / TEETH
            lag += height * math.tan(math.radians(HELIX_DEG)) / RADIUS_MM
            phi = (theta - lag) % (2.0 * math.pi)
            chip = FEED_MM_REV / TEETH * np.sin(phi)
            in_cut = (phi >= low) & (phi <= math.pi)
            t, r, a = (k * chip + e for k, e in zip(CHIP_N_MM2, EDGE_N_MM, strict=True))
            along = np.array(
                [-t * np.cos(phi) - r * np.sin(phi), t * np.sin(phi) - r * np.cos(phi), a]
            )
            total += along * (in_cut * depth_mm / slices)
    return np.asarray(total)


def _scale() -> Array:
    """Return factors (3,) by which the mean range over the passes becomes P4's."""
    ranges: Array = np.mean([np.ptp(_revolution(*one), axis=1) for one in PASSES_MM], axis=0)
    return np.array(RANGES_N) / ranges


def heat(rng: np.random.Generator, table: TrueTable, stays: float, chips: Array) -> Array:
    """Return the drift (3, n) of a sensor that chips heat: quickly its top, slowly the whole."""
    warm = np.zeros(len(chips))
    for time_s, share in zip(table.heats_s, (HEATS_SHARE, 1.0 - HEATS_SHARE), strict=True):
        keep = math.exp(-1.0 / (FORCE_HZ * time_s))
        warm += share * signal.lfilter([0.0, 1.0 - keep], [1.0, -keep], chips)
    size = stays * (1.0 + HEAT_SD * rng.standard_normal())
    return np.asarray(size * table.heat_N[:, None] * warm)


def _about_z(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


SCALE = _scale()
