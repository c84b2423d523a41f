"""Efforts that a speed controller makes: where it holds a speed, they say what it asks for.

It sets effort = k (v* − v), v as it was measured about a row before. Where nothing else moves the
axis a recording obeys this law as well as the axis' own, and what a fit says of the axis is drawn
to it: a closed loop that nothing excites (Söderström and Stoica 1989, System Identification,
ch. 10).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.explain.answer import Cause
from autodb.explain.engine.plain.odds import UNSURE

Array = NDArray[np.float64]

LATER_ROWS = (0.0, 0.5, 1.0, 1.5, 2.0)
"""Rows by which an effort may come after the speed that it answers."""
MOSTLY = 0.9
"""Share of an effort's variance from which on it is a controller's. Chosen: 0.98 in a public
motor's recording under speed control; elsewhere effort rises with speed or does not follow it."""


@dataclass(frozen=True)
class SpeedControl:
    """A controller's law: ``gain`` [effort by mm/s or deg/s], ``share`` of the variance."""

    gain: float
    share: float


def speed_control(effort: Array, velocity: Array) -> SpeedControl | None:
    """Return the law by which a speed controller makes an effort (n,) of a velocity (n,), if it
    gives MOSTLY all of it.
    """
    rows = np.arange(len(effort), dtype=np.float64)
    off, whole = effort - effort.mean(), float(np.var(effort))
    laws = []
    for later in LATER_ROWS:
        speed = np.interp(rows - later, rows, velocity)
        speed -= speed.mean()
        slope = float(speed @ off) / max(float(speed @ speed), 1e-300)
        left = float(np.mean((off - slope * speed) ** 2))
        laws.append(SpeedControl(-slope, 1.0 - left / max(whole, 1e-300)))
    best = max(laws, key=lambda law: law.share)
    return best if best.gain > 0.0 and best.share >= MOSTLY else None


def less_sure(causes: Sequence[Cause]) -> list[Cause]:
    """Return causes, none surer than UNSURE."""
    return [
        cause.model_copy(update={"confidence": min(cause.confidence, UNSURE)}) for cause in causes
    ]
