"""A feed axis of the virtual lathe in air: its signed current is a known sum of parts.

Friction comes from a table and reverses smoothly; no part has the estimators' form. All numbers are
*chosen*: a made machine, none is a published constant. Current A, position mm, speed mm/s.
"""

from dataclasses import dataclass

import numpy as np

from autodb.proofs.machines.axis.curves import reversal
from autodb.proofs.machines.axis.effects import (
    AxisCogging,
    AxisEffect,
    AxisExternalLoad,
    AxisWarmup,
    PositionFriction,
)
from autodb.proofs.machines.axis.motion import TrueMotion, coloured, moves_motion, plan_moves
from autodb.proofs.machines.lathe.process import Array

__all__ = [
    "HORIZONTAL",
    "VERTICAL",
    "AxisCogging",
    "AxisEffect",
    "AxisExternalLoad",
    "AxisWarmup",
    "PositionFriction",
    "Slide",
    "air_moves",
]


@dataclass(frozen=True)
class Slide:
    """The truth of one slide, in amperes; tables are (speed mm/s, A) pairs."""

    coulomb_A: float = 0.55
    reversal_mm_s: float = 0.25  # half the friction is back at 0.58 of this speed
    viscous_mm_s: tuple[float, ...] = (0.0, 10.0, 30.0, 80.0, 150.0, 250.0)
    viscous_A: tuple[float, ...] = (
        0.0,
        0.024,
        0.060,
        0.132,
        0.216,
        0.310,
    )  # grows slower and slower
    dip_A: float = 0.16  # extra friction at creep
    dip_mm_s: float = 7.0  # half of it is gone at this speed
    inertia_A_s2_mm: float = 0.00065
    weight_A: float = 1.10
    noise_A: float = 0.020  # sd of the coloured noise
    noise_rho: float = 0.6  # its correlation from one sample to the next


VERTICAL = Slide()
HORIZONTAL = Slide(weight_A=0.0, coulomb_A=0.62)


def slide_parts_A(slide: Slide, motion: TrueMotion) -> dict[str, Array]:
    """Contributions that every slide has, A, keyed by term identifier.

    coulomb: level x smooth direction; viscous: table, interpolated; stribeck: dip that halves at
    `dip_mm_s`; inertia: proportional to acceleration; gravity: constant.
    """
    direction = reversal(motion.v, slide.reversal_mm_s)
    speed = np.abs(motion.v)
    return {
        "coulomb": slide.coulomb_A * direction,
        "stribeck": slide.dip_A * direction / (1.0 + (speed / slide.dip_mm_s) ** 2),
        "viscous": direction * np.interp(speed, slide.viscous_mm_s, slide.viscous_A),
        "inertia": slide.inertia_A_s2_mm * motion.a,
        "gravity": np.full_like(motion.t, slide.weight_A),
    }


def air_moves(
    seed: int,
    *,
    rate_hz: float = 250.0,
    seconds: float = 60.0,
    extra: tuple[AxisEffect, ...] = (),
    slide: Slide = VERTICAL,
) -> tuple[dict[str, Array], dict[str, Array]]:
    """A recording of axis x in air (t, position, velocity, acceleration, current), and its parts.

    current = sum of the parts + coloured noise; the parts are free of noise and keyed by term
    identifier, extra effects included. A simulation that lacks one effect is the sum of the others.
    Motion and noise depend on the seed, rate and length only. Raises ValueError on a term twice.
    """
    moving, noisy = np.random.default_rng([seed, 11]), np.random.default_rng([seed, 12])
    t = np.arange(round(seconds * rate_hz)) / rate_hz
    motion = moves_motion(plan_moves(moving, seconds), t)
    parts = slide_parts_A(slide, motion)
    friction_A = parts["coulomb"] + parts["stribeck"] + parts["viscous"]
    for effect in extra:
        if effect.term in parts:
            raise ValueError(f"{effect.term!r} is given twice; give each effect once")
        parts[effect.term] = effect.part_A(motion, friction_A)

    current_A = sum(parts.values(), start=coloured(noisy, t.size, slide.noise_A, slide.noise_rho))
    recording = {
        "t": t,
        "x.position": motion.x,
        "x.velocity": motion.v,
        "x.acceleration": motion.a,
        "x.current": current_A,
    }
    return recording, parts
