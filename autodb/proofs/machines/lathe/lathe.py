"""The virtual lathe at work: the current ranges of a cut, and the cut tables it measures."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.lathe.drives import (
    FeedAxis,
    Spindle,
    feed_range_A,
    spindle_range_A,
    spindle_share,
)
from autodb.proofs.machines.lathe.machine import Lathe
from autodb.proofs.machines.lathe.process import (
    MOVING,
    Array,
    TrueCut,
    TruePair,
    mean_forces_N,
    true_forces_N,
)

__all__ = [
    "MOVING",
    "Array",
    "FeedAxis",
    "Lathe",
    "Spindle",
    "TrueCut",
    "TruePair",
    "arm_mm",
    "cut_table",
    "mean_forces_N",
    "ranges_A",
    "true_forces_N",
]

DYNAMOMETER_N = 1.5  # sd of a quasi-static reading per component; chosen, small beside 9.2 N
STILL_A = 0.004  # sd of an air or standing range: P1 section 9, "practically equal to zero"
ARM_SHARE = {
    "turn": 0.5,
    "face": 0.0,
    "taper": 0.5,
}  # share of a_p by which the edge's mean radius exceeds r_w


def arm_mm(cut: TrueCut) -> float:
    """Mean radius at which the edge cuts: r_w + a_p/2 in turning (P1 section 9), r_w in facing."""
    return 0.5 * cut.diameter_mm + ARM_SHARE[cut.operation] * cut.depth_mm


def ranges_A(
    lathe: Lathe, cut: TrueCut, force_N: Array, *, radius_mm: Array | float, share: float
) -> dict[str, Array]:
    """Noise-free current ranges of x, z and spindle, A, under force (x, y, z) of shape (3, ...).

    `share` of the torque shows in the spindle's current. A standing axis shows its standing value
    whatever presses on it (P1 section 5).
    """
    x_N, y_N, z_N = force_N
    speed_mm_s = _speeds_mm_s(cut)
    moving = {
        "x": feed_range_A(lathe.x, x_N, np.hypot(y_N, z_N), speed_mm_s=speed_mm_s["x"]),
        "z": feed_range_A(lathe.z, z_N, np.hypot(x_N, y_N), speed_mm_s=speed_mm_s["z"]),
    }
    standing = {
        "x": np.full_like(x_N, lathe.x.standing_A),
        "z": np.full_like(x_N, lathe.z.standing_A),
    }
    torque_Nm = y_N * radius_mm / 1000.0
    turning = spindle_range_A(lathe.spindle, torque_Nm, cut.spindle_rpm, share=share)
    feeding = {axis: moving[axis] for axis in MOVING[cut.operation]}
    return {**standing, **feeding, "spindle": turning}


def _speeds_mm_s(cut: TrueCut) -> dict[str, float]:
    """Speed of each slide while it feeds, mm/s."""
    along_mm_s = cut.feed_mm * cut.spindle_rpm / 60.0
    if len(MOVING[cut.operation]) == 1:
        return {"x": along_mm_s, "z": along_mm_s}
    angle = math.radians(cut.inward_deg)
    return {"x": along_mm_s * math.sin(angle), "z": along_mm_s * math.cos(angle)}


def sensing_A(lathe: Lathe, cut: TrueCut) -> dict[str, float]:
    """Standard deviation of one cut's range on each axis, A; a standing axis is quiet."""
    noise = {"x": lathe.x.noise_A, "z": lathe.z.noise_A}
    feeding = {axis: noise[axis] for axis in MOVING[cut.operation]}
    return {"x": STILL_A, "z": STILL_A, **feeding, "spindle": lathe.spindle.noise_A}


def cut_row(
    lathe: Lathe, pair: TruePair, cut: TrueCut, *, seed: Sequence[int], share: float
) -> tuple[dict[str, float], dict[str, float]]:
    """Measured ranges of one cut, A, and the dynamometer's reading of it, N."""
    process, sensing, reading = (np.random.default_rng([*seed, part]) for part in range(3))
    force_N = lathe.work_factor * true_forces_N(pair, cut, process)
    where: dict[str, Any] = {"radius_mm": arm_mm(cut), "share": share}
    in_cut = ranges_A(lathe, cut, force_N, **where)
    in_air = ranges_A(lathe, cut, np.zeros(3), **where)

    # One sensing error a cut on the range in cut; air ranges repeat almost exactly
    ranges = {}
    for axis, sd_A in sensing_A(lathe, cut).items():
        error_A, air_error_A = sensing.standard_normal(2) * (sd_A, STILL_A)
        ranges[f"{axis}.current.range"] = float(np.abs(in_cut[axis] + error_A))
        ranges[f"{axis}.current.air"] = float(np.abs(in_air[axis] + air_error_A))
    read_N = force_N + DYNAMOMETER_N * reading.standard_normal(3)
    return ranges, {f"force.{axis}": float(read_N[i]) for i, axis in enumerate("xyz")}


def feed_deg(cut: TrueCut) -> float:
    """Direction of the feed: 0 along the axis to the chuck, 90 to the centre."""
    return 90.0 if cut.operation == "face" else cut.inward_deg


def cut_table(
    lathe: Lathe,
    pair: TruePair,
    cuts: Sequence[TrueCut],
    seed: int,
    dynamometer: bool,
    *,
    pause_s: float = 60.0,
) -> dict[str, NDArray[Any]]:
    """A cut table of the contract, one row a cut, as this lathe measured it.

    The clock starts cold at 0; `pause_s` passes between cuts. Every cut has its own random stream,
    so a table with and without dynamometer, or with more cuts, has the same ranges.
    """
    return cut_table_of(lathe, [(pair, cut) for cut in cuts], seed, dynamometer, pause_s=pause_s)


def cut_table_of(
    lathe: Lathe,
    work: Sequence[tuple[TruePair, TrueCut]],
    seed: int,
    dynamometer: bool,
    *,
    pause_s: float = 60.0,
) -> dict[str, NDArray[Any]]:
    """The same of cuts that may each be of another pair; with tapers, each cut's feed direction."""
    rows = []
    start_s = 0.0
    profiled = any(cut.operation == "taper" for _, cut in work)
    for number, (pair, cut) in enumerate(work, start=1):
        share = spindle_share(lathe.spindle, seed, start_s + 0.5 * cut.duration_s)
        ranges, force = cut_row(lathe, pair, cut, seed=(seed, number), share=share)
        rows.append(
            {
                "cut": number,
                "t": start_s,
                "operation": cut.operation,
                "work.material": cut.material,
                "tool": pair.tool,
                "cutting.speed": cut.speed_m_min,
                "cutting.feed": cut.feed_mm,
                "cutting.depth": cut.depth_mm,
                **({"cutting.direction": feed_deg(cut)} if profiled else {}),
                "work.diameter": cut.diameter_mm,
                "spindle.speed": cut.spindle_rpm,
                "tool.edge": cut.tool_edge,
                "tool.cutting_time": cut.cutting_time_s,
                **ranges,
                **(force if dynamometer else {}),
            }
        )
        start_s += cut.duration_s + pause_s
    return {name: np.array([row[name] for row in rows]) for name in rows[0]} if rows else {}
