"""The virtual lathe's three drives: load in, current range out.

Modelled on the machine of P1 (11 kW, AC induction motors, Hall sensors): range = 2 x amplitude of
the phase current. What is not quoted from P1 is *chosen*.
"""

import math
from dataclasses import dataclass

import numpy as np

from autodb.proofs.machines.lathe.process import Array

WANDER_S = (2900.0, 7700.0, 21000.0)  # periods of the spindle's slow wander; chosen


@dataclass(frozen=True)
class FeedAxis:
    """A slide: load = friction + load friction + cutting force - weight that helps the feed."""

    force_per_A_N: float  # N per ampere of range
    friction_N: float
    weight_N: float  # component that helps the in-feed
    noise_A: float  # sd of one cut's range
    standing_A: float  # range reported while it stands still, whatever the load
    magnetising_A: float = 0.15  # in quadrature with the load current; chosen
    load_friction: float = 0.03  # guideway friction per newton pressed across it; chosen
    screw_loss: float = 0.35  # extra load at creep, share of the cutting force; chosen, see Lathe
    screw_mm_s: float = 5.0  # feed speed over which it fades; chosen


@dataclass(frozen=True)
class Spindle:
    """The main drive: torque = a(n) dI^b(n), a falling as 1/n above the base speed."""

    torque_per_A_Nm: float = 1.45  # N m per ampere^b at low speed; chosen, ~60 N m at 60 A
    exponent: float = 0.93  # chosen
    base_rpm: float = 1570.0  # P1 section 6
    air_A: float = 14.0  # range at standstill speed, mostly magnetising; chosen
    air_per_krpm_A: float = 2.0  # chosen
    windage_per_krpm2_A: float = 0.9  # chosen
    noise_A: float = 0.469  # sd of dI: 18.5 N (P1 Table 2, as 425 - 84 N^2) at its cut, D = 60 mm
    warm_share: float = (485.78 - 465.21) / 485.78  # reads low by this when warm: P1 Table 2
    warm_s: float = 1800.0  # time constant of that; chosen
    wander_share: float = 0.04  # sd of the slow wander; chosen, see Lathe


def feed_range_A(axis: FeedAxis, along_N: Array, across_N: Array, *, speed_mm_s: float) -> Array:
    """Current range of a moving slide: sqrt(I_mag^2 + (L/k)^2), it folds where the load L is zero.

    L = R + mu |F_across| + F_along (1 + q e^(-v/v_q)) - W, N; k N/A; feed speed v mm/s. P1
    section 8, with guideway friction that grows with load and a screw that loses more at creep.
    """
    screw = screw_load(axis, speed_mm_s)
    rubbing_N = axis.friction_N + axis.load_friction * np.abs(across_N)
    load_N = rubbing_N + screw * along_N - axis.weight_N
    range_A: Array = np.sqrt(axis.magnetising_A**2 + (load_N / axis.force_per_A_N) ** 2)
    return range_A


def screw_load(axis: FeedAxis, speed_mm_s: Array | float) -> Array:
    """Load on the screw per newton at the tool: it loses more at creep."""
    creep = np.exp(-np.asarray(speed_mm_s, dtype=np.float64) / axis.screw_mm_s)
    return np.asarray(1.0 + axis.screw_loss * creep)


def spindle_share(spindle: Spindle, seed: int, clock_s: float) -> float:
    """Share of the torque that the spindle's current shows: it reads low when warm, and wanders.

    1 - w (1 - e^(-t/T)) + slow wander, a sum of three sines of unrelated periods and random phase:
    one run of cuts sees it as a bias, many days see it as scatter.
    """
    phase = np.random.default_rng([seed, 9]).uniform(0.0, 2.0 * math.pi, len(WANDER_S))
    wander = float(np.sum(np.sin(2.0 * math.pi * clock_s / np.array(WANDER_S) + phase)))
    warm = float(warm_share(spindle, clock_s))
    return 1.0 - warm + spindle.wander_share * math.sqrt(2.0 / len(WANDER_S)) * wander


def warm_share(spindle: Spindle, clock_s: Array | float) -> Array:
    """Share of the torque that the current misses as the spindle warms: w (1 - e^(-t/T))."""
    return np.asarray(spindle.warm_share * -np.expm1(-np.asarray(clock_s) / spindle.warm_s))


def torque_law(spindle: Spindle, speed_rpm: Array | float) -> tuple[Array, Array]:
    """a and b of T = a dI^b: constant torque below the base speed, constant power above.

    a = a0 (1 + (n/n_b)^8)^(-1/8); b = b0 - 0.03 tanh((n - n_b)/600 rpm). Forms, numbers: chosen.
    """
    rpm = np.asarray(speed_rpm, dtype=np.float64)
    scale = spindle.torque_per_A_Nm * (1.0 + (rpm / spindle.base_rpm) ** 8) ** -0.125
    return scale, spindle.exponent - 0.03 * np.tanh((rpm - spindle.base_rpm) / 600.0)


def spindle_range_A(
    spindle: Spindle, torque_Nm: Array, speed_rpm: float, *, share: float = 1.0
) -> Array:
    """Current range of the spindle: air current, three terms in n (chosen), + (share T/a)^(1/b)."""
    krpm = speed_rpm / 1000.0
    air_A = spindle.air_A + spindle.air_per_krpm_A * krpm + spindle.windage_per_krpm2_A * krpm**2
    scale, exponent = torque_law(spindle, speed_rpm)
    range_A: Array = air_A + (np.maximum(torque_Nm, 0.0) * share / scale) ** (1.0 / exponent)
    return range_A
