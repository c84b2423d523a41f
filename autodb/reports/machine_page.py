"""Gather what a machine's report page shows from the database."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import select
from sqlalchemy.orm import Session

from autodb.agent.answer.traced_forces import Node
from autodb.agent.answer.tracing import trace
from autodb.agent.learn.precision_history import LearningCurve
from autodb.agent.learn.starting import start_of
from autodb.agent.rows.calibration_records import as_calibration
from autodb.agent.rows.calibrations import current_calibrations
from autodb.agent.rows.catalogue import numbers_of
from autodb.agent.rows.machines import find_machine
from autodb.agent.rows.posteriors import as_posterior, pair_name, version_chain
from autodb.agent.rows.recordings import cuts_as_table
from autodb.agent.rows.sensed_forces import QUANTITY, as_cuts
from autodb.agent.sense.sensed import as_observed, sd_beside_N
from autodb.cutting.turning import PASSIVE_AXIS
from autodb.files.job import Job
from autodb.fitting.gaussian import NORMAL_95
from autodb.pairs.averaging import learn_averaging
from autodb.pairs.engaged import BY_NAME
from autodb.pairs.forecast import forecast
from autodb.pairs.posterior import PairPosterior
from autodb.reports import figures
from autodb.reports.page import CalibrationPlot, JobRow, Page, PredictedSensed
from autodb.sensing.ranges.points import calibration_points
from autodb.sensing.ranges.validity import ANY, holds_of
from autodb.store import Store, models
from autodb.terms.vocabulary import all_terms
from autodb.wording import msgid, phrase
from autodb.wording.kept import said_again

Array = NDArray[np.float64]

LEARNT_SHARE = 0.7
"""Share of a pair's cuts, the oldest, that the page learns from to predict the others."""
LADDER = (0, 1, 2, 3, 5, 8, 13, 21, 34, 55, 89, 144)
"""Cuts after which the page shows the posterior."""
AXIS_NAMES = {"x": msgid("X axis"), "z": msgid("Z axis"), "spindle": msgid("Spindle")}


def machine_page(store: Store, machine: str, prediction_id: int) -> Page:
    """Return the report of a machine around one stored prediction of a pair that it has cut."""
    trace_text = "\n".join(_lines(trace(store, "prediction", prediction_id)))
    with store.reading() as session:
        owner = find_machine(session, machine)
        prediction = session.get_one(models.Prediction, prediction_id)
        parameters = next(row for row in prediction.parameters if row.state is None)
        history = _History(session, owner, parameters)
        checks = history.checks()
        operations = [cut.get("operation", "") for cut in prediction.cuts]
        forces = (figures.force_title(component, operations) for component in "xyz")
        return Page(
            machine=machine,
            pair=pair_name(parameters.pair),
            headline=_headline(checks, parameters),
            calibrations=tuple(calibration_plots(session, owner)),
            drive_terms=tuple(_drive_terms(session, owner.id)),
            learning=tuple(history.curves(Job.model_validate(prediction.job))),
            checks=tuple(checks),
            job_name=prediction.job["name"],
            job_columns=("Speed", *forces, "Torque", "Power"),
            job_rows=tuple(row for cut in prediction.cuts for row in _job_rows(cut)),
            trace_text=trace_text,
        )


def _lines(node: Node, depth: int = 0) -> list[str]:
    own = "  " * depth + node.text
    return [own, *(line for source in node.sources for line in _lines(source, depth + 1))]


def calibration_plots(session: Session, owner: models.Machine) -> list[CalibrationPlot]:
    """Return what is drawn of a machine's calibrations that hold now."""
    plots = []
    for axis in owner.axes:
        current = current_calibrations(session, owner.id, axis.name)
        plots += [_calibration_plot(row) for row in current]
    return plots


def _calibration_plot(row: models.CalibrationVersion) -> CalibrationPlot:
    cuts = [cut for recording in row.recordings for cut in recording.cuts]
    table = cuts_as_table(cuts, path=Path(row.recordings[0].path))
    found = as_calibration(row)
    its = np.array([not found.holds.against(cut) for cut in holds_of(table, row.axis)])
    force_N = np.where(its, table[f"force.{row.component}"], np.nan)
    points = calibration_points(table, row.axis, force_N=force_N)
    name = phrase(AXIS_NAMES.get(row.axis, row.axis))
    if found.holds != ANY:
        holds = said_again(found.holds.words())
        name = phrase("{axis} ({conditions})", axis=name, conditions=holds)
    return CalibrationPlot(
        axis=name,
        component=row.component,
        estimate=found.form.value(found.coefficients, points.sensed),
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
        .where(
            models.ChannelModel.machine_id == machine_id, models.ChannelModel.undone_at.is_(None)
        )
        .order_by(models.ChannelModel.version)
    )
    for row in rows:
        newest[row.channel] = row
    meaning = {(term.name, term.form): term.statement for term in all_terms()}
    return [
        (
            f"{AXIS_NAMES.get(model.axis, model.axis)}: {term['term']}",
            f"{term['value']:.3g} ± {2 * term['sd']:.2g} {term['unit']}",
            meaning[term["term"], term.get("form", "")],
        )
        for model in newest.values()
        for term in model.terms
    ]


class _History:
    """The cuts behind a pair's parameters, oldest first, and the posteriors on the way."""

    def __init__(
        self, session: Session, owner: models.Machine, row: models.CuttingParameters
    ) -> None:
        forces = [force for version in version_chain(row) for force in version.forces]
        self._forces = sorted(forces, key=lambda force: (force.cut_id, force.component))
        self._cuts = list(dict.fromkeys(force.cut_id for force in self._forces))
        self._pair = row.pair
        pair = row.pair
        start = start_of(session, owner.id, pair.material.name, pair.tool.name).posterior
        newest = as_posterior(row)
        self._start = replace(start, terms=newest.terms)
        self._sensed = sorted({force.component for force in forces})
        self._learnt = {len(self._cuts): newest}

    def _after(self, cuts: int) -> PairPosterior:
        """Return the posterior after the oldest cuts."""
        if cuts not in self._learnt:
            kept = set(self._cuts[:cuts])
            some = [force for force in self._forces if force.cut_id in kept]
            self._learnt[cuts] = (
                learn_averaging(self._start, as_observed(some, terms=self._start.terms)).past()
                if some
                else self._start
            )
        return self._learnt[cuts]

    def curves(self, job: Job) -> list[LearningCurve]:
        """Return what was expected of the job's first cut, of each component that it shows.

        A program has no cut of one condition, and so no curves.
        """
        if not job.cut:
            return []
        cut, tool = job.cut[0], self._pair.tool
        stated = [cut.conditions(tool.diameter_mm)]
        asked = BY_NAME[cut.operation].cuts(numbers_of(tool), stated, called=tool.name)
        count = sorted({*(n for n in LADDER if n < len(self._cuts)), len(self._cuts)})
        expected = [forecast(self._after(n), asked) for n in count]
        return [
            LearningCurve(
                component=component,
                cut=f"'{cut.name}'",
                operation=cut.operation,
                n=np.array(count, dtype=np.float64),
                mean=np.array([one.mean[0, QUANTITY[component]] for one in expected]),
                sd=np.array([one.sd[0, QUANTITY[component]] for one in expected]),
            )
            for component in self._sensed
            if component != PASSIVE_AXIS.get(cut.operation)
        ]

    def checks(self) -> list[PredictedSensed]:
        """Learn from the oldest cuts and predict what the drives sense in the newest ones."""
        first = max(2, int(LEARNT_SHARE * len(self._cuts)))
        learnt, later = self._after(first), set(self._cuts[first:])
        rest = [force for force in self._forces if force.cut_id in later]
        cuts = list({force.cut_id: force.cut for force in rest}.values())
        number, made = as_cuts(cuts)
        expected = [forecast(learnt, some) for some in made]
        mean, sd = (np.concatenate([getattr(one, k) for one in expected]) for k in ("mean", "sd"))
        return [
            _check(
                component,
                some,
                mean[at, QUANTITY[component]],
                sd[at, QUANTITY[component]],
                known=[one.key for one in learnt.shared],
            )
            for component in self._sensed
            if (some := [force for force in rest if force.component == component])
            and (at := [number[force.cut_id] for force in some])
        ]


def _check(
    component: str,
    forces: list[models.SensedForce],
    mean: Array,
    sd: Array,
    *,
    known: Sequence[str],
) -> PredictedSensed:
    """Return sensed forces (n,) beside what was expected of them.

    ``known``: keys of the errors that what is expected leaves room for. Others, as those of a day
    that is not over, are the reading's own.
    """
    sensed_N = np.array([force.value_N for force in forces], dtype=np.float64)
    sensed_sd_N = np.array([sd_beside_N(force, known) for force in forces])
    half = NORMAL_95 * np.hypot(sd, sensed_sd_N)
    return PredictedSensed(
        component=component,
        label=[_cut_words(force.cut) for force in forces],
        predicted_N=mean,
        low_N=mean - half,
        high_N=mean + half,
        sensed_N=sensed_N,
        sensed_sd_N=sensed_sd_N,
    )


def _cut_words(cut: models.Cut) -> str:
    """Return how deep and how fast a cut was fed."""
    said = [
        f"{cut.conditions[channel]:g} {unit}"
        for channel, unit in (("cutting.depth", "mm deep"), ("cutting.feed", "mm feed"))
        if channel in cut.conditions
    ]
    return ", ".join([cut.operation or "turn", *said])


def _headline(
    checks: list[PredictedSensed], parameters: models.CuttingParameters
) -> tuple[tuple[str, str], ...]:
    inside = sum(int(np.sum((c.sensed_N >= c.low_N) & (c.sensed_N <= c.high_N))) for c in checks)
    total = sum(len(c.sensed_N) for c in checks)
    off = np.concatenate([np.abs(c.predicted_N / c.sensed_N - 1.0) for c in checks])
    return (
        ("Predicted against measured, median difference", f"{100 * float(np.median(off)):.1f} %"),
        ("Measured forces inside their 95 % interval", f"{inside} of {total}"),
        ("Cuts in the fit", str(parameters.n_cuts)),
    )


def _job_rows(cut: dict[str, Any]) -> Iterator[JobRow]:
    """Yield a stored cut's mean, and its start and end where they are at other diameters."""
    ends = {name: cut[name] for name in ("start", "end") if cut.get(name)}
    changes = len({one["diameter_mm"] for one in ends.values()}) > 1
    yield _job_row(cut["name"] + (": mean" if changes else ""), cut)
    if changes:
        yield from (_job_row(f"{cut['name']}: {name}", one) for name, one in ends.items())


def _job_row(name: str, one: dict[str, Any]) -> JobRow:
    cells = [
        f"{one['speed_rpm']:.0f} rpm",
        *(_span(one[f"force_{component}_N"], "N") for component in "xyz"),
        _span(one["torque_N_m"], "N·m"),
        _span(one["power_W"], "kW", per=1000.0),
    ]
    return JobRow(name, tuple(cells))


def _span(value: dict[str, float] | None, unit: str, *, per: float = 1.0) -> str:
    """Return 'value unit (low to high)'; empty where the component is not sensed."""
    if value is None:
        return ""
    digits = 0 if abs(value["value"] / per) >= 100 else 1 if abs(value["value"] / per) >= 10 else 2
    number, low, high = (f"{value[k] / per:.{digits}f}" for k in ("value", "low", "high"))
    return f"{number} {unit} ({low} to {high})"
