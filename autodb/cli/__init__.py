"""The command `autodb`: thin faces over the agent; heavy libraries load when a command runs."""

import gc
import io
import signal
import sys
from collections import UserDict
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from types import FrameType
from typing import Annotated, Any

import typer

from autodb import __version__
from autodb.cli._common import Stopped
from autodb.cli._listed import COMMANDS, GROUP_OF, READERS, examples_of
from autodb.cli._reader import for_its_reader, shown_again
from autodb.errors import UnusableInput, printable
from autodb.files.excuses import excuse
from autodb.wording import ENGLISH, presented

INTERRUPTED, TERMINATED = 130, 143
YOUNG = 20_000
"""New objects after which garbage is searched for. Chosen: what a command imports is no garbage,
and the 700 of Python search it a thousand times, an eighth of a look-up's time."""
DEFAULT = "\\[default:"
"""How a help text says its default to rich, for which brackets are markup."""


class Commands(UserDict[str, Any]):
    """Commands by name, each imported once it is asked for: `predict` waits for no other."""

    def __getitem__(self, name: str) -> Any:
        return _command(name, self.data[name])


def commands() -> Any:
    """Return all commands as one."""
    from typer.main import get_command

    program = typer.Typer(name="autodb", add_completion=True, invoke_without_command=True)
    program.callback(invoke_without_command=True)(_alone)
    group: Any = get_command(program)
    group.commands = Commands(COMMANDS)
    return group


def _say_version(asked: bool) -> None:
    if asked:
        typer.echo(f"autodb {__version__}")
        raise typer.Exit


def _alone(
    context: typer.Context,
    _version: Annotated[
        bool,
        typer.Option("--version", is_eager=True, callback=_say_version, help="Print the version."),
    ] = False,
) -> None:
    """A CNC machine's own machining database: currents to forces, parameters, predictions.

    Without a command it says what to do next in this folder.
    """
    if context.invoked_subcommand is None:
        from autodb.cli.start.next_steps import say_next

        say_next()


def run(arguments: list[str] | None = None) -> int:
    """Run one command and return its exit status: 0 answered, 2 unusable input, 130 interrupted.

    Told to end by SIGTERM it is 143, but for what goes on until it is told so: 0.
    """
    with presented(ENGLISH):  # until a command says for whom it answers
        return _run(arguments)


def _run(arguments: list[str] | None) -> int:
    from typer.exceptions import TyperException

    try:
        code = commands().main(arguments, prog_name="autodb", standalone_mode=False)
    except TyperException as error:
        show = getattr(error, "show", None)
        if show is not None:
            show()
        return int(getattr(error, "exit_code", 2))
    except Stopped:
        return 0 if signal.SIGTERM in _told else INTERRUPTED
    except (typer.Abort, KeyboardInterrupt):
        return _interrupted()
    except Exception as error:
        if _told:  # an interrupt inside a library's import surfaces as that library's error
            return _interrupted()
        said = excuse(error)
        if said is None:
            raise
        line = error.line if isinstance(error, UnusableInput) else said
        typer.echo(f"autodb: {printable(shown_again(line))}", err=True)
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
    command: Any = get_command(found)
    command.name, command.rich_help_panel = name, GROUP_OF[name]
    for path, one in _with_those_below(name, command):
        one.epilog = examples_of(path)
        if path in READERS:
            for_its_reader(one)
        for parameter in one.params:
            parameter.help = as_written(parameter.help)
    return command


def as_written(text: str | None) -> str | None:
    """Return a help text that rich prints as it is, with the default in its brackets."""
    return text and text.replace("[default:", DEFAULT)


def _with_those_below(path: str, command: Any) -> Iterator[tuple[str, Any]]:
    """Yield a command, or those that it groups, with its name after the program's."""
    below = getattr(command, "commands", None)
    if below is None:
        yield path, command
    else:
        for name, one in below.items():
            yield from _with_those_below(f"{path} {name}", one)


_told: list[int] = []
"""Signals that told this process to end."""


def _interrupted() -> int:
    typer.echo("autodb: interrupted; nothing was half-written", err=True)
    return TERMINATED if signal.SIGTERM in _told else INTERRUPTED


def _on_signal(number: int, frame: FrameType | None) -> None:
    _told.append(number)
    signal.default_int_handler(number, frame)


def main() -> None:
    """Enter from the command line."""
    gc.set_threshold(YOUNG)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _on_signal)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without our letters shows a ?
    status = run()
    gc.freeze()  # Python searches all that is left for garbage as it ends, a fifth of a look-up
    sys.exit(status)
