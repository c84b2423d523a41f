"""Where a tool cuts, from what a dynamometer reads alone: teeth that pass shake it.

In air a reading is noise and what moves slowly; a milling tool's teeth enter and leave, so that the
reading's quick part grows many times.
"""

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.errors import UnusableInput
from autodb.records.tables import Recording
from autodb.sensing.table.model import FORCES
from autodb.wording import localized, phrase

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
    from scipy.ndimage import binary_closing, uniform_filter1d

    timing, rate_hz = recording.timing, recording.timing.rate_hz
    if rate_hz < 10.0 * SLOW_HZ:
        raise UnusableInput(
            phrase(
                "{file}: teeth do not show at {rate} Hz; record at {slow} Hz or more",
                file=recording.path,
                rate=localized(f"{rate_hz:g}"),
                slow=localized(f"{10.0 * SLOW_HZ:g}"),
            )
        )
    power, window = np.zeros(len(recording)), max(3, round(WINDOW_S * rate_hz))
    for name in FORCES:
        values = recording[name]
        quick = values - signals.lowpass_pieces(values, timing, cutoff_hz=SLOW_HZ)
        power += signals.by_piece(
            lambda own: uniform_filter1d(own, window, mode="nearest"), quick**2, timing.pieces
        )
    loud = power > LOUDER * float(np.quantile(power, QUIET))
    gap = np.ones(max(3, round(GAP_S * rate_hz)), dtype=np.bool_)
    closed = [binary_closing(loud[piece], gap) for piece in timing.pieces]
    return np.asarray(np.concatenate(closed)) | loud
