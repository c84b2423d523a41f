"""Named laws that the cuts of a table need, by the error on blocks of cuts left out of the fit.

As of axes (``engine.plain``): rows as they are, a cut's components one after the other, each over
its scatter, so that a sensor that fails in one of them does not decide for the others. What
does not go with the conditions of a cut, or shows less clearly, is left to the search by evidence.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.candidates.laws import LawColumns
from autodb.explain.cuts.candidates.library import Library
from autodb.explain.cuts.stack import Stack, designed
from autodb.explain.engine.candidates import Candidate, CandidateForm, Choice
from autodb.explain.engine.plain.growing import grown, merged_laws
from autodb.explain.engine.plain.rows import ROWS, PlainRows
from autodb.explain.engine.prior import OWN_SD

Array = NDArray[np.float64]

GOLDEN = (1.0 + np.sqrt(5.0)) / 2.0
"""Its multiples, whole parts taken off, spread evenly however many there are."""


class TableRows:
    """The cuts of a table as plain rows: difference and columns over the scatter.

    Of a long table every so many cuts. ``own``: the simulation's own terms. Cuts of a design are
    dealt, so that blocks that are left out hold all of its levels: a block of neighbours may hold
    one that is nowhere else.
    """

    gap = 0
    apart = True
    progress: Array | None = None

    def __init__(self, stack: Stack, own: dict[str, LawColumns]) -> None:
        self.own = own
        self._stack = stack
        self._cuts = slice(None, None, -(-stack.simulation.size // ROWS))
        self._order = _dealt(stack, len(range(*self._cuts.indices(len(stack.known)))))
        self._own = np.concatenate([self._flat(c.raw(self._cuts)) for c in own.values()], axis=1)
        self.own_sizes = np.concatenate([_sizes(stack, name, c) for name, c in own.items()])

    def _flat(self, raw: Array) -> Array:
        """Return raw columns (C, m, p) as rows (m·C, p), a cut's components together."""
        scaled = (raw / self._stack.sd[:, self._cuts, None])[:, self._order]
        return np.asfortranarray(np.moveaxis(scaled, 0, 1).reshape(-1, raw.shape[2]))

    @property
    def reduced_difference(self) -> Array:
        """The difference of recording and simulation, (m·C,)."""
        difference = self._stack.recording - self._stack.simulation
        return self._flat(difference[:, self._cuts, None])[:, 0]

    def chosen(self, choices: Sequence[Choice]) -> Array:
        """Return own and chosen columns, (m·C, p)."""
        return np.concatenate([self._own, *(self.columns(c.key, c.shape) for c in choices)], axis=1)

    def columns(self, _key: tuple[str, int], form: CandidateForm) -> Array:
        """Return a form's columns, (m·C, p)."""
        assert isinstance(form.law, LawColumns)  # every candidate of a cut table is made of laws
        return self._flat(form.law.raw(self._cuts))


def _dealt(stack: Stack, n: int) -> NDArray[np.intp]:
    """Return the places of n cuts in the order in which blocks take them."""
    if not designed(stack).levels:
        return np.arange(n)
    return np.asarray(np.argsort((np.arange(n) / GOLDEN) % 1.0), dtype=np.intp)


def _sizes(stack: Stack, name: str, columns: LawColumns) -> Array:
    """Return the coefficients that the simulation has of an own term, or such of which OWN_SD is
    the prior; infinite: not read off.
    """
    if name == "edge_force":
        size = np.abs(stack.edge_N_mm)
        return np.asarray(np.where(size > 0.0, size, np.inf))
    if columns.sd is not None:
        return columns.sd / OWN_SD
    return np.ones(columns.mix.shape[2])


def laws_of_table(stack: Stack, library: Library) -> tuple[Choice, ...]:
    """Return the static laws that cuts left out clearly need."""
    rows_of = TableRows(stack, library.own(stack))
    static = [c for c in library.candidates(stack) if c.named and c.static]
    rows = PlainRows(rows_of, static)
    return tuple(merged_laws(rows, grown(rows, [], static)))


def plain_rows(
    stack: Stack,
    own: dict[str, LawColumns],
    candidates: Sequence[Candidate],
    held: Sequence[Choice],
) -> PlainRows:
    """Return plain rows of all candidates, and of choices in the form that each has."""
    kept = {c.candidate.key: c.candidate for c in held}
    every = {c.key: c for c in candidates} | kept
    return PlainRows(TableRows(stack, own), every.values(), held)
