"""One reference lathe, calibrated in three ways: as published, by autodb, and by the oracle."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.lathe.reference_lathe import REGRESSION, RULES, Campaign, campaign
from autodb.proofs.runs.lathe import lathe_oracle, lathe_ours, published_lathe
from autodb.proofs.runs.lathe.lathe_cuts import LatheCuts, cuts_of
from autodb.proofs.runs.score import Z

Array = NDArray[np.float64]


@dataclass(frozen=True)
class AxisErrors:
    """Root mean square errors of an axis' force on test cuts of a plan, N, and of autodb also those
    of rules alone, how many cuts' 95 % intervals hold the force, and sums of estimates and of their
    products with themselves and with the force.
    """

    plan: str
    axis: str
    cuts: int
    published_N: float
    ours_N: float
    rules_N: float | None
    oracle_N: float
    held: int
    estimate: float
    reference: float
    squared: float
    product: float


AXES = {REGRESSION: ("x", "spindle", "z"), RULES: ("spindle", "z")}
"""Axes of which P1, table 1, prints how many cuts a plan has."""


def run_lathe(seed: int) -> list[AxisErrors]:
    """Calibrate the machine of a seed on its calibration cuts, and test it on others."""
    return [_axis(plan.name, campaign(seed, plan), axis) for plan in AXES for axis in AXES[plan]]


def _axis(plan: str, made: Campaign, axis: str) -> AxisErrors:
    known, tested = cuts_of(made, axis)
    ours, reference_N = lathe_ours.sensed(made, axis), tested.force_N
    force_N, by_rules_N = ours.force_N, ours.by_rules_N
    return AxisErrors(
        plan=plan,
        axis=axis,
        cuts=len(reference_N),
        published_N=_rmse(published_lathe.published_force_N(axis, known, tested), tested),
        ours_N=_rmse(force_N, tested),
        rules_N=None if by_rules_N is None else _rmse(by_rules_N, tested),
        oracle_N=_rmse(lathe_oracle.oracle_force_N(axis, known, tested), tested),
        held=int(np.sum(np.abs(force_N - reference_N) <= Z * ours.sd_N)),
        estimate=float(force_N.sum()),
        reference=float(reference_N.sum()),
        squared=float(force_N @ force_N),
        product=float(force_N @ reference_N),
    )


def _rmse(force_N: Array, tested: LatheCuts) -> float:
    return float(np.sqrt(np.mean((force_N - tested.force_N) ** 2)))
