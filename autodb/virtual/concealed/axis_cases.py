"""Recordings of a feed axis with hidden effects, each of a size that shows as clearly as wanted."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from autodb.virtual.concealed.axis_families import FAMILIES
from autodb.virtual.concealed.case import Case, Hidden, Rival, Yardstick, size_for
from autodb.virtual.concealed.disturbance import Disturbance
from autodb.virtual.concealed.effect import Effect, LeftOut, World
from autodb.virtual.concealed.machine import draw_disturbance, draw_machine
from autodb.virtual.concealed.moves import Array, draw_moves, log_uniform

EFFORT = "x.current"
AXIS_KINDS = tuple(family.kind for family in FAMILIES)
MISTUNED = (0.01, 0.06)
TUNINGS = ("true", "true", "mistuned", "refitted")


@dataclass(frozen=True)
class Sized:
    """An effect with its size, and how clearly it shows at that size."""

    effect: Effect
    size: float
    clarity: float


def draw_axis(seed: int, kinds: Sequence[str], wanted: float, *, family: int) -> Case:
    """The case of a seed: these kinds of AXIS_KINDS hidden, each with clarity ``wanted``.

    Moves, machine, effects, noise and record have streams of their own; families of seeds have
    nothing in common. The same arguments give the same bytes.
    """
    moving, made, shaped, noisy, kept = (
        np.random.default_rng([family, seed, stream]) for stream in range(31, 36)
    )
    moves = draw_moves(moving, _seconds(moving))
    machine = draw_machine(made)
    noise, step_A = _with_rounding(draw_disturbance(made, machine.scale_A), kept)
    drawn = [one.draw(shaped, moves) for kind in kinds for one in FAMILIES if one.kind == kind]

    # Own columns of what is included, whatever sizes the effects give it
    world = World(machine, moves)
    weighs = [effect.on(world, 1.0).weighs for effect in drawn]
    world = World(replace(machine, weighs=any((machine.weighs, *weighs))), moves)
    left_out = {effect.term for effect in drawn if isinstance(effect, LeftOut)}
    own = {term: part for term, part in world.parts.items() if term not in left_out}
    columns = np.array(list(own.values()))
    yardstick = Yardstick.beside(columns, noise.whitened)
    world, sized = _sized(world, drawn, yardstick, wanted)

    # Truth and record
    truth, hidden = _stacked(world, sized)
    disturbed = noise.draw(noisy, moves.t.size)
    measured = _recorded(world, sized, disturbed)
    measured = np.round(measured / step_A) * step_A if step_A else measured
    included = np.array([world.parts[term] for term in own])
    tuning = str(kept.choice(TUNINGS))
    simulated = _simulated(kept, included, columns, measured, tuning)

    stretches = [effect.interval_s() for effect in drawn]
    return Case(
        seed=seed,
        kind="+".join(kinds) or "nothing",
        wanted=wanted,
        reached=all(one.clarity > 0.99 * wanted for one in sized),
        tuning=tuning,
        channels={**_channels(kept, world), EFFORT: measured},
        simulation={"t": moves.t, EFFORT: simulated},
        includes=tuple(own),
        explained=(EFFORT,),
        hidden=hidden,
        interval=next((stretch for stretch in stretches if stretch), None),
        measured=measured,
        simulated=simulated,
        truth=truth,
        own=columns,
        whitened=noise.whitened,
        rivals=lambda: _rivals(world),
    )


def _seconds(rng: np.random.Generator) -> float:
    """One to two and a half minutes; of 100 some twelve are short, and one takes 20 minutes."""
    return float(
        rng.choice([rng.uniform(60, 150), rng.uniform(10, 30), 1200.0], p=[0.87, 0.12, 0.01])
    )


def _with_rounding(noise: Disturbance, rng: np.random.Generator) -> tuple[Disturbance, float]:
    """On every fifth the current is rounded: to at most the noise' sd, which gains step^2/12."""
    if rng.random() > 0.2:
        return noise, 0.0
    step = min(log_uniform(rng, 0.005, 0.02), float(np.hypot(noise.slow, noise.white)))
    return replace(noise, white=float(np.hypot(noise.white, step / np.sqrt(12.0)))), step


def _sized(
    world: World, effects: Sequence[Effect], yardstick: Yardstick, wanted: float
) -> tuple[World, list[Sized]]:
    """Size each effect alone on the machine, one after the other as each changes the machine."""
    sized = []
    for effect in sorted(effects, key=lambda one: (not isinstance(one, LeftOut), -one.stage)):

        def clarity(size: float, effect: Effect = effect, world: World = world) -> float:
            changed = World(effect.on(world, size), world.moves)
            return yardstick.clarity(effect.part(changed, changed.base, size))

        size = size_for(clarity, wanted, most=effect.most(world.machine))
        sized.append(Sized(effect, size, clarity(size)))
        world = World(effect.on(world, size), world.moves)
    return world, sorted(sized, key=lambda one: (one.effect.on_noise, one.effect.stage))


def _stacked(world: World, sized: Sequence[Sized]) -> tuple[Array, tuple[Hidden, ...]]:
    """The whole without noise, and what each effect adds to that of those before it."""
    own = [one.effect.term for one in sized if isinstance(one.effect, LeftOut)]
    total = world.base - np.sum([world.parts[term] for term in own], axis=0)
    hidden = []
    for one in sized:
        before = world.base if isinstance(one.effect, LeftOut) else total
        part = one.effect.part(world, before, one.size)
        total = total + part
        hidden.append(Hidden(one.effect.term, one.size, one.clarity, part))
    return np.asarray(total, dtype=np.float64), tuple(hidden)


def _recorded(world: World, sized: Sequence[Sized], noise: Array) -> Array:
    """The whole with noise: what acts on the record acts on the noise too."""
    before = [one for one in sized if not one.effect.on_noise]
    measured = _stacked(world, before)[0] + noise
    for one in sized:
        if one.effect.on_noise:
            measured = measured + one.effect.part(world, measured, one.size)
    return measured


def _simulated(
    rng: np.random.Generator, included: Array, columns: Array, measured: Array, tuning: str
) -> Array:
    """The included terms as they are, one of them wrong by MISTUNED, or fitted to the recording."""
    factors = np.ones(len(included))
    if tuning == "mistuned":
        factors[rng.integers(factors.size)] += rng.choice([-1.0, 1.0]) * rng.uniform(*MISTUNED)
    if tuning == "refitted":
        scale = np.max(np.abs(columns), axis=1)
        fitted = np.linalg.lstsq((columns / scale[:, None]).T, measured, rcond=None)[0]
        return np.asarray((fitted / scale) @ columns, dtype=np.float64)
    return np.asarray(factors @ included, dtype=np.float64)


def _channels(rng: np.random.Generator, world: World) -> dict[str, Array]:
    """Time and moves; on every fifth velocity and acceleration are absent, on every fourth
    position is rounded to 1 or 0.1 um."""
    moves = world.moves
    step_mm = float(rng.choice([0.001, 0.0001])) if rng.random() < 0.25 else 0.0
    x, y = (np.round(p / step_mm) * step_mm if step_mm else p for p in (moves.x, moves.y))
    channels = {"t": moves.t, "x.position": x, "y.position": y}
    if rng.random() < 0.2:
        return channels
    return {
        **channels,
        "x.velocity": moves.v,
        "x.acceleration": moves.a,
        "y.velocity": moves.y_v,
        "y.acceleration": moves.y_a,
    }


def _rivals(world: World) -> Iterator[Rival]:
    """Every effect at every shape of its grid, on this machine."""
    for family in FAMILIES:
        for effect in family.grid(world.moves):
            yield Rival(effect.term, effect.columns(world, world.base))
