"""Two more weeks of the small shop: faces, and profiles whose radius changes along the path.

Facing and tapers stay shallow: above about 250 N the weight of X no longer holds against the force
along it and its current folds (see `feed_range_A`).
"""

import numpy as np

from autodb.proofs.machines.lathe.jobs import cut_at
from autodb.proofs.machines.lathe.process import TrueCut

# Seeds, chosen once
FACING_SEED, CONTOUR_SEED = 104, 105

FACING_EDGES = ("C1", "C2", "C3")
CONTOUR_EDGES = ("D1", "D2", "D3", "D4")


def facing_week_cuts() -> list[TrueCut]:
    """36 faces on three edges; the diameter is the mean of the face, between 30 and 70 mm."""
    rng = np.random.default_rng(FACING_SEED)
    cuts = []
    for edge in FACING_EDGES:
        used_s = 0.0
        for _ in range(12):
            depth_mm = float(rng.choice([0.5, 0.6, 0.75, 0.9, 1.0]))
            feed_mm = round(min(rng.uniform(0.08, 0.3), 0.2 / depth_mm), 2)
            condition = (depth_mm, feed_mm, *_speed_and_diameter(rng))
            duration_s = round(rng.uniform(4.0, 9.0), 1)
            cuts.append(
                cut_at(
                    condition,
                    operation="face",
                    edge=edge,
                    cutting_time_s=round(used_s, 1),
                    duration_s=duration_s,
                )
            )
            used_s += duration_s
    return cuts


def contour_week_cuts() -> list[TrueCut]:
    """48 finishing cuts of profiles on four edges: a land, a taper of 20°, a face, over and over.

    All lie at 0.4 to 0.8 mm depth; a taper dives towards the axis, so both slides feed inward.
    """
    rng = np.random.default_rng(CONTOUR_SEED)
    cuts = []
    for edge in CONTOUR_EDGES:
        used_s = 0.0
        for place in range(12):
            operation = ("turn", "taper", "face")[place % 3]
            depth_mm = float(rng.choice([0.4, 0.5, 0.6, 0.7, 0.8]))
            feed_mm = round(min(rng.uniform(0.08, 0.25), 0.12 / depth_mm), 2)
            condition = (depth_mm, feed_mm, *_speed_and_diameter(rng))
            duration_s = round(rng.uniform(5.0, 12.0), 1)
            cuts.append(
                cut_at(
                    condition,
                    operation=operation,
                    edge=edge,
                    cutting_time_s=round(used_s, 1),
                    duration_s=duration_s,
                    inward_deg=20.0 if operation == "taper" else 0.0,
                )
            )
            used_s += duration_s
    return cuts


def _speed_and_diameter(rng: np.random.Generator) -> tuple[float, float]:
    """Spindle speed, rpm, and diameter, mm, at no more than 280 m/min."""
    diameter_mm = round(rng.uniform(30.0, 70.0), 1)
    fastest_rpm = min(2400.0, 280e3 / (np.pi * diameter_mm))
    return 10.0 * np.floor(rng.uniform(800.0, fastest_rpm) / 10.0), diameter_mm
