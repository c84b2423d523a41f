"""Forward regression by orthogonal least squares of SysIdentPy on given columns, sizes held out.

Source: Billings 2013, Nonlinear system identification: NARMAX methods in the time, frequency, and
spatio-temporal domains, chapter 3: columns are taken in the order of their error reduction ratio.
"""

from collections.abc import Iterator

import numpy as np
from sysidentpy.model_structure_selection import FROLS

from benchmarks.peers.choosing import best
from benchmarks.peers.problem import Array, Split

MOST_TERMS = 15
"""Of a formula; the number that SysIdentPy's own information criteria look at."""


def forward(columns: Array, target: Array, parts: Split) -> Array:
    """Return coefficients (p,) of columns (m, p), most of them 0, for a target (m,)."""
    fitted = parts.fitted
    used = np.flatnonzero(np.any(columns[fitted] != 0.0, axis=0))
    order = used[_ordered(columns[fitted][:, used], target[fitted])]
    count = best(_tried(columns, target, parts, order), target, parts)
    found = np.zeros(columns.shape[1])
    if count is not None:
        found[order[:count]] = _solved(columns[:, order[:count]], target)
    return found


def _ordered(columns: Array, target: Array) -> Array:
    """Return the columns in the order in which SysIdentPy takes them."""
    chooser = FROLS(order_selection=False, n_terms=MOST_TERMS, xlag=1, ylag=1)
    rows = np.concatenate([np.zeros(chooser.max_lag), target])[:, None]  # it drops as many
    most = min(MOST_TERMS, columns.shape[0] - 1, columns.shape[1])
    _, order, *_ = chooser.run_mss_algorithm(columns, rows, most)
    return np.asarray(order, dtype=np.intp)


def _tried(
    columns: Array, target: Array, parts: Split, order: Array
) -> Iterator[tuple[int, Array]]:
    for count in range(1, len(order) + 1):
        taken = columns[:, order[:count]]
        yield count, taken @ _solved(taken[parts.fitted], target[parts.fitted])


def _solved(columns: Array, target: Array) -> Array:
    scale = np.linalg.norm(columns, axis=0)
    return np.asarray(np.linalg.lstsq(columns / scale, target)[0] / scale)
