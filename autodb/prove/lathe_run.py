"""One reference lathe, calibrated in three ways: as published, by autodb, and by the oracle."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.prove import lathe_oracle, lathe_ours, published_lathe
from autodb.prove.lathe_cuts import COMPONENT, Cuts, cuts_of
from autodb.prove.score import Z
from autodb.virtual import reference_lathe

Array = NDArray[np.float64]


@dataclass(frozen=True)
class AxisErrors:
    """Root mean square errors of an axis' force on test cuts, N, and of autodb also how many cuts'
    95 % intervals hold the force, and sums of estimates and of their products with themselves and
    with the force.
    """

    axis: str
    cuts: int
    published_N: float
    ours_N: float
    oracle_N: float
    held: int
    estimate: float
    reference: float
    squared: float
    product: float


def run(seed: int) -> list[AxisErrors]:
    """Calibrate the machine of a seed on its calibration cuts, and test it on others."""
    made = reference_lathe.campaign(seed)
    return [_axis(made, axis) for axis in COMPONENT]


def _axis(made: reference_lathe.Campaign, axis: str) -> AxisErrors:
    known, tested = cuts_of(made, axis)
    force_N, sd_N = lathe_ours.sensed(made, axis)
    reference_N = tested.force_N
    return AxisErrors(
        axis=axis,
        cuts=len(reference_N),
        published_N=_rmse(published_lathe.force_N(axis, known, tested), tested),
        ours_N=_rmse(force_N, tested),
        oracle_N=_rmse(lathe_oracle.force_N(axis, known, tested), tested),
        held=int(np.sum(np.abs(force_N - reference_N) <= Z * sd_N)),
        estimate=float(force_N.sum()),
        reference=float(reference_N.sum()),
        squared=float(force_N @ force_N),
        product=float(force_N @ reference_N),
    )


def _rmse(force_N: Array, tested: Cuts) -> float:
    return float(np.sqrt(np.mean((force_N - tested.force_N) ** 2)))
