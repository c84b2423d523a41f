"""Friction of a reference feed axis: over speed, along the travel, after a reversal, warm and cold.

P2 is "friction and weight of feed axes", sections III and IV. No law is P2's seven-parameter form,
nor one that autodb fits. Current A, position mm, speed mm/s; shares are of ``coulomb_A``.
"""

import math
from dataclasses import dataclass, replace
from itertools import pairwise

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
)
from autodb.proofs.machines.lathe.process import Array

WARM_MM_S = 10_000.0 / 60.0  # speed of P2's figure 12
SLIDERS = 4
SLIDER_SHARES = (0.4, 0.3, 0.2, 0.1)  # of the friction, from the stiffest; chosen
SLIDES_MM = (0.002, 0.06)  # chosen: pre-sliding of published axes ends within 0.1 mm
COULOMB_A = (0.8, 1.2)  # chosen: P2 prints no friction in amperes that can be used
LEVEL_BY_WAY, VISCOUS_BY_WAY, DIP_BY_WAY = 0.02, 0.08, 0.2  # directions differ by up to; chosen
RIPPLE = (0.01, 0.03)  # chosen
FOLDS = (0.08, 0.20)  # of the cover; chosen
DROP, HEATS_S, COOLS_S = (0.185, 0.22), (16.5, 20.0), (120.0, 250.0)  # P2 figure 12: see the test


@dataclass(frozen=True)
class OneWay:
    """Friction of one direction over speed, shares."""

    level: float
    viscous: float  # at 150 mm/s
    viscous_curve: FrictionCurve
    dip: float
    dip_curve: FrictionCurve

    def share(self, speed_mm_s: Array) -> Array:
        """Level + viscous + dip at speeds (n,)."""
        viscous = self.viscous * self.viscous_curve.share(speed_mm_s)
        return self.level + viscous + self.dip * self.dip_curve.share(speed_mm_s)


@dataclass(frozen=True)
class Travel:
    """Friction along the travel, shares: a cover whose folds bend it, and the screw's turns."""

    cover: float  # from end to end
    bend_mm: float  # of its logarithm
    folds: tuple[tuple[float, float, float], ...]  # share, wave mm, phase rad of each
    ends_mm: tuple[float, float]
    ripple: float
    second: float  # of the second harmonic
    pitch_mm: float
    phase_rad: float

    def share(self, x_mm: Array) -> Array:
        """The logarithm of the way from the motor (Rudolph, cited in P2), mean 0, folds, ripple."""
        low_mm, high_mm = self.ends_mm
        whole = math.log1p((high_mm - low_mm) / self.bend_mm)
        mean = (1.0 + self.bend_mm / (high_mm - low_mm)) - 1.0 / whole
        turned = 2.0 * math.pi * x_mm / self.pitch_mm + self.phase_rad
        wave = np.sin(turned) + self.second * np.sin(2.0 * turned + 1.0)
        rise = np.log1p((x_mm - low_mm) / self.bend_mm) / whole - mean
        folds = sum(
            (a * np.sin(2.0 * math.pi * x_mm / mm + phase) for a, mm, phase in self.folds),
            start=np.zeros_like(x_mm),
        )
        return np.asarray(self.cover * rise + folds + self.ripple * wave)


@dataclass(frozen=True)
class LubricantWarming:
    """The lubricant's warmth w, 0 to 1, and what friction loses by it.

    dw/dt = p (1 - w)/heats - w/cools, p the friction power over that at 10 000 mm/min; friction is
    (1 - drop w) of the cold one.
    """

    drop: float
    heats_s: float
    cools_s: float

    def warmth(self, power: Array, step_s: float, start: float = 0.0) -> Array:
        """W (n,) at rows ``step_s`` apart."""
        gains = power * (step_s / self.heats_s)
        losses = gains + step_s / self.cools_s
        w, level = np.empty_like(power), start
        for i, (gain, loss) in enumerate(zip(gains.tolist(), losses.tolist(), strict=True)):
            w[i] = level
            level += gain - loss * level
        return w


@dataclass(frozen=True)
class TrueFriction:
    """The friction of one axis."""

    coulomb_A: float
    plus: OneWay
    minus: OneWay
    travel: Travel
    slides_mm: tuple[float, ...]  # ways at which the sliders break away
    warming: LubricantWarming

    def steady_A(self, x_mm: Array, v_mm_s: Array) -> Array:
        """Size of the friction (n,) in steady motion, cold."""
        speed = np.abs(v_mm_s)
        over_speed = np.where(v_mm_s >= 0.0, self.plus.share(speed), self.minus.share(speed))
        return np.asarray(self.coulomb_A * (over_speed + self.travel.share(x_mm)))

    def power(self, x_mm: Array, v_mm_s: Array) -> Array:
        """Friction power (n,) over its mean at 10 000 mm/min."""
        top = self.coulomb_A * self.plus.share(np.array([WARM_MM_S]))
        return self.steady_A(x_mm, v_mm_s) * np.abs(v_mm_s) / (top * WARM_MM_S)


def slid_state(x_mm: Array, slides_mm: tuple[float, ...]) -> Array:
    """Return the state of Maxwell sliders (n,), -1 to 1: which way friction acts, and how much.

    Each slider is a spring that breaks away after its way: z follows x and stays within +-1.
    Between two turns of the axis that is a straight line with an end.
    """
    turns = np.flatnonzero(np.diff(np.sign(np.diff(x_mm))) != 0) + 1
    edges = [0, *turns.tolist(), len(x_mm) - 1]
    total = np.zeros_like(x_mm)
    for share, slide_mm in zip(SLIDER_SHARES, slides_mm, strict=True):
        z = np.zeros_like(x_mm)
        for begin, end in pairwise(edges):
            way = (x_mm[begin : end + 1] - x_mm[begin]) / slide_mm
            z[begin : end + 1] = np.clip(z[begin] + way, -1.0, 1.0)
        total += share * z
    return total


def draw_friction(
    rng: np.random.Generator,
    *,
    cover: float,
    ends_mm: tuple[float, float],
    pitch_mm: float,
) -> TrueFriction:
    """Friction of an axis with a cover of about this share; every range not of P2 is chosen."""
    plus = OneWay(
        level=1.0,
        viscous=rng.uniform(0.3, 0.9),
        viscous_curve=_viscous_curve(rng),
        dip=rng.uniform(0.1, 0.4),
        dip_curve=_dip_curve(rng),
    )
    minus = replace(
        plus,
        level=1.0 + rng.uniform(-LEVEL_BY_WAY, LEVEL_BY_WAY),
        viscous=plus.viscous * (1.0 + rng.uniform(-VISCOUS_BY_WAY, VISCOUS_BY_WAY)),
        dip=plus.dip * (1.0 + rng.uniform(-DIP_BY_WAY, DIP_BY_WAY)),
    )
    travel = Travel(
        cover=cover * rng.uniform(0.7, 1.3) * rng.choice([-1.0, 1.0]),
        bend_mm=rng.uniform(20.0, 80.0),
        folds=tuple(
            (abs(cover) * rng.uniform(*FOLDS), wave_mm, rng.uniform(-math.pi, math.pi))
            for wave_mm in (rng.uniform(120.0, 200.0), rng.uniform(60.0, 100.0))
        ),
        ends_mm=ends_mm,
        ripple=rng.uniform(*RIPPLE),
        second=rng.uniform(0.0, 0.4),
        pitch_mm=pitch_mm,
        phase_rad=rng.uniform(-math.pi, math.pi),
    )
    return TrueFriction(
        coulomb_A=rng.uniform(*COULOMB_A),
        plus=plus,
        minus=minus,
        travel=travel,
        slides_mm=tuple(float(one) for one in np.sort(_log_uniform(rng, *SLIDES_MM, SLIDERS))),
        warming=LubricantWarming(rng.uniform(*DROP), rng.uniform(*HEATS_S), rng.uniform(*COOLS_S)),
    )


def _log_uniform(rng: np.random.Generator, low: float, high: float, size: int = 1) -> Array:
    return np.exp(rng.uniform(math.log(low), math.log(high), size))


def _viscous_curve(rng: np.random.Generator) -> FrictionCurve:
    bends = np.sort(_log_uniform(rng, 1.0, 120.0, 3))
    slopes = np.cumprod(np.concatenate([[1.0], rng.uniform(0.3, 0.8, 3)]))
    points = np.concatenate([[0.0], bends, [170.0]])
    values = np.concatenate([[0.0], np.cumsum(slopes * np.diff(points))])
    curves: tuple[FrictionCurve, ...] = (
        TableCurve(tuple(points.tolist()), tuple(values.tolist())),
        RationalCurve(float(_log_uniform(rng, 20.0, 300.0)[0])),
        LogCurve(float(_log_uniform(rng, 2.0, 40.0)[0])),
        PowerCurve(rng.uniform(0.35, 0.8)),
    )
    return curves[rng.integers(len(curves))]


def _dip_curve(rng: np.random.Generator) -> FrictionCurve:
    fade_mm_s = float(_log_uniform(rng, 0.5, 8.0)[0])
    curves: tuple[FrictionCurve, ...] = (
        GaussianDip(fade_mm_s),
        RationalDip(fade_mm_s),
        ExponentialDip(fade_mm_s),
    )
    return curves[rng.integers(len(curves))]
