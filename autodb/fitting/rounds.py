"""Where a round of an alternation moves nothing any more: its stationary point, not its nth round.

Rounds x ← G(x) (expectation and maximisation, a step of Gauss-Newton) come nearer by one share
each, which is close to 1 where much is not observed. Anderson's mixing (1965, J. ACM 12:547; as
Walker and Ni 2011, SIAM J. Numer. Anal. 49:1715, state it) finds the point where the last rounds'
changes, linearly combined, would be none:

    x ← G(x) − (ΔX + ΔF) γ,   F = G(x) − x,   γ = argmin |F − ΔF γ|

Mixing looks for that point where the rounds are. Where it lies far off and rounds come nearly to
rest on the way, as in a valley's bend, mixing is thrown back again and again; there, every second
round is followed by a leap the way that both went, the longer the more they are alike (squared
extrapolation of Varadhan and Roland 2008, Scand. J. Stat. 35:335):

    x ← x + 2 α r + α² v,   r = G(x) − x,   v = G(G(x)) − G(x) − r,   α = |r| / |v|

Both end at the same point as the rounds themselves, in fewer of them.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import count
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SETTLED = 1e-9
"""Change of every number in its own standard deviations at which a round moves nothing."""
MEMORY = 12
"""Rounds that are combined. Chosen: of fits of worn pairs it takes a fifth fewer than 6; 20 take no
fewer."""
MOST_ROUNDS = 1000
NEAR = 0.5
"""Standard deviations within which a round is linear enough to be mixed. Chosen."""
PLAIN = 2
"""Rounds so near, one after the other, before they are mixed. Chosen."""
WORSE = 3.0
"""A point from which a round moves so many times farther than before is left. Chosen."""
VAIN = 24
"""Rounds, none of which moves less than one before, after which they are mixed no more. Chosen."""
THROWN_BACK, LEAPING = 3, 12
"""Times that mixing is thrown back before rounds are followed by leaps, and rounds of the first
such spell; each is twice as long as the last. Chosen: earlier, fits that mixing alone would end
soon take longer."""
FIRST_LEAP, LONGER = 4.0, 4.0
"""Greatest α of the first leap, and the factor by which it grows where it is reached. Chosen."""
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

    Raises NotSettled after ``most`` rounds, one at least, but where the least of them moved nothing
    by more than ``enough``: rounds that bend may go to and fro about their point, too near for it
    to count. That round is done once more, as the last.
    """
    here, ways = start, _ways()
    way, least = next(ways), _Round(start, start, np.zeros(len(start)), far=np.inf)
    for _ in range(most):
        last = _round(here, *moved(here))
        if last.rests(settled):
            return last.there
        least = min(least, last, key=attrgetter("far"))
        here = way.after(last)
        if way.over:
            way = next(ways)
    if least.far < enough:
        return moved(least.here)[0]
    raise NotSettled(f"not at rest after {most} rounds: the least moved {least.far:.2g} sd")


@dataclass(frozen=True)
class _Round:
    """A round: where it began and ended (p,), the size (p,) in which its change counts, and how
    ``far`` the number that moves most moves, in its size.
    """

    here: Array
    there: Array
    size: Array
    far: float

    @property
    def change(self) -> Array:
        """What it changed (p,)."""
        return self.there - self.here

    def rests(self, settled: float) -> bool:
        """Return whether it moved nothing by more than ``settled`` of its size."""
        return bool(
            np.all(np.abs(self.change) <= settled * self.size + ROUNDING * np.abs(self.here))
        )


def _round(here: Array, there: Array, size: Array) -> _Round:
    far = float(np.max(np.abs(there - here) / size, initial=0.0))
    return _Round(here, there, size, far)


class _Mixing:
    """Plain rounds until they are near, then mixed ones; over where one is mixed into where rounds
    are not alike, or none moves less any more.
    """

    def __init__(self) -> None:
        self.over = False
        self._points: list[Array] = []
        self._changes: list[Array] = []
        self._least, self._best = np.inf, np.empty(0)
        self._plain, self._vain = PLAIN, 0

    def after(self, last: _Round) -> Array:
        """Return where the next round begins: the best place where it is over."""
        if last.far < self._least:
            self._least, self._best, self._vain = last.far, last.there, 0
        else:
            self._vain += 1
        if (self._plain == 0 and last.far > WORSE * self._least) or self._vain > VAIN:
            self.over = True
            return self._best
        self._points = [*self._points, last.here][-MEMORY:]
        self._changes = [*self._changes, last.change][-MEMORY:]
        self._plain = PLAIN if last.far > NEAR else max(self._plain - 1, 0)
        return last.there if self._plain else self._mixed(last)

    def _mixed(self, last: _Round) -> Array:
        """Return where the combination of the rounds' changes is least."""
        if len(self._points) == 1:
            return last.there
        both = (self._points, self._changes)
        moves, turns = (np.diff(np.array(some), axis=0).T for some in both)
        scaled = turns / last.size[:, None]
        share = np.linalg.lstsq(scaled, last.change / last.size, rcond=1e-10)[0]
        return np.asarray(last.there - (moves + turns) @ share)


class _Leaping:
    """Two plain rounds and a leap, in turn, for ``rounds``; a leap to a bad place is taken back."""

    def __init__(self, rounds: int) -> None:
        self._left = rounds
        self._longest = FIRST_LEAP
        self._plain: list[_Round] = []
        self._before: _Round | None = None

    @property
    def over(self) -> bool:
        """Whether its rounds are used up."""
        return self._left == 0

    def after(self, last: _Round) -> Array:
        """Return where the next round begins."""
        self._left -= 1
        before, self._before = self._before, None
        if before is not None and last.far > WORSE * before.far:
            self._longest = max(1.0, self._longest / LONGER)
            self._plain = []
            return before.there
        self._plain.append(last)
        if len(self._plain) < 2:
            return last.there
        first, second = self._plain
        self._before, self._plain = last, []
        return self._leapt(first, second)

    def _leapt(self, first: _Round, second: _Round) -> Array:
        """Return where two rounds, the second from where the first ended, lead."""
        way = first.change / first.size
        bend = second.change / first.size - way
        far, bent = float(np.linalg.norm(way)), float(np.linalg.norm(bend))
        if far >= self._longest * bent:
            length, self._longest = self._longest, self._longest * LONGER
        else:
            length = far / bent
        return np.asarray(first.here + first.size * (2.0 * length * way + length**2 * bend))


def _ways() -> Iterator[_Mixing | _Leaping]:
    """Yield what one after the other is tried until it is over."""
    for _ in range(THROWN_BACK):
        yield _Mixing()
    for spell in count():
        yield _Leaping(LEAPING * 2**spell)
        yield _Mixing()
