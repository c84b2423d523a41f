"""Calibrations on their way into the database, and out of it as the records that sensing takes."""

from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from autodb.agent.rows.calibrations import current_calibrations, holds_for
from autodb.sensing.dynamometer import ForceError
from autodb.sensing.ranges.calibration import Calibration, Scores
from autodb.sensing.ranges.domain import Domain, NearForm
from autodb.sensing.ranges.error_kinds import ErrorKinds
from autodb.sensing.ranges.folding import Fold
from autodb.sensing.ranges.forms import stored_form
from autodb.sensing.ranges.outliers import Outlier
from autodb.sensing.ranges.validity import Holds
from autodb.store import models


def keep_calibration(
    session: Session, machine_id: int, recordings: list[int], calibration: Calibration
) -> tuple[int, bool]:
    """Store a calibration unless it is there already; return its version and whether it is new."""
    last = _alike(current_calibrations(session, machine_id, calibration.axis), calibration.holds)
    coefficients = calibration.coefficients.tolist()
    if last is not None and sorted(r.id for r in last.recordings) == recordings:
        alike = (last.kind, last.channel) == (calibration.form.kind, calibration.channel)
        separated = last.cut_sd is not None and last.domain is not None
        errors = tuple(ForceError(**one) for one in last.reference_errors or ())
        alike &= errors == calibration.reference_errors
        close = alike and np.allclose(last.coefficients, coefficients, rtol=1e-9, atol=0.0)
        if separated and close:
            return last.version, False
    version = _newest_version(session, machine_id, calibration.axis) + 1
    sources = list(
        session.scalars(
            select(models.StoredRecording).where(models.StoredRecording.id.in_(recordings))
        )
    )
    session.add(
        models.CalibrationVersion(
            machine_id=machine_id,
            axis=calibration.axis,
            version=version,
            component=calibration.component,
            kind=calibration.form.kind,
            **asdict(calibration.holds),
            parameters=calibration.form.parameters(),
            channel=calibration.channel,
            current_unit=calibration.current_unit,
            unit=calibration.unit,
            coefficients=coefficients,
            covariance=calibration.covariance.tolist(),
            cut_sd=calibration.errors.cut_sd,
            gain_share=calibration.errors.gain_share,
            reference_share=calibration.errors.reference_share,
            current_sd=calibration.errors.current_sd,
            group_covariance=_listed(calibration.errors.group),
            domain=_kept_domain(calibration.domain),
            reference_errors=[asdict(one) for one in calibration.reference_errors] or None,
            scores=asdict(calibration.scores),
            scores_with_transients=asdict(calibration.scores_with_transients),
            transients=list(calibration.transients),
            outliers=[asdict(one) for one in calibration.outliers],
            trials={k: None if np.isnan(v) else v for k, v in calibration.trials.items()},
            current_low=calibration.current_low,
            current_high=calibration.current_high,
            offered=calibration.offered,
            verdict=calibration.verdict,
            recordings=sources,
        )
    )
    return version, True


def _newest_version(session: Session, machine_id: int, axis: str) -> int:
    newest = select(func.max(models.CalibrationVersion.version))
    of_axis = (
        models.CalibrationVersion.machine_id == machine_id,
        models.CalibrationVersion.axis == axis,
    )
    return session.scalar(newest.where(*of_axis)) or 0


def _alike(rows: list[models.CalibrationVersion], holds: Holds) -> models.CalibrationVersion | None:
    return next((row for row in rows if holds_for(row) == holds), None)


def as_calibration(row: models.CalibrationVersion) -> Calibration:
    """Return a stored calibration as the record that sensing takes."""
    return Calibration(
        form=stored_form(row.kind, row.parameters),
        axis=row.axis,
        component=row.component,
        channel=row.channel,
        current_unit=row.current_unit,
        unit=row.unit,
        coefficients=np.array(row.coefficients),
        covariance=np.array(row.covariance),
        errors=_error_kinds(row),
        scores=Scores(**row.scores),
        scores_with_transients=Scores(**row.scores_with_transients),
        transients=tuple(row.transients),
        outliers=tuple(Outlier(**one) for one in row.outliers or ()),
        trials={k: np.nan if v is None else v for k, v in (row.trials or {}).items()},
        current_low=row.current_low,
        current_high=row.current_high,
        holds=holds_for(row),
        domain=_domain(row.domain),
        reference_errors=tuple(ForceError(**one) for one in row.reference_errors or ()),
    )


def _kept_domain(domain: Domain | None) -> dict[str, Any] | None:
    """Return a domain as JSON takes it: ranges, rivals by kind, coefficients and weight, a fold."""
    if domain is None:
        return None
    rivals = [
        {"kind": one.form.kind, "coefficients": one.coefficients.tolist(), "weight": one.weight}
        for one in domain.rivals
    ]
    ranges = {name: list(ends) for name, ends in domain.ranges.items()}
    kept = {"ranges": ranges, "target": list(domain.target), "rivals": rivals}
    return kept if domain.fold is None else kept | {"fold": asdict(domain.fold)}


def _domain(kept: dict[str, Any] | None) -> Domain | None:
    if kept is None:
        return None
    rivals = tuple(
        NearForm(stored_form(one["kind"], None), np.array(one["coefficients"]), one["weight"])
        for one in kept["rivals"]
    )
    ranges = {name: (low, high) for name, (low, high) in kept["ranges"].items()}
    low, high = kept["target"]
    fold = Fold(**kept["fold"]) if "fold" in kept else None
    return Domain(ranges, (low, high), rivals, fold)


def _error_kinds(row: models.CalibrationVersion) -> ErrorKinds:
    """Return the kinds of error; 0.1.0 kept one, and what is shared in the covariance."""
    if row.cut_sd is None:
        return ErrorKinds(cut_sd=row.scores["rmse"], gain_share=0.0, reference_share=0.0)
    group = None if row.group_covariance is None else np.array(row.group_covariance)
    shares = (row.gain_share or 0.0, row.reference_share or 0.0)
    return ErrorKinds(row.cut_sd, *shares, group, row.current_sd or 0.0)


def _listed(matrix: NDArray[np.float64] | None) -> list[list[float]] | None:
    return None if matrix is None else [[float(one) for one in row] for row in matrix]
