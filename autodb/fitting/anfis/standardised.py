"""Inputs and output brought to one size, so that a model does not depend on the units.

What a learner sees: scaled rows less the plane through all of them, and two prior weights.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Unvarying(ValueError):  # noqa: N818 - the data's state, not a program error
    """Inputs that are the same in every row; ``inputs`` are their indices."""

    def __init__(self, inputs: list[int]) -> None:
        super().__init__(f"inputs {inputs} have one value in all rows: leave them out")
        self.inputs = inputs


@dataclass(frozen=True)
class Scaling:
    """Middle and half of the range of each input (d,); middle and size of the output."""

    middle: Array
    half: Array
    output_middle: float
    output_size: float

    def inputs(self, inputs: Array) -> Array:
        """Return inputs (…, d) scaled: −1 … 1 over the training range."""
        return np.asarray((inputs - self.middle) / self.half)

    def values(self, values: Array) -> Array:
        """Return outputs scaled: mean 0, standard deviation 1 over the training rows."""
        return np.asarray((values - self.output_middle) / self.output_size)

    def outputs(self, scaled: Array) -> Array:
        """Return outputs in their own unit."""
        return np.asarray(self.output_middle + self.output_size * scaled)


def scaling(inputs: Array, values: Array) -> Scaling:
    """Return the scaling of training inputs (n, d) and values (n,).

    An output that never changes keeps its own size. Raises Unvarying naming inputs that do not
    vary.
    """
    low, high = inputs.min(axis=0), inputs.max(axis=0)
    if np.any(low == high):
        raise Unvarying([int(j) for j in np.flatnonzero(low == high)])
    size = float(np.std(values))
    return Scaling(0.5 * (low + high), 0.5 * (high - low), float(np.mean(values)), size or 1.0)


@dataclass(frozen=True)
class LearnerRows:
    """Scaled inputs (n, d), what the plane leaves of the scaled values (n,), the plane (d + 1,).

    ``ridge`` and ``leash``: how much the squared distance of the consequents from the plane, and of
    the premises from their start, weighs against the sum of squared residuals.
    """

    x: Array
    left: Array
    plane: Array
    ridge: float
    leash: float

    def pick(self, which: NDArray[np.bool_]) -> "LearnerRows":
        """Return some of the rows."""
        return replace(self, x=self.x[which], left=self.left[which])


def rows(x: Array, values: Array) -> LearnerRows:
    """Return what is learned from scaled inputs (n, d) and scaled values (n,), no weights yet."""
    planes = np.column_stack([np.ones(len(x)), x])
    plane = np.asarray(np.linalg.lstsq(planes, values, rcond=None)[0], dtype=np.float64)
    return LearnerRows(x, values - planes @ plane, plane, 0.0, 0.0)
