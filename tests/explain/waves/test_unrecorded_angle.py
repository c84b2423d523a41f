"""The angle that a simulation's teeth tell where it was not recorded, as the mill comes in, too."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.explain.waves.simulation import waves_of
from autodb.explain.waves.teeth import TURN, Mill, Teeth
from autodb.files.side import SideFile
from autodb.records.tables import Recording

Array = NDArray[np.float64]

RATE_HZ, RPM, DIAMETER_MM, DEPTH_MM, FEED_MM = 4000.0, 2500.0, 10.0, 2.0, 0.08
T = np.arange(0.0, 2.4, 1.0 / RATE_HZ)
INSIDE = (T > 0.25) & (T < 2.2)
ARCS = {"side-up": (0.0, np.arccos(0.2)), "side-down": (np.pi - np.arccos(0.2), np.pi)}
WIDTH_MM = 4.0


def _angle() -> Array:
    """Return an angle of a speed that wanders by 0.05 %, more than twice over the recording."""
    speed = 1.0 + 5e-4 * np.sin(TURN * 0.9 * T)
    return np.asarray(np.cumsum(TURN * RPM / 60.0 * speed) / RATE_HZ + 0.7)


def _law(chip_mm: Array) -> tuple[Array, Array, Array]:
    grown = (np.maximum(chip_mm, 0.0) / 0.05) ** 0.8
    edge = -np.expm1(-chip_mm / 0.008)
    return 70.0 * grown + 20.0 * edge, 30.0 * grown + 24.0 * edge, 12.0 * grown + 3.0 * edge


@pytest.mark.parametrize(
    ("operation", "teeth", "helix_deg", "enters"),
    [
        pytest.param("side-up", 4, 35.0, False, marks=pytest.mark.campaign),
        ("side-down", 3, 40.0, True),
        pytest.param("side-up", 2, 38.0, True, marks=pytest.mark.campaign),
        ("side-down", 3, 0.0, False),
    ],
)
def test_the_angle_is_followed_to_a_fraction_of_a_row(
    operation: str, teeth: int, helix_deg: float, *, enters: bool
) -> None:
    """The law is then read off to 5 in 10 000 of the forces' squares; of a straight edge, which
    comes in with all of its force, to 5 in 1 000.
    """
    angle, low_high = _angle(), ARCS[operation]
    reach = np.ones(len(T))
    if enters:
        fed_mm_s = FEED_MM * teeth * RPM / 60.0
        reach = np.clip(T - T[INSIDE][0], 0.0, None) * fed_mm_s / (0.5 * DIAMETER_MM)
    twist = float(DEPTH_MM * np.tan(np.radians(helix_deg)) / (0.5 * DIAMETER_MM))
    mill = Mill(teeth, twist, DEPTH_MM, FEED_MM, low_high, slices=20 if twist else 1)
    forces = Teeth(mill, angle, INSIDE.astype(np.float64), reach).forces(_law)
    table = {"t": T, **{f"force.{axis}": forces[i] for i, axis in enumerate("xyz")}}
    side = {
        "tool": {"diameter_mm": DIAMETER_MM, "teeth": teeth, "helix_deg": helix_deg},
        "cut": {
            "operation": operation, "depth_mm": DEPTH_MM, "width_mm": WIDTH_MM,
            "feed_mm_tooth": FEED_MM, "speed_rpm": RPM,
        },
    }  # fmt: skip
    recording = Recording(Path("cut.csv"), table, side=SideFile.model_validate(side))
    parts = {f"force.{axis}": forces[i] for i, axis in enumerate("xyz")}
    waves = waves_of(recording, parts, ["shear", "edge_force"])
    off = waves.teeth.angle_rad - angle
    pitch = TURN / teeth
    off = (np.mod(off + 0.5 * pitch, pitch) - 0.5 * pitch)[np.max(np.abs(forces), axis=0) > 0.0]
    row = TURN * RPM / 60.0 / RATE_HZ
    assert np.sqrt(np.mean(off**2)) < 0.05 * row
    assert 1.0 - waves.fits < (5e-4 if helix_deg else 5e-3)
