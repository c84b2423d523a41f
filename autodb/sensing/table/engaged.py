"""Where a tool cuts, from what a dynamometer reads alone: teeth that pass shake it.

In air a reading is noise and what moves slowly; a milling tool's teeth enter and leave, so that the
reading's quick part grows many times.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_closing, uniform_filter1d

from autodb import signals
from autodb.errors import UnusableInput
from autodb.records import Recording
from autodb.sensing.table.model import FORCES

Rows = NDArray[np.bool_]

SLOW_HZ = 20.0
"""Frequency up to which a table moves, and above which teeth pass. Chosen."""
WINDOW_S, GAP_S = 0.05, 0.2
"""Length over which a power is a mean, and of what is too short to be air. Chosen."""
QUIET = 0.05
"""Share of the recording that is air at least."""
LOUDER = 9.0
"""Times the power in air from which on teeth pass. Chosen."""


def engaged(recording: Recording) -> Rows:
    """Return the rows (n,) in which a milling tool cuts.

    Raises UnusableInput for a rate at which no teeth are seen.
    """
    rate_hz = recording.rate_hz
    if rate_hz < 10.0 * SLOW_HZ:
        raise UnusableInput(
            f"{recording.path}: teeth do not show at {rate_hz:g} Hz; record at "
            f"{10.0 * SLOW_HZ:g} Hz or more"
        )
    power = np.zeros(len(recording))
    for name in FORCES:
        values = recording[name]
        quick = values - signals.lowpass(values, rate_hz=rate_hz, cutoff_hz=SLOW_HZ)
        power += uniform_filter1d(quick**2, max(3, round(WINDOW_S * rate_hz)), mode="nearest")
    loud = power > LOUDER * float(np.quantile(power, QUIET))
    gap = np.ones(max(3, round(GAP_S * rate_hz)), dtype=np.bool_)
    return np.asarray(binary_closing(loud, gap)) | loud
