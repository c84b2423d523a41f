"""The least error that forces sensed on a reference lathe can have: its own forms, fitted.

The oracle knows how the drives of ``machines.lathe.drives`` make a range of a load, how the screw
loses more at creep, how the spindle reads low while it warms. Gains, friction and weight it must
fit to the calibration cuts as anybody; what is drawn anew (sensing noise, the spindle's slow
wander) nobody can know. Friction that grows with the load across the guideway is left out: that
load is not recorded.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from autodb.proofs.machines.lathe.drives import (
    FeedAxis,
    Spindle,
    screw_load,
    torque_law,
    warm_share,
)
from autodb.proofs.machines.lathe.machine import Lathe
from autodb.proofs.runs.lathe.lathe_cuts import LatheCuts

Array = NDArray[np.float64]

HALF_CUT_S = 4.0
"""From the start of a cut, which is recorded, to its middle: half of ``DURATION_S``."""


def feed_force_N(axis: FeedAxis, known: LatheCuts, tested: LatheCuts) -> Array:
    """Return the force (n,) on test cuts: the load current, freed of the magnetising one, is linear
    in what presses on the screw.
    """
    columns, onto = _load_columns(axis, known), _load_columns(axis, tested)
    coefficients = np.linalg.lstsq(columns, known.force_N, rcond=None)[0]
    return np.asarray(onto @ coefficients)


def _load_columns(axis: FeedAxis, cuts: LatheCuts) -> Array:
    load_A = np.sqrt(np.maximum(cuts.range_A**2 - axis.magnetising_A**2, 0.0))
    per_newton = screw_load(axis, cuts.feed_mm_s)
    return np.column_stack([load_A / per_newton, 1.0 / per_newton])


def tangential_force_N(spindle: Spindle, known: LatheCuts, tested: LatheCuts) -> Array:
    """Return the force (n,) on test cuts; only the sizes of a and b are fitted."""

    def error(values: Array) -> Array:
        return _torque_Nm(spindle, values, known) - known.torque_Nm

    start = np.array([spindle.torque_per_A_Nm, spindle.exponent])
    fitted = least_squares(error, start).x
    return 1000.0 * _torque_Nm(spindle, fitted, tested) / tested.radius_mm


def _torque_Nm(spindle: Spindle, values: Array, cuts: LatheCuts) -> Array:
    there = replace(spindle, torque_per_A_Nm=float(values[0]), exponent=float(values[1]))
    scale, exponent = torque_law(there, cuts.speed_rpm)
    shown = 1.0 - warm_share(spindle, cuts.clock_s + HALF_CUT_S)
    return np.asarray(scale * np.maximum(cuts.rise_A, 0.0) ** exponent / shown)


def oracle_force_N(axis: str, known: LatheCuts, tested: LatheCuts) -> Array:
    """Return the force (n,) that the oracle senses with an axis on test cuts."""
    nominal = Lathe()
    if axis == "spindle":
        return tangential_force_N(nominal.spindle, known, tested)
    return feed_force_N(nominal.x if axis == "x" else nominal.z, known, tested)
