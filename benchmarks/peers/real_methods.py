"""`python -m benchmarks.peers.real_methods GIVEN.npz OUT.npz`: every method, one case.

A method that names picks columns; boosted trees name nothing, and give their held-out error.
Sources: FROLS, Billings, Chen, Korenberg 1989, Int. J. Control 49:2157 (SysIdentPy); STLSQ as in
`stlsq.py` (pysindy); histograms' gradient boosting (scikit-learn).
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.peers.problem import Array, split
from benchmarks.peers.real_given import RealGiven

Picked = NDArray[np.intp]
MOST_PICKED = 8
BLOCKS = 8
GAP_ROWS = 25


def frols(given: RealGiven) -> Picked:
    """Return the columns that are picked (j,): ranked by error reduction, their number held out."""
    from sysidentpy.basis_function import Polynomial
    from sysidentpy.model_structure_selection import FROLS

    columns, error = given.beside_own()
    ranking = FROLS(ylag=1, xlag=1, basis_function=Polynomial(degree=1))  # a lag costs a row
    useful = np.flatnonzero(np.any(columns != 0.0, axis=1))
    _, order, _ = ranking.error_reduction_ratio(
        columns[useful].T[1:], error[:, None], min(MOST_PICKED, len(useful))
    )
    ranked = useful[order[:MOST_PICKED]]
    errors = [_held_out(columns[ranked[:count]], error) for count in range(len(ranked) + 1)]
    return np.asarray(ranked[: int(np.argmin(errors))])


def sindy(given: RealGiven) -> Picked:
    """Return the columns that are picked (j,), threshold and ridge held out."""
    from benchmarks.peers.stlsq import sparse

    columns, error = given.beside_own()
    return np.flatnonzero(sparse(columns.T, error, split(len(error), gap=GAP_ROWS)))


def boosting(given: RealGiven) -> float:
    """Return the held-out rms of boosted trees on time, moves and simulation."""
    from sklearn.ensemble import HistGradientBoostingRegressor

    number, left = np.arange(len(given.error)) * BLOCKS // len(given.error), given.error.copy()
    for block in range(BLOCKS):
        out = number == block
        model = HistGradientBoostingRegressor(
            learning_rate=0.05, max_iter=300, early_stopping=True, random_state=0
        )
        model.fit(given.inputs[:, ~out].T, given.error[~out])
        left[out] -= model.predict(given.inputs[:, out].T)
    return float(np.sqrt(np.mean(left**2)))


def _held_out(columns: Array, error: Array) -> float:
    """Return the held-out rms of least squares on columns (k, n)."""
    number, left = np.arange(len(error)) * BLOCKS // len(error), error.copy()
    for block in range(BLOCKS):
        out = number == block
        if len(columns):
            sizes = np.linalg.lstsq(columns[:, ~out].T, error[~out], rcond=1e-9)[0]
            left[out] -= sizes @ columns[:, out]
    return float(np.sqrt(np.mean(left**2)))


def main(given: Path, out: Path) -> None:
    """Let the methods answer a case and write what each picked, or its error."""
    case = RealGiven.load(given)
    np.savez(out, frols=frols(case), sindy=sindy(case), boosting=boosting(case))


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
