"""Effects of known size, added to a real recording: each as what it changes in the effort."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from autodb.proofs.cases.real.friction_states import gone_at_reversals, rising_after_reversals
from autodb.proofs.cases.real.full_models import FittedModel
from autodb.proofs.cases.real.real_axis import Array, RealAxis
from autodb.proofs.cases.real.real_columns import (
    centred,
    elastic_shape,
    fading,
    stribeck_shape,
)

Rng = np.random.Generator
PEAK = 0.99
"""Quantile of |effort| that stands for what the drive gives; no effect is larger than that."""
MOST_FADED = 0.5
"""Of the friction, that warmth takes."""
FADING_TIME = 0.3
"""Share of the duration."""
MOST_RISE, MOST_PLAY = 0.05, 0.1
"""Distances of pre-sliding and of backlash, shares of the span."""
LOAD_SIDE = 0.6
"""Of Coulomb friction, beyond the play."""
MOST_ELASTIC = 0.8
"""Of the inertia, beyond the spring."""
MOST_GAIN = 0.5
MOST_LAG_S, MOST_LAG_ROWS = 0.1, 2.0
UNCLIPPED = 0.7
"""Quantile of |effort| that a limit leaves alone: at most three rows in ten are clipped."""
FALLEN_AT = 0.15
"""Speed at which the Stribeck part is gone, share of the top speed."""
ELASTIC_HZ = (1.0, 25.0)
RIPPLES = (5, 25)
"""Periods of a ripple within the span, where rows are dense enough."""
ROWS_OF_RIPPLE = 6.0
"""Rows that a period takes at least, at top speed."""


@dataclass(frozen=True)
class Effect:
    """What an effect of a size in (0, ``most``] changes in the effort: ``change`` gives (n,)."""

    most: float
    change: Callable[[float], Array]


def effect_on(term: str, axis: RealAxis, model: FittedModel, rng: Rng) -> Effect:
    """Draw an effect on a recording whose full model is known."""
    if term in PLACED:
        sign = 1.0 if term in ONE_SIGNED else float(rng.choice((-1.0, 1.0)))
        shape = PLACED[term](axis, rng)
        shape = sign * shape / max(float(np.max(np.abs(shape))), 1e-12)
        return Effect(effort_peak(axis), lambda size: size * shape)
    return CHANGING[term](axis, model, rng)


def effort_peak(axis: RealAxis) -> float:
    """Return the largest effort but for spikes, in the unit of the channel."""
    return float(np.quantile(np.abs(axis.effort), PEAK))


def _ripple(axis: RealAxis, rng: Rng) -> Array:
    span = float(np.ptp(axis.position))
    shortest = ROWS_OF_RIPPLE * axis.top_speed / axis.rate_hz
    most = min(float(RIPPLES[1]), span / shortest)
    period = span / rng.uniform(min(RIPPLES[0], most), most)
    return np.asarray(np.cos(2.0 * np.pi * axis.position / period + rng.uniform(0.0, 6.28)))


def _spring(axis: RealAxis, rng: Rng) -> Array:
    return centred(axis) - rng.uniform(-0.5, 0.5)


def _load(axis: RealAxis, rng: Rng) -> Array:
    """Return a load over 20 to 30 % of the rows, edges of 20 ms: no block holds it all."""
    length = round(len(axis) * rng.uniform(0.2, 0.3))
    first = int(rng.integers(len(axis) // 20, len(axis) - length - len(axis) // 20))
    inside = np.zeros(len(axis))
    inside[first : first + length] = 1.0
    edge = max(round(0.02 * axis.rate_hz), 1)
    return np.convolve(inside, np.ones(edge) / edge, mode="same")


def _cross(axis: RealAxis, _rng: Rng) -> Array:
    if axis.other_a is None:
        raise ValueError(f"{axis.name}: no other axis was recorded")
    return axis.other_a


PLACED: dict[str, Callable[[RealAxis, Rng], Array]] = {
    "coulomb": lambda axis, _: axis.direction,
    "viscous": lambda axis, _: axis.v,
    "stribeck": lambda axis, _: stribeck_shape(axis, FALLEN_AT),
    "asymmetry": lambda axis, _: np.abs(axis.direction),
    "position_friction": lambda axis, _: axis.direction * centred(axis),
    "gravity": lambda axis, _: np.ones(len(axis)),
    "spring": _spring,
    "cogging": _ripple,
    "inertia": lambda axis, _: axis.a,
    "cross_coupling": _cross,
    "external_load": _load,
    "sensor_drift": lambda axis, _: (axis.t - axis.t[0]) / np.ptp(axis.t),
}
"""Contributions, whose size is a factor."""
ONE_SIGNED = ("coulomb", "viscous", "stribeck", "inertia", "cogging")


def _warmup(axis: RealAxis, model: FittedModel, _rng: Rng) -> Effect:
    friction = model.part("coulomb") + model.part("viscous")
    shape = -friction * fading(axis, FADING_TIME)
    return Effect(MOST_FADED, lambda share: share * shape)


def _presliding(axis: RealAxis, model: FittedModel, _rng: Rng) -> Effect:
    level, span = _coulomb_level(model), float(np.ptp(axis.position))

    def change(share: float) -> Array:
        return level * (rising_after_reversals(axis, share * span) - axis.direction)

    return Effect(MOST_RISE, change)


def _backlash(axis: RealAxis, model: FittedModel, _rng: Rng) -> Effect:
    level, span = LOAD_SIDE * _coulomb_level(model), float(np.ptp(axis.position))
    return Effect(MOST_PLAY, lambda share: level * gone_at_reversals(axis, share * span))


def _coulomb_level(model: FittedModel) -> float:
    return float(model.coefficients[model.names.index("coulomb")])


def _compliance(axis: RealAxis, model: FittedModel, _rng: Rng) -> Effect:
    natural_hz = float(np.clip(axis.rate_hz / 20.0, *ELASTIC_HZ))
    inertia = float(model.coefficients[model.names.index("inertia")])
    shape = inertia * elastic_shape(axis, natural_hz)
    return Effect(MOST_ELASTIC, lambda share: share * shape)


def _gain(axis: RealAxis, _model: FittedModel, rng: Rng) -> Effect:
    """Return a factor that changes over the middle third of the recording."""
    passed = (axis.t - axis.t[0]) / np.ptp(axis.t)
    shape = float(rng.choice((-1.0, 1.0))) * axis.effort * np.clip(3.0 * passed - 1.0, 0.0, 1.0)
    return Effect(MOST_GAIN, lambda share: share * shape)


def _lag(axis: RealAxis, _model: FittedModel, _rng: Rng) -> Effect:
    def change(delay_s: float) -> Array:
        return np.asarray(np.interp(axis.t - delay_s, axis.t, axis.effort) - axis.effort)

    return Effect(max(MOST_LAG_S, MOST_LAG_ROWS / axis.rate_hz), change)


def _saturation(axis: RealAxis, _model: FittedModel, _rng: Rng) -> Effect:
    peak = float(np.max(np.abs(axis.effort)))

    def change(share: float) -> Array:
        limit = peak * (1.0 - share)
        return np.asarray(np.clip(axis.effort, -limit, limit) - axis.effort)

    return Effect(1.0 - float(np.quantile(np.abs(axis.effort), UNCLIPPED)) / peak, change)


def _lost_sign(axis: RealAxis, _model: FittedModel, _rng: Rng) -> Effect:
    """Return a sign that is lost or not: there is one size."""
    shape = np.abs(axis.effort) - axis.effort
    return Effect(1.0, lambda share: float(share > 0.0) * shape)


CHANGING: dict[str, Callable[[RealAxis, FittedModel, Rng], Effect]] = {
    "warmup": _warmup,
    "presliding": _presliding,
    "backlash": _backlash,
    "compliance": _compliance,
    "gain": _gain,
    "lag": _lag,
    "saturation": _saturation,
    "lost_sign": _lost_sign,
}
"""What changes the effort, or parts of the full model."""
NEEDED = {
    "warmup": ("coulomb", "viscous"),
    "presliding": ("coulomb",),
    "backlash": ("coulomb",),
    "compliance": ("inertia",),
}
"""Terms of which a full model must have one."""
EFFECTS = (*PLACED, *CHANGING)
