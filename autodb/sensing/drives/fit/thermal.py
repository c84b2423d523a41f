"""How warm an axis was while it was recorded: the friction it had lost, by `warmup`'s driver."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.records.tables import Recording
from autodb.sensing.drives.fit.axis_model import IdentifiedTerm
from autodb.sensing.drives.moves.motion import term_inputs
from autodb.sensing.drives.moves.protocol import FilterProtocol
from autodb.terms.warming import WARMUP

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ThermalState:
    """Friction lost at the begin and the end of a recording and when it was warmest.

    As shares of ``full``, the share of friction that is lost after long running at 10 000 mm/min.
    The term takes an axis as cold at its first row.
    """

    begin: float
    end: float
    most: float
    full: float


def lost(shape: Mapping[str, float], inputs: Mapping[str, Array]) -> Array:
    """Return the share of friction lost in each row (n,), for `warmup`'s shape parameters."""
    keywords = {p.keyword: shape[p.name] for p in WARMUP.shape}
    return 1.0 - np.asarray(WARMUP.function(inputs["t"], inputs["velocity"], **keywords))


def thermal_state(
    recording: Recording, axis: str, protocol: FilterProtocol, terms: Sequence[IdentifiedTerm]
) -> ThermalState | None:
    """Return the thermal state of a recorded axis; None where its terms have no `warmup`."""
    shape = {t.parameter: t.value for t in terms if t.term == WARMUP.name}
    if any(p.name not in shape for p in WARMUP.shape) or shape["drop"] <= 0.0:
        return None
    inputs = term_inputs(recording, axis, cutoff_hz=protocol.cutoff_hz)
    share = lost(shape, inputs) / shape["drop"]
    return ThermalState(float(share[0]), float(share[-1]), float(share.max()), shape["drop"])
