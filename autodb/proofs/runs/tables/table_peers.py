"""Greedy least squares on the generator's own columns, and which names of an answer do no work."""

import numpy as np

from autodb.proofs.cases.real.held_out import fitted_sizes
from autodb.proofs.cases.tables.published_tables import Array
from autodb.proofs.cases.tables.table_case import TabledCase
from autodb.proofs.cases.tables.table_columns import (
    SHAPES,
    TABLE_NAMES,
    ModelledComponent,
    shapes_of,
)
from autodb.proofs.cases.tables.table_models import held_out_beside, mixed_held_out
from autodb.proofs.runs.real.idle_names import AS_GOOD_WITHOUT
from autodb.proofs.runs.real.real_peers import AS_WELL, JOINS, MOST_TERMS, PeerAnswer

PEER = "greedy, own columns"


def greedy_table(case: TabledCase, place: int) -> PeerAnswer:
    """Explain a component of a table: own laws are free, names join one after another."""
    channel, force = _channel(case, place), case.table.components[place]
    own, picked = channel.model.columns, dict[str, Array]()
    while len(picked) < MOST_TERMS:
        before = mixed_held_out(_stacked(own, picked), force)
        found = _best(case, channel, picked, force)
        if found is None or found[0] > (1.0 - JOINS) * before:
            break
        picked[found[1]] = found[2]
    picked = _needed(own, picked, force)
    columns = _stacked(own, picked)
    sizes, first, said = fitted_sizes(columns, force), len(own), dict[str, float]()
    for name, shape in picked.items():
        last = first + len(shape)
        said[name] = float(np.max(np.abs(sizes[first:last] @ shape)))
        first = last
    return PeerAnswer(said, mixed_held_out(columns, force))


def idle_laws(case: TabledCase, place: int, names: tuple[str, ...]) -> tuple[str, ...]:
    """Return those of ``names`` whose removal leaves the held-out error within 2 %."""
    channel, force = _channel(case, place), case.table.components[place]
    tried = [name for name in names if name in SHAPES and name not in case.includes]
    own, picked = channel.model.columns, dict[str, Array]()
    for name in tried:
        shapes = shapes_of(name, channel)
        if shapes:
            picked[name] = shapes[int(np.argmin(held_out_beside(own, shapes, force)))]
    whole = mixed_held_out(_stacked(own, picked), force)
    without = {
        name: mixed_held_out(_stacked(own, {n: s for n, s in picked.items() if n != name}), force)
        for name in picked
    }
    untried = tuple(n for n in names if n not in picked and n not in case.includes)
    return (*(n for n, rms in without.items() if rms <= AS_GOOD_WITHOUT * whole), *untried)


def _channel(case: TabledCase, place: int) -> ModelledComponent:
    return ModelledComponent(case.own.refitted(case.table.components), case.cases[place].channel)


def _best(
    case: TabledCase, channel: ModelledComponent, picked: dict[str, Array], force: Array
) -> tuple[float, str, Array] | None:
    """Return error, name and columns of what lowers the held-out error most."""
    columns, found = _stacked(channel.model.columns, picked), list[tuple[float, str, Array]]()
    for name in TABLE_NAMES:
        shapes = shapes_of(name, channel)
        if name not in case.includes and name not in picked and shapes:
            errors = held_out_beside(columns, shapes, force)
            best = int(np.argmin(errors))
            found.append((float(errors[best]), name, shapes[best]))
    return min(found, key=lambda one: one[0], default=None)


def _needed(own: Array, picked: dict[str, Array], force: Array) -> dict[str, Array]:
    """Return the names without those that the others do as well without."""
    for name in list(picked):
        others = {one: shape for one, shape in picked.items() if one != name}
        as_well = AS_WELL * mixed_held_out(_stacked(own, picked), force)
        if others and mixed_held_out(_stacked(own, others), force) < as_well:
            picked = others
    return picked


def _stacked(own: Array, picked: dict[str, Array]) -> Array:
    return np.concatenate([own, *picked.values()])
