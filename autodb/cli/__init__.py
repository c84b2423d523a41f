"""The command `autodb`: thin faces over the agent; heavy libraries load when a command runs."""

import io
import signal
import sys
from collections import UserDict
from functools import cache
from importlib import import_module
from types import FrameType
from typing import Any

import typer

from autodb.files.excuses import excuse

INTERRUPTED = 130

COMMANDS = {
    "init": "setup.database:init",
    "machine": "setup.database:machine",
    "look": "learn.looking:look_command",
    "import": "learn.import_and_calibrate:import_",
    "calibrate": "learn.import_and_calibrate:calibrate_command",
    "standard": "setup.standard:standard",
    "sweep": "setup.sweeping:sweep",
    "identify": "learn.identifying:identify_command",
    "scale": "learn.scaling:scale",
    "reconstruct": "learn.reconstructing:reconstruct_command",
    "inspect": "learn.inspecting:inspect_command",
    "sensors": "learn.inspecting:sensors_command",
    "refresh": "learn.refreshing:refresh_command",
    "schedule": "setup.scheduling:schedule",
    "agent": "learn.running:agent",
    "fleet": "maintain.fleet:fleet",
    "serve": "setup.serving:serve",
    "token": "setup.serving:token",
    "predict": "plan.predict_and_trace:predict_command",
    "lookup": "plan.looking_up:lookup",
    "plan": "plan.planning:plan_command",
    "predictions": "plan.scoring:predictions",
    "explain": "understand.explaining:explain_command",
    "mismatch": "understand.deciding:mismatch",
    "trace": "plan.predict_and_trace:trace_command",
    "withdraw": "maintain.keeping:withdraw_command",
    "doctor": "maintain.keeping:doctor",
    "backup": "maintain.keeping:backup_command",
    "restore": "maintain.keeping:restore_command",
    "export": "maintain.keeping:export_command",
    "demo": "plan.predict_and_trace:demo",
    "prove": "develop.proving:prove",
}
"""Where each command is, by name, in the order of the help: module and name in it."""


class Commands(UserDict[str, Any]):
    """Commands by name, each imported once it is asked for: `predict` waits for no other."""

    def __getitem__(self, name: str) -> Any:
        return _command(name, self.data[name])


def commands() -> Any:
    """Return all commands as one."""
    from typer.core import TyperGroup

    what = "A CNC machine's own machining database: currents to forces, parameters, predictions."
    every: Any = Commands(COMMANDS)
    return TyperGroup(name="autodb", commands=every, help=what, no_args_is_help=True)


def run(arguments: list[str] | None = None) -> int:
    """Run one command and return its exit status: 0 answered, 2 unusable input, 130 interrupted."""
    from typer.exceptions import TyperException

    try:
        code = commands().main(arguments, prog_name="autodb", standalone_mode=False)
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
def _command(name: str, place: str) -> Any:
    """Return a command, or a group of them, built from its function."""
    from typer.main import get_command

    module, _, attribute = place.partition(":")
    found = getattr(import_module(f"autodb.cli.{module}"), attribute)
    if not isinstance(found, typer.Typer):
        alone = typer.Typer(add_completion=False)
        alone.command(name)(found)
        found = alone
    command = get_command(found)
    command.name = name
    return command


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
