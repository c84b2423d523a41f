"""What an effect of a feed axis is, and what it acts on."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from autodb.proofs.cases.axis.machine import CaseAxis
from autodb.proofs.cases.base.build import Hidable
from autodb.proofs.cases.base.moves import Array, Moves


@dataclass(frozen=True)
class CaseWorld:
    """A machine and its moves; currents in A, (n,)."""

    machine: CaseAxis
    moves: Moves

    def of(self, **sizes: Any) -> "CaseWorld":
        """The same moves of a machine with other sizes."""
        return CaseWorld(replace(self.machine, **sizes), self.moves)

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
class HiddenEffect(Hidable[CaseWorld]):
    """An effect of a feed axis; sizes are A where not said otherwise."""

    def most(self, world: CaseWorld) -> float:
        """Three times the axis' Coulomb friction."""
        return 3.0 * world.machine.scale_A


@dataclass(frozen=True)
class LeftOut(HiddenEffect):
    """A term that the machine has and the simulation lacks; its size is the machine's own."""

    own = True

    def share(self, machine: CaseAxis) -> CaseAxis:
        """Return the machine with this term at size 1."""
        raise NotImplementedError

    def columns(self, world: CaseWorld, total: Array) -> Array:
        """The machine's own column at size 1."""
        del total
        return self.share(world.machine).parts(world.moves)[self.term][None]


@dataclass(frozen=True)
class CoulombLeftOut(LeftOut):
    """Coulomb friction, in one of three laws of reversal."""

    term = "coulomb"

    def on(self, world: CaseWorld, size: float) -> CaseWorld:
        """Coulomb friction of this size."""
        return world.of(coulomb_A=size)

    def share(self, machine: CaseAxis) -> CaseAxis:
        """Coulomb friction of 1 A."""
        return replace(machine, coulomb_A=1.0)


@dataclass(frozen=True)
class ViscousLeftOut(LeftOut):
    """Viscous friction, straight or bent; its size is that at STATED_MM_S."""

    term = "viscous"

    def on(self, world: CaseWorld, size: float) -> CaseWorld:
        """Viscous friction of this size."""
        return world.of(viscous_A=size)

    def share(self, machine: CaseAxis) -> CaseAxis:
        """Viscous friction of 1 A."""
        return replace(machine, viscous_A=1.0)


@dataclass(frozen=True)
class InertiaLeftOut(LeftOut):
    """Inertia; it has one law only. Its size is that at 1 m/s^2, A."""

    term = "inertia"

    def most(self, world: CaseWorld) -> float:
        """10 A at 1 m/s^2."""
        del world
        return 10.0

    def on(self, world: CaseWorld, size: float) -> CaseWorld:
        """Inertia of this size."""
        return world.of(inertia_A_s2_mm=size / 1000.0)

    def share(self, machine: CaseAxis) -> CaseAxis:
        """Inertia of 1 A at 1 m/s^2."""
        return replace(machine, inertia_A_s2_mm=1.0 / 1000.0)


@dataclass(frozen=True)
class WeightLeftOut(LeftOut):
    """Weight; it has one law only, a constant. It may pull either way."""

    sign: float
    term = "gravity"

    def on(self, world: CaseWorld, size: float) -> CaseWorld:
        """Weight of this size."""
        return world.of(weight_A=self.sign * size, weighs=True)

    def share(self, machine: CaseAxis) -> CaseAxis:
        """Weight of 1 A."""
        return replace(machine, weight_A=self.sign, weighs=True)
