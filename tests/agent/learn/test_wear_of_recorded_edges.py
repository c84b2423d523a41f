"""Wear is learnt of edges whose changes a person recorded as of those that a file states."""

import os
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import astuple
from datetime import datetime, timedelta
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose
from sqlalchemy import select

from autodb.agent.learn.learnt_from import learnt_from
from autodb.agent.rows.posteriors import as_posterior, latest
from autodb.assets import kit
from autodb.pairs.engaged import CUTTING_TIME
from autodb.pairs.posterior import PairPosterior
from autodb.store import models, open_store
from tests.conftest import Cli, Once

pytestmark = pytest.mark.usefixtures("one_law")

RECORDINGS = kit("sample_jobs") / "stepped_shaft" / "recordings"
STARTS = {"standard": "2026-03-01T06:00", "first": "2026-03-02T06:00", "second": "2026-03-03T06:00"}
PAUSE_S = 60.0
TOOL = "carbide insert"
FIRST = (1, 13, 25)
"""Cuts that new edges made."""
STATED = ["tool.edge", "tool.cutting_time"]


def _write(name: str, table: pd.DataFrame) -> str:
    table.to_csv(f"{name}.csv", index=False)
    side = f'[recording]\nstart = "{STARTS[name]}+00:00"\n'
    Path(f"{name}.toml").write_text(side, encoding="utf-8")
    return f"{name}.csv"


def _second() -> pd.DataFrame:
    """Return the week in which three edges wear, with how long each cut took."""
    week = pd.read_csv(RECORDINGS / "shop-week-2.csv")
    lasts = np.diff(week["t"], append=week["t"].iloc[-1] + 130.0 + PAUSE_S) - PAUSE_S
    return week.assign(**{"cut.duration": lasts})


@pytest.fixture
def unworn(cli: Cli, once: Once) -> Cli:
    """Return a lathe that has learnt the week before."""

    def learn() -> None:
        cli("init")
        cli("machine", "add", "lathe-1")
        _write("standard", pd.read_csv(RECORDINGS / "standard-cuts.csv"))
        _write("first", pd.read_csv(RECORDINGS / "shop-week-1.csv"))
        cli("import", "standard.csv", "first.csv", "--machine", "lathe-1")
        cli("calibrate")
        assert cli("refresh").code == 0

    once(learn)
    return cli


def _stated(cli: Cli) -> None:
    """Have the second week come in as a log that says all of its edges."""
    cli("import", _write("second", _second()), "--machine", "lathe-1")
    cli("refresh")


def _recorded(cli: Cli, *, late: bool = False) -> None:
    """Have it come in as one that says nothing of them: people record the changes."""
    if not late:
        _change_all(cli)
    cli("import", _write("second", _second().drop(columns=STATED)), "--machine", "lathe-1")
    cli("refresh")
    if late:
        _change_all(cli)
        cli("refresh")


def _change_all(cli: Cli) -> None:
    for number in FIRST:
        _change(cli, number)


def _change(cli: Cli, number: int) -> str:
    """Record that a new edge made a cut of the second week."""
    week = _second()
    t = float(week.loc[week["cut"] == number, "t"].iloc[0])
    at = datetime.fromisoformat(f"{STARTS['second']}+00:00") + timedelta(seconds=t)
    return cli("edge", "changed", "--tool", TOOL, "--at", at.isoformat()).out


def _learnt() -> tuple[PairPosterior, int]:
    """Return the pair's newest posterior, and its version; it has learnt cuts of known ages."""
    store = open_store("sqlite:///autodb.sqlite3")
    try:
        with store.reading() as session:
            row = latest(session, 1, session.scalars(select(models.Pair.id)).one())
            assert row is not None
            assert CUTTING_TIME in learnt_from(session, row.id).ranges
            return as_posterior(row), row.version
    finally:
        store.close()


def _wear(cli: Cli, learn: Callable[[Cli], None]) -> PairPosterior:
    """Return what is learnt of worn edges, in a folder of its own."""
    before = Path.cwd()
    folder = Path(tempfile.mkdtemp(dir=before.parent))
    shutil.copytree(before, folder, dirs_exist_ok=True)
    os.chdir(folder)
    try:
        learn(cli)
        assert "tool_wear confirmed" in cli("mismatch", "confirm", 1).out
        return _learnt()[0]
    finally:
        os.chdir(before)


def test_wear_is_that_of_stated_edges(unworn: Cli) -> None:
    stated = _wear(unworn, _stated)
    assert stated.wear is not None
    for late in (False, True):
        recorded = _wear(unworn, partial(_recorded, late=late))
        assert recorded.cuts == stated.cuts
        assert recorded.wear is not None
        assert_allclose(astuple(recorded.wear)[:3], astuple(stated.wear)[:3], rtol=1e-6)
        assert_allclose(recorded.state.mean, stated.state.mean, rtol=1e-5, atol=1e-8)
        assert_allclose(recorded.state.covariance, stated.state.covariance, rtol=1e-4, atol=1e-8)


def test_a_change_that_nobody_recorded_is_inferred_of_counted_cuts_too(unworn: Cli) -> None:
    _recorded(unworn)
    unworn("mismatch", "confirm", 1)
    known, version = _learnt()
    done = unworn("edge", "undo", 2).out
    assert "12 cuts count as before it" in done
    assert f"version {version} is taken back; 'autodb refresh' learns it anew" in done

    # The next refresh finds the change itself, and learns the wear that it had learnt
    said = unworn("refresh").out
    assert "fell back to its beginning before cut 13 of second.csv" in said
    assert "inferred, the edge was changed after 1409 s" in said
    learnt, later = _learnt()
    assert later == version + 1
    assert_allclose(learnt.state.mean, known.state.mean, rtol=1e-5, atol=1e-8)
    assert "nothing new" in unworn("refresh").out

    # A person's word is first: the edge that was recorded a cut later has no other change
    assert "11 cuts that came in since count" in _change(unworn, 14)
    assert "taken back" not in unworn("refresh").out
    with_word, _ = _learnt()
    assert with_word.wear is not None
    assert not np.allclose(with_word.state.mean, known.state.mean, rtol=1e-5)
