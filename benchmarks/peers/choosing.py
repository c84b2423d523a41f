"""The choice that every method makes on the held-out rows: a setting, or no correction at all."""

from collections.abc import Iterable
from typing import TypeVar

from benchmarks.peers.problem import Array, Split, squared

T = TypeVar("T")


def best(candidates: Iterable[tuple[T, Array]], target: Array, parts: Split) -> T | None:
    """Return the candidate with the least squared error on the held-out rows, or None for none.

    Each candidate comes with what it gives at every row (m,) of the target (m,), those first that
    write least: a later one must be better. The first to be better than is no correction at all.
    """
    rows = parts.held_out
    least, chosen = squared(target[rows]), None
    for candidate, given in candidates:
        error = squared(target[rows] - given[rows])
        if error < least:
            least, chosen = error, candidate
    return chosen
