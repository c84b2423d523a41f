"""The command line for daily life: help in groups with examples, defaults, a next step."""

import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from typer.core import TyperGroup

from autodb import __version__
from autodb.cli import commands
from autodb.cli._listed import EXAMPLES, GROUPS, example_lines
from tests.conftest import Cli

ALONE = {"standard list"}
"""Commands that take nothing: there is one way to run them."""


def _paths(command: object, path: str) -> list[str]:
    below = getattr(command, "commands", None)
    if below is None:
        return [path]
    return [one for name in below for one in _paths(below[name], f"{path} {name}".strip())]


PATHS = _paths(commands(), "")


def _context(words: list[str]) -> None:
    """Parse words as the command line does; raises what that raises."""
    command, name = commands(), words[0]
    while isinstance(command, TyperGroup):
        name, command = words[0], command.commands[words[0]]
        words = words[1:]
    with command.make_context(name, words):
        pass


@pytest.mark.parametrize("path", PATHS)
def test_each_command_has_examples_that_it_takes(path: str, cli: Cli) -> None:
    lines = example_lines(path)
    assert len(lines) == (1 if path in ALONE else 2)
    for line in lines:
        _context(shlex.split(line)[1:])
    shown = " ".join(cli(*path.split(), "--help").out.split())
    assert all(" ".join(line.split()) in shown for line in lines)


def test_every_example_is_of_a_command() -> None:
    known = [line for path in PATHS for line in example_lines(path)]
    assert sorted(known) == sorted(EXAMPLES.strip().splitlines())


def test_help_is_in_groups(cli: Cli) -> None:
    text = cli("--help").out
    places = [text.index(f"─ {group} ─") for group in GROUPS]
    assert places == sorted(places)
    assert "Ctrl-C" in text


def test_defaults_are_shown_in_brackets(cli: Cli) -> None:
    text = cli("predict", "--help").out
    assert "Name of the machine [default: the only one]" in text
    assert "Database URL [default: AUTODB_DB or sqlite:///autodb.sqlite3]" in text


def test_the_version_is_printed(cli: Cli) -> None:
    assert cli("--version").out == f"autodb {__version__}\n"


def test_alone_it_says_what_to_do_next(cli: Cli) -> None:
    assert "autodb init" in cli().out
    cli("init")
    assert "autodb machine add NAME" in cli().out
    cli("machine", "add", "lathe-1")
    said = cli()
    assert said.code == 0
    assert "1 machine (lathe-1), 0 recordings" in said.out
    assert "autodb import FILE" in said.out


def test_alone_it_says_what_is_wrong_with_the_database(cli: Cli) -> None:
    Path("autodb.sqlite3").write_text("no database")
    assert cli().code == 2


def test_the_only_machine_is_the_default(cli: Cli) -> None:
    cli("init")
    assert "no machine yet" in cli("lookup").err
    cli("machine", "add", "lathe-1")
    assert "machine 'lathe-1' has no fitted pair yet" in cli("lookup").out
    cli("machine", "add", "lathe-2")
    refused = cli("lookup")
    assert refused.code == 2
    assert "there are several machines: name one of lathe-1, lathe-2" in refused.err
    cli("machine", "retire", "lathe-2")
    assert cli("lookup").code == 0


def test_without_a_machine_commands_say_what_they_need(cli: Cli) -> None:
    assert "either --simulation FILE or --machine NAME" in cli("explain", "a.csv").err
    assert "give a cut table, or --machine NAME" in cli("calibrate").err
    assert "either --machine NAME or --moves FILE" in cli("reconstruct", "a.csv").err


def test_a_file_is_imported_of_the_only_machine(cli: Cli) -> None:
    Path("cuts.csv").write_text("cut,t,z.current\n1,0,2.0\n2,10,3.0\n")
    assert "not stored" in cli("import", "cuts.csv").out
    cli("init")
    assert "not stored" in cli("import", "cuts.csv").out
    cli("machine", "add", "lathe-1")
    assert "recording 1: cuts.csv: imported, 2 rows, 2 cuts" in cli("import", "cuts.csv").out


@pytest.mark.parametrize("command", [["sensors"], ["mismatch", "list"]], ids=" ".join)
def test_a_machine_is_always_an_option_and_alone_for_one_version(
    command: list[str], cli: Cli
) -> None:
    cli("init")
    cli("machine", "add", "lathe-1")
    cli("machine", "add", "lathe-2")
    named, alone = cli(*command, "--machine", "lathe-1"), cli(*command, "lathe-1")
    assert (named.code, named.err) == (0, "")
    assert (alone.code, alone.out) == (0, named.out)
    assert alone.err == "autodb: 'lathe-1' alone goes in the next version; use --machine\n"


def test_the_database_may_be_a_path(cli: Cli) -> None:
    assert cli("init", "--db", "shop.sqlite3").code == 0
    assert Path("shop.sqlite3").exists()


def test_a_folder_is_no_recording(cli: Cli) -> None:
    refused = cli("import", ".")
    assert refused.code == 2
    assert refused.err == "autodb: .: is a folder; give a file in it\n"


def test_ctrl_c_stops_what_goes_on_without_alarm(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    def pressed(_: float) -> None:
        raise KeyboardInterrupt

    cli("init")
    cli("machine", "add", "lathe-1")
    Path("inbox").mkdir()
    monkeypatch.setattr("time.sleep", pressed)
    stopped = cli("refresh", "--inbox", "inbox", "--watch")
    assert (stopped.code, stopped.err) == (130, "autodb: stopped\n")


def test_ctrl_c_stops_an_agent_without_alarm(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    def pressed(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("autodb.live.agentfile.read_agentfile", lambda _: None)
    monkeypatch.setattr("autodb.agent.operate.running.Agent.__init__", lambda *_, **__: None)
    monkeypatch.setattr("autodb.agent.operate.running.Agent.run", pressed)
    stopped = cli("agent", "agent.toml")
    assert (stopped.code, stopped.err) == (130, "")


def test_the_shell_completes_commands_and_options() -> None:
    asked = {"lookup --dep": "--depth", "pre": "predict\npredictions"}
    for words, completed in asked.items():
        told = {
            "_AUTODB_COMPLETE": "complete_bash",
            "COMP_WORDS": f"autodb {words}",
            "COMP_CWORD": str(len(words.split())),
        }
        done = subprocess.run(
            [sys.executable, "-m", "autodb"],
            env={**os.environ, **told}, capture_output=True, text=True, check=True,
        )  # fmt: skip
        assert done.stdout.strip() == completed
