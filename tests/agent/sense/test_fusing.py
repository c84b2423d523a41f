"""One answer of drive model, network and table: who disagrees is named, with what is off of it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.agent.sense.fusing import fuse_component
from autodb.agent.sense.reconstructing import ReconstructedLoad
from autodb.records.tables import Recording
from autodb.sensing.drives.reconstruct import DriveLoad
from autodb.sensing.fusion import DRIVE, NETWORK, TABLE

Array = NDArray[np.float64]

RATE_HZ = 50.0
T = np.arange(0.0, 24.0, 1.0 / RATE_HZ)
X = 60.0 + 40.0 * np.sin(2.0 * np.pi * T / 8.0)
FORCE_N = 80.0 * ((T > 4.0) & (T < 20.0)) * (1.0 + 0.3 * np.sin(2.0 * np.pi * T / 3.0))
RECORDING = Recording(Path("cut.csv"), {"t": T, "x.position": X, "x.velocity": np.gradient(X, T)})


def _sensed(force_N: Array, sd_N: float, seed: int) -> ReconstructedLoad:
    rng = np.random.default_rng([seed, 60])
    none = np.zeros(len(T), dtype=np.bool_)
    load = DriveLoad(
        axis="x", unit="N", bandwidth_hz=10.0, value=-force_N + sd_N * rng.standard_normal(len(T)),
        sd=np.full(len(T), sd_N), direction=np.sign(np.gradient(X)), standing=none, turned=none,
        outside=none, braking=none, at_limit=none,
    )  # fmt: skip
    return ReconstructedLoad(load, f"sensor {seed}", None)


def _sensors(drive_N: Array = FORCE_N) -> dict[str, ReconstructedLoad]:
    return {
        DRIVE: _sensed(drive_N, 4.0, 1),
        NETWORK: _sensed(FORCE_N, 4.0, 2),
        TABLE: _sensed(FORCE_N, 4.0, 3),
    }


def _off_N(sensed: ReconstructedLoad) -> float:
    return float(np.sqrt(np.mean((-sensed.load.value - FORCE_N) ** 2)))


def test_sensors_that_agree_are_one_answer() -> None:
    made = fuse_component(RECORDING, "x", _sensors(), None)
    assert made.disagrees is None
    assert _off_N(made) == pytest.approx(4.0 / np.sqrt(3.0), rel=0.1)
    assert list(made.weight) == [DRIVE, NETWORK, TABLE]
    total = np.sum(list(made.weight.values()), axis=0)
    np.testing.assert_allclose(total, 1.0)


def test_a_drive_whose_friction_grew_is_named_and_counts_less() -> None:
    """45 N more Coulomb friction than its model has: explain says so, as of an axis' effort."""
    rubbed = FORCE_N - 45.0 * np.sign(np.gradient(X))
    made = fuse_component(RECORDING, "x", _sensors(rubbed), None)
    assert str(made.disagrees) in str(made.said)
    assert f"{DRIVE} does not agree with the others" in str(made.disagrees)
    assert "coulomb" in str(made.disagrees)
    assert made.weight[DRIVE].mean() < 0.05
    assert _off_N(made) < 5.0


def test_of_two_nobody_is_named() -> None:
    both = _sensors(FORCE_N + 60.0)
    del both[TABLE]
    made = fuse_component(RECORDING, "x", both, None)
    assert f"{DRIVE} and {NETWORK} do not agree" in str(made.said)
    agree = fuse_component(RECORDING, "x", {**both, DRIVE: _sensors()[DRIVE]}, None)
    assert np.median(made.load.sd) > 3.0 * np.median(agree.load.sd)


def test_where_explain_can_take_no_position_it_says_so() -> None:
    still = replace(RECORDING, channels={"t": T})
    made = fuse_component(still, "x", _sensors(FORCE_N + 60.0), None)
    assert f"{DRIVE} does not agree with the others" in str(made.said)
    assert "cannot be determined" in str(made.said)
