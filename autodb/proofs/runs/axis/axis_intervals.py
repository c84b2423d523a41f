"""Proof: the intervals of an identified axis hold what is true of axes drawn at random.

An axis in air is recorded and identified; what ``feed_axis.identify`` gives, coefficients and their
covariance, becomes a 95 % interval of every quantity of ``machines.axis.quantities`` that its model
has.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.proofs.machines.axis.axes import draw_run
from autodb.proofs.machines.axis.quantities import (
    EFFORT_AT,
    FRICTION_MM_S,
    effort_name,
    friction_name,
    quantities,
)
from autodb.proofs.runs.oracle import oracle
from autodb.proofs.runs.score import Judged, Z
from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import identify
from autodb.sensing.drives.fit.axis_model import Identified, amplitudes

Array = NDArray[np.float64]
Given = tuple[float, float, float]
"""Value, low and high end of its 95 % interval."""
TERMS = ("inertia", "viscous", "coulomb", "gravity", "asymmetry", "position_friction")
OWN = {
    ("inertia", "coefficient"): "inertia",
    ("gravity", "level"): "weight",
    ("position_friction", "slope"): "position friction",
    ("cogging", "amplitude"): "cogging amplitude",
    ("cogging", "period"): "cogging period",
}
"""Quantity of a term's parameter."""


def run_axis_intervals(seed: int) -> list[Judged]:
    """Draw, record and identify the axis of a seed; a recording that is refused gives nothing."""
    drawn = draw_run(seed)
    recording = Recording(path=Path(f"axis-{seed}.csv"), channels=drawn.channels)
    try:
        given = quantity_intervals(identified_axis(recording))
    except UnusableInput:
        given = {}
    best, judged = oracle(drawn), []
    for asked in quantities(drawn.axis, drawn.motion):
        value, low, high = given.get(asked.name, (None, None, None))
        judged.append(
            Judged(asked.name, asked.unit, asked.truth, value, low, high, *best.interval(asked))
        )
    return judged


def identified_axis(recording: Recording) -> Identified:
    """Identify every term that a drawn axis may have; a ripple only where one stands out."""
    try:
        return identify(recording, terms=(*TERMS, "cogging"))
    except UnusableInput:
        return identify(recording, terms=TERMS)


def quantity_intervals(found: Identified) -> dict[str, Given]:
    """Return value and 95 % interval of every quantity that an identified model gives."""
    given: dict[str, Given] = {}
    for term in (*found.fitted, *amplitudes(found)):
        name = OWN.get((term.term, term.parameter))
        if name is not None and term.sd:
            given[name] = _interval(term.value, term.sd)
    if found.steady is not None:
        value, sd = found.steady.friction(np.array(FRICTION_MM_S))
        for v, mean, s in zip(FRICTION_MM_S, value, sd, strict=True):
            given[friction_name(v)] = _interval(mean, s)
        places, speeds = np.array(EFFORT_AT).T
        value, sd = found.steady.effort(places, speeds)
        for (x, v), mean, s in zip(EFFORT_AT, value, sd, strict=True):
            given[effort_name(x, v)] = _interval(mean, s)
    return given


def _interval(value: float, sd: float) -> Given:
    return float(value), float(value - Z * sd), float(value + Z * sd)
