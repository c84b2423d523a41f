"""Which other names are fair: those that alone explain about as much as the true one."""

import numpy as np

from autodb.proofs.cases.real.full_models import FittedModel
from autodb.proofs.cases.real.held_out import Blocks, fitted_sizes
from autodb.proofs.cases.real.real_axis import Array, RealAxis
from autodb.proofs.cases.real.real_columns import NOT_NEGATIVE, REAL_TERMS, columns_of

AS_GOOD = 1.1
"""Held-out error of another name, of that of the true one, up to which both are fair."""
TAKEN = 0.5
"""Share of the squared error that the true name takes, which a fair one takes at least.

Chosen: beside a weak effect no name at all is within AS_GOOD.
"""


def rivals_of(
    concealed: str, axis: RealAxis, own: FittedModel, simulated: Array, rms_full: float
) -> dict[str, float]:
    """Return the other names that are fair, with the peak of what each then contributes.

    ``own`` has the columns of what the simulation keeps; each name joins them alone.
    """
    model = own.refitted(axis.effort)
    before = model.held_out(axis.effort).rms
    most = min(AS_GOOD * rms_full, np.sqrt(max(before**2 - TAKEN * (before**2 - rms_full**2), 0.0)))
    found = {}
    for name in REAL_TERMS:
        if name == concealed or name in own.terms:
            continue
        error, peak = best_of_name(name, axis, model, simulated)
        if error <= most:
            found[name] = peak
    return found


def best_of_name(
    name: str, axis: RealAxis, model: FittedModel, simulated: Array
) -> tuple[float, float]:
    """Return held-out error and peak of a name beside a model, at its best shape.

    Friction and mass that come out negative explain nothing; no peak exceeds that of the effort.
    """
    best, most = (np.inf, 0.0), float(np.max(np.abs(axis.effort)))
    residual = axis.effort - model.whole
    for columns in columns_of(name, axis, simulated, residual):
        both = np.concatenate([model.columns, columns])
        error = Blocks.of(both, axis.effort).held_out(list(range(len(both)))).rms
        sizes = fitted_sizes(both, axis.effort)[len(model.columns) :]
        if error < best[0] and not (name in NOT_NEGATIVE and sizes[0] < 0.0):
            best = (error, min(float(np.max(np.abs(sizes @ columns))), most))
    return best
