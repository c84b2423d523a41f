"""Inputs and output brought to one size, so that a model does not depend on the units."""

from dataclasses import dataclass

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
