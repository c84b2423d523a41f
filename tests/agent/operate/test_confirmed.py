"""A cause that a person confirms is in the machine's next version, and explain finds it no more.

The truth is written here: four symmetric terms and one that a machine's first model lacks.
"""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from pyarrow import csv

from autodb.agent.operate.deciding import confirm, reject
from autodb.agent.operate.fitting_confirmed import of_term
from autodb.agent.rows.machines import find_machine
from autodb.agent.sense.identifying import newest_model, stored_terms
from autodb.agent.sense.reconstructing import reconstruct_on_machine
from autodb.errors import UnusableInput
from autodb.records import Recording, read
from autodb.sensing.drives import feed_axis
from autodb.sensing.drives.fit.axis_model import Identified, IdentifiedTerm, Posteriors
from autodb.store import Store, models, open_store
from autodb.terms.vocabulary import effect_called
from tests.conftest import Cli, Once
from tests.helpers.trapezoids import COULOMB, INERTIA, NOISE, VISCOUS, WEIGHT, moves

Array = NDArray[np.float64]
LEVEL, SLOPE = 0.06, 4e-4
URL = "sqlite:///autodb.sqlite3"
FORCE = "x.drive_force"
Refused = Callable[..., str]


def effort(channels: dict[str, Array], seed: int, *, uneven: float = 1.0) -> Array:
    """Return the current of the four terms, and of friction that is uneven by direction, (n,)."""
    v, a = channels["x.velocity"], channels["x.acceleration"]
    sense = np.clip(v / 0.05, -1.0, 1.0)
    noise = np.random.default_rng([seed, 2]).normal(0, NOISE, len(v))
    own = COULOMB * sense + VISCOUS * v + INERTIA * a + WEIGHT
    return own + uneven * (LEVEL * np.abs(sense) + SLOPE * np.abs(v)) + noise


def written(name: str, seed: int, **truth: float) -> Path:
    channels = moves(seed)
    csv.write_csv(pa.table({**channels, "x.current": effort(channels, seed, **truth)}), name)
    return Path(name)


@pytest.fixture
def machine(cli: Cli, once: Once) -> Cli:
    """Return the command line beside a machine whose first model is symmetric."""

    def identify() -> None:
        Path("m.toml").write_text("[axes.x]\n")
        cli("init")
        cli("machine", "add", "mill", "--file", "m.toml")
        done = cli("identify", written("a.csv", 1), "--machine", "mill")
        assert "x.current: version 1 of machine 'mill'" in done.out

    once(identify)
    return cli


def stored(version: int, channel: str = "x.current") -> list[Any]:
    store = open_store(URL)
    with store.reading() as session:
        row = newest_model(session, find_machine(session, "mill").id, channel)
        assert row is not None
        assert row.version == version
        terms = stored_terms(row)
    store.close()
    return terms


def mismatch(recording: Path, cli: Cli, term: str, **columns: Any) -> int:
    """Keep a cause as explain would, and return its number."""
    cli("import", recording, "--machine", "mill")
    store = open_store(URL)
    with store.writing() as session:
        named = session.query(models.StoredRecording).filter(
            models.StoredRecording.path.endswith(recording.name)
        )
        row = models.Mismatch(
            **{
                "recording_id": named.one().id, "channel": "x.current", "term": term,
                "kind": "missing", "confidence": 0.9, "parameters": {}, "statement": "It differs.",
                "alternatives": [], **columns,
            }
        )  # fmt: skip
        session.add(row)
        session.flush()
        number = row.id
    store.close()
    return number


def causes(done_out: str) -> dict[str, str]:
    found = json.loads(done_out)["channels"]["x.current"]["missing"]
    return {cause["term"]: cause["kind"] for cause in found}


def test_the_next_prediction_contains_what_was_confirmed(machine: Cli) -> None:
    second, third = written("b.csv", 2), written("c.csv", 3)
    said = machine("explain", second, "--machine", "mill").out
    assert "  mismatch 1: asymmetry (missing, 99 % sure): " in said
    assert "'autodb mismatch confirm NUMBER'" in said
    listed = machine("mismatch", "list", "mill").out
    assert "asymmetry" in listed
    assert "open" in listed
    shown = machine("mismatch", "show", 1).out
    assert "term: asymmetry (missing, 99 % sure)" in shown
    assert "status: open" in shown
    assert "made:" not in shown
    assert "A·s/mm" in shown
    entry = effect_called("asymmetry")
    assert f"advice: {entry.check} ({entry.check_source})" in shown
    assert f"asymmetry: {entry.check}\n" in said
    shutil.copy("autodb.sqlite3", "undecided.sqlite3")
    done = machine("mismatch", "confirm", 1, "--by", "Ann")
    assert "x.current: version 2 of machine 'mill', started from version 1" in done.out
    truth = {"level": LEVEL, "coefficient": SLOPE}
    for term in (t for t in stored(2) if t.term == "asymmetry"):
        assert abs(term.value - truth[term.parameter]) < 3.0 * term.sd
    # another recording of the machine: with the version, and without
    without = machine(
        "explain", third, "--machine", "mill", "--db", "sqlite:///undecided.sqlite3", "--json"
    )
    assert causes(without.out)["asymmetry"] == "missing"
    found = machine("explain", third, "--machine", "mill", "--json").out
    assert causes(found) == {}
    assert_allclose(
        json.loads(found)["channels"]["x.current"]["fit"]["rms_before"], NOISE, rtol=0.03
    )
    # where it came from
    assert "asymmetry (missing, confirmed by Ann on" in machine("trace", "model", 2).out
    assert "it made model 2: x.current version 2" in machine("trace", "mismatch", 1).out
    shown = machine("mismatch", "show", 1).out
    assert "status: confirmed by Ann on " in shown
    assert "made: x.current version 2 (model 2)" in shown
    assert machine("doctor").code == 0


def test_what_was_found_before_a_new_version_is_said(machine: Cli) -> None:
    second = written("b.csv", 2)
    number = mismatch(second, machine, "asymmetry")
    other = mismatch(second, machine, "lag")
    elsewhere = mismatch(second, machine, "lag", channel="y.current")
    done = machine("mismatch", "confirm", number).out
    assert f"still open, found before this version: {other}; 'autodb explain" in done
    assert str(elsewhere) not in done.rpartition("still open")[2]


def test_a_confirmed_term_of_another_size_is_mistuned(machine: Cli) -> None:
    number = mismatch(written("b.csv", 2), machine, "asymmetry")
    machine("mismatch", "confirm", number)
    later = machine("explain", written("c.csv", 3, uneven=2.0), "--machine", "mill")
    assert f"mismatch {number + 1}: asymmetry (mistuned, " in later.out
    done = machine("mismatch", "confirm", number + 1)
    assert "version 3 of machine 'mill', started from version 2" in done.out
    assert "moved since version 2: asymmetry level" in done.out
    level = next(t for t in stored(3) if (t.term, t.parameter) == ("asymmetry", "level"))
    assert abs(level.value - 2.0 * LEVEL) < 3.0 * level.sd


def test_a_term_found_where_the_model_came_from(machine: Cli) -> None:
    """The version that has seen the recording is no prior: its rows would count twice."""
    written("b.csv", 2)
    machine("identify", "b.csv", "--machine", "mill")
    number = mismatch(Path("b.csv"), machine, "asymmetry")
    done = machine("mismatch", "confirm", number)
    assert "version 3 of machine 'mill', started from version 1" in done.out
    again = mismatch(Path("b.csv"), machine, "asymmetry")
    assert "version 3 of machine 'mill': already there" in machine("mismatch", "confirm", again).out
    assert "version 3" in machine("trace", "mismatch", again).out


@pytest.mark.parametrize("seed", range(20, 24))
def test_a_version_that_lacked_a_term_does_not_hold_the_fit_back(seed: int) -> None:
    """Its friction and weight swallowed part of the effect; what they still say does no harm."""
    terms = (*feed_axis.default_terms("axis"), "asymmetry")
    first, second = (
        Recording(path=Path("a.csv"), channels={**m, "x.current": effort(m, n)})
        for n, m in ((seed, moves(seed)), (seed + 50, moves(seed + 50)))
    )
    lacked = feed_axis.identify(first)
    with_it = feed_axis.identify(second, terms=terms, posteriors=posteriors(lacked))
    truth = {"coulomb": COULOMB, "gravity": WEIGHT, "inertia": INERTIA, "viscous": VISCOUS}
    swallowed = abs(lacked.value("gravity") - WEIGHT)
    for term in (t for t in with_it.fitted if t.term in truth):
        assert abs(term.value - truth[term.term]) < 3.5 * (term.sd or 0.0)
    assert abs(with_it.value("gravity") - WEIGHT) < 0.1 * swallowed
    assert with_it.moved == ()


def posteriors(model: Identified) -> Posteriors:
    names = tuple((t.key, t.parameter) for t in model.fitted)
    return Posteriors(names, np.array([t.value for t in model.fitted]), model.covariance)


def test_given_shapes_stay_those_of_the_version_believed() -> None:
    first, second = (
        Recording(path=Path("a.csv"), channels={**m, "x.current": effort(m, n, uneven=0.0)})
        for n, m in ((1, moves(1)), (2, moves(2)))
    )
    terms = (*feed_axis.default_terms("axis"), "position_friction")
    one = feed_axis.identify(first, terms=terms)
    given = {(t.key, t.parameter): t.value for t in one.terms if t.sd == 0}
    known = posteriors(one)
    both = feed_axis.identify(
        second, terms=terms, posteriors=Posteriors(known.names, known.mean, known.covariance, given)
    )
    middle = next(t.value for t in both.terms if t.parameter == "middle")
    assert middle == given["position_friction", "middle"]
    alone = feed_axis.identify(second, terms=terms)
    assert abs(middle - next(t.value for t in alone.terms if t.parameter == "middle")) > 10.0


def test_moves_one_way_do_not_excite_it_and_the_mismatch_stays_open(
    machine: Cli, refused: Refused
) -> None:
    channels = moves(3, forwards_only=True)
    moving = np.abs(channels["x.velocity"]) > 2.0
    table = {name: values[moving] for name, values in channels.items()}
    table["t"] = np.arange(moving.sum()) / 250.0
    csv.write_csv(pa.table({**table, "x.current": effort(channels, 3)[moving]}), "one-way.csv")
    number = mismatch(Path("one-way.csv"), machine, "asymmetry")
    line = refused("mismatch", "confirm", number)
    assert f"mismatch {number} stays open: one-way.csv does not excite asymmetry; asymmetry" in line
    assert "both directions" in line
    assert "open" in machine("mismatch", "list", "mill").out
    assert stored(1)


def test_what_belongs_to_a_recording_changes_no_model(machine: Cli, refused: Refused) -> None:
    load = mismatch(Path("a.csv"), machine, "external_load")
    done = machine("mismatch", "confirm", load)
    assert done.out == (
        f"mismatch {load}: external_load confirmed; "
        "it belongs to this recording: it is noted, no prediction changes\n"
    )
    assert machine("mismatch", "confirm", load).out.endswith("already confirmed as external_load\n")
    assert stored(1)
    assert machine("mismatch", "reject", load).out == f"mismatch {load}: external_load rejected\n"
    line = refused("mismatch", "confirm", load)
    assert "was rejected on" in line
    assert f"take that back first with 'autodb mismatch reopen {load}'" in line
    assert machine("doctor").code == 0


def test_unknown_gets_its_name_later(machine: Cli, refused: Refused) -> None:
    others = ["asymmetry", "gain"]
    number = mismatch(written("b.csv", 2), machine, "unknown", alternatives=others)
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
    number = mismatch(
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
    number = mismatch(Path("a.csv"), machine, "asymmetry")
    assert machine("mismatch", "reject", number).out == f"mismatch {number}: asymmetry rejected\n"
    assert machine("mismatch", "reject", number).out == f"mismatch {number}: already rejected\n"
    assert f"mismatch {number} was rejected on" in refused("mismatch", "confirm", number)
    assert "no open mismatch" in machine("mismatch", "list", "mill").out
    assert "rejected" in machine("mismatch", "list", "mill", "--all").out
    assert stored(1)


def test_what_is_not_there(machine: Cli, refused: Refused) -> None:
    assert "there is no mismatch 7; list a machine's with 'autodb mismatch list NAME'" in refused(
        "mismatch", "confirm", 7
    )
    assert "there is no mismatch 7" in refused("mismatch", "reject", 7)
    assert "there is no mismatch 7" in refused("mismatch", "show", 7)
    assert "no machine 'mil' (did you mean mill" in refused("mismatch", "list", "mil")
    number = mismatch(written("b.csv", 2), machine, "asymmetry")
    Path("b.csv").write_text("something else")
    assert f"mismatch {number} stays open: " in refused("mismatch", "confirm", number)
    assert stored(1)


def test_a_recording_with_names_of_its_own_is_read_as_it_was_imported(machine: Cli) -> None:
    channels = moves(2)
    table = {"time": channels["t"], "X": channels["x.position"], "I": effort(channels, 2)}
    csv.write_csv(pa.table(table), "b.csv")
    Path("names.toml").write_text('[channels]\nt = "time"\n"x.position" = "X"\n"x.current" = "I"\n')
    machine("import", "b.csv", "--machine", "mill", "--columns", "names.toml")
    Path("names.toml").unlink()
    number = mismatch(Path("b.csv"), machine, "asymmetry")
    assert "version 2" in machine("mismatch", "confirm", number).out


def test_of_two_at_once_one_decides(machine: Cli) -> None:
    """The other one decides while the first is at its fit, before it writes."""
    number = mismatch(written("b.csv", 2), machine, "asymmetry")
    other = mismatch(Path("b.csv"), machine, "viscous", kind="mistuned")
    first, second = open_store(URL), open_store(URL)

    def meanwhile(what: Callable[[Store], object]) -> Callable[[str], None]:
        def call(step: str) -> None:
            if step == "fitting":
                what(second)

        return call

    with pytest.raises(UnusableInput, match="was rejected on"):
        confirm(first, number, progress=meanwhile(lambda s: reject(s, number)))
    with pytest.raises(UnusableInput, match="got another version during the fit"):
        third = mismatch(Path("b.csv"), machine, "asymmetry")
        confirm(first, third, progress=meanwhile(lambda s: confirm(s, other)))
    done = confirm(first, third, progress=meanwhile(lambda s: confirm(s, third)))
    assert done.already
    with first.reading() as session:
        assert session.query(models.ChannelModel).count() == 3
        assert session.get_one(models.Mismatch, number).status == "rejected"
    first.close()
    second.close()


def test_the_doctor_misses_the_version_of_a_confirmed_cause(machine: Cli) -> None:
    number = mismatch(written("b.csv", 2), machine, "asymmetry")
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


@pytest.mark.campaign
def test_uneven_friction_of_the_real_axis(
    cli: Cli, emps: Path, pulses: Path, sample_jobs: Path
) -> None:
    """Confirmed from one recording, it lowers the error on the other."""
    columns = sample_jobs / "emps" / "columns.toml"
    Path("m.toml").write_text("[axes.x]\n")
    cli("init")
    cli("machine", "add", "mill", "--file", "m.toml")
    cli("identify", emps, "--columns", columns, "--machine", "mill")
    symmetric = stored(1, FORCE)
    said = cli("explain", emps, "--columns", columns, "--machine", "mill").out
    number = next(
        line.split(":")[0].split()[1]
        for line in said.splitlines()
        if ": asymmetry (missing" in line
    )
    assert "version 2 of machine 'mill'" in cli("mismatch", "confirm", number).out
    other = read(pulses, columns=columns)
    assert isinstance(other, Recording)
    protocol = feed_axis.identify(other).protocol
    before, after = (
        feed_axis.cross_test(other, "x", protocol, terms) for terms in (symmetric, stored(2, FORCE))
    )
    assert after < before


def test_a_weight_that_turns_is_no_ripple() -> None:
    turning, ripple, magnets = (
        IdentifiedTerm(term, "cosine", 1.0, 0.1, "A", form=form)
        for term, form in (("gravity", "tilt"), ("position_friction", "periodic"), ("cogging", ""))
    )
    terms = [turning, ripple, magnets]
    assert of_term(terms, "gravity") == [turning]
    assert of_term(terms, "cogging") == [ripple, magnets]
    assert of_term(terms, "position_friction") == []


def test_what_is_reconstructed_has_the_confirmed_term_until_it_is_taken_back(
    machine: Cli,
) -> None:
    third = written("c.csv", 3)

    def load_A() -> tuple[Array, str]:
        store, recorded = open_store(URL), read(third)
        assert isinstance(recorded, Recording)
        (found,) = reconstruct_on_machine(
            store, "mill", recorded, axis=None, bandwidth_hz=20.0, observer=False
        )
        store.close()
        return found.load.value, found.model

    before, was = load_A()
    number = mismatch(written("b.csv", 2), machine, "asymmetry")
    machine("mismatch", "confirm", number, "--why", "the gib is tight towards +")
    after, is_now = load_A()
    assert (was, is_now) == tuple(f"version {n} of machine 'mill'" for n in (1, 2))
    assert np.std(after) < 0.5 * np.std(before)
    assert ": the gib is tight towards +" in machine("mismatch", "show", number).out
    done = machine("mismatch", "reopen", number).out
    assert done == (
        f"mismatch {number}: asymmetry is open again\nx.current version 2 is taken back\n"
    )
    again, called = load_A()
    assert called == "version 1 of machine 'mill'"
    np.testing.assert_array_equal(again, before)
    assert (
        "version 3 of machine 'mill', started from version 1"
        in machine("mismatch", "confirm", number).out
    )
    assert machine("doctor").code == 0


def test_a_version_that_two_causes_hold_stays_until_both_are_taken_back(machine: Cli) -> None:
    written("b.csv", 2)
    number = mismatch(Path("b.csv"), machine, "asymmetry")
    machine("mismatch", "confirm", number)
    again = mismatch(Path("b.csv"), machine, "asymmetry")
    assert "version 2 of machine 'mill': already there" in machine("mismatch", "confirm", again).out
    machine("mismatch", "reopen", number)
    assert stored(2)
    machine("identify", written("d.csv", 4), "--machine", "mill")
    done = machine("mismatch", "reject", again).out
    assert "x.current version 2 is taken back" in done
    assert "x.current version 3 is taken back" in done
    assert stored(1)
