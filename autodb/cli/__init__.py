"""The command `autodb`: thin faces over the agent; heavy libraries load when a command runs."""

import io
import signal
import sys
from functools import cache
from types import FrameType
from typing import Any

import typer

from autodb.cli.develop import proving
from autodb.cli.learn import (
    identifying,
    inspecting,
    learning,
    reconstructing,
    refreshing,
    running,
    scaling,
    sensing,
)
from autodb.cli.maintain import fleet, keeping, withdrawing
from autodb.cli.plan import answers, looking_up, planning
from autodb.cli.setup import database, scheduling, serving, standard, sweeping
from autodb.cli.understand import deciding, explaining
from autodb.files.excuses import excuse

INTERRUPTED = 130

app = typer.Typer(
    help="A CNC machine's own machining database: currents to forces, parameters, predictions.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.command("init")(database.init)
app.add_typer(database.machine, name="machine")
app.command("import")(learning.import_)
app.command("calibrate")(learning.calibrate)
app.add_typer(standard.standard, name="standard")
app.command("sweep")(sweeping.sweep)
app.command("identify")(identifying.identify)
app.command("scale")(scaling.scale)
app.command("reconstruct")(reconstructing.reconstruct)
app.command("inspect")(inspecting.inspect)
app.command("sensors")(sensing.sensors)
app.command("refresh")(refreshing.refresh)
app.command("schedule")(scheduling.schedule)
app.command("agent")(running.agent)
app.add_typer(fleet.fleet, name="fleet")
app.command("serve")(serving.serve)
app.add_typer(serving.token, name="token")
app.command("predict")(answers.predict)
app.command("lookup")(looking_up.lookup)
app.command("plan")(planning.plan)
app.command("explain")(explaining.explain)
app.add_typer(deciding.mismatch, name="mismatch")
app.command("trace")(answers.trace)
app.command("withdraw")(withdrawing.withdraw)
app.command("doctor")(keeping.doctor)
app.command("backup")(keeping.backup)
app.command("restore")(keeping.restore)
app.command("export")(keeping.export)
app.command("demo")(answers.demo)
app.command("prove")(proving.prove)


def run(arguments: list[str] | None = None) -> int:
    """Run one command and return its exit status: 0 answered, 2 unusable input, 130 interrupted."""
    from typer.exceptions import TyperException

    try:
        code = _command().main(arguments, prog_name="autodb", standalone_mode=False)
    except TyperException as error:
        show = getattr(error, "show", None)
        if show is not None:
            show()
        return int(getattr(error, "exit_code", 2))
    except (typer.Abort, KeyboardInterrupt):
        return _interrupted()
    except Exception as error:
        if _pressed:  # an interrupt inside a library's import surfaces as that library's error
            return _interrupted()
        said = excuse(error)
        if said is None:
            raise
        typer.echo(f"autodb: {said}", err=True)
        return 2
    return _interrupted() if code == INTERRUPTED else int(code or 0)


@cache
def _command() -> Any:
    """Return all commands as one; built once in a process that runs several."""
    from typer.main import get_command

    return get_command(app)


_pressed: list[int] = []


def _interrupted() -> int:
    typer.echo("autodb: interrupted; nothing was half-written", err=True)
    return INTERRUPTED


def _on_interrupt(number: int, frame: FrameType | None) -> None:
    _pressed.append(number)
    signal.default_int_handler(number, frame)


def main() -> None:
    """Enter from the command line."""
    signal.signal(signal.SIGINT, _on_interrupt)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without our letters shows a ?
    sys.exit(run())
