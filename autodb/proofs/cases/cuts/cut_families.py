"""Every effect on a table of cuts by its kind: how one is drawn, and all its shapes on a grid."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from autodb.proofs.cases.base.case import Array
from autodb.proofs.cases.base.moves import log_uniform
from autodb.proofs.cases.cuts import cut_effects as cutting
from autodb.proofs.cases.cuts.cut_effects import EVEN, CutEffect, Shares
from autodb.proofs.cases.cuts.cuts import CaseCuts

Generator = np.random.Generator
Clock = Callable[[Array], Array]


@dataclass(frozen=True)
class CutFamily:
    """All effects of one kind; the grid has even shares, each component has a column anyway."""

    kind: str
    draw: Callable[[Generator, CaseCuts], CutEffect]
    grid: Callable[[CaseCuts], Iterator[CutEffect]]


def _shares(rng: Generator) -> Shares:
    """All components change, not alike."""
    x, y, z = rng.uniform(0.5, 1.5, 3)
    return float(x), float(y), float(z)


def _one(rng: Generator) -> Shares:
    """One component changes, either way."""
    at, sign = rng.integers(3), rng.choice([-1.0, 1.0])
    x, y, z = sign * np.eye(3)[at]
    return float(x), float(y), float(z)


def _signed(rng: Generator) -> Shares:
    sign = float(rng.choice([-1.0, 1.0]))
    return (sign, sign, sign)


def _edge_force(rng: Generator, cuts: CaseCuts) -> CutEffect:
    del cuts
    return cutting.EdgeForceLeftOut(_shares(rng))


def _edge_forces(cuts: CaseCuts) -> Iterator[CutEffect]:
    del cuts
    yield cutting.EdgeForceLeftOut(EVEN)


def _size_effect(rng: Generator, cuts: CaseCuts) -> CutEffect:
    del cuts
    law = partial(cutting.thinning, thin_mm=log_uniform(rng, 0.03, 0.12), fades=_coin(rng))
    return cutting.SizeEffect(_shares(rng), law, True)


def _size_effects(cuts: CaseCuts) -> Iterator[CutEffect]:
    del cuts
    for thin in np.geomspace(0.03, 0.12, 4).tolist():
        for fades in (False, True):
            law = partial(cutting.thinning, thin_mm=thin, fades=fades)
            yield cutting.SizeEffect(EVEN, law, True)


def _softening(rng: Generator, cuts: CaseCuts) -> CutEffect:
    del cuts
    wide = float(rng.choice([0.0, rng.uniform(0.3, 1.0)]))
    law = partial(cutting.softer, at_m_min=rng.uniform(110.0, 260.0), wide=wide)
    return cutting.SpeedSoftening(_shares(rng), law, True)


def _softenings(cuts: CaseCuts) -> Iterator[CutEffect]:
    del cuts
    for at in (110.0, 160.0, 210.0, 260.0):
        for wide in (0.0, 0.3, 0.6, 1.0):
            law = partial(cutting.softer, at_m_min=at, wide=wide)
            yield cutting.SpeedSoftening(EVEN, law, True)


def _built_up(rng: Generator, cuts: CaseCuts) -> CutEffect:
    at = float(np.quantile(cuts.speed_m_min, rng.uniform(0.3, 0.7)))
    law = partial(cutting.band, at_m_min=at, wide=rng.uniform(0.12, 0.3), ends=_coin(rng))
    return cutting.BuiltUpEdge(_shares(rng), law, True)


def _built_ups(cuts: CaseCuts) -> Iterator[CutEffect]:
    for at in np.quantile(cuts.speed_m_min, np.linspace(0.3, 0.7, 7)).tolist():
        for wide in (0.12, 0.2, 0.3):
            law = partial(cutting.band, at_m_min=at, wide=wide, ends=True)
            yield cutting.BuiltUpEdge(EVEN, law, True)


def _longest_s(cuts: CaseCuts) -> float:
    return float(np.max(cuts.used_s + cuts.duration_s))


def _wear(rng: Generator, cuts: CaseCuts) -> CutEffect:
    rates = tuple(np.exp(rng.uniform(-0.35, 0.35, 8)).tolist())
    life_s = _longest_s(cuts) / rng.uniform(0.5, 1.2)
    return cutting.ToolWear(_shares(rng), life_s, rates, _coin(rng))


def _wears(cuts: CaseCuts) -> Iterator[CutEffect]:
    """All edges at the same rate."""
    for used in (0.5, 0.85, 1.2):
        for stages in (False, True):
            yield cutting.ToolWear(EVEN, _longest_s(cuts) / used, (1.0,), stages)


def _hard_spot(rng: Generator, cuts: CaseCuts) -> CutEffect:
    n = cuts.t_s.size
    length = max(3, round(rng.uniform(0.05, 0.25) * n))
    first = int(rng.integers(1, n - length + 2))
    return cutting.HardSpot(_shares(rng), first, first + length - 1, _coin(rng))


def _hard_spots(cuts: CaseCuts) -> Iterator[CutEffect]:
    n = cuts.t_s.size
    for share in (0.05, 0.085, 0.15, 0.25):
        length = max(3, round(share * n))
        for first in range(1, n - length + 2, max(1, length // 3)):
            yield cutting.HardSpot(EVEN, first, first + length - 1, False)


def _depth(rng: Generator, cuts: CaseCuts) -> CutEffect:
    del cuts
    return cutting.DepthError(_signed(rng), float(rng.choice([0.0, rng.uniform(-0.1, 0.1)])))


def _depths(cuts: CaseCuts) -> Iterator[CutEffect]:
    del cuts
    yield cutting.DepthError(EVEN, 0.0)


def _nose(rng: Generator, cuts: CaseCuts) -> CutEffect:
    del cuts
    return cutting.NoseRadius(EVEN, rng.uniform(0.5, 1.5), _coin(rng))


def _noses(cuts: CaseCuts) -> Iterator[CutEffect]:
    del cuts
    for depth in (0.5, 0.9, 1.5):
        yield from (cutting.NoseRadius(EVEN, depth, fades) for fades in (False, True))


def _deflection(rng: Generator, cuts: CaseCuts) -> CutEffect:
    del cuts
    half_N = float(rng.choice([0.0, log_uniform(rng, 200.0, 1500.0)]))
    return cutting.Deflection(_shares(rng), half_N)


def _deflections(cuts: CaseCuts) -> Iterator[CutEffect]:
    del cuts
    yield from (cutting.Deflection(EVEN, half_N) for half_N in (0.0, 200.0, 550.0, 1500.0))


def _drift(rng: Generator, cuts: CaseCuts) -> CutEffect:
    del cuts
    clocks: tuple[Clock, ...] = (
        partial(settling_over_time, within=rng.uniform(0.1, 0.6)),
        partial(bent_rise, power=0.5),
        partial(two_slow_waves, phase=rng.uniform(-np.pi, np.pi)),
    )
    return cutting.ForceDrift(_one(rng), clocks[rng.integers(len(clocks))])


def _drifts(cuts: CaseCuts) -> Iterator[CutEffect]:
    del cuts
    clocks: list[Clock] = [
        partial(settling_over_time, within=within) for within in (0.1, 0.25, 0.6)
    ]
    clocks += [partial(bent_rise, power=0.5)]
    clocks += [partial(two_slow_waves, phase=0.25 * np.pi * i) for i in range(8)]
    for clock in clocks:
        yield from (cutting.ForceDrift(shares, clock) for shares in SINGLE)


def _gain(rng: Generator, cuts: CaseCuts) -> CutEffect:
    del cuts
    clocks: tuple[Clock, ...] = (
        partial(bent_rise, power=rng.uniform(0.6, 1.6)),
        partial(step, at=rng.uniform(0.25, 0.75), wide=rng.uniform(0.005, 0.05)),
    )
    return cutting.ForceGain(_one(rng), clocks[rng.integers(len(clocks))])


def _gains(cuts: CaseCuts) -> Iterator[CutEffect]:
    del cuts
    clocks: list[Clock] = [partial(bent_rise, power=power) for power in (0.6, 1.0, 1.6)]
    clocks += [partial(step, at=at, wide=0.02) for at in np.linspace(0.25, 0.75, 9).tolist()]
    for clock in clocks:
        yield from (cutting.ForceGain(shares, clock) for shares in SINGLE)


def settling_over_time(u: Array, *, within: float) -> Array:
    """Exponential settling; u is the share of the time."""
    return -np.expm1(-u / within)


def two_slow_waves(u: Array, *, phase: float) -> Array:
    """Two slow waves."""
    wave: Array = np.sin(np.pi * u + phase) + 0.6 * np.sin(2.6 * np.pi * u + 2.0 * phase)
    return 0.6 * wave


def bent_rise(u: Array, *, power: float) -> Array:
    """From 0 to 1, bent."""
    return np.asarray(u**power, dtype=np.float64)


def step(u: Array, *, at: float, wide: float) -> Array:
    """A smooth step."""
    return 0.5 + 0.5 * np.tanh((u - at) / wide)


SINGLE: tuple[Shares, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def _coin(rng: Generator) -> bool:
    return bool(rng.random() < 0.5)


def _whip(rng: Generator, cuts: CaseCuts) -> CutEffect:
    del cuts
    return cutting.OutlyingCuts(
        _shares(rng), partial(cutting.whip, power=rng.uniform(1.5, 3.0)), False
    )


def _by_hour(rng: Generator, cuts: CaseCuts) -> CutEffect:
    period_s = float(cuts.t_s[-1]) / rng.uniform(3.0, 9.0)
    phase = rng.uniform(-np.pi, np.pi)
    law = partial(cutting.by_hour, period_s=period_s, phase=phase)
    return cutting.OutlyingCuts(_shares(rng), law, False)


def _by_turns(rng: Generator, cuts: CaseCuts) -> CutEffect:
    del cuts
    law = partial(cutting.by_turns, every=int(rng.integers(2, 4)))
    return cutting.OutlyingCuts(_shares(rng), law, False)


def _none(cuts: CaseCuts) -> Iterator[CutEffect]:
    """A rival of no identifier is right as little as none."""
    del cuts
    yield from ()


CUT_FAMILIES = (
    CutFamily("edge_force", _edge_force, _edge_forces),
    CutFamily("size_effect", _size_effect, _size_effects),
    CutFamily("speed_softening", _softening, _softenings),
    CutFamily("built_up_edge", _built_up, _built_ups),
    CutFamily("tool_wear", _wear, _wears),
    CutFamily("hard_spot", _hard_spot, _hard_spots),
    CutFamily("depth_error", _depth, _depths),
    CutFamily("nose_radius", _nose, _noses),
    CutFamily("deflection", _deflection, _deflections),
    CutFamily("sensor_drift", _drift, _drifts),
    CutFamily("gain", _gain, _gains),
    CutFamily("outside_whip", _whip, _none),
    CutFamily("outside_hours", _by_hour, _none),
    CutFamily("outside_turns", _by_turns, _none),
)
