"""What autodb identifies of a reference mill from its sweeps, and estimates of forces in its
cuts."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.mill.reference_mill import (
    Logged,
    MillAxis,
    RecordedMilledCut,
    swept_axis,
)
from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import identify
from autodb.sensing.drives.fit.axis_model import Identified
from autodb.sensing.drives.reconstruct import DriveModel, reconstruct

Array = NDArray[np.float64]

TERMS = (
    "inertia",
    "viscous",
    "coulomb",
    "gravity",
    "stribeck",
    "asymmetry",
    "position_friction",
    "spring",
    "cogging",
    "presliding",
)


def identified_mill_axis(seed: int, axis: MillAxis) -> Identified:
    """Fit all terms of an axis together to its whole sweep."""
    seen = mill_recording(swept_axis(seed, axis), axis.name)
    return identify(seen, axis=axis.name, terms=TERMS, by_way=True)


def loads_A(
    models: Mapping[str, DriveModel], cuts: Sequence[RecordedMilledCut], *, bandwidth_hz: float
) -> dict[tuple[str, str], Array]:
    """Return the load (n,) of each cut on each axis, without delay, A."""
    return {
        (one.cut.name, name): reconstruct(
            mill_recording(one.axes[name], name), model, bandwidth_hz=bandwidth_hz
        ).value
        for one in cuts
        for name, model in models.items()
    }


def mill_recording(logged: Logged, name: str) -> Recording:
    """Return what the control logged of an axis as a recording has it."""
    motion = logged.motion
    channels = {
        "t": motion.t,
        f"{name}.position": motion.x,
        f"{name}.velocity": motion.v,
        f"{name}.acceleration": motion.a,
        f"{name}.current": logged.current_A,
    }
    return Recording(path=Path(f"{name}.csv"), channels=channels)
