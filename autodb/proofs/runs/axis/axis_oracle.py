"""The least error that a friction field of a reference axis can have: its own forms, fitted.

The oracle knows the laws of ``reference_friction``: which curves over speed, where the
covers bend, how long the folds are, the ways of the sliders, how warm the lubricant was. Sizes,
weight and inertia it must fit to the same segments as anybody; how runs differ nobody can know.
"""

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.axis.motion import TrueMotion
from autodb.proofs.machines.axis.reference_axis import (
    PLACE_SD,
    RUN_SD,
    SLOW_SD,
    STICK_SD,
    ReferenceAxis,
    Traced,
    stick_share,
)
from autodb.proofs.machines.axis.reference_friction import slid_state
from autodb.proofs.runs.axis.axis_cells import SweepSegments

Array = NDArray[np.float64]


def currents_A(made: Traced, where: SweepSegments) -> tuple[Array, Array]:
    """Return the current of every row of the sweep, and of the contour, (n,) each.

    Every speed and direction counts alike, but for what sticks and slips. Inertia, which no pass at
    constant speed shows, is
    given.
    """
    axis = made.axis
    columns, onto = (_columns(axis, run.motion) for run in (made.sweep, made.contour))
    field = where.cells(made.sweep.current_A)
    root = np.sqrt(field.weights / _variance(axis, field.v_mm_s))
    seen = np.column_stack([where.means(one) for one in columns.T])
    sizes = np.linalg.lstsq(seen * root[:, None], field.current_A * root, rcond=1e-10)[0]
    sweep, contour = made.sweep.motion, made.contour.motion
    return (
        np.asarray(columns @ sizes + axis.inertia_A_s2_mm * sweep.a),
        np.asarray(onto @ sizes + axis.inertia_A_s2_mm * contour.a),
    )


def _variance(axis: ReferenceAxis, v_mm_s: Array) -> Array:
    """Return how friction differs from pass to pass, relative, (n,)."""
    sticks = STICK_SD * stick_share(v_mm_s) * axis.sticks
    return np.asarray(RUN_SD**2 + SLOW_SD**2 + PLACE_SD**2 + sticks**2)


def _columns(axis: ReferenceAxis, motion: TrueMotion) -> Array:
    """Return the columns (n, k) of everything whose size is fitted; the last is the weight's."""
    friction, travel = axis.friction, axis.friction.travel
    speed = np.abs(motion.v)
    turned = slid_state(motion.x, friction.slides_mm)
    warmth = friction.warming.warmth(friction.power(motion.x, motion.v), motion.t[1] - motion.t[0])
    rubs = turned * (1.0 - friction.warming.drop * warmth)
    over_speed = [
        way * law
        for one, way in ((friction.plus, motion.v >= 0.0), (friction.minus, motion.v < 0.0))
        for law in (
            np.ones_like(speed), one.viscous_curve.share(speed), one.dip_curve.share(speed)
        )
    ]  # fmt: skip
    waves = [mm for _, mm, _ in travel.folds] + [travel.pitch_mm, 0.5 * travel.pitch_mm]
    turns = [2.0 * np.pi * motion.x / mm for mm in waves]
    low_mm, _ = travel.ends_mm
    along = [
        np.log1p((motion.x - low_mm) / travel.bend_mm),
        *(wave(turn) for turn in turns for wave in (np.sin, np.cos)),
    ]
    columns = [rubs * one for one in (*over_speed, *along)]
    if axis.weight_A:
        columns.append(np.ones_like(speed))
    return np.column_stack(columns)
