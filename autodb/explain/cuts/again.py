"""Cuts of a table made again at its end, to distinguish two explanations of it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from autodb.explain.cuts.candidates.laws import LawColumns
from autodb.explain.cuts.carried import Elsewhere
from autodb.explain.cuts.cut_search import FoundInCuts
from autodb.explain.cuts.distinguishing import Teller, Trials
from autodb.explain.cuts.stack import Conditions, Stack
from autodb.explain.cuts.trials import CutTrial

Array = NDArray[np.float64]
Rows = NDArray[np.intp]
Own = Callable[[Stack], dict[str, LawColumns]]

TIMES = (1, 3, 10)
"""How often a cut is made again, the fewest first. Chosen."""


@dataclass(frozen=True)
class Again(Trials):
    """Trials that are cuts of the table themselves: ``rows`` of all of them, one after the other.

    Simulation and scatter are those of the rows; ``own`` builds the columns that are free anyhow.
    """

    rows: Rows
    own: Own

    @cached_property
    def cuts(self) -> Elsewhere:
        """All cuts of all trials."""
        table, rows = self.result.stack, self.rows
        simulation = table.simulation[:, rows]
        stack = replace(
            table,
            known=_after(table.known, rows),
            recording=simulation,
            simulation=simulation,
            edge_mm=table.edge_mm[:, rows],
            sd=table.sd[:, rows],
            like=table,
        )
        return Elsewhere(stack, self.own(stack), {})


def made_again(result: FoundInCuts, own: Own, *, unit: str) -> Teller:
    """Return what distinguishes effects by the table's cuts made again, those of each condition.

    Every effect must say how it is built ``anew``.
    """
    known = result.stack.known
    first = _one_of_each(result.stack)
    rounds = [
        Again(
            result,
            [_trial(known, row, times) for row in first],
            np.repeat(first, times),
            own,
        )
        for times in TIMES
    ]
    return Teller(result, rounds, unit)


def _one_of_each(stack: Stack) -> Rows:
    """Return the first row of each simulated rise, to three digits."""
    size = float(np.max(np.abs(stack.simulation)))
    _, first = np.unique(np.round(stack.simulation[0] / size, 3), return_index=True)
    return np.sort(first)


def _trial(known: Conditions, row: int, times: int) -> CutTrial:
    often = "once more" if times == 1 else f"{times} times more"
    words = f"Make cut {known.number[row]:g} {often} at the end"
    return CutTrial(words, _after(known, np.full(times, row)))


def _after(known: Conditions, rows: Rows) -> Conditions:
    """Return the conditions of some rows made after the last one, with the last edge."""
    count = 1.0 + np.arange(len(rows))
    step_s = float(np.median(np.diff(known.t_s)))

    def like(values: Array | None) -> Array | None:
        return None if values is None else values[rows]

    def last(values: Array | None) -> Array | None:
        return None if values is None else np.full(len(rows), values[-1])

    return replace(
        known,
        number=known.number[-1] + count,
        t_s=known.t_s[-1] + step_s * count,
        depth_mm=known.depth_mm[rows],
        thickness_mm=like(known.thickness_mm),
        speed_m_min=like(known.speed_m_min),
        edge=last(known.edge),
        cutting_time_s=last(known.cutting_time_s),
        other={name: values[rows] for name, values in known.other.items()},
    )
