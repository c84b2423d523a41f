"""What an effect is, of a feed axis or of a table of cuts, and how effects make a recording.

A world is what effects act on: a machine and its moves, or cuts. Arrays end in samples (n,).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Generic, Protocol, TypeVar

import numpy as np

from autodb.proofs.cases.base.case import Array, Hidden, Yardstick, size_for

MISTUNED = (0.01, 0.06)
TUNINGS = ("true", "true", "mistuned", "refitted")


class Acted(Protocol):
    """A world: contributions of its own terms, by their identifiers, and their sum."""

    @property
    def parts(self) -> dict[str, Array]:
        """Contributions (..., n)."""

    @property
    def base(self) -> Array:
        """Their sum."""


W = TypeVar("W", bound=Acted)


@dataclass(frozen=True)
class Hidable(Generic[W]):
    """One effect of one shape. Its part follows from its size, and what there is before it.

    ``term``: identifier; ``stage``: contributions 0, changes of friction 1, of the whole 2, of the
    record 3, which act in this order; ``own``: it is a term of the world that the simulation lacks;
    ``on_noise``: what it does it does to the noise too.
    """

    term: ClassVar[str]
    stage: ClassVar[int] = 0
    own: ClassVar[bool] = False

    @property
    def on_noise(self) -> bool:
        """Noise comes after it, but for what acts on the record."""
        return False

    def most(self, world: W) -> float:
        """Return the largest size that is still physical."""
        raise NotImplementedError

    def on(self, world: W, size: float) -> W:
        """Return the world itself, changed only by an effect whose size lies in it."""
        del size
        return world

    def columns(self, world: W, total: Array) -> Array:
        """Return columns (k, ..., n) that span what it adds at any size."""
        raise NotImplementedError

    def part(self, world: W, total: Array, size: float) -> Array:
        """Return what it adds to the total (..., n) before it: size times its only column."""
        (column,) = self.columns(world, total)
        part: Array = size * column
        return part

    def interval(self, world: W) -> tuple[float, float] | None:
        """Return the stretch in which it acts, of an effect that has one."""
        del world
        return None


@dataclass(frozen=True)
class Sized(Generic[W]):
    """An effect with its size, and how clearly it shows at that size."""

    effect: Hidable[W]
    size: float
    clarity: float


def sized(
    world: W, effects: Sequence[Hidable[W]], yardstick: Yardstick, wanted: float
) -> tuple[W, list[Sized[W]]]:
    """Size each effect alone on its world, one after the other as each changes the world.

    Returns the world with all of them, and the effects in the order in which they act.
    """
    found = []
    for effect in sorted(effects, key=lambda one: (not one.own, -one.stage)):

        def clarity(size: float, effect: Hidable[W] = effect, world: W = world) -> float:
            changed = effect.on(world, size)
            return yardstick.clarity(effect.part(changed, changed.base, size))

        size = size_for(clarity, wanted, most=effect.most(world))
        found.append(Sized(effect, size, clarity(size)))
        world = effect.on(world, size)
    return world, sorted(found, key=lambda one: (one.effect.on_noise, one.effect.stage))


def stacked(world: W, effects: Sequence[Sized[W]]) -> tuple[Array, tuple[Hidden, ...]]:
    """Return the whole without noise, and what each effect adds to those before it."""
    lacking = [world.parts[one.effect.term] for one in effects if one.effect.own]
    total = world.base - np.sum(lacking, axis=0)
    hidden = []
    for one in effects:
        part = one.effect.part(world, world.base if one.effect.own else total, one.size)
        total = total + part
        hidden.append(Hidden(one.effect.term, one.size, one.clarity, part))
    return np.asarray(total, dtype=np.float64), tuple(hidden)


def recorded_whole(world: W, effects: Sequence[Sized[W]], noise: Array) -> Array:
    """Return the whole with noise: what acts on the record acts on the noise too."""
    measured = stacked(world, [one for one in effects if not one.effect.on_noise])[0] + noise
    for one in effects:
        if one.effect.on_noise:
            measured = measured + one.effect.part(world, measured, one.size)
    return measured


def simulated(
    rng: np.random.Generator, included: Array, own: Array, measured: Array, tuning: str
) -> Array:
    """Return a simulation: included terms (terms, ..., n) as they are, or wrong, or fitted.

    `mistuned`: one of them is wrong by MISTUNED; `refitted`: own columns (p, ..., n) are fitted to
    the recording by plain least squares, so they take over some of what is hidden.
    """
    factors = np.ones(len(included))
    which, sign, by = rng.integers(factors.size), rng.choice([-1.0, 1.0]), rng.uniform(*MISTUNED)
    if tuning == "mistuned":
        factors[which] += sign * by
    if tuning == "refitted":
        flat = own.reshape(len(own), -1)
        scale = np.max(np.abs(flat), axis=1)
        sizes = np.linalg.lstsq((flat / scale[:, None]).T, measured.ravel(), rcond=None)[0]
        return np.asarray(np.tensordot(sizes / scale, own, axes=1), dtype=np.float64)
    return np.asarray(np.tensordot(factors, included, axes=1), dtype=np.float64)
