"""`life`: how long an edge lasts in a job, of pairs whose wear was learnt."""

from pathlib import Path
from typing import Annotated

import typer

from autodb.cli._common import Database, Json, MachineName, opened_machine, say, working
from autodb.cli.everyday.predicting import ToolPath, stated_tool

JobFile = Annotated[
    Path, typer.Argument(readable=False, help="Job file (TOML) with the cuts of one part.")
]
LimitsGiven = Annotated[
    list[str] | None,
    typer.Option(
        "--limit",
        metavar="CHANNEL=VALUE",
        help="Limit of force.x, force.y, force.z (N), torque.spindle (N·m) or spindle.power (W); "
        "several by repeating it [default: the machine's limits].",
    ),
]
SurelyKept = Annotated[
    float,
    typer.Option(
        "--sure", metavar="PERCENT", min=50.0, max=99.9, help="How surely limits are kept."
    ),
]


def life_command(
    job: JobFile,
    machine: MachineName = None,
    limit: LimitsGiven = None,
    sure: SurelyKept = 95.0,
    tool_file: ToolPath = None,
    json: Json = False,
    db: Database = None,
) -> None:
    """Say how many parts an edge lasts until forces, torque or power pass a limit.

    Nothing is stored. It needs a pair whose wear was learnt.
    """
    from autodb.agent.answer.bounds.lasting import ToolLife, limit_stated, tool_life
    from autodb.agent.answer.looking_up import PairReader
    from autodb.agent.answer.predicting import followed_program
    from autodb.files.job import read_job

    asked = read_job(job)
    limits = dict(limit_stated(text, where="--limit") for text in limit or ())
    geometry = {} if tool_file is None else stated_tool(tool_file, asked.tool)[1]
    with opened_machine(db, machine) as (store, name), working(f"tool life on {name}"):
        program = followed_program(store, name, asked)
        with store.reading() as session:
            basis = PairReader(session, name).basis(asked.material, asked.tool)
            found = tool_life(
                basis.with_tool(geometry), asked, limits=limits, sure=sure / 100.0, program=program
            )
    if json:
        from pydantic import TypeAdapter

        say(TypeAdapter(ToolLife).dump_json(found, indent=1).decode())
        return
    for line in found.lines:
        say(line)
