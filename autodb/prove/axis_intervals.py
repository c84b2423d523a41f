"""Proof: the intervals of an identified axis hold what is true of axes drawn at random.

An axis in air is recorded and identified; what ``drives.identify`` gives, coefficients and their
covariance, becomes a 95 % interval of every quantity of ``virtual.quantities`` that its model has.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.prove.oracle import oracle
from autodb.prove.score import Judged, Z
from autodb.records import Recording
from autodb.sensing.drives import Identified, identify
from autodb.virtual.axes import draw_run
from autodb.virtual.quantities import (
    EFFORT_AT,
    FRICTION_MM_S,
    effort_name,
    friction_name,
    quantities,
)

Array = NDArray[np.float64]
Given = tuple[float, float, float]
"""Value, low and high end of its 95 % interval."""


def run(seed: int) -> list[Judged]:
    """Draw, record and identify the axis of a seed; a recording that is refused gives nothing."""
    drawn = draw_run(seed)
    recording = Recording(path=Path(f"axis-{seed}.csv"), channels=drawn.channels)
    try:
        given = intervals(identify(recording))
    except UnusableInput:
        given = {}
    best, judged = oracle(drawn), []
    for asked in quantities(drawn.axis, drawn.motion):
        value, low, high = given.get(asked.name, (None, None, None))
        judged.append(
            Judged(asked.name, asked.unit, asked.truth, value, low, high, *best.interval(asked))
        )
    return judged


def intervals(found: Identified) -> dict[str, Given]:
    """Return value and 95 % interval of every quantity that an identified model gives.

    Its friction is one level and one slope, the same at every place and in both directions.
    """
    given = {
        "inertia": _given(found, {"inertia": 1.0}),
        "weight": _given(found, {"gravity": 1.0}),
    }
    for v in FRICTION_MM_S:
        given[friction_name(v)] = _given(found, _friction(v))
    for x, v in EFFORT_AT:
        given[effort_name(x, v)] = _given(found, {**_friction(v), "gravity": 1.0})
    return given


def _friction(v_mm_s: float) -> dict[str, float]:
    return {"coulomb": float(np.sign(v_mm_s)), "viscous": v_mm_s}


def _given(found: Identified, weights: dict[str, float]) -> Given:
    """Return a sum of coefficients, and ± z sd."""
    row = np.array([weights.get(term.term, 0.0) for term in found.terms])
    value = float(row @ [term.value for term in found.terms])
    sd = float(np.sqrt(row @ found.covariance @ row))
    return value, value - Z * sd, value + Z * sd
