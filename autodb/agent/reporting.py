"""Gather what a machine's report page shows from the database."""

from pathlib import Path
from typing import Any

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb import forward
from autodb.agent.calibrating import as_calibration, latest_calibration
from autodb.agent.importing import cuts_as_table
from autodb.agent.machines import find_machine
from autodb.agent.refreshing import (
    as_sensed_cuts,
    chain,
    forces_of_pair,
    pair_name,
)
from autodb.agent.tracing import Node, trace
from autodb.inverse import SensedCuts, learn
from autodb.page import CalibrationPlot, JobRow, LearningCurve, Page, PredictedSensed
from autodb.sensing import ranges
from autodb.store import Store, models
from autodb.terms import TERMS

LEARNT_SHARE = 0.7
"""Share of a pair's cuts, the oldest, that the page learns from to predict the others."""
AXIS_NAMES = {"x": "X axis", "z": "Z axis", "spindle": "Spindle"}


def machine_page(store: Store, machine: str, prediction_id: int) -> Page:
    """Return the report of a machine around one stored prediction."""
    trace_text = "\n".join(_lines(trace(store, "prediction", prediction_id)))
    with store.reading() as session:
        owner = find_machine(session, machine)
        prediction = session.get_one(models.Prediction, prediction_id)
        parameters = sorted(prediction.parameters, key=lambda row: (row.operation, row.component))
        several = len({row.operation for row in parameters}) > 1
        forces = [_forces(session, owner.id, row) for row in parameters]
        components = [
            f"{row.component} ({row.operation})" if several else row.component for row in parameters
        ]
        checks = [_check(c, f) for c, f in zip(components, forces, strict=True)]
        return Page(
            machine=machine,
            pair=pair_name(parameters[0].pair),
            headline=_headline(checks, parameters),
            calibrations=tuple(_calibrations(session, owner)),
            drive_terms=tuple(_drive_terms(session, owner.id)),
            learning=tuple(_curve(c, f) for c, f in zip(components, forces, strict=True)),
            checks=tuple(checks),
            job_name=prediction.job["name"],
            job_columns=("Speed", "Force X", "Force Y", "Force Z", "Torque", "Power"),
            job_rows=tuple(_job_row(cut) for cut in prediction.cuts),
            trace_text=trace_text,
        )


def _lines(node: Node, depth: int = 0) -> list[str]:
    own = "  " * depth + node.text
    return [own, *(line for source in node.sources for line in _lines(source, depth + 1))]


def _calibrations(session: Session, owner: models.Machine) -> list[CalibrationPlot]:
    plots = []
    for axis in owner.axes:
        row = latest_calibration(session, owner.id, axis.name)
        if row is None:
            continue
        cuts = [cut for recording in row.recordings for cut in recording.cuts]
        table = cuts_as_table(cuts, path=Path(row.recordings[0].path))
        points, found = ranges.calibration_points(table, row.axis), as_calibration(row)
        plots.append(
            CalibrationPlot(
                axis=AXIS_NAMES.get(row.axis, row.axis),
                component=row.component,
                estimate=found.form.value(found.coefficients, points.felt),
                target=points.target,
                equation=found.form.equation(found.coefficients, row.unit, row.current_unit),
                unit=row.unit,
                rmse=row.scores["rmse"],
                offered=row.offered,
                verdict=row.verdict.split(": ", maxsplit=1)[1],
            )
        )
    return plots


def _drive_terms(session: Session, machine_id: int) -> list[tuple[str, str, str]]:
    newest: dict[str, models.ChannelModel] = {}
    rows = session.scalars(
        select(models.ChannelModel)
        .where(models.ChannelModel.machine_id == machine_id)
        .order_by(models.ChannelModel.version)
    )
    for row in rows:
        newest[row.channel] = row
    meaning = {term.name: term.statement for term in TERMS}
    return [
        (
            f"{AXIS_NAMES.get(model.axis, model.axis)}: {term['term']}",
            f"{term['value']:.3g} ± {2 * term['sd']:.2g} {term['unit']}",
            meaning[term["term"]],
        )
        for model in newest.values()
        for term in model.terms
    ]


def _forces(session: Session, machine_id: int, row: models.CuttingParameters) -> SensedCuts:
    """Return the sensed cuts behind a version of a pair's parameters, oldest first."""
    calibration = chain(row)[-1].forces[0].calibration
    assert calibration is not None  # parameters are learnt from calibrated forces
    forces = forces_of_pair(session, machine_id, row.pair_id, row.operation, calibration.id)
    return as_sensed_cuts(forces, calibration)


def _part(cuts: SensedCuts, rows: slice) -> SensedCuts:
    return SensedCuts(
        feed_mm=cuts.feed_mm[rows],
        depth_mm=cuts.depth_mm[rows],
        force_N=cuts.force_N[rows],
        sd_N=cuts.sd_N[rows],
        common=cuts.common[rows],
        calibration_covariance=cuts.calibration_covariance,
        form=cuts.form,
        coefficients=cuts.coefficients,
    )


def _curve(component: str, cuts: SensedCuts) -> LearningCurve:
    """Learn from the first 1, 2, … cuts: the belief after each."""
    count = np.arange(1, len(cuts.force_N) + 1)
    beliefs = [learn(_part(cuts, slice(0, int(n)))).belief for n in count]
    return LearningCurve(
        component=component,
        n=count.astype(np.float64),
        mean=np.array([b.mean[:2] for b in beliefs]),
        sd=np.array([np.sqrt(np.diag(b.covariance)[:2]) for b in beliefs]),
    )


def _check(component: str, cuts: SensedCuts) -> PredictedSensed:
    """Learn from the oldest cuts and predict what the drives feel in the newest ones."""
    first = max(2, int(LEARNT_SHARE * len(cuts.force_N)))
    learnt = learn(_part(cuts, slice(0, first)))
    rest = _part(cuts, slice(first, None))
    mean, sd = forward.force_N(rest.feed_mm, rest.depth_mm, learnt)
    half = forward.NORMAL_95 * np.sqrt(sd**2 + rest.sd_N**2)
    return PredictedSensed(
        component=component,
        label=[
            f"{depth:g} mm deep, {feed:g} mm/rev"
            for depth, feed in zip(rest.depth_mm, rest.feed_mm, strict=True)
        ],
        predicted_N=mean,
        low_N=mean - half,
        high_N=mean + half,
        sensed_N=rest.force_N,
        sensed_sd_N=rest.sd_N,
    )


def _headline(
    checks: list[PredictedSensed], parameters: list[models.CuttingParameters]
) -> tuple[tuple[str, str], ...]:
    inside = sum(int(np.sum((c.sensed_N >= c.low_N) & (c.sensed_N <= c.high_N))) for c in checks)
    total = sum(len(c.sensed_N) for c in checks)
    off = np.concatenate([np.abs(c.predicted_N / c.sensed_N - 1.0) for c in checks])
    return (
        ("Predicted against felt, median difference", f"{100 * float(np.median(off)):.1f} %"),
        ("Felt forces inside their 95 % interval", f"{inside} of {total}"),
        ("Cuts learnt from", str(max(row.n_cuts for row in parameters))),
    )


def _job_row(cut: dict[str, Any]) -> JobRow:
    cells = [
        f"{cut['speed_rpm']:.0f} rpm",
        *(_span(cut[f"force_{component}_N"], "N") for component in "xyz"),
        _span(cut["torque_N_m"], "N·m"),
        _span(cut["power_W"], "kW", per=1000.0),
    ]
    return JobRow(cut["name"], tuple(cells))


def _span(value: dict[str, float] | None, unit: str, *, per: float = 1.0) -> str:
    """Return 'value unit (low to high)'; empty where the component is not sensed."""
    if value is None:
        return ""
    digits = 0 if abs(value["value"] / per) >= 100 else 1 if abs(value["value"] / per) >= 10 else 2
    number, low, high = (f"{value[k] / per:.{digits}f}" for k in ("value", "low", "high"))
    return f"{number} {unit} ({low} to {high})"
