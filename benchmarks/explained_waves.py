"""What explaining a milled waveform costs: seconds of the processor and peak memory by its length.

`python -m benchmarks.explained_waves`: a slot by two straight teeth, run-out left out; each length
in a process of its own. Growth is what twice as many rows cost times as much.
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.files.channels import FORCES
from autodb.files.side import SideFile
from autodb.records.tables import Recording
from benchmarks.by_length import print_cost, print_growth

Array = NDArray[np.float64]

ROWS = (7_500, 15_000, 30_000, 60_000, 240_000)
RATE_HZ, SPEED_RPM = 5_000.0, 3_000.0
DEPTH_MM, FEED_MM, RUNOUT_MM = 2.0, 0.08, 0.01
SHEAR_N_MM2, EDGE_N_MM, NOISE_N = (1_800.0, 600.0, 300.0), (20.0, 25.0, 3.0), 4.0


def _forces(angle: Array, engaged: Array, out_mm: float) -> Array:
    """Return forces x, y, z (3, n) of two teeth, the one standing out further than the other."""
    forces = np.zeros((3, len(angle)))
    for sign, tip in ((1.0, angle), (-1.0, angle + np.pi)):
        sin, cos = np.sin(tip), np.cos(tip)
        chip = np.maximum(FEED_MM * sin + sign * 2.0 * out_mm, 0.0) * engaged * (sin > 0.0)
        t, r, a = (
            DEPTH_MM * (shear * chip + edge * (chip > 0.0))
            for shear, edge in zip(SHEAR_N_MM2, EDGE_N_MM, strict=True)
        )
        forces += np.array([-t * cos - r * sin, t * sin - r * cos, a])
    return forces


def explained(count: int) -> None:
    """Explain a waveform of so many rows; print seconds of processor, GiB, and what is named."""
    print_cost(*slot(count))


def slot(count: int) -> tuple[Recording, Recording]:
    """Return the forces of a slot in so many rows, and a simulation without the run-out."""
    t = np.arange(count) / RATE_HZ
    angle = 2.0 * np.pi * SPEED_RPM / 60.0 * t
    engaged = ((t > 0.1 * t[-1]) & (t < 0.9 * t[-1])).astype(float)
    sensed = _forces(angle, engaged, RUNOUT_MM)
    sensed += NOISE_N * np.random.default_rng(0).normal(size=sensed.shape)
    side = SideFile.model_validate(
        {
            "tool": {"diameter_mm": 10.0, "teeth": 2, "helix_deg": 0.0},
            "cut": {
                "operation": "slot", "depth_mm": DEPTH_MM, "width_mm": 10.0,
                "feed_mm_tooth": FEED_MM, "speed_rpm": SPEED_RPM,
            },
        }
    )  # fmt: skip
    turned = {"t": t, "spindle.angle": np.degrees(angle)}
    recording = Recording(
        Path("recording"), turned | dict(zip(FORCES, sensed, strict=True)), side=side
    )
    simulated = dict(zip(FORCES, _forces(angle, engaged, 0.0), strict=True))
    return recording, Recording(Path("simulation"), {"t": t, **simulated})


if __name__ == "__main__":
    if len(sys.argv) > 1:
        explained(int(sys.argv[1]))
    else:
        print_growth(__spec__.name, ROWS, "rows")
