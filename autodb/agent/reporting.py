"""Gather what a machine's report page shows from the database."""

from pathlib import Path
from typing import Any

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb import forward
from autodb.agent.calibrations import as_calibration, current_calibrations
from autodb.agent.importing import cuts_as_table
from autodb.agent.machines import find_machine
from autodb.agent.refreshing import (
    as_sensed_cuts,
    chain,
    forces_of_pair,
    pair_name,
)
from autodb.agent.tracing import Node, trace
from autodb.fitting import NORMAL_95
from autodb.inverse import SensedCuts, learn
from autodb.page import CalibrationPlot, JobRow, LearningCurve, Page, PredictedSensed
from autodb.sensing import ranges
from autodb.sensing.holds import ANY, holds_of
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
        current = current_calibrations(session, owner.id, axis.name)
        plots += [_calibration_plot(row) for row in current]
    return plots


def _calibration_plot(row: models.Calibration) -> CalibrationPlot:
    cuts = [cut for recording in row.recordings for cut in recording.cuts]
    table = cuts_as_table(cuts, path=Path(row.recordings[0].path))
    found = as_calibration(row)
    its = np.array([not found.holds.against(cut) for cut in holds_of(table, row.axis)])
    force_N = np.where(its, table[f"force.{row.component}"], np.nan)
    points = ranges.calibration_points(table, row.axis, force_N=force_N)
    name = AXIS_NAMES.get(row.axis, row.axis)
    return CalibrationPlot(
        axis=f"{name} ({found.holds.words()})" if found.holds != ANY else name,
        component=row.component,
        estimate=found.form.value(found.coefficients, points.felt),
        target=points.target,
        equation=found.form.equation(found.coefficients, row.unit, row.current_unit),
        unit=row.unit,
        rmse=row.scores["rmse"],
        offered=row.offered,
        verdict=row.verdict.split(": ", maxsplit=1)[1],
    )


def _drive_terms(session: Session, machine_id: int) -> list[tuple[str, str, str]]:
    newest: dict[str, models.ChannelModel] = {}
    rows = session.scalars(
        select(models.ChannelModel)
        .where(models.ChannelModel.machine_id == machine_id)
        .order_by(models.ChannelModel.version)
    )
    for row in rows:
        newest[row.channel] = row
    meaning = {(term.name, term.form): term.statement for term in TERMS}
    return [
        (
            f"{AXIS_NAMES.get(model.axis, model.axis)}: {term['term']}",
            f"{term['value']:.3g} ± {2 * term['sd']:.2g} {term['unit']}",
            meaning[term["term"], term.get("form", "")],
        )
        for model in newest.values()
        for term in model.terms
    ]


def _forces(session: Session, machine_id: int, row: models.CuttingParameters) -> SensedCuts:
    """Return the sensed cuts behind a version of a pair's parameters, oldest first."""
    felt_by = {
        f.calibration.id: f.calibration for v in chain(row) for f in v.forces if f.calibration
    }
    current = list(felt_by.values())
    forces = forces_of_pair(session, machine_id, row.pair_id, row.operation, current)
    return as_sensed_cuts(forces)


def _curve(component: str, cuts: SensedCuts) -> LearningCurve:
    """Learn from the first 1, 2, … cuts: the belief after each."""
    count = np.arange(1, len(cuts.force_N) + 1)
    beliefs = [learn(cuts.part(slice(0, int(n)))).belief for n in count]
    return LearningCurve(
        component=component,
        n=count.astype(np.float64),
        mean=np.array([b.mean[:2] for b in beliefs]),
        sd=np.array([np.sqrt(np.diag(b.covariance)[:2]) for b in beliefs]),
    )


def _check(component: str, cuts: SensedCuts) -> PredictedSensed:
    """Learn from the oldest cuts and predict what the drives feel in the newest ones."""
    first = max(2, int(LEARNT_SHARE * len(cuts.force_N)))
    learnt = learn(cuts.part(slice(0, first)))
    rest = cuts.part(slice(first, None))
    mean, sd = forward.force_N(rest.feed_mm, rest.depth_mm, learnt)
    half = NORMAL_95 * np.sqrt(sd**2 + rest.sd_N**2)
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
