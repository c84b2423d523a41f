"""A case of a real axis as other methods get it: columns of all names, and what is to be explained.

Arrays end in rows (n,). What the simulation's own terms can follow is taken out of both before a
method looks for names, so that these stay free.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.peers.problem import Array


@dataclass(frozen=True)
class RealGiven:
    """``names`` (k,) of columns (k, n); own columns (m, n); the error of the simulation (n,).

    ``inputs`` (p, n) are time, moves and simulation, for what needs no columns.
    """

    names: tuple[str, ...]
    columns: Array
    own: Array
    error: Array
    inputs: Array

    def save(self, path: Path) -> None:
        """Write it as .npz."""
        np.savez(
            path, names=np.array(self.names), columns=self.columns, own=self.own,
            error=self.error, inputs=self.inputs,
        )  # fmt: skip

    @classmethod
    def load(cls, path: Path) -> "RealGiven":
        """Return what was saved."""
        with np.load(path) as held:
            names = tuple(str(name) for name in held["names"])
            return cls(names, held["columns"], held["own"], held["error"], held["inputs"])

    def beside_own(self) -> tuple[Array, Array]:
        """Return columns and error less what own columns can follow, columns of unit norm."""
        left, values, _ = np.linalg.svd(self.own.T, full_matrices=False)
        basis = left[:, values > 1e-9 * values[0]] if len(self.own) else np.zeros((0, 0))

        def rest(values: Array) -> Array:
            return values - (values @ basis) @ basis.T if basis.size else values

        columns = rest(self.columns)
        norms = np.linalg.norm(columns, axis=1, keepdims=True)
        whole = np.linalg.norm(self.columns, axis=1, keepdims=True)
        columns[(norms <= 1e-6 * whole)[:, 0]] = 0.0
        return columns / np.where(norms > 1e-6 * whole, norms, 1.0), rest(self.error)
