"""`predict`, `explain`, `trace`, `demo`: what a machine answers."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Protocol

import typer

from autodb.cli._common import (
    Columns,
    Database,
    Group,
    MachineName,
    Resample,
    opened,
    read_one,
    say,
    show,
    table,
    working,
)

if TYPE_CHECKING:
    from rich.tree import Tree

    from autodb.agent.explaining import AgainstMachine, KeptCause, Key
    from autodb.agent.predicting import Behind, Predicted
    from autodb.agent.tracing import Node
    from autodb.exceeding import Exceeding
    from autodb.explain import Explained
    from autodb.forward import Interval, PredictedCut
    from autodb.machinefile import Limits
    from autodb.records import CutTable, Recording

JobFile = Annotated[
    Path, typer.Argument(readable=False, help="Job file (TOML) with the cuts to predict.")
]
Json = Annotated[bool, typer.Option("--json", help="Print the answer as JSON.")]
RecordingFile = Annotated[Path, typer.Argument(readable=False, help="The recording or cut table.")]
Simulation = Annotated[
    Path | None,
    typer.Option(
        "--simulation", readable=False, help="File with the same t or cut and its channels."
    ),
]
Includes = Annotated[
    str | None,
    typer.Option("--includes", help="Terms that the simulation already has, with commas between."),
]
ModelOf = Annotated[
    str | None, typer.Option("--machine", help="Use this machine's own stored models.")
]
OutFolder = Annotated[
    Path | None, typer.Option("--out", help="Folder for the answer [default: ./NAME-explained].")
]
Kind = Annotated[
    str,
    typer.Argument(
        help="prediction, parameters, force, calibration, model, mismatch or recording."
    ),
]


def predict(
    job: JobFile,
    machine: MachineName,
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
    from autodb.agent.machines import limits_of_machine
    from autodb.agent.predicting import predict_job
    from autodb.jobs import read_job
    from autodb.store.copies import check_target

    if csv is not None:
        check_target(csv, suffix=".csv", option="--csv")
    if plot is not None:
        check_target(plot, suffix=".html", option="--plot")
    asked = read_job(job)
    with opened(db) as store:
        answer = predict_job(store, machine, asked)
        limits = limits_of_machine(store, machine)
    _write_predicted(answer, limits, csv, plot)
    if json:
        from pydantic import TypeAdapter

        from autodb.agent.predicting import Predicted

        say(TypeAdapter(Predicted).dump_json(answer, indent=1).decode())
        return
    show_predicted(f"Job '{asked.name}': {asked.material} / {asked.tool}", answer.cuts)
    say_answer(answer.cuts, answer)
    for what, path in (("table", csv), ("picture", plot)):
        if path is not None:
            say(f"{what}: {path}")
    say(f"prediction {answer.prediction_id}: 'autodb trace prediction {answer.prediction_id}'")


def _write_predicted(
    answer: "Predicted", limits: "dict[str, Limits]", csv: Path | None, plot: Path | None
) -> None:
    from autodb.store.copies import write_text

    if csv is not None:
        from autodb.predictedfile import as_csv

        write_text(csv, as_csv(answer.cuts, limits))
    if plot is not None:
        from autodb.predictedpage import render

        write_text(plot, render(answer, limits))


class Answer(Protocol):
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


def say_answer(cuts: "Sequence[PredictedCut]", answer: Answer) -> None:
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
    """Print predicted cuts; the peaks of mills and of a program's lines below the means."""
    rows = table(
        title, "cut", ">rpm", ">m/min", ">force.x N", ">force.y N", ">force.z N", ">torque N·m",
        ">power W",
    )  # fmt: skip
    for cut in cuts:
        forces = {"x": cut.force_x_N, "y": cut.force_y_N, "z": cut.force_z_N}
        rows.add_row(
            cut.name or cut.operation,
            f"{cut.speed_rpm:.0f}",
            f"{cut.speed_m_min:.0f}",
            *(interval(v) + (" *" if axis == cut.passive else "") for axis, v in forces.items()),
            interval(cut.torque_N_m),
            interval(cut.power_W),
        )
        if cut.peaks is not None:
            peaks = cut.peaks
            largest = (peaks.force_x_N, peaks.force_y_N, peaks.force_z_N, peaks.torque_N_m)
            rows.add_row(f"  peak {cut.of_what}", "", "", *(interval(v) for v in largest), "")
    show(rows)
    if any(cut.passive for cut in cuts):
        say("* passive: no drive feels it; from the law alone")


def interval(value: "Interval") -> str:
    """Return 'value (low to high)'."""
    digits = 0 if abs(value.value) >= 100 else 1
    return f"{value.value:.{digits}f} ({value.low:.{digits}f} to {value.high:.{digits}f})"


def explain(
    recording: RecordingFile,
    simulation: Simulation = None,
    includes: Includes = None,
    machine: ModelOf = None,
    columns: Columns = None,
    group: Group = None,
    resample: Resample = None,
    out: OutFolder = None,
    json: Json = False,
    db: Database = None,
) -> None:
    """Say what a simulation of a recording leaves out, where, and how the fit improves."""
    from autodb.errors import UnusableInput
    from autodb.explain.files import write_answer

    if (simulation is None) == (machine is None):
        raise UnusableInput("give either --simulation FILE or --machine NAME")
    if machine is not None and (group is not None or resample is not None):
        raise UnusableInput("--group and --resample go with --simulation")
    if machine is not None and includes is not None:
        raise UnusableInput("--includes goes with --simulation: a stored model says what it has")
    with working(f"explaining {recording.name}") as progress:
        if simulation is not None:
            measured = read_one(recording, columns=columns, group=group, resample_hz=resample)
            simulated = read_one(
                simulation, columns=None, group=group, resample_hz=resample, like=measured
            )
            explained, kept = _against_file(measured, simulated, includes), {}
            _say_doubts(measured)
        else:
            answer = _against_machine(str(machine), recording, columns, db)
            explained, kept = answer.explained, answer.kept
        progress("writing the report")
        folder = out or Path(f"{recording.stem}-explained")
        write_answer(explained, folder)
    for note in explained.notes:
        typer.echo(note, err=True)
    if json:
        say((folder / "explanation.json").read_text(encoding="utf-8").rstrip())
        return
    _say_causes(explained, kept)
    say(f"report: {folder / 'report.html'}")
    if any(cause.status == "open" for cause in kept.values()):
        say("keep a cause that holds on the machine: 'autodb mismatch confirm NUMBER', or drop it: "
            "'autodb mismatch reject NUMBER'")  # fmt: skip


def _say_doubts(measured: "Recording | CutTable") -> None:
    """Say what looks like a wrong unit or a clipped sensor; it is explained all the same."""
    from autodb.records.plausible import doubts
    from autodb.records.summary import summary_of

    for doubt in doubts(summary_of(measured), measured.side):
        typer.echo(f"doubtful: {measured.path}: {doubt}", err=True)


def _against_file(
    measured: "Recording | CutTable", simulated: "Recording | CutTable", includes: str | None
) -> "Explained":
    from autodb.explain import explain as run

    names = None if includes is None else [n.strip() for n in includes.split(",") if n.strip()]
    return run(measured, simulated, includes=names)


def _against_machine(
    machine: str, recording: Path, columns: Path | None, db: str | None
) -> "AgainstMachine":
    from autodb.agent.explaining import explain_with_machine

    with opened(db) as store:
        return explain_with_machine(store, machine, recording, columns=columns)


def _say_causes(explained: "Explained", kept: "dict[Key, KeptCause]") -> None:
    from autodb.explain.advice import advice

    for channel, answer in explained.explanation.channels.items():
        if not answer.mismatch:
            before = f"{answer.fit.rms_before:.3g} {answer.unit}"
            say(f"{channel}: no mismatch beyond noise (rms {before})")
            continue
        fit = answer.fit
        say(
            f"{channel}: held-out error {fit.heldout_before:.3g} → {fit.heldout_after:.3g} "
            f"{answer.unit} (noise {fit.noise_floor:.3g})"
        )
        for cause in answer.missing:
            other = f"; or {', '.join(cause.alternatives)}" if cause.alternatives else ""
            row = kept.get((channel, cause.term, cause.kind))
            say(f"  {_numbered(row)}{cause.term} ({cause.kind}, {100 * cause.confidence:.0f} % sure"
                f"{other}): {cause.statement}")  # fmt: skip
    answers = explained.explanation.channels.values()
    for term in dict.fromkeys(cause.term for answer in answers for cause in answer.missing):
        say(f"{term}: {advice(term).check}")


def _numbered(row: "KeptCause | None") -> str:
    if row is None:
        return ""
    return f"mismatch {row.number}{'' if row.status == 'open' else f', {row.status}'}: "


def trace(
    kind: Kind,
    number: Annotated[int, typer.Argument(help="Its number.", min=1, max=2**63 - 1)],
    db: Database = None,
) -> None:
    """Show where a stored number came from, down to recordings."""
    from autodb.agent.tracing import trace as run

    with opened(db) as store:
        node = run(store, kind, number)
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
    from autodb.demo import run

    with working("demo") as progress:
        lines = run(out, progress=progress)
    for line in lines:
        say(line)
