"""A file whose side file was mended is read again: what was read of it before counts no more."""

from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import select

import autodb
from autodb.store import models, open_store
from tests.conftest import Cli

MACHINE = ("--machine", "m")
ROWS = "".join(
    f"{k},{feed},{depth},150,50,{1600 * feed**0.75 * depth:.1f},{700 * feed**0.6 * depth:.1f}\n"
    for k, (feed, depth) in enumerate([(0.1, 1), (0.2, 1), (0.3, 2), (0.1, 3), (0.2, 2), (0.3, 1)])
)
HEAD = "cut,cutting.feed,cutting.depth,cutting.speed,work.diameter,force.y,force.z\n"
SAID = '[recording]\nwork = "C45"\n[tool]\nname = "insert"\nkind = "turning_insert"\n'


@pytest.fixture
def shop(cli: Cli) -> Cli:
    """Return the command line beside a table of cuts of which nobody says the material."""
    Path("cuts.csv").write_text(HEAD + ROWS)
    for words in (["init"], ["machine", "add", "m"], ["import", "cuts.csv", *MACHINE]):
        done = cli(*words)
        assert done.code == 0, done.err
    Path("said.txt").write_text(done.out)
    return cli


def test_cuts_without_a_pair_are_said_when_they_come_in(shop: Cli) -> None:
    said = Path("said.txt").read_text()
    assert "nothing is learnt of 6 cuts that say no work material or no tool" in said
    assert "[recording] work and [tool] name in cuts.toml" in said
    assert "version" not in shop("refresh", *MACHINE).out


def test_a_mended_side_file_is_read_again_and_learnt(shop: Cli) -> None:
    Path("cuts.toml").write_text(SAID)
    assert "--again reads it with this one" in shop("import", "cuts.csv", *MACHINE).out
    done = shop("import", "cuts.csv", *MACHINE, "--again")
    assert done.code == 0
    assert "recording 2: cuts.csv: imported, 6 rows, 6 cuts" in done.out
    assert "nothing is learnt" not in done.out
    assert "C45 / insert: version 1 from 6 cuts" in shop("refresh", *MACHINE).out
    again = shop("import", "cuts.csv", *MACHINE, "--again")
    assert "recording 2: cuts.csv: already there, 6 rows" in again.out
    trace = shop("trace", "recording", "1").out
    assert "withdrawn" in trace
    assert "its file was read again with another side file" in trace
    checks = shop("doctor")
    assert checks.code == 0, checks.out


def test_what_was_learnt_with_the_wrong_side_file_is_taken_back(shop: Cli) -> None:
    Path("cuts.toml").write_text(SAID)
    shop("import", "cuts.csv", *MACHINE, "--again")
    shop("refresh", *MACHINE)
    Path("cuts.toml").write_text(SAID.replace("C45", "42CrMo4"))
    assert shop("import", "cuts.csv", *MACHINE, "--again").code == 0
    assert "42CrMo4 / insert: version 1 from 6 cuts" in shop("refresh", *MACHINE).out
    store = open_store("sqlite:///autodb.sqlite3")
    with store.reading() as session:
        taken_back = {
            row.pair.material.name: row.undone_at is not None
            for row in session.scalars(select(models.CuttingParameters))
        }
    store.close()
    assert taken_back == {"C45": True, "42CrMo4": False}


def test_a_side_file_that_cannot_be_read_leaves_all_as_it_was(shop: Cli) -> None:
    Path("cuts.toml").write_text('[channels]\n"force.y" = "Fc"\n')
    done = shop("import", "cuts.csv", *MACHINE, "--again")
    assert done.code == 2
    Path("cuts.toml").unlink()
    assert (
        "recording 1: cuts.csv: already there, 6 rows" in shop("import", "cuts.csv", *MACHINE).out
    )


def test_a_withdrawn_file_is_read_as_its_side_file_says_now(shop: Cli) -> None:
    shop("withdraw", "1", "--why", "no material", *MACHINE)
    assert "withdrawn (no material)" in shop("import", "cuts.csv", *MACHINE).out
    Path("cuts.toml").write_text(SAID)
    done = shop("import", "cuts.csv", *MACHINE)
    assert "recording 2: cuts.csv: imported, 6 rows, 6 cuts" in done.out


def test_one_of_two_readings_counts(shop: Cli) -> None:
    """The first does not come back while the second counts."""
    Path("cuts.toml").write_text(SAID)
    shop("import", "cuts.csv", *MACHINE, "--again")
    refused = shop("withdraw", "1", "--undo", *MACHINE)
    assert refused.code == 2
    assert "recording 1 was read again as recording 2; withdraw that one first" in refused.err
    shop("withdraw", "2", "--why", "wrong", *MACHINE)
    assert shop("withdraw", "1", "--undo", *MACHINE).code == 0


def test_the_library_reads_again(shop: Cli) -> None:
    del shop
    machine: Any = autodb.open("autodb.sqlite3").machine("m")
    Path("cuts.toml").write_text(SAID)
    assert machine.import_("cuts.csv").to_dict()["other_side"]
    assert machine.import_("cuts.csv", again=True).to_dict()["recording_id"] == 2
