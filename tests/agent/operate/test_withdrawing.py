"""What is only explained teaches nothing; what is withdrawn, and what came of it, holds no more."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from autodb.agent.operate.withdrawing import take_again, withdraw
from autodb.agent.rows.calibrations import current_calibrations
from autodb.agent.rows.posteriors import as_posterior, latest
from autodb.assets import kit
from autodb.store import models, open_store
from tests.conftest import Cli, Once

pytestmark = pytest.mark.usefixtures("one_law")

MACHINE = ("--machine", "lathe-1")
RECORDINGS = kit("sample_jobs") / "stepped_shaft" / "recordings"
STANDARD, MONDAY, TUESDAY = 1, 2, 3


@pytest.fixture(autouse=True)
def there(cli: Cli, once: Once) -> Cli:
    """Return a calibrated lathe that has learnt a day, and what it cut on the next."""

    def make() -> None:
        pd.read_csv(RECORDINGS / "standard-cuts.csv").drop(columns="tool").to_csv(
            "standard.csv", index=False
        )  # of no tool: nothing is learnt from it
        _week(0, 8).to_csv("monday.csv", index=False)
        _week(8, 16).to_csv("tuesday.csv", index=False)
        cli("init")
        cli("machine", "add", "lathe-1", "--file", RECORDINGS.parent / "machine.toml")
        cli("import", "standard.csv", *MACHINE)
        cli("calibrate", *MACHINE)
        cli("import", "monday.csv", *MACHINE)
        assert cli("refresh", *MACHINE).code == 0

    once(make)
    return cli


def _week(first: int, last: int) -> pd.DataFrame:
    return pd.read_csv(RECORDINGS / "shop-week-1.csv").iloc[first:last]


@contextmanager
def _reading() -> Iterator[Session]:
    store = open_store("sqlite:///autodb.sqlite3")
    try:
        with store.reading() as session:
            yield session
    finally:
        store.close()


def _posterior() -> tuple[np.ndarray, np.ndarray, int]:
    """Return mean and covariance of the pair's law, and how many cuts it rests on."""
    with _reading() as session:
        row = latest(session, 1, session.scalars(select(models.Pair.id)).one())
        assert row is not None
        posterior = as_posterior(row)
        return posterior.law.mean, posterior.law.covariance, row.n_cuts


def _counting() -> int:
    with _reading() as session:
        query = select(func.count()).where(models.Cut.superseded_at.is_(None))
        return session.scalar(query) or 0


def _same(before: tuple[np.ndarray, np.ndarray, int]) -> None:
    mean, covariance, cuts = _posterior()
    assert cuts == before[2]
    sd = np.maximum(np.sqrt(np.diag(before[1])), 1e-9)
    assert_allclose((mean - before[0]) / sd, 0.0, atol=1e-6)
    assert_allclose(covariance / np.outer(sd, sd), before[1] / np.outer(sd, sd), atol=1e-5)


def test_what_is_explained_teaches_nothing(there: Cli) -> None:
    counted, before = _counting(), _posterior()
    assert there("explain", "tuesday.csv", *MACHINE, "--out", "ex").code == 0
    assert _counting() == counted
    assert "nothing new" in there("refresh", *MACHINE).out
    _same(before)
    assert "only explained" in there("trace", "recording", TUESDAY).out


def test_what_was_explained_counts_once_it_is_imported(there: Cli) -> None:
    counted = _counting()
    there("explain", "tuesday.csv", *MACHINE, "--out", "ex")
    assert "imported, 8 rows, 8 cuts" in there("import", "tuesday.csv", *MACHINE).out
    assert _counting() == counted + 8
    assert "from 16 cuts" in there("refresh", *MACHINE).out
    assert "already there" in there("import", "tuesday.csv", *MACHINE).out
    assert "nothing new" in there("refresh", *MACHINE).out


def test_a_recording_that_counts_is_not_counted_again_as_it_is_explained(there: Cli) -> None:
    counted = _counting()
    there("explain", "monday.csv", *MACHINE, "--out", "ex")
    pd.read_csv("monday.csv").to_parquet("copy.parquet", index=False)
    there("explain", "copy.parquet", *MACHINE, "--out", "ex")
    assert _counting() == counted


def test_withdrawn_it_is_as_if_it_had_never_come_in(there: Cli) -> None:
    before = _posterior()
    there("import", "tuesday.csv", *MACHINE)
    there("refresh", *MACHINE)
    assert _posterior()[2] == 16
    done = there("withdraw", TUESDAY, *MACHINE, "--why", "another tool was in the turret")
    assert done.code == 0, done.err
    assert "recording 3: 8 cuts are no longer used" in done.out
    assert "taken back: steel bar / carbide insert version 2" in done.out
    _same(before)
    said = there("trace", "recording", TUESDAY).out
    assert "withdrawn" in said
    assert "another tool was in the turret" in said
    again = there("import", "tuesday.csv", *MACHINE).out
    assert "withdrawn (another tool was in the turret), it does not count" in again
    assert "nothing new" in there("refresh", *MACHINE).out
    assert there("doctor").code == 0


def test_withdrawn_by_mistake_it_comes_back(there: Cli) -> None:
    there("import", "tuesday.csv", *MACHINE)
    there("refresh", *MACHINE)
    both = _posterior()
    there("withdraw", TUESDAY, *MACHINE, "--why", "a mistake")
    again = there("withdraw", TUESDAY, *MACHINE, "--undo")
    assert "recording 3: 8 cuts are used again" in again.out
    _same(both)


def test_the_only_cuts_of_a_pair_leave_nothing_of_it(there: Cli) -> None:
    there("withdraw", MONDAY, *MACHINE, "--why", "chatter")
    with _reading() as session:
        assert latest(session, 1, session.scalars(select(models.Pair.id)).one()) is None
    assert there("lookup", *MACHINE).out.count("carbide insert") == 0


def test_a_calibration_is_taken_back_and_the_one_before_holds_again(there: Cli) -> None:
    def holding() -> list[tuple[int, float]]:
        with _reading() as session:
            rows = current_calibrations(session, 1, "z")
            return [(row.version, row.coefficients[0]) for row in rows]

    before = holding()
    more = pd.read_csv("standard.csv").assign(cut=lambda t: t["cut"] + 100)
    more["z.current.range"] *= 1.2
    more.to_csv("more.csv", index=False)
    there("import", "more.csv", *MACHINE)
    there("calibrate", *MACHINE)
    assert holding() != before
    said = there("withdraw", 3, *MACHINE, "--why", "wrong range").out
    assert "taken back: calibration of z version 2" in said
    assert "'autodb calibrate --machine lathe-1' fits" in said
    assert holding() == before
    there("withdraw", STANDARD, *MACHINE, "--why", "drifted")
    assert holding() == []
    assert "no calibration is usable" in there("refresh", *MACHINE).out


def test_a_model_that_took_a_withdrawn_one_as_known_goes_too(there: Cli) -> None:
    moves = pd.read_csv(RECORDINGS / "air-moves.csv")
    moves.to_csv("first.csv", index=False)
    moves.assign(t=moves["t"] + 100.0).to_csv("second.csv", index=False)
    there("identify", "first.csv", *MACHINE, "--axis", "z")
    there("identify", "second.csv", *MACHINE, "--axis", "z")
    said = there("withdraw", 3, *MACHINE, "--why", "no warm-up").out
    assert "taken back: model of z.current version 1" in said
    assert "taken back: model of z.current version 2" in said
    with _reading() as session:
        versions = select(models.ChannelModel.version, models.ChannelModel.undone_at)
        assert all(undone is not None for _, undone in session.execute(versions))
    there("identify", "second.csv", *MACHINE, "--axis", "z")
    with _reading() as session:
        assert session.scalar(select(func.max(models.ChannelModel.version))) == 3


@pytest.mark.parametrize("asked", [("--why", "a worn edge"), ("--undo",)], ids=" ".join)
def test_one_that_was_killed_before_it_had_learnt_anew_is_gone_on_with(
    there: Cli, asked: tuple[str, ...]
) -> None:
    if asked == ("--undo",):
        assert there("withdraw", MONDAY, *MACHINE, "--why", "a worn edge").code == 0
    store = open_store("sqlite:///autodb.sqlite3")
    if asked == ("--undo",):
        take_again(store, "lathe-1", MONDAY)
    else:
        withdraw(store, "lathe-1", MONDAY, why="a worn edge")
    passes = select(func.count()).select_from(models.RefreshPass)
    with store.reading() as session:
        before = session.scalar(passes)
    done = there("withdraw", MONDAY, *MACHINE, *asked)
    assert done.code == 0, done.err
    assert "already done, its cuts are" in done.out
    with store.reading() as session:
        assert session.scalar(passes) == (before or 0) + 1
    store.close()
    assert "nothing new" in there("refresh", *MACHINE).out
    other = there("withdraw", MONDAY, *MACHINE, "--why", "another")
    assert (other.code == 2) == (asked != ("--undo",))


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ((9, "--why", "x"), "machine 'lathe-1' has no recording 9"),
        ((MONDAY,), "withdraw needs --why TEXT or --undo"),
    ],
)
def test_what_cannot_be_withdrawn_is_said(
    there: Cli, arguments: tuple[object, ...], says: str
) -> None:
    done = there("withdraw", *arguments, *MACHINE)
    assert done.code == 2
    assert says in done.err


def test_a_retired_machine_takes_nothing_in_and_answers_on(there: Cli) -> None:
    assert "retired" in there("machine", "retire", "lathe-1").out
    refused = there("import", "tuesday.csv", *MACHINE)
    assert refused.code == 2
    assert "run 'autodb machine retire lathe-1 --undo'" in refused.err
    Path("in").mkdir()
    assert "is retired since" in there("refresh", *MACHINE, "--inbox", "in").err
    assert there("lookup", *MACHINE).code == 0
    there("machine", "add", "lathe-2")
    assert "lathe-1" not in there("fleet", "refresh").out
    there("machine", "retire", "lathe-1", "--undo")
    assert there("import", "tuesday.csv", *MACHINE).code == 0


def test_a_machine_is_called_otherwise_and_knows_what_it_knew(there: Cli) -> None:
    before = _posterior()
    there("machine", "add", "lathe-2")
    assert (
        "there is a machine 'lathe-2' already"
        in there("machine", "rename", "lathe-1", "lathe-2").err
    )
    assert there("machine", "rename", "lathe-1", "turning centre").code == 0
    assert "nothing new" in there("refresh", "--machine", "turning centre").out
    _same(before)
