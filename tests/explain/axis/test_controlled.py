"""What a speed controller makes is told from what the axis needs."""

import re
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.axis.sensors_of_axis import speed_control
from autodb.explain.engine.plain.odds import UNSURE
from autodb.records.tables import Recording

Array = NDArray[np.float64]
T_S = np.arange(4000) / 250.0
SET_MM_S, GAIN_A_S_MM = 7.0, 0.07
HUNTING_MM_S = 5.0 * np.sin(2.0 * np.pi * 3.1 * T_S) + 2.0 * np.sin(2.0 * np.pi * 11.0 * T_S + 1.0)
SPEED_MM_S = SET_MM_S + HUNTING_MM_S
MASS_A_S2_MM = 1e-4


def _controlled(later_rows: float) -> Array:
    """Return the effort of a controller that sees speed some rows late."""
    rows = np.arange(len(T_S), dtype=np.float64)
    seen = np.interp(rows - later_rows, rows, SPEED_MM_S)
    noise = np.random.default_rng(3).normal(0.0, 0.02, len(T_S))
    return np.asarray(0.2 + GAIN_A_S_MM * (SET_MM_S - seen) + noise)


@pytest.mark.parametrize("later_rows", [0.0, 0.5, 2.0])
def test_a_controllers_law_is_found_with_its_gain(later_rows: float) -> None:
    law = speed_control(_controlled(later_rows), SPEED_MM_S)
    assert law is not None
    assert law.gain == pytest.approx(GAIN_A_S_MM, rel=0.03)
    assert law.share > 0.95


def test_friction_mass_and_noise_are_none() -> None:
    """Effort that rises with speed, as friction does, or goes with acceleration or with nothing."""
    rng = np.random.default_rng(4)
    viscous = 0.05 * SPEED_MM_S + rng.normal(0.0, 0.01, len(T_S))
    mass = MASS_A_S2_MM * np.gradient(SPEED_MM_S, T_S)
    half = _controlled(0.5) + rng.normal(0.0, 0.3, len(T_S))
    for effort in (viscous, mass, half, rng.normal(0.0, 1.0, len(T_S)), np.ones(len(T_S))):
        assert speed_control(effort, SPEED_MM_S) is None


def test_of_a_controllers_effort_no_name_is_sure_and_it_is_said_why() -> None:
    effort = _controlled(0.5)
    place = np.cumsum(SPEED_MM_S) / 250.0
    channels = {"t": T_S, "x.position": place, "x.velocity": SPEED_MM_S}
    recording = Recording(Path("r.csv"), {**channels, "x.current": effort})
    simulation = {"t": T_S, "x.current": 0.2 * np.sign(SPEED_MM_S)}
    done = explain(recording, Recording(Path("s.csv"), simulation), includes=["coulomb"])
    causes = done.explanation.channels["x.current"].missing
    assert causes
    assert all(cause.confidence <= UNSURE for cause in causes)
    (said,) = [note for note in done.notes if "speed controller" in note]
    assert re.match(r"9\d ?% of the effort .* x\.velocity \(0\.07\d* A ", said)
