"""One reference machine: the friction field and the contour of its axes, estimated in several
ways."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.axis.reference_axis import AXES, Traced, recorded_axis
from autodb.proofs.runs.axis import axis_oracle
from autodb.proofs.runs.axis.axis_cells import SweepSegments, segments
from autodb.proofs.runs.axis.axis_errors import contour_errors, field_error
from autodb.proofs.runs.axis.axis_ours import ours
from autodb.proofs.runs.axis.published_axis import published_axis

Array = NDArray[np.float64]

PUBLISHED, OURS, TERMS_ALONE = "as published", "autodb", "autodb, its terms alone"
ORACLE, KNOWN = "oracle", "truth without wander"


@dataclass(frozen=True)
class AxisModelErrors:
    """Errors of one way on one axis, shares: of the measured field and of the true one; of the
    contour, over its current and over its friction, mean of the feeds; by how much its friction is
    predicted too high; of the weight, None where none is estimated.
    """

    way: str
    axis: str
    measured: float
    true: float
    contour: float
    contour_friction: float
    high: float
    weight: float | None


@dataclass(frozen=True)
class _Prediction:
    """Currents of the field's segments, and of the contour's rows, A; and the weight."""

    field_A: Array
    contour_A: Array
    weight_A: float | None = None


def run_axis_gate(seed: int) -> list[AxisModelErrors]:
    """Identify the axes of a seed's machine the published way."""
    errors = []
    for name in AXES:
        made = recorded_axis(seed, name)
        where = segments(made)
        errors.append(_errors_of(PUBLISHED, _published(made, where), made, where))
    return errors


def run_axes(seed: int) -> list[AxisModelErrors]:
    """Identify them in every way."""
    errors = []
    for name in AXES:
        made = recorded_axis(seed, name)
        where = segments(made)
        errors += [_errors_of(way, one, made, where) for way, one in _ways(made, where).items()]
    return errors


def _ways(made: Traced, where: SweepSegments) -> dict[str, _Prediction]:
    found = ours(made, where)
    field_A = where.means(found.sweep_A)
    sweep_A, contour_A = axis_oracle.currents_A(made, where)
    return {
        PUBLISHED: _published(made, where),
        OURS: _Prediction(field_A, found.contour_A, found.weight_A),
        TERMS_ALONE: _Prediction(where.means(found.sweep_terms_A), found.contour_terms_A),
        ORACLE: _Prediction(where.means(sweep_A), contour_A),
        KNOWN: _Prediction(where.means(made.sweep.expected_A), made.contour.expected_A),
    }


def _published(made: Traced, where: SweepSegments) -> _Prediction:
    cells = where.cells(made.sweep.current_A)
    model = published_axis(cells, vertical=made.axis.name == "z")
    motion = made.contour.motion
    return _Prediction(
        model.current_A(cells.x_mm, cells.v_mm_s),
        model.current_A(motion.x, motion.v),
        model.weight_A,
    )


def _errors_of(way: str, one: _Prediction, made: Traced, where: SweepSegments) -> AxisModelErrors:
    true_A = made.axis.weight_A
    errors = contour_errors(made, one.contour_A)
    weighed = one.weight_A is not None and true_A > 0.0
    return AxisModelErrors(
        way=way,
        axis=made.axis.name,
        measured=field_error(where.cells(made.sweep.current_A), one.field_A, true_A),
        true=field_error(where.cells(made.sweep.expected_A), one.field_A, true_A),
        contour=float(np.mean([error.error for error in errors])),
        contour_friction=float(np.mean([error.of_friction for error in errors])),
        high=float(np.mean([error.high for error in errors])),
        weight=abs(one.weight_A / true_A - 1.0) if weighed and one.weight_A is not None else None,
    )
