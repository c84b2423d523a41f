"""What a planner counts of a predicted cut: its time, what it takes off, specific force, energy.

The specific force k_c is what the cutting power makes of the material taken off in that time,
k_c = 60 000 P/Q with P in W and Q in mm³/min: the mean tangential force over the chip's
cross-section. Energy is power times time, of the cut alone, at the spindle.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from autodb.cutting.turning import force_role
from autodb.forward.prediction import COLUMNS, Interval, PredictedCut

W_MIN_A_J = 60.0 * 1000.0
"""N/mm² a W min/mm³."""


@dataclass(frozen=True)
class CutFigures:
    """Of one cut: time, removal rate, specific force, energy; None where nobody says how far.

    ``energy_kJ`` needs the time, which needs the cut's length. ``roles``: which of force x, y, z is
    the passive, the cutting and the feed force (Fp, Fc, Ff), of operations in which one is.
    """

    time_s: float | None
    removal_cm3_min: float | None
    specific_N_mm2: Interval | None
    energy_kJ: Interval | None
    roles: Mapping[str, str]


@dataclass(frozen=True)
class JobTotals:
    """Of all cuts of a job: time, what they take off, energy; None where that of one is not known.

    The interval of the energy is as wide as where all cuts are off alike.
    """

    time_s: float | None
    removed_cm3: float | None
    energy_kJ: Interval | None


def cut_figures(cut: PredictedCut) -> CutFigures:
    """Return what a planner counts of a cut."""
    removal, time_s = cut.removal_mm3_min, cut.time_s
    specific = None if not removal else _scaled(cut.power_W, W_MIN_A_J / removal)
    energy = None if time_s is None else _scaled(cut.power_W, 0.001 * time_s)
    roles = {one: force_role(one, [cut.operation]) for one in COLUMNS}
    named = {role: f"force.{one}" for one, role in roles.items() if role}
    return CutFigures(time_s, None if removal is None else 0.001 * removal, specific, energy, named)


def job_totals(figures: Sequence[CutFigures]) -> JobTotals:
    """Return the sums over the cuts of a job."""
    times = [one.time_s for one in figures if one.time_s is not None]
    removed = [
        one.removal_cm3_min * one.time_s / 60.0
        for one in figures
        if one.removal_cm3_min is not None and one.time_s is not None
    ]
    energies = [one.energy_kJ for one in figures if one.energy_kJ is not None]
    ends = zip(*((one.value, one.low, one.high) for one in energies), strict=True)
    every = len(figures)
    return JobTotals(
        time_s=sum(times) if len(times) == every else None,
        removed_cm3=sum(removed) if len(removed) == every else None,
        energy_kJ=Interval(*map(sum, ends)) if len(energies) == every else None,
    )


def _scaled(one: Interval, factor: float) -> Interval:
    return Interval(factor * one.value, factor * one.low, factor * one.high, one.freedom)
