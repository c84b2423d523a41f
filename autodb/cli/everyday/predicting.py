"""`predict`: what a machine answers for a job."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Protocol

import typer

from autodb.cli._common import (
    Database,
    Json,
    MachineName,
    SelfContained,
    check_page,
    opened_machine,
    say,
    show,
    table,
)
from autodb.cli._reader import headed, in_english, interval, shown_again, table_number
from autodb.wording import ENGLISH, amount_words, listed, msgid, phrase, presentation, shop_amount

if TYPE_CHECKING:
    from autodb.agent.answer.predicting import JobAnswer, Predicted
    from autodb.agent.learn.known import Behind
    from autodb.files.machine import AxisLimits
    from autodb.forward.cut_figures import CutFigures, JobTotals
    from autodb.forward.limits import Exceeding, LimitStanding
    from autodb.forward.prediction import Moment, Peaks, PredictedCut

JobFile = Annotated[
    Path, typer.Argument(readable=False, help="Job file (TOML) with the cuts to predict.")
]
ToolPath = Annotated[
    Path | None,
    typer.Option(
        "--tool-file",
        metavar="FILE",
        help="What is known of the tool: a tool file (TOML), a tool bit of FreeCAD (.fctb), or a "
        "catalogue's data: ISO 13399 (.p21), GTC (.zip), DIN 4000 (.xml, .csv).",
    ),
]


def predict_command(
    job: JobFile,
    machine: MachineName = None,
    csv: Annotated[
        Path | None,
        typer.Option("--csv", metavar="FILE", help="Write the answer as a table: FILE.csv."),
    ] = None,
    plot: Annotated[
        Path | None,
        typer.Option("--plot", metavar="FILE", help="Write the answer as a picture: FILE.html."),
    ] = None,
    self_contained: SelfContained = False,
    tool_file: ToolPath = None,
    beside: Annotated[
        Path | None,
        typer.Option(
            "--beside", metavar="JOB", help="Another job, to compare; its answer is not kept."
        ),
    ] = None,
    json: Json = False,
    db: Database = None,
) -> None:
    """Predict forces, torque and power of a job's cuts, with 95 % intervals."""
    from autodb.agent.answer.predicting import answer_job, predict_job
    from autodb.agent.rows.machines import limits_of_machine
    from autodb.files.job import read_job
    from autodb.files.targets import check_target

    if csv is not None:
        check_target(csv, suffix=".csv", option="--csv")
    check_page(plot, option="--plot", self_contained=self_contained)
    asked = read_job(job)
    other = None if beside is None else read_job(beside)
    made = [cut.operation for cut in asked.cut]
    stated = None if tool_file is None else stated_tool(tool_file, asked.tool, made)[1]
    with opened_machine(db, machine) as (store, name):
        with in_english(json):
            answer = predict_job(store, name, asked, tool=stated)
            same = stated if other is not None and other.tool == asked.tool else None
            compared = () if other is None else (answer, answer_job(store, name, other, tool=same))
        limits, drawn = limits_of_machine(store, name), answer
        if json and plot is not None and presentation() != ENGLISH:  # its notes for the reader
            shown = answer_job(store, name, asked, tool=stated)
            drawn = replace(answer, notes=shown.notes)
    if csv is not None:
        _write_table(answer, limits, csv)
    if plot is not None:
        _write_picture(drawn, limits, plot, self_contained=self_contained)
    if json:
        _say_as_json(answer, compared)
        return
    _say_predicted(answer, compared)
    for what, path in ((msgid("table: {file}"), csv), (msgid("picture: {file}"), plot)):
        if path is not None:
            say(phrase(what, file=path))
    number = answer.prediction_id
    say(phrase("prediction {number}: 'autodb trace prediction {number}'", number=number))


def _say_predicted(answer: "Predicted", compared: "tuple[JobAnswer, ...]") -> None:
    """Print an answer as tables and sentences, and beside it one that is compared."""
    from autodb.forward.bending import bending_in_words

    job = answer.job
    pair = f"{job.material} / {job.tool}"
    show_predicted(phrase("Job '{job}': {pair}", job=job.name, pair=pair), answer.cuts)
    show_figures(answer.cuts, answer.figures, answer.totals)
    for line in bending_in_words(answer.cuts, answer.bending):
        say(line)
    say_answer(answer.cuts, answer)
    if compared:
        from autodb.cli.everyday.comparing import show_beside

        show_beside(compared)


def _write_picture(
    answer: "Predicted", limits: "dict[str, AxisLimits]", plot: Path, *, self_contained: bool
) -> None:
    from autodb.reports.planned.predicted import render_prediction
    from autodb.reports.written import write_page

    write_page(plot, render_prediction(answer, limits), self_contained=self_contained)


def _say_as_json(answer: "Predicted", compared: "tuple[JobAnswer, ...]") -> None:
    """Print an answer, or two that are compared, as JSON."""
    from pydantic import TypeAdapter

    from autodb.agent.answer.predicting import JobAnswer, Predicted

    if compared:
        say(TypeAdapter(tuple[JobAnswer, ...]).dump_json(compared, indent=1).decode())
    else:
        say(TypeAdapter(Predicted).dump_json(answer, indent=1).decode())


def stated_tool(
    path: Path, name: str | None, operations: Iterable[str] = ()
) -> tuple[str, dict[str, float]]:
    """Return a tool file's name and its geometry by name.

    Raises UnusableInput for another tool, or one of a kind that makes no cut of ``operations``.
    """
    from autodb.errors import UnusableInput
    from autodb.files.job_cut import refuse_other_kind
    from autodb.files.tool import geometry_of, read_tool

    file = read_tool(path, name)
    if name is not None and file.name != name:
        raise UnusableInput(
            phrase(
                "{file}: is of tool '{file_2}', and '{name}' is asked for; use one name",
                file=path,
                file_2=file.name,
                name=name,
            )
        )
    refuse_other_kind(path, file, operations)
    return file.name, geometry_of(file).model_dump(exclude_none=True)


def _write_table(answer: "Predicted", limits: "dict[str, AxisLimits]", csv: Path) -> None:
    from autodb.files.targets import write_text
    from autodb.forward.predictedfile import prediction_as_csv

    with in_english():  # programs read it
        text = prediction_as_csv(answer.cuts, limits, asked=answer.job)
    write_text(csv, text)


class AnswerOptions(Protocol):
    """What comes with predicted cuts, asked for by a job or alone."""

    @property
    def behind(self) -> "Behind":
        """On what the answer rests."""

    @property
    def notes(self) -> tuple[str, ...]:
        """What a planner has to know of it."""

    @property
    def exceeds(self) -> "tuple[Exceeding, ...]":
        """The limits that a cut may exceed."""

    @property
    def limits(self) -> "tuple[LimitStanding, ...]":
        """How the cuts stand to all limits."""


def show_figures(
    cuts: "Sequence[PredictedCut]",
    figures: "Sequence[CutFigures]",
    totals: "JobTotals | None" = None,
) -> None:
    """Print what a planner counts of cuts: time, removal rate, specific force, energy."""
    rows = table(
        "",
        phrase("cut"),
        headed(phrase("time"), "s"),
        headed(phrase("removal"), "cm³/min"),
        headed(phrase("specific force"), "N/mm²"),
        headed(phrase("energy"), "kJ"),
    )
    for cut, one in zip(cuts, figures, strict=True):
        rows.add_row(
            cut.name or phrase(cut.operation),
            "" if one.time_s is None else table_number(one.time_s, "s", 1),
            "" if one.removal_cm3_min is None else table_number(one.removal_cm3_min, "cm³/min", 1),
            "" if one.specific_N_mm2 is None else interval(one.specific_N_mm2, "N/mm²"),
            "" if one.energy_kJ is None else interval(one.energy_kJ, "kJ"),
        )
    show(rows)
    if totals is None or len(figures) == 1 or totals.time_s is None:
        return
    removed = table_number(totals.removed_cm3 or 0.0, "cm³", 1)
    said = [amount_words(totals.time_s, "s", ".1f"), f"{removed} {shop_amount(1.0, 'cm³')[1]}"]
    if totals.energy_kJ is not None:
        said.append(f"{interval(totals.energy_kJ, 'kJ')} kJ")
    say(phrase("all cuts: {what}", what=listed(said)))


def say_answer(cuts: "Sequence[PredictedCut]", answer: AnswerOptions) -> None:
    """Print below predicted cuts how they stand to limits, the notes, and what is behind it."""
    from autodb.forward.limits import standings_in_words

    for one in answer.exceeds:
        name, said = cuts[one.cut - 1].name, one.statement
        if name:
            cut = phrase("cut {number} '{name}'", number=one.cut, name=name)
            said = phrase("{cut}: {said}", cut=cut, said=said)
        say(said)
    for line in standings_in_words(answer.limits):
        say(line)
    for note in answer.notes:
        say(shown_again(note))
    say(phrase("95 % intervals; behind it: {behind}", behind=behind_words(answer.behind)))


def behind_words(behind: "Behind") -> str:
    """Return on how many cuts and which version of a pair's parameters an answer rests."""
    if behind.parameters is None:
        return phrase("no cut of this pair")
    return phrase(
        "{cuts} cuts, version {version} (parameters {parameters})",
        cuts=behind.cuts,
        version=behind.version,
        parameters=behind.parameters,
    )


def show_predicted(title: str, cuts: "Sequence[PredictedCut]") -> None:
    """Print predicted cuts; below the means their start and end, where these differ, and peaks."""
    operations = [cut.operation for cut in cuts]
    rows = table(
        title,
        phrase("cut"),
        headed("", "rpm"),
        headed("", "m/min"),
        *(headed(_force_words(axis, operations), "N") for axis in "xyz"),
        headed(phrase("torque"), "N·m"),
        headed(phrase("power"), "W"),
    )
    for cut in cuts:
        forces = {"x": cut.force_x_N, "y": cut.force_y_N, "z": cut.force_z_N}
        name = cut.name or phrase(cut.operation)
        rows.add_row(
            phrase("{cut}: mean", cut=name) if cut.changes else name,
            table_number(cut.speed_rpm, "rpm", 0),
            table_number(cut.speed_m_min, "m/min", 0),
            *(
                interval(v, "N") + (" *" if axis == cut.passive else "")
                for axis, v in forces.items()
            ),
            interval(cut.torque_N_m, "N·m"),
            interval(cut.power_W, "W"),
        )
        for called, some in cut.statistics:
            said = map(interval, some.quantities, ("N", "N", "N", "N·m", "W"))
            rows.add_row(f"  {phrase(called)}", *_speeds(some), *said)
    show(rows)
    if any(cut.passive for cut in cuts):
        say(phrase("* passive force: no drive senses it; it comes from the law alone"))


def _force_words(axis: str, operations: list[str]) -> str:
    """Return what the head of a force's column says, with its name where all cuts give it one."""
    from autodb.cutting.turning import force_role

    return f"{force_role(axis, operations)} force.{axis}".strip()


def _speeds(some: "Moment | Peaks") -> tuple[str, str]:
    from autodb.forward.prediction import Moment

    if isinstance(some, Moment):
        return table_number(some.speed_rpm, "rpm", 0), table_number(some.speed_m_min, "m/min", 0)
    return "", ""
