"""A joint that sticks and slips, logged over a slow bus: its speed tells its stamps right."""

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.timing.examined import examined

Array = NDArray[np.float64]


def _stick_slip(seed: int) -> tuple[Array, dict[str, Array]]:
    """Return uneven stamps [s] and the angle and speed of a joint that moves in jerks."""
    rng, fine_s = np.random.default_rng(seed), 0.001
    jerks = np.repeat(rng.choice([0.0, 0.0, 15.0, -15.0, 40.0, -40.0], 900), 80)
    speed = np.convolve(jerks, np.ones(25) / 25.0, mode="same")
    angle = np.cumsum(speed) * fine_s
    rows = np.cumsum(
        rng.choice([15, 22, 30, 45, 90, 150], 1200, p=[0.2, 0.3, 0.3, 0.1, 0.05, 0.05])
    )
    rows = rows[rows < len(angle)]
    return rows * fine_s + rng.uniform(0.0, 1e-5, len(rows)), {
        "a.angle": angle[rows],
        "a.velocity": speed[rows],
    }


def test_a_joint_that_sticks_and_slips_is_taken_at_its_stamps() -> None:
    """A place that leaps is no sign of wrong stamps where its speed leaps, too."""
    stamps, channels = _stick_slip(1)
    findings = examined(stamps, channels, where="joint.csv").findings
    assert "uneven" in [finding.kind for finding in findings]


def test_without_its_speed_nothing_tells_such_stamps_right() -> None:
    stamps, channels = _stick_slip(1)
    with pytest.raises(UnusableInput, match="moves by leaps"):
        examined(stamps, {"a.angle": channels["a.angle"]}, where="joint.csv")


def test_stamps_that_the_speed_does_not_bear_out_are_refused() -> None:
    stamps, channels = _stick_slip(1)
    steps = np.random.default_rng(2).permutation(np.diff(stamps))
    wrong = np.concatenate([[0.0], np.cumsum(steps)])
    with pytest.raises(UnusableInput, match="moves by leaps"):
        examined(wrong, channels, where="joint.csv")
