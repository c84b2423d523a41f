"""A cause that a person confirms is in the machine's next version, and explain finds it no more."""

import json
import shutil
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from numpy.testing import assert_allclose
from pyarrow import csv

from autodb.agent.operate.fitting_confirmed import of_term
from autodb.agent.sense.reconstructing import reconstruct_on_machine
from autodb.records.source import read
from autodb.records.tables import Recording
from autodb.sensing.drives import feed_axis
from autodb.sensing.drives.fit.axis_model import Identified, IdentifiedTerm, Posteriors
from autodb.store import open_store
from autodb.terms.vocabulary import effect_called
from tests.conftest import Cli
from tests.helpers.trapezoids import COULOMB, INERTIA, NOISE, VISCOUS, WEIGHT, moves
from tests.helpers.uneven_axis import (
    FORCE,
    LEVEL,
    SLOPE,
    URL,
    Array,
    Refused,
    keep_mismatch,
    stored_version,
    uneven_effort,
    write_uneven,
)


def causes(done_out: str) -> dict[str, str]:
    found = json.loads(done_out)["channels"]["x.current"]["missing"]
    return {cause["term"]: cause["kind"] for cause in found}


def test_the_next_prediction_contains_what_was_confirmed(machine: Cli) -> None:
    second, third = write_uneven("b.csv", 2), write_uneven("c.csv", 3)
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
    for term in (t for t in stored_version(2) if t.term == "asymmetry"):
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
    second = write_uneven("b.csv", 2)
    number = keep_mismatch(second, machine, "asymmetry")
    other = keep_mismatch(second, machine, "lag")
    elsewhere = keep_mismatch(second, machine, "lag", channel="y.current")
    done = machine("mismatch", "confirm", number).out
    assert f"still open, found before this version: {other}; 'autodb explain" in done
    assert str(elsewhere) not in done.rpartition("still open")[2]


def test_a_confirmed_term_of_another_size_is_mistuned(machine: Cli) -> None:
    number = keep_mismatch(write_uneven("b.csv", 2), machine, "asymmetry")
    machine("mismatch", "confirm", number)
    later = machine("explain", write_uneven("c.csv", 3, uneven=2.0), "--machine", "mill")
    assert f"mismatch {number + 1}: asymmetry (mistuned, " in later.out
    done = machine("mismatch", "confirm", number + 1)
    assert "version 3 of machine 'mill', started from version 2" in done.out
    assert "moved since version 2: asymmetry level" in done.out
    level = next(t for t in stored_version(3) if (t.term, t.parameter) == ("asymmetry", "level"))
    assert abs(level.value - 2.0 * LEVEL) < 3.0 * level.sd


def test_a_term_found_where_the_model_came_from(machine: Cli) -> None:
    """The version that has seen the recording is no prior: its rows would count twice."""
    write_uneven("b.csv", 2)
    machine("identify", "b.csv", "--machine", "mill")
    number = keep_mismatch(Path("b.csv"), machine, "asymmetry")
    done = machine("mismatch", "confirm", number)
    assert "version 3 of machine 'mill', started from version 1" in done.out
    again = keep_mismatch(Path("b.csv"), machine, "asymmetry")
    assert "version 3 of machine 'mill': already there" in machine("mismatch", "confirm", again).out
    assert "version 3" in machine("trace", "mismatch", again).out


@pytest.mark.parametrize("seed", range(20, 24))
def test_a_version_that_lacked_a_term_does_not_hold_the_fit_back(seed: int) -> None:
    """Its friction and weight swallowed part of the effect; what they still say does no harm."""
    terms = (*feed_axis.default_terms("axis"), "asymmetry")
    first, second = (
        Recording(path=Path("a.csv"), channels={**m, "x.current": uneven_effort(m, n)})
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
        Recording(path=Path("a.csv"), channels={**m, "x.current": uneven_effort(m, n, uneven=0.0)})
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
    csv.write_csv(
        pa.table({**table, "x.current": uneven_effort(channels, 3)[moving]}), "one-way.csv"
    )
    number = keep_mismatch(Path("one-way.csv"), machine, "asymmetry")
    line = refused("mismatch", "confirm", number)
    assert f"mismatch {number} stays open: one-way.csv does not excite asymmetry; asymmetry" in line
    assert "both directions" in line
    assert "open" in machine("mismatch", "list", "mill").out
    assert stored_version(1)


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
    symmetric = stored_version(1, FORCE)
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
        feed_axis.cross_test(other, "x", protocol, terms)
        for terms in (symmetric, stored_version(2, FORCE))
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
    third = write_uneven("c.csv", 3)

    def load_A() -> tuple[Array, str]:
        store, recorded = open_store(URL), read(third)
        assert isinstance(recorded, Recording)
        (found,) = reconstruct_on_machine(
            store, "mill", recorded, axis=None, bandwidth_hz=20.0, observer=False
        )
        store.close()
        return found.load.value, found.model

    before, was = load_A()
    number = keep_mismatch(write_uneven("b.csv", 2), machine, "asymmetry")
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
    write_uneven("b.csv", 2)
    number = keep_mismatch(Path("b.csv"), machine, "asymmetry")
    machine("mismatch", "confirm", number)
    again = keep_mismatch(Path("b.csv"), machine, "asymmetry")
    assert "version 2 of machine 'mill': already there" in machine("mismatch", "confirm", again).out
    machine("mismatch", "reopen", number)
    assert stored_version(2)
    machine("identify", write_uneven("d.csv", 4), "--machine", "mill")
    done = machine("mismatch", "reject", again).out
    assert "x.current version 2 is taken back" in done
    assert "x.current version 3 is taken back" in done
    assert stored_version(1)
