"""Two kinds of error of a sensed force: one cut's own, and what all cuts of a calibration share.

More cuts average the first, never the second (physics reference, section 7). Shared are the errors
of the coefficients, of the gain from day to day, and of the reference forces.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DAY_SHARE = {"x": 0.0, "z": 0.0, "spindle": (485.78 - 465.21) / 485.78}
"""Relative standard deviation of an axis' gain from day to day, where the cuts of one day show
none: P1, table 2, the mean force sensed in 12 repeats against the mean measured; that of F_z
agrees.
"""
CLEAR = 2.0
"""Standard errors above which errors of neighbouring cuts go together by more than chance."""
LEAST_OWN = 0.1
"""Share of the error on groups left out that is at least one cut's own."""


@dataclass(frozen=True)
class ErrorKinds:
    """What a calibration's cuts say of both kinds.

    ``cut_sd``: standard deviation of one cut's own error, in the target's unit. ``gain_share``:
    relative standard deviation between the gain fitted and that of the cuts of another day.
    ``reference_share``: that of all reference forces together.
    """

    cut_sd: float
    gain_share: float
    reference_share: float

    def shared(self, scaling: Array) -> Array:
        """Return the covariance (p, p) of coefficients that scale by ``scaling`` (p,) a share."""
        share = self.gain_share**2 + self.reference_share**2
        return np.asarray(share * np.outer(scaling, scaling))


def apart(
    estimate: Array, error: Array, *, rmse: float, day_share: float, reference_share: float
) -> ErrorKinds:
    """Tell the kinds apart by cuts (n,) in their order: estimates, and target − estimate.

    ``rmse`` on groups left out holds a cut's own error and the wander seen, which is shared by the
    cuts of a day. A gain that is known to differ by ``day_share`` from day to day but was seen to
    wander by less had its error in these cuts too.
    """
    slow = slow_share(estimate, error)
    own = rmse**2 - slow**2 * float(np.mean(estimate**2))
    unseen = max(0.0, day_share**2 - slow**2)
    return ErrorKinds(
        cut_sd=float(np.sqrt(max(own, (LEAST_OWN * rmse) ** 2))),
        gain_share=float(np.sqrt(max(day_share, slow) ** 2 + unseen)),
        reference_share=reference_share,
    )


def slow_share(estimate: Array, error: Array) -> float:
    """Return the relative standard deviation of a gain that wanders slowly from cut to cut.

    Errors of neighbours go together as far as the gain is the same for both:
    Σ e_i e_{i+1} / Σ f_i f_{i+1} is its variance, f the estimates (n,). One below ``CLEAR``
    standard errors of chance counts as none.
    """
    scale = float(estimate[1:] @ estimate[:-1])
    if scale <= 0:
        return 0.0
    variance = float(error[1:] @ error[:-1]) / scale
    chance = float(error @ error) / np.sqrt(len(error)) / scale
    return float(np.sqrt(variance)) if variance > CLEAR * chance else 0.0
