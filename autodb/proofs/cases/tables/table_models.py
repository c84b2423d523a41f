"""The full model of each published table: its laws, chosen once, fitted by least squares.

F = K·f·(a + δ)·(1 - e·ln(v/v̄)) + E·(a + δ), component by component, with one depth δ that is off.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from autodb.proofs.cases.real.full_models import FittedModel
from autodb.proofs.cases.real.held_out import (
    BLOCKS,
    DEPENDENT,
    block_numbers,
    fitted_sizes,
    held_out,
)
from autodb.proofs.cases.tables.published_tables import Array, PublishedTable, published_tables

WITH_SPEED = ("shear", "edge_force", "speed_softening")
TABLE_TERMS = {
    "aouici": WITH_SPEED,
    "bartarya": WITH_SPEED,
    "borsos": WITH_SPEED,
    "fnides": WITH_SPEED,
    "lin": ("shear", "edge_force", "depth_error"),
    "mata": WITH_SPEED,
    "drill": WITH_SPEED,
}
"""Laws that lower the error of cuts left out; a depth that is off only where one component is: of
several it came out as another depth for each. A drill's depth is half of its diameter."""
MOST_OFF = 0.5
"""Largest depth that is off, of the smallest depth."""


@dataclass(frozen=True)
class PublishedModel:
    """A model of all components: one fitted model each, and the depth ``off`` in mm they share."""

    table: PublishedTable
    channels: dict[str, FittedModel]
    off_mm: float

    @property
    def terms(self) -> tuple[str, ...]:
        """Return its laws."""
        return next(iter(self.channels.values())).terms

    @property
    def components(self) -> Array:
        """Return what it says (C, n)."""
        return np.array([model.whole for model in self.channels.values()])

    def part(self, term: str) -> Array:
        """Return what a law adds (C, n)."""
        return np.array([model.part(term) for model in self.channels.values()])

    def slope(self) -> Array:
        """Return dF/da (C, n), N/mm."""
        return np.array([_slope(self.table, model) for model in self.channels.values()])

    def errors(self, components: Array) -> Array:
        """Return the error of cuts left out of the fit to forces (C, n), (C,), N."""
        models = zip(self.channels.values(), components, strict=True)
        return np.array([mixed_held_out(model.columns, own) for model, own in models])

    def of_channels(self, channels: dict[str, FittedModel]) -> "PublishedModel":
        """Return the same depth with other models of the components."""
        return PublishedModel(self.table, channels, self.off_mm)

    def without(self, term: str) -> "PublishedModel":
        """Return the model less a law, the others kept."""
        return self.of_channels({name: one.without(term) for name, one in self.channels.items()})

    def refitted(self, components: Array) -> "PublishedModel":
        """Return the same columns fitted to other forces (C, n)."""
        pairs = zip(self.channels.items(), components, strict=True)
        return self.of_channels({name: one.refitted(own) for (name, one), own in pairs})

    def mistuned(self, term: str, share: float) -> "PublishedModel":
        """Return the model with one law larger by a share in all components."""
        changed = {name: one.mistuned(term, share) for name, one in self.channels.items()}
        return self.of_channels(changed)

    def rows(self, kept: "np.typing.NDArray[np.intp]") -> "PublishedModel":
        """Return the same model of some cuts."""
        channels = {name: one.rows(kept) for name, one in self.channels.items()}
        return PublishedModel(self.table.rows(kept), channels, self.off_mm)


@cache
def table_model(name: str) -> PublishedModel:
    """Return the full model of a table, fitted to all of it."""
    from scipy.optimize import minimize_scalar

    table = published_tables()[name]
    if "depth_error" not in TABLE_TERMS[name]:
        return PublishedModel(table, _fitted(table, 0.0), 0.0)
    scale = np.std(table.components, axis=1)[:, None]

    def left(off_mm: float) -> float:
        columns = _laws(table, off_mm)
        said = np.array([fitted_sizes(columns, one) @ columns for one in table.components])
        return float(np.sum(((table.components - said) / scale) ** 2))

    most = MOST_OFF * float(table.depth.min())
    off_mm = float(minimize_scalar(left, bounds=(-most, most), method="bounded").x)
    return PublishedModel(table, _fitted(table, off_mm), off_mm)


def _fitted(table: PublishedTable, off_mm: float) -> dict[str, FittedModel]:
    return {name: _channel(table, force, off_mm) for name, force in table.forces.items()}


def _channel(table: PublishedTable, force: Array, off_mm: float) -> FittedModel:
    """Fit one component at a depth that is off, and then that error's column beside the others."""
    names, columns = tuple(_law_names(table)), _laws(table, 0.0)
    if "depth_error" not in TABLE_TERMS[table.name]:
        return FittedModel(names, columns, fitted_sizes(columns, force))
    true = _laws(table, off_mm)
    off = fitted_sizes(true, force) @ (true - columns)
    columns = np.vstack([columns, off])
    return FittedModel((*names, "depth_error"), columns, fitted_sizes(columns, force))


def _law_names(table: PublishedTable) -> list[str]:
    return [term for term in TABLE_TERMS[table.name] if term != "depth_error"]


def _laws(table: PublishedTable, off_mm: float) -> Array:
    """Return the columns (k, n) of a table's laws at depths that are off."""
    return np.array([_plain(table, term, table.depth + off_mm) for term in _law_names(table)])


def _plain(table: PublishedTable, term: str, depth: Array) -> Array:
    """Return the column (n,) of a law at coefficient 1."""
    if term == "shear":
        return table.feed * depth
    if term == "edge_force":
        return depth
    return -table.feed * depth * table.log_speed


def _slope(table: PublishedTable, model: FittedModel) -> Array:
    laws = [term for term in model.terms if term != "depth_error"]
    return np.asarray(sum(model.part(term) for term in laws) / table.depth)


def mixed_held_out(columns: Array, force: Array) -> float:
    """Return the rms error of cuts left out of the fit, in groups drawn once: tables are sorted."""
    mixed = _mixed(len(force))
    return held_out(columns[:, mixed], force[mixed]).rms


def held_out_beside(columns: Array, shapes: list[Array], force: Array) -> Array:
    """Return the errors (m,) of ``mixed_held_out`` with each of the shapes beside the columns."""
    errors = np.empty(len(shapes))
    single = [i for i, shape in enumerate(shapes) if len(shape) == 1]
    if single:
        errors[single] = _held_out_of_each(
            columns, np.concatenate([shapes[i] for i in single]), force
        )
    for i, shape in enumerate(shapes):
        if len(shape) > 1:
            errors[i] = mixed_held_out(np.concatenate([columns, shape]), force)
    return errors


def _held_out_of_each(columns: Array, added: Array, force: Array) -> Array:
    """Return the errors with one more column each, of (m, n)."""
    mixed = _mixed(len(force))
    both = np.vstack([added, force])[:, mixed]
    own, squares = columns[:, mixed], np.zeros(len(added))
    number = block_numbers(len(force))
    for block in range(BLOCKS):
        out, kept = number == block, number != block
        fitted = np.linalg.lstsq(own[:, kept].T, both[:, kept].T, rcond=DEPENDENT)[0].T @ own
        left = both - fitted
        power = np.sum(left[:-1, kept] ** 2, axis=1)
        least = DEPENDENT * np.sum(both[:-1, kept] ** 2, axis=1)
        size = (left[:-1, kept] @ left[-1, kept]) / np.where(power > least, power, np.inf)
        squares += np.sum((left[-1, out] - size[:, None] * left[:-1, out]) ** 2, axis=1)
    return np.asarray(np.sqrt(squares / len(force)))


def _mixed(n: int) -> "np.typing.NDArray[np.intp]":
    return np.random.default_rng(n).permutation(n)
