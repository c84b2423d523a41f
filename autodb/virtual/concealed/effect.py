"""What an effect of a feed axis is, and what it acts on."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from autodb.virtual.concealed.machine import Machine
from autodb.virtual.concealed.moves import Array, Moves


@dataclass(frozen=True)
class World:
    """A machine and its moves; currents in A, (n,)."""

    machine: Machine
    moves: Moves

    @cached_property
    def parts(self) -> dict[str, Array]:
        """Contributions of the machine's own terms."""
        return self.machine.parts(self.moves)

    @cached_property
    def base(self) -> Array:
        """Sum of the machine's own terms."""
        return np.asarray(np.sum(list(self.parts.values()), axis=0), dtype=np.float64)

    @cached_property
    def friction(self) -> Array:
        """Coulomb and viscous friction."""
        return self.parts["coulomb"] + self.parts["viscous"]

    @cached_property
    def way(self) -> Array:
        """Direction of motion, -1..1."""
        way: Array = self.machine.direction(self.moves.v)
        return way

    @cached_property
    def turned_mm(self) -> Array:
        """Way since the last reversal, or since the first motion."""
        travelled = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(self.moves.x)))])
        sign = self.held
        turns = np.concatenate([[True], (sign[1:] != sign[:-1])])
        last = np.maximum.accumulate(np.where(turns, np.arange(sign.size), 0))
        since: Array = travelled - travelled[last]
        return since

    @cached_property
    def held(self) -> Array:
        """Sign of the last motion; 0 before the first."""
        sign = np.where(np.abs(self.moves.v) > 1e-6, np.sign(self.moves.v), 0.0)
        last = np.maximum.accumulate(np.where(sign != 0.0, np.arange(sign.size), 0))
        held: Array = sign[last]
        return held


@dataclass(frozen=True)
class Effect:
    """One effect of one shape. Its part follows from its size, and what there is before it.

    ``term``: identifier; ``stage``: contributions 0, changes of friction 1, of the whole 2, of the
    record 3, which act in this order; ``most``: largest physical size, A where not said otherwise.
    """

    term: ClassVar[str]
    stage: ClassVar[int] = 0
    on_noise: ClassVar[bool] = False  # what it does it does to the noise too

    def most(self, machine: Machine) -> float:
        """Largest size: three times the axis' Coulomb friction."""
        return 3.0 * machine.scale_A

    def on(self, world: World, size: float) -> Machine:
        """Return the machine itself, changed only by an effect that lies in its own sizes."""
        del size
        return world.machine

    def part(self, world: World, total: Array, size: float) -> Array:
        """What is added to the total (n,) before it: size x the only column."""
        (column,) = self.columns(world, total)
        part: Array = size * column
        return part

    def columns(self, world: World, total: Array) -> Array:
        """Columns (k, n) that span what it adds at any size."""
        raise NotImplementedError

    def interval_s(self) -> tuple[float, float] | None:
        """Return the stretch in which it acts, of an effect that has one."""
        return None


@dataclass(frozen=True)
class LeftOut(Effect):
    """A term that the machine has and the simulation lacks; its size is the machine's own."""

    def share(self, machine: Machine) -> Machine:
        """Return the machine with this term at size 1."""
        raise NotImplementedError

    def columns(self, world: World, total: Array) -> Array:
        """The machine's own column at size 1."""
        del total
        return self.share(world.machine).parts(world.moves)[self.term][None]


@dataclass(frozen=True)
class CoulombLeftOut(LeftOut):
    """Coulomb friction, in one of three laws of reversal."""

    term = "coulomb"

    def on(self, world: World, size: float) -> Machine:
        """Coulomb friction of this size."""
        return replace(world.machine, coulomb_A=size)

    def share(self, machine: Machine) -> Machine:
        """Coulomb friction of 1 A."""
        return replace(machine, coulomb_A=1.0)


@dataclass(frozen=True)
class ViscousLeftOut(LeftOut):
    """Viscous friction, straight or bent; its size is that at STATED_MM_S."""

    term = "viscous"

    def on(self, world: World, size: float) -> Machine:
        """Viscous friction of this size."""
        return replace(world.machine, viscous_A=size)

    def share(self, machine: Machine) -> Machine:
        """Viscous friction of 1 A."""
        return replace(machine, viscous_A=1.0)


@dataclass(frozen=True)
class InertiaLeftOut(LeftOut):
    """Inertia; it has one law only. Its size is that at 1 m/s^2, A."""

    term = "inertia"

    def most(self, machine: Machine) -> float:
        """10 A at 1 m/s^2."""
        del machine
        return 10.0

    def on(self, world: World, size: float) -> Machine:
        """Inertia of this size."""
        return replace(world.machine, inertia_A_s2_mm=size / 1000.0)

    def share(self, machine: Machine) -> Machine:
        """Inertia of 1 A at 1 m/s^2."""
        return replace(machine, inertia_A_s2_mm=1.0 / 1000.0)


@dataclass(frozen=True)
class WeightLeftOut(LeftOut):
    """Weight; it has one law only, a constant. It may pull either way."""

    sign: float
    term = "gravity"

    def on(self, world: World, size: float) -> Machine:
        """Weight of this size."""
        return replace(world.machine, weight_A=self.sign * size, weighs=True)

    def share(self, machine: Machine) -> Machine:
        """Weight of 1 A."""
        return replace(machine, weight_A=self.sign, weighs=True)
