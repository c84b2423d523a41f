"""Explain the forces of a table of cuts, all components together."""

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer import ChannelAnswer, Trace
from autodb.explain.cutting.answers import answers
from autodb.explain.cutting.look import look, stack_of
from autodb.records import CutTable

Array = NDArray[np.float64]


def explain_cuts(
    table: CutTable, simulation: dict[str, Array], includes: list[str] | None
) -> dict[str, tuple[ChannelAnswer, Trace]]:
    """Say what the simulation of a cut table's forces leaves out, by channel.

    ``simulation``: force channel → (n,) in the table's order of cuts.
    """
    looked = look(stack_of(table, simulation, includes), includes)
    return answers(table, looked, frozenset(includes or ()))
