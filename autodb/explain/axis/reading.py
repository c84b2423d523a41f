"""All that the answer about one axis channel is read from."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.explain.axis.signals import AxisSignals
from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import Choice
from autodb.explain.engine.fitted import FittedEffects
from autodb.explain.engine.inquiry import Inquiry
from autodb.explain.engine.noise import Noise

Array = NDArray[np.float64]


@dataclass(frozen=True)
class AxisReading:
    """``bench`` has what the simulation lacks by plain rows as own columns; ``noise`` weighs its
    rows in the final fit; ``choices`` are what was found beside, tuned; ``had``: the terms of the
    simulation, read off it or said to be; ``whole``: the rows as recorded, less the simulation.
    """

    bench: WhiteRows
    inquiry: Inquiry
    noise: Noise
    choices: tuple[Choice, ...]
    fitted: FittedEffects
    signals: AxisSignals
    had: frozenset[str]
    unit: str
    whole: WhiteRows

    @property
    def everything(self) -> tuple[Choice, ...]:
        """All that was found: laws that plain rows need, then the choices."""
        return (*self.inquiry.founded, *self.choices)

    @property
    def correction(self) -> Array:
        """What all that was found adds, and the simulation's own terms re-tuned, (n,)."""
        return sum((law.effect for law in self.inquiry.laws), start=self.fitted.correction)
