"""The exponent of a softening that the simulation has with another size is the recording's."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.answer import Cause
from autodb.records.tables import CutTable

Array = NDArray[np.float64]
SCATTER = 0.01


def _softening(*, simulated: float, recorded: float) -> Cause:
    rng = np.random.default_rng(4)
    design = np.array(np.meshgrid([0.1, 0.2, 0.3], [0.5, 1.0, 2.0], [100.0, 140.0, 200.0]))
    feed, depth, speed = rng.permutation(design.reshape(3, -1).T).T
    number = np.arange(1.0, len(speed) + 1)

    def force(exponent: float) -> Array:
        return np.asarray(1800.0 * feed * depth * (speed / 140.0) ** -exponent + 60.0 * depth)

    measured = force(recorded) * (1.0 + SCATTER * rng.standard_normal(len(speed)))
    known = {
        "cut": number, "t": 60.0 * number, "cutting.feed": feed, "cutting.depth": depth,
        "cutting.speed": speed,
    }  # fmt: skip
    found = explain(
        CutTable(Path("cuts.csv"), known | {"force.y": measured}),
        CutTable(Path("simulation.csv"), {"cut": number, "force.y": force(simulated)}),
        includes=["shear", "edge_force", *(["speed_softening"] if simulated else [])],
    )
    (cause,) = found.explanation.channels["force.y"].missing
    return cause


@pytest.mark.parametrize(
    ("simulated", "recorded", "kind"),
    [(0.2, 0.45, "mistuned"), (0.4, 0.1, "mistuned"), (0.0, 0.3, "missing")],
)
def test_the_exponent_is_that_of_the_recording(
    simulated: float, recorded: float, kind: str
) -> None:
    cause = _softening(simulated=simulated, recorded=recorded)
    assert (cause.term, cause.kind) == ("speed_softening", kind)
    assert cause.parameters["exponent"].value == pytest.approx(recorded, abs=0.04)
