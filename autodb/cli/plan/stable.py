"""`stability`: to what depth cuts are stable with a tool point that gives way."""

from pathlib import Path
from typing import Annotated

import typer

from autodb.cli._common import (
    Database,
    Json,
    MachineName,
    SelfContained,
    check_page,
    opened_machine,
    say,
    working,
)
from autodb.cli._reader import in_english, shown_again
from autodb.cli.everyday.predicting import ToolPath, stated_tool
from autodb.wording import phrase

JobFile = Annotated[Path, typer.Argument(readable=False, help="Job file (TOML) with the cuts.")]
DynamicsFile = Annotated[
    Path,
    typer.Option(
        "--dynamics",
        readable=False,
        metavar="FILE",
        help="How the tool point gives way: modes (TOML), or a measured receptance (CSV).",
    ),
]


def stability_command(
    job: JobFile,
    dynamics: DynamicsFile,
    machine: MachineName = None,
    tool_file: ToolPath = None,
    plot: Annotated[
        Path | None,
        typer.Option("--plot", metavar="FILE", help="Write the lobes as a picture: FILE.html."),
    ] = None,
    self_contained: SelfContained = False,
    json: Json = False,
    db: Database = None,
) -> None:
    """Say to what depth a job's cuts are stable, beside their limits; nothing is stored."""
    from autodb.agent.answer.bounds.stable import stability_lines, stable_cuts
    from autodb.agent.answer.looking_up import PairReader
    from autodb.files.job import read_job
    from autodb.forward.stability.dynamics import read_tool_point

    check_page(plot, option="--plot", self_contained=self_contained)
    asked, point = read_job(job), read_tool_point(dynamics)
    made = [cut.operation for cut in asked.cut]
    geometry = {} if tool_file is None else stated_tool(tool_file, asked.tool, made)[1]
    with (
        in_english(json),
        opened_machine(db, machine) as (store, name),
        store.reading() as session,
    ):
        basis = PairReader(session, name).basis(asked.material, asked.tool).with_tool(geometry)
        with working(f"lobes for {name}"):
            found = stable_cuts(basis, asked, point)
    if plot is not None:
        from autodb.reports.planned.lobes import render_lobes
        from autodb.reports.written import write_page

        write_page(plot, render_lobes(asked, found), self_contained=self_contained)
    if json:
        from pydantic import TypeAdapter

        from autodb.agent.answer.bounds.stable import StableCut

        say(TypeAdapter(tuple[StableCut, ...]).dump_json(found, indent=1).decode())
        return
    for line in stability_lines(found):
        say(shown_again(line))
    say(
        phrase(
            "95 % intervals: of the pair's forces and of what gives way; worn edges damp slow cuts "
            "more"
        )
    )
    if plot is not None:
        say(phrase("picture: {file}", file=plot))
