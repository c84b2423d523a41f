"""`edge`: changes are recorded, listed and undone; what is wrong is refused in one line."""

import json
from collections.abc import Callable

import pytest

from tests.conftest import Cli

TOOL = "carbide insert"
Refused = Callable[..., str]


@pytest.fixture
def with_cuts(cli: Cli, sample_jobs: object) -> Cli:
    """Return the command line on a lathe with 32 cuts, which came in now."""
    cli("init")
    cli("machine", "add", "lathe-1")
    cli("import", f"{sample_jobs}/stepped_shaft/recordings/standard-cuts.csv")
    return cli


def test_a_change_is_recorded_listed_and_undone(with_cuts: Cli) -> None:
    cli = with_cuts
    assert "no edge change is recorded" in cli("edge", "list").out
    done = cli("edge", "changed", "--tool", TOOL, "--at", "2026-03-01T07:30Z", "--by", "Maria")
    assert done.out == (
        "edge change 1: carbide insert on 2026-03-01 07:30 UTC; "
        "32 cuts that came in since count for the new edge\n"
    )
    done = cli("edge", "changed", "--tool", TOOL, "--at", "2026-03-01T08:30+01:00")
    assert "2026-03-01 07:30 UTC, already there; 32 cuts" in done.out
    done = cli("edge", "changed", "--tool", TOOL, "--why", "chipped", "--machine", "lathe-1")
    assert "cuts that come in from now on count for the new edge" in done.out
    last, every = (cli("edge", "list", *more).out for more in ((), ("--all",)))
    assert ("chipped" in last, "Maria" in last) == (True, False)
    assert ("chipped" in every, "Maria" in every) == (True, True)
    assert "edge change 2" in cli("edge", "undo", 2).out
    assert "already undone" in cli("edge", "undo", 2).out
    assert "Maria" in cli("edge", "list").out
    assert "undone" in cli("edge", "list", "--all").out


def test_programs_read_what_was_done(with_cuts: Cli) -> None:
    given = ("edge", "changed", "--tool", TOOL, "--at", "2026-03-01T07:30Z", "--json")
    done = json.loads(with_cuts(*given).out)
    at = "2026-03-01T07:30:00+00:00"
    assert (done["number"], done["tool"], done["at"], done["cuts"]) == (1, TOOL, at, 32)
    found = json.loads(with_cuts("edge", "list", "--json").out)
    assert [(one["number"], one["cuts"], one["undone_at"]) for one in found["edges"]] == [
        (1, 32, None)
    ]
    assert json.loads(with_cuts("edge", "undo", 1, "--json").out)["cuts"] == 32
    assert json.loads(with_cuts("edge", "list", "--json").out)["edges"] == []


def test_what_is_wrong_is_refused_in_one_line(with_cuts: Cli, refused: Refused) -> None:
    assert "did you mean carbide insert?" in refused("edge", "changed", "--tool", "carbide inserd")
    assert "is none" in refused("edge", "changed", "--tool", TOOL, "--at", "yesterday")
    assert "still to come" in refused("edge", "changed", "--tool", TOOL, "--at", "2999-01-01")
    assert "no machine 'l'" in refused("edge", "changed", "--tool", TOOL, "--machine", "l")
    assert "there is no edge change 5" in refused("edge", "undo", 5)
    with_cuts("machine", "retire", "lathe-1")
    assert "is retired" in refused("edge", "changed", "--tool", TOOL, "--machine", "lathe-1")
    assert with_cuts("edge", "changed").code == 2
