"""New rows in a fitted system: consequents move, premises and hull stay.

    tallied = tally(model, inputs, values)      # sums of rows: tallied + others, in any order
    newer = refreshed(model, tallied)           # as if fitted to all rows at once
    undone(newer, tallied)                      # the first model again

What a point outside the training box is remains what the premises were learned on: rows out there
sharpen the consequents, but no set was ever shaped to them.
"""

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.anfis.model import Anfis, with_best_consequents
from autodb.fitting.anfis.premises import rule_columns
from autodb.fitting.anfis.sums import Sums, consequent_sums

Array = NDArray[np.float64]


def tally(model: Anfis, inputs: Array, values: Array) -> Sums:
    """Return what rows, inputs (n, d) and values (n,), say to a model with these premises."""
    x = model.scaling.inputs(inputs)
    plane = model.belief.plane
    left = model.scaling.values(values) - (plane[0] + x @ plane[1:])
    return consequent_sums(rule_columns(model.premises, x), left)


def refreshed(model: Anfis, rows: Sums) -> Anfis:
    """Return the model with the rows added. Raises NotMonotone as ``fit`` does."""
    return _with(model, model.sums + rows)


def without_rows(model: Anfis, rows: Sums) -> Anfis:
    """Return the model without rows that were added before.

    Raises TooFewRows where they leave nothing for the residual, NotMonotone.
    """
    return _with(model, model.sums - rows)


def _with(model: Anfis, rows: Sums) -> Anfis:
    return with_best_consequents(
        model.premises, model.scaling, model.belief, rows,
        hull=model.hull, learned=model.learned, monotone=model.monotone,
    )  # fmt: skip
