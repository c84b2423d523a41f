"""Recordings of a feed axis with hidden effects, each of a size that shows as clearly as wanted."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from autodb.proofs.cases.axis.axis_families import FAMILIES
from autodb.proofs.cases.axis.effect import CaseWorld
from autodb.proofs.cases.axis.machine import draw_disturbance, draw_machine
from autodb.proofs.cases.base.build import TUNINGS, recorded_whole, simulated, sized, stacked
from autodb.proofs.cases.base.case import Case, Rival, Yardstick
from autodb.proofs.cases.base.disturbance import ChannelNoise
from autodb.proofs.cases.base.moves import Array, draw_moves, log_uniform

EFFORT = "x.current"
AXIS_KINDS = tuple(family.kind for family in FAMILIES)


def draw_axis_case(seed: int, kinds: Sequence[str], wanted: float, *, family: int) -> Case:
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
    world = CaseWorld(machine, moves)
    weighs = [effect.on(world, 1.0).machine.weighs for effect in drawn]
    world = world.of(weighs=any((machine.weighs, *weighs)))
    left_out = {effect.term for effect in drawn if effect.own}
    own = {term: part for term, part in world.parts.items() if term not in left_out}
    columns = np.array(list(own.values()))
    yardstick = Yardstick.beside(columns, noise.whitened)
    world, effects = sized(world, drawn, yardstick, wanted)

    # Truth and record
    truth, hidden = stacked(world, effects)
    disturbed = noise.draw(noisy, moves.t.size)
    measured = recorded_whole(world, effects, disturbed)
    measured = np.round(measured / step_A) * step_A if step_A else measured
    included = np.array([world.parts[term] for term in own])
    tuning = str(kept.choice(TUNINGS))
    simulation = simulated(kept, included, columns, measured, tuning)

    stretches = [effect.interval(world) for effect in drawn]
    return Case(
        seed=seed,
        kind="+".join(kinds) or "nothing",
        wanted=wanted,
        reached=all(one.clarity > 0.99 * wanted and np.any(one.part) for one in hidden),
        tuning=tuning,
        channels={**_channels(kept, world), EFFORT: measured},
        simulation={"t": moves.t, EFFORT: simulation},
        includes=tuple(own),
        explained=(EFFORT,),
        hidden=hidden,
        interval=next((stretch for stretch in stretches if stretch), None),
        measured=measured,
        simulated=simulation,
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


def _with_rounding(noise: ChannelNoise, rng: np.random.Generator) -> tuple[ChannelNoise, float]:
    """On every fifth the current is rounded: to at most the noise' sd, which gains step^2/12."""
    if rng.random() > 0.2:
        return noise, 0.0
    step = min(log_uniform(rng, 0.005, 0.02), float(np.hypot(noise.slow, noise.white)))
    return replace(noise, white=float(np.hypot(noise.white, step / np.sqrt(12.0)))), step


def _channels(rng: np.random.Generator, world: CaseWorld) -> dict[str, Array]:
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


def _rivals(world: CaseWorld) -> Iterator[Rival]:
    """Every effect at every shape of its grid, on this machine."""
    for family in FAMILIES:
        for effect in family.grid(world.moves):
            yield Rival(effect.term, effect.columns(world, world.base))
