"""What autodb identifies of a reference axis from its sweep, and predicts of the contour."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.axis.reference_axis import RecordedRun, Traced
from autodb.proofs.runs.axis.axis_cells import SweepSegments
from autodb.proofs.runs.axis.published_axis import published_weight
from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import identify, predict_effort
from autodb.sensing.drives.fit.axis_model import Identified
from autodb.sensing.drives.moves.protocol import FilterProtocol

Array = NDArray[np.float64]

FRICTION = ("stribeck", "asymmetry", "position_friction", "presliding", "warmup")
TERMS = ("inertia", "viscous", "coulomb", "gravity", *FRICTION, "cogging")
"""`cogging` finds the ripple of the screw's turns, in the friction or beside it."""
PROTOCOL = FilterProtocol(cutoff_hz=20.0, decimate=5)
"""Ten rows a second: a sweep is steady motion."""


@dataclass(frozen=True)
class Ours:
    """Current of every row of the sweep, and of the contour, (n,) each, A; both also of the terms
    alone, which a database keeps; and the weight, A.
    """

    sweep_A: Array
    contour_A: Array
    sweep_terms_A: Array
    contour_terms_A: Array
    weight_A: float


def ours(made: Traced, where: SweepSegments) -> Ours:
    """Identify an axis from its sweep, cycles at 10 000 mm/min included, and predict."""
    name = made.axis.name
    found = sweep_identified(made)
    sweep, contour = (axis_recording(run, name) for run in (made.sweep, made.contour))
    sweep_A = predict_effort(sweep, name, found.terms, found.off_law)
    return Ours(
        sweep_A=sweep_A,
        contour_A=predict_effort(contour, name, found.terms, found.off_law),
        sweep_terms_A=predict_effort(sweep, name, found.terms),
        contour_terms_A=predict_effort(contour, name, found.terms),
        weight_A=published_weight(where.cells(sweep_A)) if name == "z" else 0.0,
    )


def sweep_identified(made: Traced) -> Identified:
    """Fit all terms together to the whole sweep."""
    name = made.axis.name
    seen = axis_recording(made.sweep, name)
    return identify(seen, axis=name, terms=TERMS, protocol=PROTOCOL, by_way=True)


def axis_recording(run: RecordedRun, name: str) -> Recording:
    """Return a run as a control's trace has it: position, feed rate, current."""
    channels = {
        "t": run.motion.t,
        f"{name}.position": run.motion.x,
        f"{name}.velocity": run.motion.v,
        f"{name}.current": run.current_A,
    }
    return Recording(path=Path(f"{name}.csv"), channels=channels)
