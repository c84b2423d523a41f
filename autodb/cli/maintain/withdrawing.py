"""`withdraw`: a recording that should not have come in, with all that was derived from it."""

from typing import Annotated

import typer

from autodb.cli._common import Database, MachineName, opened_store, say, working

Number = Annotated[int, typer.Argument(help="Number of the recording.", min=1, max=2**63 - 1)]


def withdraw_command(
    recording: Number,
    machine: MachineName,
    why: Annotated[
        str | None, typer.Option("--why", metavar="TEXT", help="Why; a trace says it.")
    ] = None,
    undo: Annotated[
        bool, typer.Option("--undo", help="Have a withdrawn recording count again.")
    ] = False,
    db: Database = None,
) -> None:
    """Take a recording back, with what was derived from it, and learn anew without it."""
    from autodb.agent.operate.refreshing import refresh
    from autodb.agent.operate.withdrawing import take_again, withdraw
    from autodb.errors import UnusableInput

    if undo == (why is not None):
        raise UnusableInput("withdraw needs --why TEXT, or --undo; one of them would work")
    with opened_store(db) as store, working(f"learning {machine} anew") as progress:
        if why is None:
            done = take_again(store, machine, recording)
        else:
            done = withdraw(store, machine, recording, why=why)
        learnt = refresh(store, machine, progress=progress)
    what = "count again" if undo else "count no more"
    cuts = "already, its cuts" if done.already else f"{done.cuts} cuts"
    say(f"recording {recording}: {cuts} {what}")
    for line in done.taken_back:
        say(f"taken back: {line}")
    if any(line.startswith("calibration") for line in done.taken_back):
        say(f"'autodb calibrate --machine {machine}' fits current to force without it")
    for line in learnt.lines():
        say(line)
