"""The full model of each recording: its terms, chosen once, and why; fitted by least squares."""

from dataclasses import dataclass

import numpy as np

from autodb.proofs.cases.real.held_out import Blocks, HeldOut, fitted_sizes
from autodb.proofs.cases.real.real_axis import Array, RealAxis
from autodb.proofs.cases.real.real_columns import centred

SLOTS_18 = (6, 12, 18, 24, 36, 42, 48, 60, 72, 84, 144)
"""Orders a turn of the LAAS motor, as the recordings in `data/real` have them."""
SLOTS_12 = (7, 12, 14, 21, 24, 28, 36, 48, 60, 84)
"""Orders a turn of the ODrive motor: 7 pole pairs and 12 slots, as its cogging map shows them."""
TURN_MM = 10.0


@dataclass(frozen=True)
class FullModel:
    """Terms of a recording's model, orders of its cogging a turn of 10 mm, and the reason."""

    terms: tuple[str, ...]
    reason: str
    orders: tuple[int, ...] = ()


FULL_MODELS = {
    "laas-acc": FullModel(("inertia", "viscous", "coulomb"), "swings: inertia and friction"),
    "laas-map": FullModel(
        ("coulomb", "gravity", "cogging"), "creeps both ways: no speed, no inertia", SLOTS_18
    ),
    "laas-roll": FullModel(("coulomb", "cogging"), "one speed, one direction", (12, 24, 36, 48)),
    "laas-speed": FullModel(
        ("coulomb", "viscous", "inertia", "cogging"), "cogging swings the speed", SLOTS_18
    ),
    "smart-x": FullModel(("inertia", "viscous", "coulomb"), "a horizontal slide of a mill"),
    "smart-y": FullModel(("inertia", "viscous", "coulomb"), "a horizontal slide of a mill"),
    "tiago-torso": FullModel(("viscous", "coulomb", "gravity"), "lifts; slow, so no inertia"),
    "tx40-j1": FullModel(("inertia", "viscous", "coulomb"), "turns about the vertical"),
    "tx40-j4": FullModel(("inertia", "viscous", "coulomb"), "the forearm's roll: no weight"),
    "emps": FullModel(
        ("inertia", "viscous", "coulomb", "asymmetry"), "published: friction by direction"
    ),
    "emps-pulses": FullModel(
        ("inertia", "viscous", "coulomb", "asymmetry"), "published: friction by direction"
    ),
    "emps-loaded": FullModel(
        ("inertia", "viscous", "coulomb", "asymmetry", "external_load"), "pulses of known times"
    ),
    "odrive-slow": FullModel(("gravity", "cogging"), "creeps one way: a constant", SLOTS_12),
    "odrive-slow-fed": FullModel(("gravity", "cogging"), "creeps one way: a constant", SLOTS_12),
    "odrive-beside": FullModel(("gravity", "viscous", "cogging"), "creeps and trembles", SLOTS_12),
    "odrive-beside-fed": FullModel(
        ("gravity", "viscous", "cogging"), "creeps and trembles", SLOTS_12
    ),
    "odrive-pull": FullModel(("gravity", "viscous"), "pulls a weight one way"),
    "odrive-pull-fed": FullModel(("gravity", "viscous"), "pulls a weight one way"),
    "odrive-pull-fast": FullModel(("gravity", "viscous"), "pulls a weight one way"),
    "odrive-pull-fast-fed": FullModel(("gravity", "viscous"), "pulls a weight one way"),
}
"""By recording. A constant is called gravity, whatever bears it: it is held against others."""


@dataclass(frozen=True)
class FittedModel:
    """A model fitted to an effort: columns (k, n), the term of each, coefficients (k,)."""

    names: tuple[str, ...]
    columns: Array
    coefficients: Array

    def part(self, term: str) -> Array:
        """Return what a term adds (n,)."""
        own = np.array([name == term for name in self.names])
        return np.asarray(self.coefficients[own] @ self.columns[own])

    @property
    def whole(self) -> Array:
        """Return what the model says (n,)."""
        return np.asarray(self.coefficients @ self.columns)

    @property
    def terms(self) -> tuple[str, ...]:
        """Return its terms, each once."""
        return tuple(dict.fromkeys(self.names))

    def without(self, term: str) -> "FittedModel":
        """Return the model less a term, the other coefficients kept."""
        own = np.array([name != term for name in self.names])
        names = tuple(name for name in self.names if name != term)
        return FittedModel(names, self.columns[own], self.coefficients[own])

    def refitted(self, effort: Array) -> "FittedModel":
        """Return the same columns fitted to another effort (n,)."""
        return FittedModel(self.names, self.columns, fitted_sizes(self.columns, effort))

    def mistuned(self, term: str, share: float) -> "FittedModel":
        """Return the model with the coefficients of one term larger by a share."""
        factor = np.array([1.0 + share * (name == term) for name in self.names])
        return FittedModel(self.names, self.columns, factor * self.coefficients)

    def rows(self, kept: "np.typing.NDArray[np.intp] | slice") -> "FittedModel":
        """Return the same model of some rows."""
        return FittedModel(self.names, self.columns[:, kept], self.coefficients)

    def held_out(self, effort: Array) -> HeldOut:
        """Return the error of its columns on an effort, each block predicted from the others."""
        return Blocks.of(self.columns, effort).held_out(list(range(len(self.names))))


def full_model(axis: RealAxis) -> FittedModel:
    """Return the full model of a recording, fitted to all of it."""
    known = FULL_MODELS[axis.name]
    named = [(term, column) for term in known.terms for column in _columns(term, axis, known)]
    columns = np.array([column for _, column in named])
    return FittedModel(
        tuple(name for name, _ in named), columns, fitted_sizes(columns, axis.effort)
    )


def _columns(term: str, axis: RealAxis, known: FullModel) -> Array:
    """Return the columns (k, n) of one term."""
    if term == "cogging":
        turns = 2.0 * np.pi * np.outer(known.orders, axis.position) / TURN_MM
        return np.concatenate([np.cos(turns), np.sin(turns)])
    plain = {
        "coulomb": axis.direction,
        "viscous": axis.v,
        "inertia": axis.a,
        "gravity": np.ones(len(axis)),
        "asymmetry": np.abs(axis.v),
        "spring": centred(axis),
        "external_load": axis.load,
    }
    return np.array([plain[term]])
