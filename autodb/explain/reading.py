"""All that the answer about one axis channel is read from."""

from dataclasses import dataclass

from autodb.explain.axis_signals import AxisSignals
from autodb.explain.bench import Bench
from autodb.explain.fitted import Fitted
from autodb.explain.inquiry import Inquiry
from autodb.explain.noise import Noise
from autodb.explain.suspects import Choice


@dataclass(frozen=True)
class Reading:
    """``noise`` weighs the rows of the final fit; ``choices`` are tuned; ``had``: the terms of the
    simulation, read off it or said to be.
    """

    bench: Bench
    inquiry: Inquiry
    noise: Noise
    choices: tuple[Choice, ...]
    fitted: Fitted
    signals: AxisSignals
    had: frozenset[str]
    unit: str
