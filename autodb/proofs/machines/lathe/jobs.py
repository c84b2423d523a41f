"""What the sample machine cuts: a calibration programme and two weeks of a small shop.

Conditions span P1's (depth 1-2.5 mm, feed 0.1-0.4 mm/rev, 800-2400 rpm; section 9). Facing stays
shallow: above about 250 N the weight of X no longer holds against the feed force and its current
folds (see `feed_range_A`).
"""

import math

import numpy as np

from autodb.proofs.machines.lathe.process import TrueCut

# Seeds and edge lots, chosen once
STANDARD_SEED, WEEK_1_SEED, WEEK_2_SEED = 101, 102, 103

MATERIAL = "steel bar"
REPEATED = (2.0, 0.20, 1000.0, 60.0)

# depth mm, feed mm/rev, speed rpm, machined diameter mm
TURNED = (
    (1.0, 0.10, 2400.0, 48.0),
    (1.0, 0.20, 1800.0, 56.0),
    (1.0, 0.30, 1200.0, 64.0),
    (1.0, 0.40, 800.0, 70.0),
    (1.5, 0.10, 1500.0, 60.0),
    (1.5, 0.15, 2100.0, 46.0),
    (1.5, 0.20, 1000.0, 68.0),
    (1.5, 0.30, 2400.0, 42.0),
    (1.5, 0.40, 1200.0, 58.0),
    (2.0, 0.10, 1000.0, 72.0),
    (2.0, 0.15, 2400.0, 44.0),
    (2.0, 0.20, 1500.0, 62.0),
    (2.0, 0.30, 800.0, 66.0),
    (2.0, 0.40, 1800.0, 40.0),
    (2.5, 0.10, 2100.0, 50.0),
    (2.5, 0.25, 1200.0, 54.0),
    *(REPEATED,) * 4,
)
FACED = (
    (0.5, 0.10, 1200.0, 60.0),
    (0.5, 0.20, 1500.0, 56.0),
    (0.5, 0.30, 1000.0, 64.0),
    (0.75, 0.10, 1800.0, 52.0),
    (0.75, 0.20, 1200.0, 60.0),
    (0.75, 0.30, 800.0, 66.0),
    (1.0, 0.10, 1000.0, 62.0),
    (1.0, 0.15, 1500.0, 58.0),
    (1.0, 0.20, 1200.0, 54.0),
    (1.0, 0.25, 800.0, 68.0),
    (1.25, 0.10, 1200.0, 60.0),
    (1.5, 0.10, 1000.0, 56.0),
)
TURN_S, FACE_S = 10.0, 4.0


def cut_at(
    condition: tuple[float, float, float, float],
    *,
    operation: str = "turn",
    edge: str = "fresh",
    cutting_time_s: float = 0.0,
    duration_s: float = TURN_S,
    inward_deg: float = 0.0,
) -> TrueCut:
    """A cut at (depth mm, feed mm/rev, speed rpm, machined diameter mm) on the sample material."""
    depth_mm, feed_mm, speed_rpm, diameter_mm = condition
    return TrueCut(
        speed_m_min=math.pi * diameter_mm * speed_rpm / 1000.0,
        feed_mm=feed_mm,
        depth_mm=depth_mm,
        diameter_mm=diameter_mm,
        operation=operation,
        tool_edge=edge,
        cutting_time_s=cutting_time_s,
        duration_s=duration_s,
        material=MATERIAL,
        inward_deg=inward_deg,
    )


def standard_cuts() -> list[TrueCut]:
    """The 32 calibration cuts in random order, a new edge after every eighth."""
    cuts = [(c, "turn", TURN_S) for c in TURNED] + [(c, "face", FACE_S) for c in FACED]
    order = np.random.default_rng(STANDARD_SEED).permutation(len(cuts))
    ordered, used_s = [], 0.0
    for place, index in enumerate(order):
        condition, operation, duration_s = cuts[index]
        used_s = used_s if place % 8 else 0.0
        ordered.append(
            cut_at(
                condition,
                operation=operation,
                edge=f"standard-{place // 8 + 1}",
                cutting_time_s=used_s,
                duration_s=duration_s,
            )
        )
        used_s += duration_s
    return ordered


def production_cuts(
    seed: int, edges: tuple[str, ...], cuts_an_edge: int, shortest_s: float, longest_s: float
) -> list[TrueCut]:
    """Turning cuts as a shop has them: random conditions, edge after edge.

    Chip area is kept to 0.5 mm^2 and speed to 280 m/min, what an 11 kW lathe cuts steel with.
    """
    rng = np.random.default_rng(seed)
    cuts = []
    for edge in edges:
        used_s = 0.0
        for _ in range(cuts_an_edge):
            depth_mm = float(rng.choice([1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5]))
            feed_mm = round(min(rng.uniform(0.1, 0.4), 0.5 / depth_mm), 2)
            diameter_mm = round(rng.uniform(36.0, 76.0), 1)
            fastest_rpm = min(2400.0, 280e3 / (math.pi * diameter_mm))
            speed_rpm = 10.0 * math.floor(rng.uniform(800.0, fastest_rpm) / 10.0)
            duration_s = round(rng.uniform(shortest_s, longest_s), 1)
            cuts.append(
                cut_at(
                    (depth_mm, feed_mm, speed_rpm, diameter_mm),
                    edge=edge,
                    cutting_time_s=round(used_s, 1),
                    duration_s=duration_s,
                )
            )
            used_s += duration_s
    return cuts


def week_1_cuts() -> list[TrueCut]:
    """40 cuts on five edges, each used for under three minutes."""
    return production_cuts(WEEK_1_SEED, ("A1", "A2", "A3", "A4", "A5"), 8, 12.0, 22.0)


def week_2_cuts() -> list[TrueCut]:
    """36 cuts on three edges, each worn out: about 24 minutes of cutting."""
    return production_cuts(WEEK_2_SEED, ("B1", "B2", "B3"), 12, 100.0, 135.0)
