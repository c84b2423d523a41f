"""All that the answer about one axis channel is read from."""

from dataclasses import dataclass

from autodb.explain.axis.signals import AxisSignals
from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import Choice
from autodb.explain.engine.fitted import FittedEffects
from autodb.explain.engine.inquiry import Inquiry
from autodb.explain.engine.noise import Noise


@dataclass(frozen=True)
class AxisReading:
    """``noise`` weighs the rows of the final fit; ``choices`` are tuned; ``had``: the terms of the
    simulation, read off it or said to be.
    """

    bench: WhiteRows
    inquiry: Inquiry
    noise: Noise
    choices: tuple[Choice, ...]
    fitted: FittedEffects
    signals: AxisSignals
    had: frozenset[str]
    unit: str
