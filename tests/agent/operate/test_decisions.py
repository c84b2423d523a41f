"""Decisions about mismatches are kept, shown, refused, reversed; of two at once one holds."""

from collections.abc import Callable
from pathlib import Path

import pyarrow as pa
import pytest
from pyarrow import csv

from autodb.agent.operate.deciding import confirm, reject
from autodb.errors import UnusableInput
from autodb.store import Store, models, open_store
from tests.conftest import Cli
from tests.helpers.trapezoids import moves
from tests.helpers.uneven_axis import (
    URL,
    Refused,
    keep_mismatch,
    stored_version,
    uneven_effort,
    write_uneven,
)


def test_what_belongs_to_a_recording_changes_no_model(machine: Cli, refused: Refused) -> None:
    load = keep_mismatch(Path("a.csv"), machine, "external_load")
    done = machine("mismatch", "confirm", load)
    assert done.out == (
        f"mismatch {load}: external_load confirmed; "
        "it belongs to this recording: it is noted, no prediction changes\n"
    )
    assert machine("mismatch", "confirm", load).out.endswith("already confirmed as external_load\n")
    assert stored_version(1)
    assert machine("mismatch", "reject", load).out == f"mismatch {load}: external_load rejected\n"
    line = refused("mismatch", "confirm", load)
    assert "was rejected on" in line
    assert f"take that back first with 'autodb mismatch reopen {load}'" in line
    assert machine("doctor").code == 0


def test_unknown_gets_its_name_later(machine: Cli, refused: Refused) -> None:
    others = ["asymmetry", "gain"]
    number = keep_mismatch(write_uneven("b.csv", 2), machine, "unknown", alternatives=others)
    assert "may be unknown or asymmetry or gain, not 'asymetry' (did you mean asymmetry" in refused(
        "mismatch", "confirm", number, "--as", "asymetry"
    )
    said = machine("mismatch", "confirm", number).out
    assert said.endswith("no model changes; use --as asymmetry to put it into one\n")
    done = machine("mismatch", "confirm", number, "--as", "asymmetry", "--by", "Ann")
    assert "version 2 of machine 'mill'" in done.out
    assert (
        "already confirmed as asymmetry"
        in machine("mismatch", "confirm", number, "--as", "asymmetry").out
    )
    assert "as asymmetry by Ann" in refused("mismatch", "confirm", number, "--as", "gain")
    assert "confirmed as asymmetry by Ann" in machine("mismatch", "list", "mill", "--all").out


def test_all_that_is_kept_of_a_mismatch_is_shown(machine: Cli) -> None:
    number = keep_mismatch(
        Path("a.csv"), machine, "unknown", alternatives=["asymmetry", "gain"],
        parameters={"size": {"value": 0.42, "low": 0.4, "high": 0.44, "unit": "A"}},
        variables=["x.position"], intervals=[[83.9, 110.7]], to_tell_apart="Move back.",
        regime=[
            {"signal": "x.position", "low": 310.0, "high": 480.0, "share": 0.71},
            {"signal": "x.velocity", "low": 5.0, "high": 9.0, "share": 0.6, "rows": 0.12},
        ],
    )  # fmt: skip
    shown = machine("mismatch", "show", number).out
    for text in (
        f"mismatch {number}: x.current of recording 1: a.csv", "term: unknown (missing, 90 % sure)",
        "statement: It differs.",
        "where: from 83.9 to 110.7 s; x.position 310 to 480 mm, 71 % of it; "
        "x.velocity 5 to 9 mm/s, 60 % of the squared error in 12 % of the rows",
        "depends on: x.position", "or: asymmetry, gain", "to tell them apart: Move back.",
        "status: open",
    ):  # fmt: skip
        assert text in shown
    assert "size 0.42 0.4 0.44 A" in " ".join(shown.split())


def test_a_rejected_cause_stays_rejected(machine: Cli, refused: Refused) -> None:
    number = keep_mismatch(Path("a.csv"), machine, "asymmetry")
    assert machine("mismatch", "reject", number).out == f"mismatch {number}: asymmetry rejected\n"
    assert machine("mismatch", "reject", number).out == f"mismatch {number}: already rejected\n"
    assert f"mismatch {number} was rejected on" in refused("mismatch", "confirm", number)
    assert "no open mismatch" in machine("mismatch", "list", "mill").out
    assert "rejected" in machine("mismatch", "list", "mill", "--all").out
    assert stored_version(1)


def test_what_is_not_there(machine: Cli, refused: Refused) -> None:
    assert (
        "there is no mismatch 7; list a machine's with 'autodb mismatch list --machine NAME'"
        in refused("mismatch", "confirm", 7)
    )
    assert "there is no mismatch 7" in refused("mismatch", "reject", 7)
    assert "there is no mismatch 7" in refused("mismatch", "show", 7)
    assert "no machine 'mil' (did you mean mill" in refused("mismatch", "list", "--machine", "mil")
    number = keep_mismatch(write_uneven("b.csv", 2), machine, "asymmetry")
    Path("b.csv").write_text("something else")
    assert f"mismatch {number} stays open: " in refused("mismatch", "confirm", number)
    assert stored_version(1)


def test_a_recording_with_names_of_its_own_is_read_as_it_was_imported(machine: Cli) -> None:
    channels = moves(2)
    table = {"time": channels["t"], "X": channels["x.position"], "I": uneven_effort(channels, 2)}
    csv.write_csv(pa.table(table), "b.csv")
    Path("names.toml").write_text('[channels]\nt = "time"\n"x.position" = "X"\n"x.current" = "I"\n')
    machine("import", "b.csv", "--machine", "mill", "--columns", "names.toml")
    Path("names.toml").unlink()
    number = keep_mismatch(Path("b.csv"), machine, "asymmetry")
    assert "version 2" in machine("mismatch", "confirm", number).out


def test_of_two_at_once_one_decides(machine: Cli) -> None:
    """The other one decides while the first is at its fit, before it writes."""
    number = keep_mismatch(write_uneven("b.csv", 2), machine, "asymmetry")
    other = keep_mismatch(Path("b.csv"), machine, "viscous", kind="mistuned")
    first, second = open_store(URL), open_store(URL)

    def meanwhile(what: Callable[[Store], object]) -> Callable[[str], None]:
        def call(step: str) -> None:
            if step == "fitting":
                what(second)

        return call

    with pytest.raises(UnusableInput, match="was rejected on"):
        confirm(first, number, progress=meanwhile(lambda s: reject(s, number)))
    with pytest.raises(UnusableInput, match="got another version during the fit"):
        third = keep_mismatch(Path("b.csv"), machine, "asymmetry")
        confirm(first, third, progress=meanwhile(lambda s: confirm(s, other)))
    done = confirm(first, third, progress=meanwhile(lambda s: confirm(s, third)))
    assert done.already
    with first.reading() as session:
        assert session.query(models.ChannelModel).count() == 3
        assert session.get_one(models.Mismatch, number).status == "rejected"
    first.close()
    second.close()


def test_the_doctor_misses_the_version_of_a_confirmed_cause(machine: Cli) -> None:
    number = keep_mismatch(write_uneven("b.csv", 2), machine, "asymmetry")
    machine("mismatch", "confirm", number)
    assert machine("doctor").code == 0
    store = open_store(URL)
    with store.writing() as session:
        row = session.get_one(models.Mismatch, number)
        row.models.clear()
    store.close()
    done = machine("doctor")
    assert done.code == 1
    assert f"mismatch {number}: x.current: asymmetry" in done.out
