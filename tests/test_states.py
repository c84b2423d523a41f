"""Cuts that are not of a pair's usual state stand aside, are explained, and become a state."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sqlalchemy import select

from autodb.pairs.belief import DAY
from autodb.sensing.error_kinds import ErrorKinds, day_moves
from autodb.store import models, open_store
from tests.conftest import Cli, Once

URL = "sqlite:///autodb.sqlite3"


@pytest.fixture
def learnt(cli: Cli, sample_jobs: Path, once: Once) -> Cli:
    """Return the command line on a lathe that has learnt a week of sound cuts."""

    def learn() -> None:
        recordings = sample_jobs / "stepped_shaft" / "recordings"
        cli("init")
        cli("machine", "add", "lathe-1")
        for name in ("standard-cuts.csv", "shop-week-1.csv"):
            cli("import", recordings / name, "--machine", "lathe-1")
        cli("calibrate", "--machine", "lathe-1")
        done = cli("refresh", "--machine", "lathe-1")
        assert "version 1 from 72 cuts" in done.out
        assert "usual state" not in done.out

    once(learn)
    return cli


@pytest.fixture
def worn(learnt: Cli, sample_jobs: Path) -> Iterator[Cli]:
    """Return it after a week in which edges wear out."""
    recordings = sample_jobs / "stepped_shaft" / "recordings"
    learnt("import", recordings / "shop-week-2.csv", "--machine", "lathe-1")
    yield learnt


def _rows() -> list[dict[str, Any]]:
    store = open_store(URL)
    with store.reading() as session:
        found = [
            {
                "version": row.version,
                "state": row.state,
                "cuts": {force.cut_id for force in row.forces},
                "shared": [one["key"] for one in row.shared or ()],
                "tau": row.mean[0],
            }
            for row in session.scalars(
                select(models.CuttingParameters).order_by(models.CuttingParameters.version)
            )
        ]
    store.close()
    return found


def _may_also_be(term: str) -> None:
    """Give the first mismatch an alternative, as explain would where cuts do not tell."""
    store = open_store(URL)
    with store.writing() as session:
        session.get_one(models.Mismatch, 1).alternatives = [term]
    store.close()


def test_cuts_stand_aside_are_named_and_once_confirmed_are_a_state(worn: Cli) -> None:
    done = worn("refresh", "--machine", "lathe-1").out
    assert "are not of its usual state" in done
    assert "force.y: tool_wear (missing)" in done
    usual = _rows()[-1]
    assert (usual["version"], usual["state"]) == (2, None)

    # Left alone they stay aside, and nothing is explained again
    again = worn("refresh", "--machine", "lathe-1").out
    assert "are not of its usual state" in again
    assert "mismatch" not in again
    assert len(_rows()) == 2

    # Confirmed they are a state, and the usual one is as it was
    _may_also_be("hard_spot")
    done = worn("mismatch", "confirm", "1", "--as", "hard_spot").out
    assert "of five such cuts that stand aside 'autodb refresh --machine lathe-1' makes a" in done
    assert "carbide insert, hard_spot: version 3" in worn("refresh", "--machine", "lathe-1").out
    first, second, state = _rows()
    assert state["state"] == "hard_spot"
    assert not state["cuts"] & (first["cuts"] | second["cuts"])
    assert "usual state" not in worn("refresh", "--machine", "lathe-1").out
    assert len(_rows()) == 3

    # The look-up of a cut such as only they were is the state's, another's the usual
    fresh, late = (_force(worn, cutting_time) for cutting_time in (0, _late_s()))
    assert (fresh["state"], late["state"]) == (None, "hard_spot")
    assert late["force_y_N"]["value"] > 1.1 * fresh["force_y_N"]["value"]


def _late_s() -> float:
    """Return a time on the edge that only cuts of another state have: the latest of them."""
    store = open_store(URL)
    with store.reading() as session:
        rows = session.scalars(select(models.CuttingParameters)).all()
        times = {
            state: max(
                float(force.cut.conditions["tool.cutting_time"])
                for row in rows
                if row.state == state
                for force in row.forces
            )
            for state in (None, "hard_spot")
        }
    store.close()
    assert times["hard_spot"] > times[None]
    return times["hard_spot"]


def _force(cli: Cli, cutting_time: float) -> dict[str, Any]:
    done = cli(
        "lookup", "--machine", "lathe-1", "--material", "steel bar", "--tool", "carbide insert",
        "--diameter", 50, "--depth", 1.5, "--feed", 0.2, "--speed", 220, "--cutting-time",
        cutting_time, "--json",
    )  # fmt: skip
    found: dict[str, Any] = json.loads(done.out)["cut"]
    return found


def test_rejected_they_are_learnt_after_all(worn: Cli) -> None:
    worn("refresh", "--machine", "lathe-1")
    before = _rows()[-1]
    for number in (1, 2):
        assert worn("mismatch", "reject", number).code == 0
    assert "version 3 from 108 cuts" in worn("refresh", "--machine", "lathe-1").out
    assert not _rows()[-1]["cuts"] & before["cuts"]


def test_the_errors_of_days_are_not_kept(learnt: Cli) -> None:
    del learnt
    assert not [key for key in _rows()[0]["shared"] if key.startswith(DAY)]


def test_what_days_share_and_what_is_a_days_own_are_all_that_is_shared() -> None:
    group = np.array([[16.0, -0.6], [-0.6, 0.09]])
    scaling = np.array([10.0, 200.0])
    kinds = ErrorKinds(1.0, 0.03, 0.04, group)
    references = np.pad(0.04**2 * np.outer(scaling, scaling), (0, 1))
    standing = np.pad(kinds.standing(scaling), (0, 1))
    moves = day_moves(scaling)
    whole = references + standing + moves @ kinds.of_a_day @ moves.T
    assert_allclose(whole, kinds.shared(scaling))
