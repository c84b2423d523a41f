"""Every effect on a milled waveform by its kind: how one is drawn, and all its shapes on a grid."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from autodb.proofs.cases.base.case import Array
from autodb.proofs.cases.base.moves import log_uniform
from autodb.proofs.cases.mill import mill_effects as milled
from autodb.proofs.cases.mill import mill_table_effects as on_table
from autodb.proofs.cases.mill.mill_effects import MillEffect, Three
from autodb.proofs.cases.mill.milling import MillWorld

Generator = np.random.Generator
EVEN: Three = (1.0, 1.0, 1.0)
APART = 0.15
"""A tone is this share of the spindle's frequency away from its multiples, once folded or not."""


@dataclass(frozen=True)
class MillFamily:
    """All effects of one kind; ``tilts``: it shows on a tilted table only."""

    kind: str
    draw: Callable[[Generator, MillWorld], MillEffect]
    grid: Callable[[MillWorld], Iterator[MillEffect]]
    tilts: bool = False


def _shares(rng: Generator) -> Three:
    """Tangential, radial, axial, not alike; axial a little."""
    return float(rng.uniform(0.7, 1.3)), float(rng.uniform(0.7, 1.8)), float(rng.uniform(0.0, 0.3))


def _of_some(rng: Generator) -> Three:
    """One component, or all unlike, either way."""
    signs = rng.choice([-1.0, 1.0], 3)
    kept = np.eye(3)[rng.integers(3)] if rng.random() < 0.5 else rng.uniform(0.3, 1.0, 3)
    x, y, z = signs * kept
    return float(x), float(y), float(z)


def _edge(rng: Generator, world: MillWorld) -> MillEffect:
    del world
    return milled.EdgeOfMillLeftOut(_shares(rng))


def _edges(world: MillWorld) -> Iterator[MillEffect]:
    del world
    yield milled.EdgeOfMillLeftOut(EVEN)


def _run_out(rng: Generator, world: MillWorld) -> MillEffect:
    teeth = world.cut.teeth
    if rng.random() < 0.75:
        off = rng.uniform(0.0, 2.0 * np.pi)
        shape = np.cos(off - 2.0 * np.pi * np.arange(teeth) / teeth)
    else:
        shape = -1.0 * (np.arange(teeth) == rng.integers(teeth))
    return milled.RunOut(tuple((shape / np.max(np.abs(shape))).tolist()))


def _run_outs(world: MillWorld) -> Iterator[MillEffect]:
    """Each tooth out or in by itself: all there is comes near a sum of them."""
    for tooth in range(world.cut.teeth):
        for sign in (1.0, -1.0):
            yield milled.RunOut(tuple((sign * np.eye(world.cut.teeth)[tooth]).tolist()))
    for off in np.linspace(0.0, 2.0 * np.pi, 13)[:-1]:
        shape = np.cos(off - 2.0 * np.pi * np.arange(world.cut.teeth) / world.cut.teeth)
        yield milled.RunOut(tuple((shape / np.max(np.abs(shape))).tolist()))


def _thin(rng: Generator, world: MillWorld) -> MillEffect:
    del world
    return milled.ThinChips(log_uniform(rng, 0.01, 0.05), _coin(rng))


def _thins(world: MillWorld) -> Iterator[MillEffect]:
    del world
    for thin in np.geomspace(0.01, 0.05, 4).tolist():
        for fades in (False, True):
            yield milled.ThinChips(thin, fades)


def _deeper(rng: Generator, world: MillWorld) -> MillEffect:
    del world
    return milled.DeeperCut(float(rng.choice([-1.0, 1.0])))


def _deepers(world: MillWorld) -> Iterator[MillEffect]:
    del world
    for sign in (1.0, -1.0):
        yield milled.DeeperCut(sign)


def _wear(rng: Generator, world: MillWorld) -> MillEffect:
    del world
    return milled.WearWithin(_shares(rng), float(rng.choice([0.0, rng.uniform(0.2, 0.8)])))


def _wears(world: MillWorld) -> Iterator[MillEffect]:
    del world
    for bent in (0.0, 0.4, 0.8):
        yield milled.WearWithin(EVEN, bent)


def _hard(rng: Generator, world: MillWorld) -> MillEffect:
    cut = world.cut
    whole = cut.end_s - cut.begin_s
    length = rng.uniform(0.06, 0.3) * whole
    first = float(rng.uniform(cut.begin_s + 0.05 * whole, cut.end_s - 0.05 * whole - length))
    between = (first, first + float(length))
    share = partial(milled.within_stretch, between=between, soft=rng.uniform(0.05, 0.4))
    return milled.HardStretch(share, between)


def _hards(world: MillWorld) -> Iterator[MillEffect]:
    cut = world.cut
    ends = np.linspace(cut.begin_s, cut.end_s, 9)
    for first, last in ((a, b) for a in ends for b in ends if 0.0 < b - a < 0.5 * (ends[-1] - a)):
        between = (float(first), float(last))
        yield milled.HardStretch(partial(milled.within_stretch, between=between, soft=0.2), between)


def _gives(rng: Generator, world: MillWorld) -> MillEffect:
    del world
    half = float(rng.choice([0.0, rng.uniform(0.3, 1.0)]))
    return milled.GivesWay(partial(milled.giving_way, half=half))


def _give(world: MillWorld) -> Iterator[MillEffect]:
    del world
    for half in (0.0, 0.5, 1.0):
        yield milled.GivesWay(partial(milled.giving_way, half=half))


def _chatter(rng: Generator, world: MillWorld) -> MillEffect:
    """A tone of 300 to 2500 Hz, above half the rate seen folded, off the spindle's multiples."""
    rate_Hz = 1.0 / float(world.cut.t_s[1] - world.cut.t_s[0])
    turns_Hz = world.cut.speed_rpm / 60.0
    while True:
        tone = log_uniform(rng, 300.0, 2500.0)
        seen = abs(tone - rate_Hz * round(tone / rate_Hz))
        multiples = np.arange(1, 1 + int(rate_Hz / turns_Hz)) * turns_Hz
        folded = np.abs(multiples - rate_Hz * np.round(multiples / rate_Hz))
        near = np.min(np.abs(folded - seen))
        if near > APART * turns_Hz and seen > 50.0:
            break
    knots = np.cumsum(rng.normal(0.0, rng.uniform(0.1, 1.0), 16))
    ways = rng.uniform(0.3, 1.0, 3) * np.exp(1j * rng.uniform(0.0, 2.0 * np.pi, 3))
    x, y, z = ways * [1.0, 1.0, 0.3] / np.max(np.abs(ways[:2]))
    wandering = partial(_wandering, knots=tuple(knots.tolist()), end=float(world.cut.t_s[-1]))
    return milled.Chatter(
        tone, wandering, float(rng.uniform(0.0, 0.8)), (complex(x), complex(y), complex(z))
    )


def _wandering(t_s: Array, *, knots: tuple[float, ...], end: float) -> Array:
    from scipy.interpolate import CubicSpline

    places = np.linspace(0.0, end, len(knots))
    return np.asarray(CubicSpline(places, knots)(t_s), dtype=np.float64)


def _still(t_s: Array) -> Array:
    return np.zeros_like(t_s)


def _chatters(world: MillWorld) -> Iterator[MillEffect]:
    """Tones all over: none is near a hidden one, which the oracle is given itself."""
    del world
    for tone in np.geomspace(300.0, 2500.0, 12).tolist():
        yield milled.Chatter(tone, _still, 0.4, (1.0, 1.0, 1.0))


def _drift(rng: Generator, world: MillWorld) -> MillEffect:
    del world
    return milled.LinkDrift(_of_some(rng), partial(_over_time, clock=_clock(rng)))


def _clock(rng: Generator) -> Callable[[Array], Array]:
    """A course of time from 0 to about 1: straight, bent, or rising to a level."""
    kind = rng.integers(3)
    if kind == 0:
        return partial(_bent, power=1.0)
    if kind == 1:
        return partial(_bent, power=float(rng.uniform(1.3, 2.5)))
    return partial(_levels, share=float(rng.uniform(0.15, 0.6)))


def _bent(u: Array, *, power: float) -> Array:
    return np.asarray(u**power)


def _levels(u: Array, *, share: float) -> Array:
    return -np.expm1(-u / share)


def _over_time(world: MillWorld, *, clock: Callable[[Array], Array]) -> Array:
    return clock(world.cut.t_s / world.cut.t_s[-1])


def _clocks() -> Iterator[Callable[[Array], Array]]:
    for power in (1.0, 1.6, 2.4):
        yield partial(_bent, power=power)
    for share in (0.15, 0.3, 0.6):
        yield partial(_levels, share=share)


def _drifts(world: MillWorld) -> Iterator[MillEffect]:
    del world
    for clock in _clocks():
        yield milled.LinkDrift(EVEN, partial(_over_time, clock=clock))


def _heat(rng: Generator, world: MillWorld) -> MillEffect:
    seconds = rng.uniform(0.15, 1.0) * (world.cut.end_s - world.cut.begin_s)
    x, y, z = rng.uniform(0.1, 0.4), rng.uniform(0.1, 0.4), 1.0
    sign = float(rng.choice([-1.0, 1.0]))
    shares = (sign * float(x), -sign * float(y), sign * z)
    return milled.ChipHeat(shares, partial(milled.warming_in_work, seconds=float(seconds)))


def _heats(world: MillWorld) -> Iterator[MillEffect]:
    for share in (0.15, 0.3, 0.6, 1.0):
        seconds = share * (world.cut.end_s - world.cut.begin_s)
        yield milled.ChipHeat(EVEN, partial(milled.warming_in_work, seconds=seconds))


def _weighs(rng: Generator, world: MillWorld) -> MillEffect:
    del rng, world
    return on_table.Weighs()


def _weights(world: MillWorld) -> Iterator[MillEffect]:
    if np.any(world.cut.a_rad):
        yield on_table.Weighs()


def _swings(rng: Generator, world: MillWorld) -> MillEffect:
    del world
    x, y, z = rng.choice([-1.0, 1.0], 3) * rng.uniform(0.05, 0.25, 3)
    return on_table.Swings((float(x), float(y), float(z)))


def _swung(world: MillWorld) -> Iterator[MillEffect]:
    if np.any(world.cut.a_rad) or np.any(world.cut.c_rad):
        yield on_table.Swings(EVEN)


def _gain(rng: Generator, world: MillWorld) -> MillEffect:
    """Another constant from the first row on, or one that changes."""
    del world
    at, sign = rng.integers(3), float(rng.choice([-1.0, 1.0]))
    x, y, z = sign * np.eye(3)[at]
    return milled.LinkGain((float(x), float(y), float(z)), _even if _coin(rng) else _clock(rng))


def _even(u: Array) -> Array:
    return np.ones_like(u)


def _gains(world: MillWorld) -> Iterator[MillEffect]:
    del world
    for clock in (_even, *_clocks()):
        for x, y, z in np.eye(3):
            yield milled.LinkGain((float(x), float(y), float(z)), clock)


def _crossed(rng: Generator, world: MillWorld) -> MillEffect:
    """One pair of components, both ways, or all."""
    del world
    shares = rng.uniform(-1.0, 1.0, 6)
    if rng.random() < 0.5:
        kept = [(0, 2), (1, 4), (3, 5)][rng.integers(3)]
        shares = np.where(np.isin(np.arange(6), kept), shares, 0.0)
    return milled.CrossTalk(tuple((shares / np.max(np.abs(shares))).tolist()))


def _crosses(world: MillWorld) -> Iterator[MillEffect]:
    del world
    yield milled.CrossTalk((1.0,) * 6)


def _outside(rng: Generator, world: MillWorld) -> MillEffect:
    """Bands in the work, or a hum of the mains."""
    cut = world.cut
    if _coin(rng):
        way = cut.feed_mm_s * (cut.end_s - cut.begin_s)
        period = way / rng.uniform(4.0, 15.0)
        phase = float(rng.uniform(0.0, 2.0 * np.pi))
        return milled.Banded(partial(milled.bands, period_mm=float(period), phase=phase))
    phase = float(rng.uniform(0.0, 2.0 * np.pi))
    return milled.Hum(_of_some(rng), partial(_mains, phase=phase))


def _mains(world: MillWorld, *, phase: float) -> Array:
    angle = 2.0 * np.pi * 50.0 * world.cut.t_s + phase
    return np.asarray(np.sin(angle) + 0.4 * np.sin(3.0 * angle))


def _outsides(world: MillWorld) -> Iterator[MillEffect]:
    cut = world.cut
    way = cut.feed_mm_s * (cut.end_s - cut.begin_s)
    for count in np.linspace(4.0, 15.0, 12).tolist():
        for phase in (0.0, 0.5 * np.pi):
            yield milled.Banded(partial(milled.bands, period_mm=way / count, phase=phase))
    for phase in (0.0, 0.5 * np.pi):
        yield milled.Hum(EVEN, partial(_mains, phase=phase))


def _coin(rng: Generator) -> bool:
    return bool(rng.random() < 0.5)


MILL_FAMILIES = (
    MillFamily("edge_force", _edge, _edges),
    MillFamily("runout", _run_out, _run_outs),
    MillFamily("size_effect", _thin, _thins),
    MillFamily("depth_error", _deeper, _deepers),
    MillFamily("tool_wear", _wear, _wears),
    MillFamily("hard_spot", _hard, _hards),
    MillFamily("deflection", _gives, _give),
    MillFamily("chatter", _chatter, _chatters),
    MillFamily("sensor_drift", _drift, _drifts),
    MillFamily("thermal_drift", _heat, _heats),
    MillFamily("table_gravity", _weighs, _weights, tilts=True),
    MillFamily("table_inertia", _swings, _swung, tilts=True),
    MillFamily("gain", _gain, _gains),
    MillFamily("crosstalk", _crossed, _crosses),
    MillFamily("outside", _outside, _outsides),
)
MILL_KINDS = tuple(family.kind for family in MILL_FAMILIES)
