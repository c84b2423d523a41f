"""Every effect of a feed axis by its kind: how one is drawn, and all its shapes on a grid.

The grid is what an oracle compares: forms as the generator has them, at steps of their shapes.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np

from autodb.proofs.cases.axis import added_effects as added
from autodb.proofs.cases.axis import changing_effects as changing
from autodb.proofs.cases.axis.effect import (
    CoulombLeftOut,
    HiddenEffect,
    InertiaLeftOut,
    ViscousLeftOut,
    WeightLeftOut,
)
from autodb.proofs.cases.base.moves import Array, Moves, log_uniform

Generator = np.random.Generator


@dataclass(frozen=True)
class EffectFamily:
    """All effects of one kind."""

    kind: str
    draw: Callable[[Generator, Moves], HiddenEffect]
    grid: Callable[[Moves], Iterator[HiddenEffect]]

    @property
    def outside(self) -> bool:
        """Say whether no identifier stands for it."""
        return self.kind.startswith("outside")


def _angle(rng: Generator) -> float:
    return float(rng.uniform(-np.pi, np.pi))


def _sign(rng: Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _travel(moves: Moves) -> tuple[float, float]:
    return float(np.min(moves.x)), float(np.max(moves.x))


def _inside(rng: Generator, moves: Moves) -> float:
    """A place in the middle six tenths of the travel."""
    low, high = _travel(moves)
    return float(low + rng.uniform(0.2, 0.8) * (high - low))


def _places(moves: Moves, count: int) -> Array:
    low, high = _travel(moves)
    return np.linspace(low, high, count + 2)[1:-1]


def _stribeck(rng: Generator, moves: Moves) -> HiddenEffect:
    del moves
    exponent = float(rng.choice([0.0, rng.uniform(1.4, 3.0)]))
    return added.HiddenStribeck(log_uniform(rng, 2.0, 15.0), exponent)


def _stribecks(moves: Moves) -> Iterator[HiddenEffect]:
    del moves
    for fade in np.geomspace(2.0, 15.0, 7).tolist():
        yield from (added.HiddenStribeck(fade, exponent) for exponent in (0.0, 1.4, 2.2, 3.0))


def _asymmetry(rng: Generator, moves: Moves) -> HiddenEffect:
    del moves
    return added.Asymmetry(float(rng.choice([0.0, 1.0, rng.uniform(0.2, 0.8)])))


def _asymmetries(moves: Moves) -> Iterator[HiddenEffect]:
    del moves
    yield from (added.Asymmetry(share) for share in (0.0, 0.25, 0.5, 0.75, 1.0))


def _friction_along(rng: Generator, moves: Moves) -> HiddenEffect:
    places = (
        partial(
            added.softplus_rise, from_mm=_inside(rng, moves), bend_mm=log_uniform(rng, 5.0, 40.0)
        ),
        partial(added.bump, at_mm=_inside(rng, moves), wide_mm=log_uniform(rng, 60.0, 200.0)),
        partial(
            added.rippled,
            period_mm=log_uniform(rng, 20.0, 80.0),
            phase=_angle(rng),
            sharp=rng.uniform(0.3, 2.0),
        ),
    )
    return added.FrictionAlong(places[rng.integers(len(places))])


def _frictions_along(moves: Moves) -> Iterator[HiddenEffect]:
    for place in _places(moves, 9).tolist():
        yield added.FrictionAlong(partial(added.softplus_rise, from_mm=place, bend_mm=15.0))
        for wide in (60.0, 90.0, 135.0, 200.0):
            yield added.FrictionAlong(partial(added.bump, at_mm=place, wide_mm=wide))
    yield from (added.AnyRippled(period) for period in np.geomspace(20.0, 80.0, 10).tolist())


def _spring(rng: Generator, moves: Moves) -> HiddenEffect:
    return added.Spring(_inside(rng, moves), float(rng.choice([0.0, rng.uniform(0.2, 1.5)])))


def _springs(moves: Moves) -> Iterator[HiddenEffect]:
    for rest in _places(moves, 5).tolist():
        yield from (added.Spring(rest, harden) for harden in (0.0, 0.2, 0.7, 1.5))


def _cogging(rng: Generator, moves: Moves) -> HiddenEffect:
    del moves
    second = float(rng.choice([0.0, rng.uniform(0.1, 0.4)]))
    return added.HiddenCogging(log_uniform(rng, 5.0, 40.0), _angle(rng), second, _angle(rng))


def _coggings(moves: Moves) -> Iterator[HiddenEffect]:
    del moves
    yield from (added.AnyCogging(period) for period in np.geomspace(5.0, 40.0, 24).tolist())


def _cross_coupling(rng: Generator, moves: Moves) -> HiddenEffect:
    del moves
    if rng.random() < 0.5:
        return added.CrossCoupling(rng.uniform(15.0, 60.0), 0)
    return added.CrossCoupling(0.0, int(rng.integers(2, 7)))


def _cross_couplings(moves: Moves) -> Iterator[HiddenEffect]:
    del moves
    yield from (added.CrossCoupling(hz, 0) for hz in (15.0, 24.0, 38.0, 60.0))
    yield from (added.CrossCoupling(0.0, mean) for mean in (2, 4, 6))


def _external_load(rng: Generator, moves: Moves) -> HiddenEffect:
    whole = float(moves.t[-1])
    long_s = rng.uniform(0.08, 0.3) * whole
    start_s = rng.uniform(0.05, 0.95) * (whole - long_s)
    edge_s = min(log_uniform(rng, 0.05, 0.5), 0.2 * long_s)
    lean, push = rng.uniform(-0.2, 0.2), bool(rng.random() < 0.35)
    return added.HiddenExternalLoad(start_s, start_s + long_s, edge_s, lean, push)


def _external_loads(moves: Moves) -> Iterator[HiddenEffect]:
    whole = float(moves.t[-1])
    for share in (0.08, 0.12, 0.19, 0.3):
        for start in np.arange(0.0, 1.0 - share, 0.5 * share).tolist():
            yield added.HiddenExternalLoad(start * whole, (start + share) * whole, 0.2, 0.0, False)


def _sensor_drift(rng: Generator, moves: Moves) -> HiddenEffect:
    whole = float(moves.t[-1])
    courses = (
        partial(added.exponential_settling, time_constant_s=whole * log_uniform(rng, 0.1, 0.6)),
        partial(added.root, whole_s=whole),
        partial(added.wander, whole_s=whole, phases=(_angle(rng), _angle(rng), _angle(rng))),
    )
    return added.SensorDrift(courses[rng.integers(len(courses))])


def _sensor_drifts(moves: Moves) -> Iterator[HiddenEffect]:
    whole = float(moves.t[-1])
    for share in (0.1, 0.18, 0.33, 0.6):
        yield added.SensorDrift(partial(added.exponential_settling, time_constant_s=share * whole))
    yield added.SensorDrift(partial(added.root, whole_s=whole))
    quarters = [0.5 * np.pi * i for i in range(4)]
    for phases in product(quarters[:2], quarters, quarters):
        yield added.SensorDrift(partial(added.wander, whole_s=whole, phases=phases))


def _warmup(rng: Generator, moves: Moves) -> HiddenEffect:
    del moves
    cool = float(rng.choice([0.25, 1.0]))
    return changing.HiddenWarmup(log_uniform(rng, 10.0, 200.0), cool, bool(rng.random() < 0.5))


def _warmups(moves: Moves) -> Iterator[HiddenEffect]:
    del moves
    for time_s in np.geomspace(10.0, 200.0, 6).tolist():
        yield from (changing.HiddenWarmup(time_s, cool, False) for cool in (0.25, 1.0))


def _presliding(rng: Generator, moves: Moves) -> HiddenEffect:
    del moves
    return changing.Presliding(log_uniform(rng, 0.005, 0.2), bool(rng.random() < 0.5))


def _preslidings(moves: Moves) -> Iterator[HiddenEffect]:
    del moves
    for length in np.geomspace(0.005, 0.2, 6).tolist():
        yield from (changing.Presliding(length, slips) for slips in (False, True))


def _backlash(rng: Generator, moves: Moves) -> HiddenEffect:
    del moves
    gap, soft = log_uniform(rng, 0.03, 0.5), rng.uniform(0.05, 0.2)
    return changing.Backlash(gap, soft, bool(rng.random() < 0.5))


def _backlashes(moves: Moves) -> Iterator[HiddenEffect]:
    del moves
    for gap in np.geomspace(0.03, 0.5, 9).tolist():
        yield changing.Backlash(gap, 0.1, True)


def _compliance(rng: Generator, moves: Moves) -> HiddenEffect:
    del moves
    second = float(rng.choice([0.0, rng.uniform(0.2, 0.5)]))
    return changing.Compliance(log_uniform(rng, 10.0, 60.0), log_uniform(rng, 0.02, 0.15), second)


def _compliances(moves: Moves) -> Iterator[HiddenEffect]:
    del moves
    for hz in np.geomspace(10.0, 60.0, 9).tolist():
        yield from (changing.Compliance(hz, damping, 0.0) for damping in (0.03, 0.1))


def _gain(rng: Generator, moves: Moves) -> HiddenEffect:
    whole = float(moves.t[-1])
    courses = (
        partial(changing.drifting, whole_s=whole, power=rng.uniform(0.6, 1.6)),
        partial(
            changing.stepping,
            at_s=rng.uniform(0.2, 0.8) * whole,
            wide_s=log_uniform(rng, 0.1, 3.0),
        ),
    )
    return changing.ChangedGain(courses[rng.integers(len(courses))])


def _gains(moves: Moves) -> Iterator[HiddenEffect]:
    whole = float(moves.t[-1])
    for power in (0.6, 1.0, 1.6):
        yield changing.ChangedGain(partial(changing.drifting, whole_s=whole, power=power))
    for share in np.linspace(0.2, 0.8, 9).tolist():
        yield changing.ChangedGain(partial(changing.stepping, at_s=share * whole, wide_s=0.6))


def _lag(rng: Generator, moves: Moves) -> HiddenEffect:
    del moves
    return changing.Lag(_sign(rng))


def _lags(moves: Moves) -> Iterator[HiddenEffect]:
    del moves
    yield from (changing.Lag(sign) for sign in (-1.0, 1.0))


def _saturation(rng: Generator, moves: Moves) -> HiddenEffect:
    del moves
    sides = ((1.0, -1.0), (1.0,), (-1.0,))[rng.integers(3)]
    return changing.Saturation(sides, float(rng.choice([0.0, rng.uniform(0.05, 0.3)])))


def _saturations(moves: Moves) -> Iterator[HiddenEffect]:
    del moves
    for sides in ((1.0, -1.0), (1.0,), (-1.0,)):
        yield changing.Saturation(sides, 0.0)


def _lost_signs(moves: Moves) -> Iterator[HiddenEffect]:
    del moves
    yield changing.LostSign()


def _corner(rng: Generator, moves: Moves) -> HiddenEffect:
    law = partial(
        added.corner,
        at_mm=_inside(rng, moves),
        wide_mm=log_uniform(rng, 15.0, 40.0),
        at_mm_s=log_uniform(rng, 10.0, 100.0),
    )
    return added.OddEffect(law)


def _pump(rng: Generator, moves: Moves) -> HiddenEffect:
    del moves
    return added.OddEffect(partial(added.pump, hz=log_uniform(rng, 0.2, 2.0), phase=_angle(rng)))


def _across(law: Callable[..., Array], rng: Generator, moves: Moves) -> HiddenEffect:
    wide_mm, power = float(np.ptp(moves.y)), rng.uniform(0.7, 2.0)
    return added.OddEffect(partial(law, wide_mm=wide_mm, power=power))


def _product(rng: Generator, moves: Moves) -> HiddenEffect:
    from_mm, mm_s = _inside(rng, moves), log_uniform(rng, 50.0, 200.0)
    return added.OddEffect(partial(added.place_and_speed, from_mm=from_mm, mm_s=mm_s))


def _none(moves: Moves) -> Iterator[HiddenEffect]:
    """A rival of no identifier is right as little as none."""
    del moves
    yield from ()


def _just(make: Callable[[Generator], HiddenEffect]) -> Callable[[Generator, Moves], HiddenEffect]:
    def draw(rng: Generator, moves: Moves) -> HiddenEffect:
        del moves
        return make(rng)

    return draw


FAMILIES = (
    EffectFamily("coulomb", _just(lambda _: CoulombLeftOut()), lambda _: iter((CoulombLeftOut(),))),
    EffectFamily("viscous", _just(lambda _: ViscousLeftOut()), lambda _: iter((ViscousLeftOut(),))),
    EffectFamily("inertia", _just(lambda _: InertiaLeftOut()), lambda _: iter((InertiaLeftOut(),))),
    EffectFamily(
        "gravity",
        _just(lambda rng: WeightLeftOut(_sign(rng))),
        lambda _: iter((WeightLeftOut(1.0),)),
    ),
    EffectFamily("stribeck", _stribeck, _stribecks),
    EffectFamily("asymmetry", _asymmetry, _asymmetries),
    EffectFamily("position_friction", _friction_along, _frictions_along),
    EffectFamily("spring", _spring, _springs),
    EffectFamily("cogging", _cogging, _coggings),
    EffectFamily("cross_coupling", _cross_coupling, _cross_couplings),
    EffectFamily("warmup", _warmup, _warmups),
    EffectFamily("presliding", _presliding, _preslidings),
    EffectFamily("backlash", _backlash, _backlashes),
    EffectFamily("compliance", _compliance, _compliances),
    EffectFamily("external_load", _external_load, _external_loads),
    EffectFamily("gain", _gain, _gains),
    EffectFamily("sensor_drift", _sensor_drift, _sensor_drifts),
    EffectFamily("lag", _lag, _lags),
    EffectFamily("saturation", _saturation, _saturations),
    EffectFamily("lost_sign", _just(lambda _: changing.LostSign()), _lost_signs),
    EffectFamily("outside_corner", _corner, _none),
    EffectFamily("outside_pump", _pump, _none),
    EffectFamily("outside_y_friction", partial(_across, added.friction_across), _none),
    EffectFamily("outside_y_load", partial(_across, added.load_across), _none),
    EffectFamily("outside_product", _product, _none),
)
