"""`predict`, `trace`, `demo`: what a machine answers."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Protocol

import typer

from autodb.cli._common import (
    Database,
    Json,
    MachineName,
    opened_machine,
    opened_store,
    say,
    say_json,
    show,
    table,
    working,
)

if TYPE_CHECKING:
    from rich.tree import Tree

    from autodb.agent.answer.predicting import Predicted
    from autodb.agent.answer.tracing import Node
    from autodb.agent.learn.known import Behind
    from autodb.files.machine import AxisLimits
    from autodb.forward.limits import Exceeding
    from autodb.forward.prediction import Interval, Moment, Peaks, PredictedCut

JobFile = Annotated[
    Path, typer.Argument(readable=False, help="Job file (TOML) with the cuts to predict.")
]
Kind = Annotated[
    str,
    typer.Argument(
        help="prediction, parameters, force, calibration, model, mismatch or recording."
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
    json: Json = False,
    db: Database = None,
) -> None:
    """Predict forces, torque and power of a job's cuts, with 95 % intervals."""
    from autodb.agent.answer.predicting import predict_job
    from autodb.agent.rows.machines import limits_of_machine
    from autodb.files.job import read_job
    from autodb.files.targets import check_target

    if csv is not None:
        check_target(csv, suffix=".csv", option="--csv")
    if plot is not None:
        check_target(plot, suffix=".html", option="--plot")
    asked = read_job(job)
    with opened_machine(db, machine) as (store, name):
        answer = predict_job(store, name, asked)
        limits = limits_of_machine(store, name)
    _write_predicted(answer, limits, csv, plot)
    if json:
        from pydantic import TypeAdapter

        from autodb.agent.answer.predicting import Predicted

        say(TypeAdapter(Predicted).dump_json(answer, indent=1).decode())
        return
    show_predicted(f"Job '{asked.name}': {asked.material} / {asked.tool}", answer.cuts)
    say_answer(answer.cuts, answer)
    for what, path in (("table", csv), ("picture", plot)):
        if path is not None:
            say(f"{what}: {path}")
    say(f"prediction {answer.prediction_id}: 'autodb trace prediction {answer.prediction_id}'")


def _write_predicted(
    answer: "Predicted", limits: "dict[str, AxisLimits]", csv: Path | None, plot: Path | None
) -> None:
    from autodb.files.targets import write_text

    if csv is not None:
        from autodb.forward.predictedfile import prediction_as_csv

        write_text(csv, prediction_as_csv(answer.cuts, limits))
    if plot is not None:
        from autodb.reports.predicted import render_prediction

        write_text(plot, render_prediction(answer, limits))


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


def say_answer(cuts: "Sequence[PredictedCut]", answer: AnswerOptions) -> None:
    """Print below predicted cuts which limits they may exceed, the notes, and what is behind it."""
    for one in answer.exceeds:
        name = cuts[one.cut - 1].name
        say(f"cut {one.cut} '{name}': {one.statement}" if name else one.statement)
    for note in answer.notes:
        say(note)
    say(f"95 % intervals; behind it: {behind_words(answer.behind)}")


def behind_words(behind: "Behind") -> str:
    """Return on how many cuts and which version of a pair's parameters an answer rests."""
    if behind.parameters is None:
        return "no cut of this pair"
    return f"{behind.cuts} cuts, version {behind.version} (parameters {behind.parameters})"


def show_predicted(title: str, cuts: "Sequence[PredictedCut]") -> None:
    """Print predicted cuts; below the means their start and end, where these differ, and peaks."""
    rows = table(
        title, "cut", ">rpm", ">m/min", ">force.x N", ">force.y N", ">force.z N", ">torque N·m",
        ">power W",
    )  # fmt: skip
    for cut in cuts:
        forces = {"x": cut.force_x_N, "y": cut.force_y_N, "z": cut.force_z_N}
        name = cut.name or cut.operation
        rows.add_row(
            f"{name}: mean" if cut.changes else name,
            f"{cut.speed_rpm:.0f}",
            f"{cut.speed_m_min:.0f}",
            *(interval(v) + (" *" if axis == cut.passive else "") for axis, v in forces.items()),
            interval(cut.torque_N_m),
            interval(cut.power_W),
        )
        for called, some in cut.statistics:
            rows.add_row(f"  {called}", *_speeds(some), *(interval(v) for v in some.quantities))
    show(rows)
    if any(cut.passive for cut in cuts):
        say("* passive force: no drive senses it; it comes from the law alone")


def _speeds(some: "Moment | Peaks") -> tuple[str, str]:
    from autodb.forward.prediction import Moment

    if isinstance(some, Moment):
        return f"{some.speed_rpm:.0f}", f"{some.speed_m_min:.0f}"
    return "", ""


def interval(value: "Interval") -> str:
    """Return 'value (low to high)'."""
    digits = 0 if abs(value.value) >= 100 else 1
    return f"{value.value:.{digits}f} ({value.low:.{digits}f} to {value.high:.{digits}f})"


def trace_command(
    kind: Kind,
    number: Annotated[int, typer.Argument(help="Its number.", min=1, max=2**63 - 1)],
    json: Json = False,
    db: Database = None,
) -> None:
    """Show where a stored number came from, down to recordings."""
    from autodb.agent.answer.tracing import trace

    with opened_store(db) as store:
        node = trace(store, kind, number)
    if json:
        say_json(node)
        return
    show(as_tree(node))


def as_tree(node: "Node") -> "Tree":
    """Return a trace as a tree to print."""
    from rich.text import Text
    from rich.tree import Tree

    tree = Tree(Text(node.text, overflow="fold"))
    for source in node.sources:
        tree.children.append(as_tree(source))
    return tree


def demo(
    out: Annotated[Path, typer.Option("--out", help="Folder for the demo's files.")] = Path(
        "demo-out"
    ),
) -> None:
    """Run the whole job on a sample machine and write its report."""
    from autodb.cli.start.demo import run_demo

    with working("demo") as progress:
        lines = run_demo(out, progress=progress)
    for line in lines:
        say(line)
