"""Explain the forces of a table of cuts, and those of a mill over time, all components together."""

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer import ChannelAnswer, Trace
from autodb.explain.cutting.answers import answers
from autodb.explain.cutting.look import look, stack_of
from autodb.explain.milling.answers import Told
from autodb.explain.milling.look import look as look_at_waves
from autodb.records import CutTable, Recording

Array = NDArray[np.float64]


def explain_cuts(
    table: CutTable, simulation: dict[str, Array], includes: list[str] | None
) -> dict[str, tuple[ChannelAnswer, Trace]]:
    """Say what the simulation of a cut table's forces leaves out, by channel.

    ``simulation``: force channel → (n,) in the table's order of cuts.
    """
    looked = look(stack_of(table, simulation, includes), includes)
    return answers(table, looked, frozenset(includes or ()))


def explain_waves(
    recording: Recording, simulation: dict[str, Array], includes: list[str] | None
) -> dict[str, tuple[ChannelAnswer, Trace]]:
    """Say what the simulation of a mill's forces over time leaves out, by channel.

    ``simulation``: force channel → (n,) at the recording's times.

    Raises UnusableInput where the side file says too little of the mill and its cut.
    """
    looked = look_at_waves(recording, simulation, includes)
    return Told(recording, looked, frozenset(includes or ())).answers()
