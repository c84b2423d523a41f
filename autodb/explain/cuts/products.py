"""Inner products of everything that a table's forces may hold, in chunks of cuts."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from autodb.explain.cuts.candidates.laws import LawColumns, SpreadLaw
from autodb.explain.cuts.few_rows import TableProducts
from autodb.explain.cuts.stack import Stack
from autodb.explain.engine.candidates import Candidate
from autodb.explain.engine.search import DETAIL

Array = NDArray[np.float64]


def products(
    stack: Stack,
    own: Sequence[LawColumns],
    candidates: Sequence[Candidate],
    *,
    freedom: float,
    known: bool,
) -> TableProducts:
    """Return inner products of own columns, all candidates in all shapes, and the difference."""
    blocks: dict[tuple[str, int], LawColumns] = {}
    for candidate in candidates:
        for number, form in enumerate(candidate.forms):
            blocks[candidate.key, number] = _of(form.law)
        if candidate.detail is not None:
            blocks[candidate.key, DETAIL] = _of(candidate.detail)
    inner = _inner(stack, [*own, *blocks.values()])
    widths = [columns.mix.shape[2] for columns in blocks.values()]
    return TableProducts(
        inner,
        own=sum(columns.mix.shape[2] for columns in own),
        widths=dict(zip(blocks, widths, strict=True)),
        rows=stack.simulation.size,
        freedom=freedom,
        known=known,
    )


def _of(build: object) -> LawColumns:
    assert isinstance(build, LawColumns)  # every candidate of a cut table is made of laws
    return build


def _inner(stack: Stack, columns: Sequence[LawColumns]) -> Array:
    """Return the inner products of the white difference and all white columns (K + 1, K + 1)."""
    laws = {id(c.law): c.law for c in columns}
    first = dict(zip(laws, np.cumsum([1, *(law.width for law in laws.values())]), strict=False))
    weight = stack.mixing.T @ stack.mixing
    raw = _by_component(stack, list(laws.values()), weight)
    spread = _spread(columns, first, raw.shape[-1], len(stack.names))
    total = np.zeros((spread[0].shape[1],) * 2)
    for i, of_i in enumerate(spread):
        for j, of_j in enumerate(spread):
            if weight[i, j] != 0.0:
                total += weight[i, j] * (of_i.T @ np.asarray(of_j.T @ raw[i, j].T).T)
    return total


def _by_component(stack: Stack, laws: Sequence[SpreadLaw], weight: Array) -> Array:
    """Return products (C, C, Q + 1, Q + 1) of the laws' columns over the sd."""
    count = len(stack.names)
    width = sum(law.width for law in laws) + 1
    raw = np.zeros((count, count, width, width))
    for rows in stack.chunks:
        difference = (stack.recording - stack.simulation)[:, rows, None]
        built = np.concatenate([difference, *(law.build(rows) for law in laws)], axis=2)
        built /= stack.sd[:, rows, None]
        for i in range(count):
            for j in range(i, count):
                if weight[i, j] != 0.0:
                    raw[i, j] += built[i].T @ built[j]
    for i in range(count):
        for j in range(i):
            raw[i, j] = raw[j, i].T
    return raw


def _spread(
    columns: Sequence[LawColumns], first: dict[int, int], width: int, count: int
) -> list[sparse.csr_array]:
    """Return which columns of the laws add up to which of the stack, by component."""
    at = np.cumsum([1, *(c.mix.shape[2] for c in columns)])
    made = []
    for component in range(count):
        rows, cols, values = [np.zeros(1, int)], [np.zeros(1, int)], [np.ones(1)]
        for c, start in zip(columns, at, strict=False):
            q, p = np.nonzero(c.mix[component])
            rows.append(first[id(c.law)] + q)
            cols.append(start + p)
            values.append(c.mix[component][q, p])
        places = (np.concatenate(rows), np.concatenate(cols))
        shape = (width, int(at[-1]))
        made.append(sparse.csr_array((np.concatenate(values), places), shape=shape))
    return made
