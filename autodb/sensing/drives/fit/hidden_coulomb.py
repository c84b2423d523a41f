"""Whether what friction may be off its laws by hides Coulomb friction."""

import numpy as np

from autodb.fitting.linear import least_squares, spanning
from autodb.sensing.drives.fit.held_out import nearer_held_out
from autodb.sensing.drives.fit.linearised import linearised
from autodb.sensing.drives.fit.solved import Solved
from autodb.sensing.drives.moves.prepared import Prepared
from autodb.terms.friction import COULOMB

BLURRED = 0.1
"""Share of the effort's rms by which Coulomb friction is unsure at least, where it may be the
deviation from the law that hides it. Chosen: of sweeps of axes it is sure to 0.03 of it."""


def coulomb_is_hidden(solved: Solved, rows: Prepared, published: Prepared) -> bool:
    """Say whether Coulomb friction is vague only because friction may deviate from its law.

    The law is its best approximation over even speeds; where moves dwell at few of them, the others
    could be anything, and what every move shows of friction would not be told. It is then that of
    the speeds that they dwell at, unless blocks left out are nearer with the deviation.
    """
    problem = solved.problem
    names = [part.term for part, _ in problem.names]
    if COULOMB not in names or solved.deviation is None:
        return False
    level, kept = names.index(COULOMB), spanning(problem.columns)
    column = problem.columns[:, level]
    size = float(np.sqrt(np.mean(column**2) / np.mean(rows.effort**2)))
    own = float(np.sqrt(solved.covariance[level, level]))
    if size * own < BLURRED or level not in kept:
        return False
    plain = least_squares(problem.columns[:, kept], problem.target, lags=0)
    if size * float(plain.sd[kept.index(level)]) > BLURRED:
        return False
    there = linearised(published, problem.parts)
    return not nearer_held_out(published, there, solved.off_law_sds, sweep=False)[0]
