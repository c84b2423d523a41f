"""Explain the forces of a table of cuts, and those of a mill over time, all components together."""

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer.answer import ChannelAnswer, Trace
from autodb.explain.cuts.answers import answers
from autodb.explain.cuts.look import look, stack_of
from autodb.explain.engine.fit import SAME, no_difference, rms
from autodb.explain.waves.answers import Told
from autodb.explain.waves.look import look as look_at_waves
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
    if all(_is_same(recording[name], values) for name, values in simulation.items()):
        return {name: _nothing(recording, name) for name in simulation}
    looked = look_at_waves(recording, simulation, includes)
    return Told(recording, looked, frozenset(includes or ())).answers()


def _is_same(measured: Array, simulated: Array) -> bool:
    return rms(measured - simulated) <= SAME * max(rms(measured), rms(simulated))


def _nothing(recording: Recording, name: str) -> tuple[ChannelAnswer, Trace]:
    values = recording[name]
    trace = Trace("t", recording.t_s, recording=values, simulation=values, corrected=values)
    return no_difference(recording.unit(name)), trace
