"""Where a round of an alternation moves nothing any more: its stationary point, not its nth round.

Rounds x ← G(x) (expectation and maximisation, a step of Gauss-Newton) come nearer by one share
each, which is close to 1 where much is not observed. Anderson's mixing (1965, J. ACM 12:547; as
Walker and Ni 2011, SIAM J. Numer. Anal. 49:1715, state it) finds the point where the last rounds'
changes, linearly combined, would be none:

    x ← G(x) − (ΔX + ΔF) γ,   F = G(x) − x,   γ = argmin |F − ΔF γ|

It ends at the same point as the rounds themselves, in fewer of them.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SETTLED = 1e-9
"""Change of every number in its own standard deviations at which a round moves nothing."""
MEMORY = 12
"""Rounds that are combined. Chosen: of fits of worn pairs it takes a fifth fewer than 6; 20 take no
fewer."""
MIXED_ROUNDS, DAMPED = 150, 0.3
"""Rounds after which they are no longer mixed, and the share of each that is then gone: rounds that
go to and fro between two places come to rest between them. Chosen."""
MOST_ROUNDS = 1000
NEAR = 0.5
"""Standard deviations within which a round is linear enough to be mixed. Chosen."""
PLAIN = 2
"""Rounds so near, one after the other, before they are mixed. Chosen."""
WORSE = 3.0
"""A mixed point whose round moves so many times farther than the least is left. Chosen."""
ROUNDING = 1e-14
"""Relative error of a round, below which what it moves is rounding."""


class NotSettled(ValueError):  # noqa: N818 - the data's state, not a program error
    """Rounds that do not come to rest."""


def stationary(
    moved: Callable[[Array], tuple[Array, Array]],
    start: Array,
    *,
    settled: float = SETTLED,
    most: int = MOST_ROUNDS,
    enough: float = 0.0,
) -> Array:
    """Return the point (p,) that a round leaves where it is.

    ``moved``: G(x) (p,) of a point, and the size (p,) in which a change of each number counts, its
    standard deviation.

    Raises NotSettled after ``most`` rounds, but where the last moved nothing by more than
    ``enough``: rounds that bend may go to and fro about their point, too near for it to count.
    """
    here, plain = start, PLAIN
    points: list[Array] = []
    changes: list[Array] = []
    least, best = np.inf, start
    far, there = np.inf, start
    for number in range(most):
        there, size = moved(here)
        change = there - here
        far = float(np.max(np.abs(change) / size, initial=0.0))
        if np.all(np.abs(change) <= settled * size + ROUNDING * np.abs(here)):
            return there
        if number >= MIXED_ROUNDS:
            here = here + DAMPED * change
            continue
        if plain == 0 and far > WORSE * least:  # mixed into where rounds are not alike: go back
            points, changes, here, plain, least = [], [], best, PLAIN, np.inf
            continue
        if far < least:
            least, best = far, there
        points, changes = [*points, here][-MEMORY:], [*changes, change][-MEMORY:]
        plain = PLAIN if far > NEAR else max(plain - 1, 0)
        here = there if plain else _mixed(points, changes, size)
    if far < enough:
        return there
    raise NotSettled(f"not at rest after {most} rounds: the last moved {far:.2g} sd")


def _mixed(points: list[Array], changes: list[Array], size: Array) -> Array:
    """Return where the combination of the rounds' changes is least."""
    here, change = points[-1], changes[-1]
    if len(points) == 1:
        return here + change
    moves, turns = (np.diff(np.array(some), axis=0).T for some in (points, changes))
    share = np.linalg.lstsq(turns / size[:, None], change / size, rcond=1e-10)[0]
    return np.asarray(here + change - (moves + turns) @ share)
