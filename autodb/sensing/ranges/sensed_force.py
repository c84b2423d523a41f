"""The force that a calibrated axis senses in each cut, and how far off it may be."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.records.tables import CutTable
from autodb.sensing.ranges.calibration import Calibration
from autodb.sensing.ranges.feeding import moving, torque_arm_mm
from autodb.sensing.ranges.folding import Fold
from autodb.sensing.ranges.forms import MeasuredCuts
from autodb.sensing.ranges.points import current_signal, measured_cuts
from autodb.wording import stored_msgid

Array = NDArray[np.float64]

PASSIVE_IN_NO_CURRENT = "stands still: a passive force shows in no current"
STANDS_STILL = stored_msgid("{axis} stands still: a passive force shows in no current")
NOT_RECORDED = stored_msgid("no {axis} current recorded")
LACKING = stored_msgid(
    "no {axis} current, or no speed, diameter, depth or spindle temperature that its calibration "
    "takes, for this cut"
)
FOLDS = stored_msgid(
    "{axis}'s range folds where the force takes up the weight: up to {force} two forces show one "
    "range"
)
OUTSIDE = stored_msgid("outside the calibrated range: {what}")
"""Why an axis that does not move senses nothing, as it is said and kept."""


@dataclass(frozen=True)
class SensedForces:
    """Force of every row: value and per-cut sd (NaN where not sensed), and why not.

    ``common`` is the derivative of the force by the calibration's coefficients and offset, a column
    for each of the shared covariance: the error that all rows share is common · N(0, shared). The
    last column is the form's choice, where the calibration knows its domain.
    """

    force_N: Array
    sd_N: Array
    common: Array
    not_sensed: list[str | None]


def sense(table: CutTable, calibration: Calibration) -> SensedForces:
    """Return the force that a calibrated axis senses in every row of a table."""
    signal = current_signal(table, calibration.axis)
    n = len(table)
    if signal is None:
        why: list[str | None] = [NOT_RECORDED.format(axis=calibration.axis)] * n
        common = np.zeros((n, len(calibration.shared_covariance)))
        return SensedForces(np.full(n, np.nan), np.full(n, np.nan), common, why)
    sensed_there, form = measured_cuts(table, calibration.axis, signal[1]), calibration.form
    target = form.value(calibration.coefficients, sensed_there)
    to_N = _newtons_per_target(table, calibration)
    moves, known = moving(table, calibration.axis), np.isfinite(target * to_N)
    fold = None if calibration.domain is None else calibration.domain.fold
    folds = np.zeros(n, dtype=np.bool_) if fold is None else signal[1] <= fold.current
    sensed = moves & known & ~folds
    unknown = LACKING.format(axis=calibration.axis)
    reason = [
        None if ok
        else stands_still(calibration.axis) if not moved
        else unknown if fold is None or not folded
        else two_forces(calibration.axis, fold, calibration.unit)
        for ok, moved, folded in zip(sensed, moves, folds, strict=True)
    ]  # fmt: skip
    force = np.where(sensed, target * to_N, np.nan)
    spread = np.hypot(calibration.errors.cut_sd, form.beyond(sensed_there))
    spread = np.hypot(spread, of_current(calibration, sensed_there))
    sd = np.where(sensed, spread * np.abs(to_N), np.nan)
    slopes = form.slopes(calibration.coefficients, sensed_there)
    if calibration.errors.group is not None:
        slopes = np.column_stack([slopes, np.ones(n)])
    if calibration.domain is not None:
        beyond = calibration.domain.beyond(calibration.law, sensed_there)
        slopes = np.column_stack([slopes, beyond])
    return SensedForces(force, sd, slopes * to_N[:, None], reason)


def left_domain(table: CutTable, calibration: Calibration) -> tuple[int, str]:
    """Return how many rows lie outside what a calibration was made with, and of what, in words."""
    signal, domain = current_signal(table, calibration.axis), calibration.domain
    if signal is None or domain is None:
        return 0, ""
    there = measured_cuts(table, calibration.axis, signal[1])
    out = domain.outside(calibration.law, there) & moving(table, calibration.axis)
    units = calibration.unit, calibration.current_unit
    left = domain.left(calibration.law, there.at(out), *units)
    return int(out.sum()), OUTSIDE.format(what="; ".join(left))


def stands_still(axis: str) -> str:
    """Return why an axis that does not move senses no force."""
    return STANDS_STILL.format(axis=axis)


def two_forces(axis: str, fold: Fold, unit: str) -> str:
    """Return why a range that folds senses no force."""
    return FOLDS.format(axis=axis, force=f"{abs(fold.force):.4g} {unit}")


def of_current(calibration: Calibration, sensed: MeasuredCuts) -> Array:
    """Return the standard deviation (n,) that the currents' own error gives the target.

    A cut that does not state its error has that of the calibration's cuts; where these stated none
    it is in the error of a cut.
    """
    usual = calibration.errors.current_sd
    if not usual:
        return np.zeros_like(sensed.current)
    stated = np.full_like(sensed.current, np.nan) if sensed.stated_sd is None else sensed.stated_sd
    error = np.where(np.isfinite(stated), stated, usual)
    up, down = (
        calibration.form.value(calibration.coefficients, sensed.moved(step))
        for step in (error, -error)
    )  # a form need not be straight over an error that is large
    return np.asarray(0.5 * np.abs(up - down))


def _newtons_per_target(table: CutTable, calibration: Calibration) -> Array:
    if calibration.unit == "N":
        return np.ones(len(table))
    arm_mm = torque_arm_mm(table)
    return np.full(len(table), np.nan) if arm_mm is None else 1000.0 / arm_mm
