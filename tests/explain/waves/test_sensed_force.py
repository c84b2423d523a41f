"""A scale and crosstalk act on all of the force that is sensed, on what a simulation lacks, too."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.answer import Explained
from autodb.explain.waves.teeth import TURN, Mill, Teeth
from autodb.files.side import SideFile
from autodb.records.tables import Recording

Array = NDArray[np.float64]

RATE_HZ, RPM, DIAMETER_MM, DEPTH_MM, FEED_MM, TEETH, HELIX_DEG = (
    4000.0, 2350.0, 10.0, 2.0, 0.06, 4, 30.0,
)  # fmt: skip
NOISE_N = 4.0
T = np.arange(0.0, 1.6, 1.0 / RATE_HZ)
INSIDE = (T > 0.15) & (T < 1.45)
ANGLE = TURN * RPM / 60.0 * T
MILL = Mill(
    TEETH,
    float(DEPTH_MM * np.tan(np.radians(HELIX_DEG)) / (0.5 * DIAMETER_MM)),
    DEPTH_MM,
    FEED_MM,
    (0.0, np.pi),
    slices=20,
)
SENDS = Teeth(MILL, ANGLE, INSIDE.astype(np.float64), np.ones(len(T)))
SIDE: dict[str, dict[str, float | str]] = {
    "tool": {"diameter_mm": DIAMETER_MM, "teeth": TEETH, "helix_deg": HELIX_DEG},
    "cut": {
        "operation": "slot", "depth_mm": DEPTH_MM, "width_mm": DIAMETER_MM,
        "feed_mm_tooth": FEED_MM, "speed_rpm": RPM,
    },
}  # fmt: skip


def _shear(chip_mm: Array) -> tuple[Array, Array, Array]:
    grown = (np.maximum(chip_mm, 0.0) / 0.05) ** 0.85
    return 90.0 * grown, 35.0 * grown, 15.0 * grown


def _edge(chip_mm: Array) -> tuple[Array, Array, Array]:
    cuts = (chip_mm > 0.0).astype(np.float64)
    return 20.0 * cuts, 24.0 * cuts, 3.0 * cuts


def _law(chip_mm: Array) -> tuple[Array, Array, Array]:
    t, r, a = (one + two for one, two in zip(_shear(chip_mm), _edge(chip_mm), strict=True))
    return t, r, a


def _table(forces: Array) -> dict[str, Array]:
    return {"t": T, **{f"force.{axis}": forces[i] for i, axis in enumerate("xyz")}}


def _explained(sensed: Array, simulated: Array) -> Explained:
    noisy = sensed + NOISE_N * np.random.default_rng(5).standard_normal(sensed.shape)
    channels = {**_table(noisy), "spindle.angle": np.degrees(ANGLE)}
    recording = Recording(Path("cut.csv"), channels, side=SideFile.model_validate(SIDE))
    simulation = Recording(Path("simulation.csv"), _table(simulated))
    return explain(recording, simulation, includes=["shear", "edge_force"])


def _named(explained: Explained) -> set[str]:
    answers = explained.explanation.channels.values()
    return {c.term for answer in answers for c in answer.missing if c.kind == "missing"}


def test_a_scale_and_crosstalk_are_no_law_of_the_chip() -> None:
    """In a slot a smooth law of the chip gives most of what they do, with five times as many
    coefficients.
    """
    felt = SENDS.forces(_law)
    scaled = felt * np.array([np.ones(len(T)), 1.0 + 0.02 * T / T[-1], np.ones(len(T))])
    sensed = scaled + 0.04 * np.array([scaled[1], 0.3 * scaled[2], -scaled[0]])
    explained = _explained(sensed, 1.03 * felt)
    assert _named(explained) == {"gain", "crosstalk"}


def test_own_terms_that_are_fitted_anew_are_so_in_every_component() -> None:
    """A simulation refitted to a recording in which y shows too much is off in z, too."""
    truth = SENDS.forces(_law)
    sensed = truth.copy()
    sensed[1] *= 1.1
    own = np.array([SENDS.forces(_shear), SENDS.forces(_edge)])
    refitted = np.linalg.lstsq(own.reshape(2, -1).T, sensed.ravel(), rcond=None)[0]
    simulated = np.tensordot(refitted, own, axes=1)
    explained = _explained(sensed, simulated)
    assert _named(explained) == {"gain"}
    for i, axis in enumerate("xyz"):
        off = explained.traces[f"force.{axis}"].corrected - sensed[i]
        assert np.std(off) < 0.25 * np.std(simulated[i] - sensed[i])
