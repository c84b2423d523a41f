"""A pass asks only what changed: what had no answer is asked again once its evidence is other."""

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pandas as pd
import pytest
from sqlalchemy import select

from autodb.agent.answer.pooled import asked_before, pooling
from autodb.agent.answer.pooled.asked_before import MOST_KEPT, AskedBefore, KeptInquiry
from autodb.agent.answer.pooled.pooled_mismatches import LOOKED_BACK
from autodb.agent.learn.learnt_from import excluded_cuts
from autodb.agent.rows.refresh_cursor import last_mark
from autodb.explain import Explained
from autodb.records.tables import CutTable
from autodb.store import models, open_store
from tests.agent.conftest import DAYS, MACHINE
from tests.conftest import Cli, Once

pytestmark = pytest.mark.usefixtures("one_law")

URL = "sqlite:///autodb.sqlite3"
WEAR = "tool_wear"
WORN = range(3, 9)
"""The recordings of the worn days."""


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return how many cuts each explanation of a pass was asked of; no name is ever reached."""
    asked: list[int] = []

    def nameless(sensed: CutTable, *tables: object, includes: list[str]) -> Explained:
        assert "shear" in includes
        assert len(tables) == 1
        asked.append(len(sensed.cut))
        return Explained(cast("Any", SimpleNamespace(channels={})), {})

    monkeypatch.setattr(pooling, "explain", nameless)
    return asked


@pytest.fixture
def asked(sound_week: Cli, once: Once, calls: list[int]) -> Cli:
    """Return the command line after a pass that explained worn days, and named nothing."""
    before = Path.cwd()

    def refresh() -> None:
        shutil.copytree(before, ".", dirs_exist_ok=True)
        for name in DAYS:
            assert sound_week("import", name, *MACHINE).code == 0
        said = sound_week("refresh", *MACHINE).out
        assert "outliers from its normal cutting state" in said
        assert "mismatch" not in said
        assert sound_week("backup", "asked.sqlite3").code == 0
        assert len(calls) == 2  # excluded cuts, and all of the pair for wear

    once(refresh)
    calls.clear()
    return sound_week


def _sound(cli: Cli, sample_jobs: Path, rows: int, seed: int = 1) -> None:
    """Import sound cuts of the pair, in an order of their own."""
    week = pd.read_csv(sample_jobs / "stepped_shaft" / "recordings" / "shop-week-1.csv")
    table = week.iloc[:rows].copy()
    table["t"] += 1e6 * seed
    table["cutting.depth"] *= 1.0 + 1e-4 * seed
    table.to_csv(f"sound-{seed}.csv", index=False)
    assert cli("import", f"sound-{seed}.csv", *MACHINE).code == 0


def _kept() -> list[KeptInquiry]:
    store = open_store(URL)
    with store.reading() as session:
        mark = last_mark(session, 1)
        assert mark is not None
        rows = mark.asked
    store.close()
    return [KeptInquiry(**row) for row in rows]


def test_what_had_no_answer_is_not_asked_again(
    asked: Cli, calls: list[int], sample_jobs: Path
) -> None:
    before = _kept()
    assert [one.about for one in before] == [None, WEAR]
    for seed in (1, 2):
        _sound(asked, sample_jobs, 3, seed)
        done = asked("refresh", *MACHINE).out
        assert "version" in done
        assert "outliers from its normal cutting state" in done
    assert calls == []
    assert _kept() == before

    # Nor by a pass that examines every cut: another pair was decided on, say
    store = open_store(URL)
    with store.writing("lathe-1") as session:
        for row in session.scalars(select(models.RefreshPass)):
            row.basis = {**(row.basis or {}), "decided": [7, "2026-01-01"]}
    store.close()
    assert asked("refresh", *MACHINE).code == 0
    assert calls == []
    assert asked("doctor").code == 0


def test_cuts_that_came_have_it_asked_again(
    asked: Cli, calls: list[int], sample_jobs: Path
) -> None:
    """One more excluded cut is enough, in both; of sound ones a tenth, of what all cuts show."""
    (of_excluded, of_all) = _kept()
    more = int(0.1 * of_all.cuts) + 1
    _sound(asked, sample_jobs, more)
    asked("refresh", *MACHINE)
    assert len(calls) == 1
    assert [one.cuts for one in _kept()] == [of_excluded.cuts, of_all.cuts + more]
    calls.clear()
    worn = pd.read_csv(DAYS[-1]).assign(**{"tool.edge": "B4"})
    worn["cutting.depth"] *= 1.001
    worn.to_csv("later.csv", index=False)
    asked("import", "later.csv", *MACHINE)
    asked("refresh", *MACHINE)
    assert len(calls) == 2
    assert calls[0] == of_excluded.cuts + len(worn)


def _withdrawn(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    del monkeypatch
    assert cli("withdraw", _of_excluded()[0], *MACHINE, "--why", "another bar").code == 0


def _read_again(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    del monkeypatch
    name = DAYS[_of_excluded()[0] - WORN[0]]
    Path(name).with_suffix(".toml").write_text('[recording]\njob = "shaft 7"\n')
    assert "imported" in cli("import", name, *MACHINE, "--again").out


def _calibrated(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the standard cuts again, at currents that are lower by a thousandth."""
    del monkeypatch
    store = open_store(URL)
    with store.reading() as session:
        table = pd.read_csv(session.get_one(models.StoredRecording, 1).path)
    store.close()
    table["spindle.current.range"] *= 0.999
    table.to_csv("again.csv", index=False)
    said = cli("calibrate", "again.csv", *MACHINE).out
    assert "R²" in said
    assert "already there" not in said


def _of_another_version(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    del cli
    monkeypatch.setattr(asked_before, "__version__", "99.0.0")


Undoing = Callable[[Cli, pytest.MonkeyPatch], None]


@pytest.mark.parametrize("undo", [_withdrawn, _read_again, _calibrated, _of_another_version])
def test_what_undoes_its_evidence_has_it_asked_again(
    asked: Cli,
    calls: list[int],
    sample_jobs: Path,
    monkeypatch: pytest.MonkeyPatch,
    undo: Undoing,
) -> None:
    undo(asked, monkeypatch)
    _sound(asked, sample_jobs, 3)
    assert asked("refresh", *MACHINE).code == 0
    assert calls

    # And then is not again
    calls.clear()
    _sound(asked, sample_jobs, 3, 2)
    assert asked("refresh", *MACHINE).code == 0
    assert calls == []


def _of_excluded() -> list[int]:
    """Return the recordings, by id, that hold excluded cuts, the fullest first."""
    store = open_store(URL)
    with store.reading() as session:
        cuts = [cut.recording_id for cut in excluded_cuts(session, 1, 1, upto=10**6)]
    store.close()
    return sorted(set(cuts), key=cuts.count, reverse=True)


def test_taking_a_withdrawal_back_has_it_asked_again(asked: Cli, calls: list[int]) -> None:
    number = _of_excluded()[0]
    asked("withdraw", number, *MACHINE, "--why", "another bar")
    asked("refresh", *MACHINE)
    assert calls
    calls.clear()
    asked("withdraw", number, *MACHINE, "--undo")
    asked("refresh", *MACHINE)
    assert calls


def test_a_decision_has_it_asked_again_and_so_does_reopening(asked: Cli, calls: list[int]) -> None:
    store = open_store(URL)
    with store.writing("lathe-1") as session:
        row = models.Mismatch(
            recording_id=2, channel="force.y", term="edge_force", kind="missing",
            pairs=[session.get_one(models.Pair, 1)], confidence=0.5, statement="said by hand",
            parameters={"size": {"value": 1.0, "low": 0.0, "high": 2.0, "unit": "N"}},
        )  # fmt: skip
        session.add(row)
        session.flush()
        number = row.id
    store.close()
    for decide in ("reject", "reopen"):
        assert asked("mismatch", decide, number).code == 0
        asked("refresh", *MACHINE)
        assert calls, decide
        calls.clear()


def test_it_goes_with_the_database(asked: Cli, calls: list[int], sample_jobs: Path) -> None:
    """A restored backup knows what it was asked; a database of before passes kept it asks."""
    before = _kept()
    _sound(asked, sample_jobs, 12)
    asked("refresh", *MACHINE)
    assert _kept() != before
    calls.clear()
    assert asked("restore", "asked.sqlite3", "--replace").code == 0
    assert _kept() == before
    _sound(asked, sample_jobs, 3, 2)
    asked("refresh", *MACHINE)
    assert calls == []
    store = open_store(URL)
    with store.writing("lathe-1") as session:
        for row in session.scalars(select(models.RefreshPass)):
            row.basis = {k: v for k, v in (row.basis or {}).items() if k != "asked"}
    store.close()
    _sound(asked, sample_jobs, 3, 3)
    asked("refresh", *MACHINE)
    assert len(calls) == 2


def test_those_among_the_newest_cuts_are_excluded_still(asked: Cli) -> None:
    del asked
    store = open_store(URL)
    with store.reading() as session:
        every = [cut.id for cut in excluded_cuts(session, 1, 1, upto=10**6)]
        last = session.scalars(select(models.Cut.id).order_by(models.Cut.id.desc())).all()
        for newest in (1, 10, 20, LOOKED_BACK):
            some = excluded_cuts(session, 1, 1, upto=10**6, newest=newest)
            assert [cut.id for cut in some] == [n for n in every if n in last[:newest]]
    store.close()
    assert every


ONE = KeptInquiry(1, None, 3, 40, 12, "ab", {"force.y": [100.0, -50.0]})


@pytest.mark.parametrize(
    ("now", "same"),
    [
        ({}, True),
        ({"expected_N": {"force.y": [100.9, -50.4]}}, True),
        ({"expected_N": {"force.y": [100.0, -50.6]}}, False),
        ({"expected_N": {"force.z": [100.0, -50.0]}}, False),
        ({"evidence": "cd"}, False),
    ],
)
def test_expected_forces_may_move_by_a_hundredth(now: dict[str, Any], same: bool) -> None:
    assert ONE.says_the_same(replace(ONE, **now)) is same


def test_those_asked_last_are_kept() -> None:
    every = AskedBefore()
    for number in range(MOST_KEPT + 5):
        every.keep(replace(ONE, pair=number))
    every.keep(replace(ONE, pair=7, evidence="cd"))
    rows = every.rows
    assert len(rows) == MOST_KEPT
    assert (rows[-1]["pair"], rows[-1]["evidence"]) == (7, "cd")
    assert AskedBefore(rows).rows == rows
    assert sum(row["pair"] == 7 for row in rows) == 1
