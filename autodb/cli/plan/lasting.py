"""`life`: how long an edge lasts in a job, of pairs whose wear was learnt."""

from pathlib import Path
from typing import Annotated

import typer

from autodb.cli._common import Database, Json, MachineName, opened_machine, say, working
from autodb.cli._reader import in_english, shown_again
from autodb.cli.everyday.predicting import ToolPath, stated_tool
from autodb.wording import phrase

JobFiles = Annotated[
    list[Path],
    typer.Argument(
        metavar="JOB...",
        readable=False,
        help="Job file (TOML) with the cuts of one part; several, each of one tool, that make it "
        "together.",
    ),
]
LimitsGiven = Annotated[
    list[str] | None,
    typer.Option(
        "--limit",
        metavar="[EDGE:]CHANNEL=VALUE",
        help="Limit of force.x, force.y, force.z (N), torque.spindle (N·m) or spindle.power (W), "
        "of all edges or of one (a job's tool, or a program's); several by repeating it [default: "
        "the machine's limits].",
    ),
]
SurelyKept = Annotated[
    float,
    typer.Option(
        "--sure", metavar="PERCENT", min=50.0, max=99.9, help="How surely limits are kept."
    ),
]


def life_command(
    jobs: JobFiles,
    machine: MachineName = None,
    limit: LimitsGiven = None,
    sure: SurelyKept = 95.0,
    tool_file: ToolPath = None,
    json: Json = False,
    db: Database = None,
) -> None:
    """Say how many parts edges last until forces, torque or power pass a limit.

    Each job's tool, and each tool of a program, is an edge of its own; of several it is said which
    ends first. Nothing is stored. It needs pairs whose wear was learnt.
    """
    from autodb.agent.answer.bounds.lasting import limit_stated
    from autodb.agent.answer.bounds.lives import AskedLife, ToolLives, tool_lives
    from autodb.agent.answer.looking_up import PairReader
    from autodb.agent.answer.predicting import followed_program
    from autodb.errors import UnusableInput
    from autodb.files.job import read_job

    asked = [read_job(path) for path in jobs]
    limits = dict(limit_stated(text, where="--limit") for text in limit or ())
    only = asked[0].tool if len(asked) == 1 else None
    stated = None if tool_file is None else stated_tool(tool_file, only)
    if stated is not None and stated[0] not in [one.tool for one in asked]:
        raise UnusableInput(
            phrase(
                "--tool-file: no job has the tool '{stated}' of {tool_file}",
                stated=stated[0],
                tool_file=tool_file,
            )
        )
    with (
        in_english(json),
        opened_machine(db, machine) as (store, name),
        working(f"tool life on {name}"),
    ):
        programs = [followed_program(store, name, job) for job in asked]
        with store.reading() as session:
            reader, some = PairReader(session, name), []
            for job, program in zip(asked, programs, strict=True):
                basis = reader.basis(job.material, job.tool)
                if stated is not None and stated[0] == job.tool:
                    basis = basis.with_tool(stated[1])
                some.append(AskedLife(basis, job, program))
            found = tool_lives(some, limits=limits, sure=sure / 100.0)
    if json:
        from pydantic import TypeAdapter

        say(TypeAdapter(ToolLives).dump_json(found, indent=1).decode())
        return
    for line in found.lines:
        say(shown_again(line))
