"""What an axis' terms leave of motion that they were not fitted to."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.covariance import long_run_variance
from autodb.fitting.linear import solve, triangle
from autodb.fitting.scores import leave_one_out
from autodb.sensing.drives.fit.linearised import Linearised
from autodb.sensing.drives.fit.steady import friction_deviation
from autodb.sensing.drives.fit.unevenness import row_roots
from autodb.sensing.drives.moves.motion import motion_blocks
from autodb.sensing.drives.moves.prepared import Prepared

Array = NDArray[np.float64]

GAP_S = 0.25
"""Rows this near to a block left out are not fitted on."""


def nearer_held_out(
    rows: Prepared, problem: Linearised, sds: Array | None, *, sweep: bool
) -> tuple[bool, Array]:
    """Say whether blocks left out are nearer with what friction is off its laws; and what is left
    (m,) of them the nearer way. Of a sweep rows count by the way gone, else by time.

    ``sds`` (groups,): how large it is; None where it is not told.
    """
    left = held_out_effort(rows, problem)
    deviation = friction_deviation(rows, problem) if sds is not None else None
    if deviation is None or sds is None:
        return False, left
    with_it = held_out_off_law(rows, problem, deviation.groups, sds)
    counts = np.abs(rows.sampled("velocity")) if sweep else np.ones(len(left))
    nearer = bool(counts @ with_it**2 < counts @ left**2)
    return nearer, with_it if nearer else left


def held_out_effort(rows: Prepared, problem: Linearised) -> Array:
    """Return what terms leave (m,) of blocks of motion that they were not fitted to.

    A coefficient is believed to add no more than the effort's rms: that of a term which only the
    few rows of a reversal tell from another would be anything, and wrong elsewhere.
    """
    weights, _ = solve(triangle(problem.columns, problem.target))
    noise = float(np.std(problem.target - problem.columns @ weights))
    return _left(rows, problem.columns, problem.target, _pull(rows, problem, noise))


def held_out_off_law(
    rows: Prepared, problem: Linearised, groups: Sequence[Array], sds: Array
) -> Array:
    """Return what terms leave (m,), friction off its laws by ``groups`` (m, k) with ``sds`` each.

    Rows count by how much they scatter, as in the fit of a sweep.
    """
    root = row_roots(rows, problem, list(groups))
    matrix = np.column_stack([problem.columns, *groups]) * root[:, None]
    target = problem.target * root
    weights = np.linalg.lstsq(matrix, target, rcond=1e-10)[0]
    noise = float(np.sqrt(long_run_variance(target - matrix @ weights)))
    free = np.repeat(noise / sds, [group.shape[1] for group in groups])
    pull = np.concatenate([_pull(rows, problem, noise), free])
    return _left(rows, matrix, target, pull) / root


def _pull(rows: Prepared, problem: Linearised, noise: float) -> Array:
    adds = [p not in part.term.shape for part, p in problem.names]
    effort_rms = float(np.sqrt(np.mean(rows.effort**2)))
    size = np.sqrt(np.mean(problem.columns**2, axis=0))
    return np.where(adds, noise * size / effort_rms, 0.0)


def _left(rows: Prepared, matrix: Array, target: Array, pull: Array) -> Array:
    blocks = motion_blocks(rows.sampled("t"), rows.sampled("direction"))
    gap = round(GAP_S * rows.rate_hz / rows.protocol.decimate)
    return leave_one_out(matrix, target, blocks, gap=gap, pull=pull)
