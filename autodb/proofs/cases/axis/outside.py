"""Axes that do what no identifier stands for, and axes that do not: to tell what is mistuned.

Every odd seed hides physics outside the vocabulary, of five kinds in turn: drag, friction that
begins at a speed, friction that saturates with speed, hysteresis over millimetres, the load of
another axis. Every even one hides a term of the vocabulary, or nothing.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from autodb.proofs.cases.axis.added_effects import OddEffect, friction_across, load_across
from autodb.proofs.cases.axis.axis_families import FAMILIES
from autodb.proofs.cases.axis.effect import CaseWorld, HiddenEffect
from autodb.proofs.cases.axis.machine import draw_disturbance, draw_machine
from autodb.proofs.cases.base.build import TUNINGS, recorded_whole, simulated, sized, stacked
from autodb.proofs.cases.base.case import Yardstick
from autodb.proofs.cases.base.moves import Array, Moves, draw_moves, log_uniform

Generator = np.random.Generator

FAMILY = 4
"""Family of seeds, which no other cases share."""
CLARITIES = (20.0, 8.0, 60.0)
INSIDE = (
    "coulomb", "viscous", "inertia", "gravity", "stribeck", "asymmetry", "position_friction",
    "spring", "cogging", "",
)  # fmt: skip
"""What even seeds hide; the last of them nothing."""


@dataclass(frozen=True)
class Outside:
    """A recording of an axis, its simulation, and the truth of both.

    ``factors``: by which the simulation's own terms, by identifier, are off their true size;
    ``terms``: names that are right, `unknown` for what no identifier stands for.
    """

    seed: int
    kind: str
    wanted: float
    reached: bool
    tuning: str
    channels: dict[str, Array]
    simulation: dict[str, Array]
    includes: tuple[str, ...]
    terms: frozenset[str]
    factors: dict[str, float]
    truth: Array


def drag(world: CaseWorld, *, power: float, mm_s: float) -> Array:
    """Drag of oil or air: it rises faster than the speed."""
    friction: Array = world.way * (np.abs(world.moves.v) / mm_s) ** power
    return friction


def from_speed_on(world: CaseWorld, *, mm_s: float) -> Array:
    """Friction of something that only drags above a speed."""
    friction: Array = world.way * np.maximum(np.abs(world.moves.v) / mm_s - 1.0, 0.0)
    return friction


def saturating(world: CaseWorld, *, mm_s: float) -> Array:
    """Friction that rises with speed and then no more."""
    friction: Array = world.way * np.tanh(np.abs(world.moves.v) / mm_s)
    return friction


def hysteresis(world: CaseWorld, *, length_mm: float) -> Array:
    """A load that winds up over millimetres of travel and down again (Dahl 1968)."""
    way, load = np.diff(world.moves.x, prepend=world.moves.x[0]), np.zeros(len(world.moves.x))
    for k in range(1, len(load)):
        turned = load[k - 1] + way[k] / length_mm - load[k - 1] * abs(way[k]) / length_mm
        load[k] = np.clip(turned, -1.0, 1.0)
    return load


def _drag(rng: Generator, moves: Moves) -> HiddenEffect:
    top = float(np.max(np.abs(moves.v)))
    return OddEffect(partial(drag, power=float(rng.uniform(1.6, 2.6)), mm_s=top))


def _from_speed_on(rng: Generator, moves: Moves) -> HiddenEffect:
    top = float(np.max(np.abs(moves.v)))
    return OddEffect(partial(from_speed_on, mm_s=float(rng.uniform(0.2, 0.6)) * top))


def _saturating(rng: Generator, moves: Moves) -> HiddenEffect:
    del moves
    return OddEffect(partial(saturating, mm_s=log_uniform(rng, 20.0, 120.0)))


def _hysteresis(rng: Generator, moves: Moves) -> HiddenEffect:
    del moves
    return OddEffect(partial(hysteresis, length_mm=log_uniform(rng, 2.0, 30.0)))


def _another_axis(rng: Generator, moves: Moves) -> HiddenEffect:
    law = (friction_across, load_across)[rng.integers(2)]
    wide_mm, power = float(np.ptp(moves.y)), float(rng.uniform(0.7, 2.0))
    return OddEffect(partial(law, wide_mm=wide_mm, power=power))


OUTSIDE: dict[str, Callable[[Generator, Moves], HiddenEffect]] = {
    "drag": _drag,
    "from a speed on": _from_speed_on,
    "saturating friction": _saturating,
    "hysteresis": _hysteresis,
    "another axis": _another_axis,
}


ALSO = {"hysteresis": ("presliding",)}
"""Names that are right as well: Dahl's law is that of pre-sliding, over a longer way."""


def hidden_kind(seed: int) -> str:
    """Return what a seed hides; nothing said is nothing hidden."""
    turn, even = divmod(seed - 1, 2)
    return INSIDE[turn % len(INSIDE)] if even else list(OUTSIDE)[turn % len(OUTSIDE)]


def draw_outside(seed: int) -> Outside:
    """Return the case of a seed, 1, 2, …; the same bytes each time."""
    moving, made, shaped, noisy, kept = (
        np.random.default_rng([FAMILY, seed, stream]) for stream in range(31, 36)
    )
    kind, wanted = hidden_kind(seed), CLARITIES[(seed - 1) // 2 % len(CLARITIES)]
    moves = draw_moves(moving, float(moving.uniform(40.0, 90.0)))
    machine = draw_machine(made)
    noise = draw_disturbance(made, machine.scale_A)
    world = CaseWorld(machine, moves)
    hidden = [OUTSIDE[kind](shaped, moves)] if kind in OUTSIDE else []
    hidden += [one.draw(shaped, moves) for one in FAMILIES if one.kind == kind]

    # What the simulation includes, and how clearly the effect is to show beside it
    weighs = [effect.on(world, 1.0).machine.weighs for effect in hidden]
    world = world.of(weighs=any((machine.weighs, *weighs)))
    lacks = {effect.term for effect in hidden if effect.own}
    names = [term for term in world.parts if term not in lacks]
    columns = np.array([world.parts[term] for term in names])
    world, effects = sized(world, hidden, Yardstick.beside(columns, noise.whitened), wanted)

    # Truth, record and simulation
    truth, parts = stacked(world, effects)
    measured = recorded_whole(world, effects, noise.draw(noisy, moves.t.size))
    included = np.array([world.parts[term] for term in names])
    tuning = str(kept.choice(TUNINGS))
    simulation = simulated(kept, included, columns, measured, tuning)
    return Outside(
        seed=seed,
        kind=kind or "nothing",
        wanted=wanted,
        reached=all(one.clarity > 0.99 * wanted and np.any(one.part) for one in parts),
        tuning=tuning,
        channels=_channels(moves, measured),
        simulation={"t": moves.t, "x.current": simulation},
        includes=tuple(names),
        terms=frozenset((*(one.term for one in parts), *ALSO.get(kind, ()))),
        factors=_factors(dict(zip(names, included, strict=True)), simulation),
        truth=truth,
    )


def _channels(moves: Moves, measured: Array) -> dict[str, Array]:
    return {
        "t": moves.t,
        "x.position": moves.x,
        "y.position": moves.y,
        "x.velocity": moves.v,
        "x.acceleration": moves.a,
        "y.velocity": moves.y_v,
        "y.acceleration": moves.y_a,
        "x.current": measured,
    }


def _factors(parts: dict[str, Array], simulation: Array) -> dict[str, float]:
    """Return by which each own term of a simulation is off; a simulation is made of these."""
    matrix = np.array(list(parts.values())).T
    scale = np.maximum(np.max(np.abs(matrix), axis=0), 1e-300)
    found = np.linalg.lstsq(matrix / scale, simulation, rcond=None)[0] / scale
    return dict(zip(parts, found.tolist(), strict=True))
