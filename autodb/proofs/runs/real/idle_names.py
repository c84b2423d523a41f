"""Names in an answer to a null that do no work: without them the held-out error is as good.

A plain fit of our own decides, of the model's columns and those of each name at its best shape.
"""

import numpy as np

from autodb.proofs.cases.real.held_out import Blocks
from autodb.proofs.cases.real.real_axis import Array
from autodb.proofs.cases.real.real_case import RealCase
from autodb.proofs.cases.real.real_columns import TRIED, columns_of

AS_GOOD_WITHOUT = 1.02


def idle_names(case: RealCase, names: tuple[str, ...]) -> tuple[str, ...]:
    """Return those of ``names`` whose removal leaves the held-out error within 2 %."""
    y, columns, groups = case.axis.effort, case.own.columns, dict[str, list[int]]()
    for name in dict.fromkeys(names):
        if name not in TRIED or name in case.includes:
            continue
        shape = _best_shape(case, columns, name)
        if shape is None:
            continue
        groups[name] = list(range(len(columns), len(columns) + len(shape)))
        columns = np.concatenate([columns, shape])
    blocks = Blocks.of(columns, y)
    every = list(range(len(columns)))
    whole = blocks.held_out(every).rms
    without = {
        name: blocks.held_out([i for i in every if i not in group]).rms
        for name, group in groups.items()
    }
    untried = tuple(n for n in names if n not in groups and n not in case.includes)
    return (*(n for n, rms in without.items() if rms <= AS_GOOD_WITHOUT * whole), *untried)


def _best_shape(case: RealCase, columns: Array, name: str) -> Array | None:
    y = case.axis.effort
    tried = columns_of(name, case.axis, case.simulated, y - case.own.whole)
    errors = [_error_of(np.concatenate([columns, shape]), y) for shape in tried]
    return tried[int(np.argmin(errors))] if errors else None


def _error_of(columns: Array, y: Array) -> float:
    return Blocks.of(columns, y).held_out(list(range(len(columns)))).rms
