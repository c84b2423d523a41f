"""`withdraw`: a recording that should not have come in, with all that was derived from it."""

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import (
    Database,
    Json,
    MachineName,
    opened_machine,
    say,
    say_json,
    working,
)
from autodb.cli._reader import in_english, shown_again
from autodb.wording import phrase

if TYPE_CHECKING:
    from autodb.agent.operate.withdrawing import Withdrawn

Number = Annotated[int, typer.Argument(help="Number of the recording.", min=1, max=2**63 - 1)]


def withdraw_command(
    recording: Number,
    machine: MachineName = None,
    why: Annotated[
        str | None, typer.Option("--why", metavar="TEXT", help="Why; a trace says it.")
    ] = None,
    undo: Annotated[
        bool, typer.Option("--undo", help="Have a withdrawn recording count again.")
    ] = False,
    json: Json = False,
    db: Database = None,
) -> None:
    """Take a recording back, with what was derived from it, and fit again without it."""
    from autodb.agent.operate.refreshing import refresh
    from autodb.agent.operate.withdrawing import take_again, withdraw
    from autodb.errors import UnusableInput

    if undo == (why is not None):
        raise UnusableInput(phrase("withdraw needs --why TEXT or --undo; give one of them"))
    with (
        in_english(),  # what is found is kept
        opened_machine(db, machine) as (store, name),
        working(f"learning {name} anew") as progress,
    ):
        if why is None:
            done = take_again(store, name, recording)
        else:
            done = withdraw(store, name, recording, why=why)
        learnt = refresh(store, name, progress=progress)
    if json:
        with in_english():
            lines = learnt.lines()
        say_json({"recording": recording, **asdict(done), "learnt": lines})
        return
    say(_withdrawn_words(recording, done, undo=undo))
    for line in done.taken_back:
        say(phrase("taken back: {what}", what=shown_again(line)))
    if any(line.startswith("calibration") for line in done.taken_back):
        say(
            phrase(
                "'autodb calibrate --machine {name}' fits current to force without it", name=name
            )
        )
    for line in learnt.lines():
        say(line)


def _withdrawn_words(recording: int, done: "Withdrawn", *, undo: bool) -> str:
    """Return what became of a recording's cuts."""
    called = {"number": recording, "count": done.cuts}
    if done.already and undo:
        return phrase("recording {number}: already done, its cuts are used again", **called)
    if done.already:
        return phrase("recording {number}: already done, its cuts are no longer used", **called)
    if undo:
        return phrase("recording {number}: {count} cuts are used again", **called)
    return phrase("recording {number}: {count} cuts are no longer used", **called)
