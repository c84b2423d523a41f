"""Excluded cuts of small files are explained together, and their cause is one mismatch."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose
from sqlalchemy import select

from autodb.agent.answer.pooled.pooling import DAY_S, common_stamps, explain_mismatch
from autodb.agent.learn.learnt_from import excluded_cuts
from autodb.agent.operate.withdrawing import withdraw
from autodb.store import migrate, models, open_store
from autodb.store.schemas import head
from tests.agent.answer.test_undecided_causes import looked_up, true_N
from tests.agent.conftest import DAYS, MACHINE
from tests.conftest import Cli

pytestmark = pytest.mark.usefixtures("one_law")

URL = "sqlite:///autodb.sqlite3"
FILES = DAYS
"""The week's first two recordings are numbers 1 and 2."""
OTHER = "aluminium bar"


def _import(cli: Cli, *names: str) -> None:
    for name in names:
        assert cli("import", name, *MACHINE).code == 0


def _mismatches(status: str | None = None) -> dict[int, dict[str, Any]]:
    """Return what is kept of mismatches, by number."""
    store = open_store(URL)
    with store.reading() as session:
        found = {
            row.id: {
                "key": (row.channel, row.term, row.kind), "status": row.status,
                "recordings": [one.id for one in row.recordings], "found_in": row.found_in,
                "confidence": row.confidence, "size": row.parameters["size"]["value"],
            }
            for row in session.scalars(select(models.Mismatch).order_by(models.Mismatch.id))
            if status in (None, row.status)
        }  # fmt: skip
    store.close()
    return found


def _excluded() -> dict[int, int]:
    """Return how many cuts of the pair are excluded, by recording."""
    store = open_store(URL)
    with store.reading() as session:
        cuts = excluded_cuts(session, 1, 1, upto=10**6)
        found = [cut.recording_id for cut in cuts]
    store.close()
    return {number: found.count(number) for number in sorted(set(found))}


def test_six_small_files_name_their_cause_once(worn_days: Cli) -> None:
    said = Path("said.txt").read_text()
    holding = _excluded()
    assert sum(holding.values()) < 10
    assert max(holding.values()) <= 3
    (y, one), (z, other) = _mismatches().items()
    assert one["key"] == ("force.y", "tool_wear", "missing")
    assert other["key"] == ("force.z", "tool_wear", "missing")
    assert one["recordings"] == other["recordings"] == list(holding)
    cuts, excluded = 6 * len(holding), sum(holding.values())
    assert one["found_in"] == {"cuts": cuts, "excluded": excluded, "edges": ["B1", "B2", "B3"]}
    words = f"{cuts} cuts of {len(holding)} recordings, {excluded} excluded, edges B1, B2, B3"
    for number, channel in ((y, "force.y"), (z, "force.z")):
        assert f"mismatch {number}: {channel}: tool_wear (missing), in {words}\n" in said

    # The list, the row itself and its trace say where it was found
    assert words in " ".join(worn_days("mismatch", "list", "lathe-1").out.split())
    shown = worn_days("mismatch", "show", y).out
    names = ", ".join(FILES[number - 3] for number in holding)
    assert f"of recordings {', '.join(map(str, holding))}: {names}" in shown
    assert f"found in: {words}" in shown
    traced = worn_days("trace", "mismatch", y).out
    assert all(FILES[number - 3] in traced for number in holding)

    # One table of the same cuts names it too
    table = pd.concat([pd.read_csv(FILES[number - 3]) for number in holding])
    table.to_csv("one.csv", index=False)
    answer = json.loads(worn_days("explain", "one.csv", *MACHINE, "--json").out)
    for channel in ("force.y", "force.z"):
        (cause,) = answer["channels"][channel]["missing"]
        assert (cause["term"], cause["kind"]) == ("tool_wear", "missing")
    assert worn_days("doctor").code == 0


def test_what_is_explained_is_left_alone_until_more_comes_in(sound_week: Cli) -> None:
    said, names_then = {}, []
    for names in (FILES[:2], FILES[2:]):
        _import(sound_week, *names)
        said[names] = sound_week("refresh", *MACHINE).out
        names_then.append([one["key"][1] for one in _mismatches().values()])
    opened = [names for names in said if re.search(r"mismatch \d+: force", said[names])]
    brought = [names for names in said if "now force" in said[names]]
    assert len(opened) == 1
    assert brought

    # Two excluded cuts do not say what they are: all cuts together, that grow with use, do
    assert names_then == 2 * [["tool_wear", "tool_wear"]]

    # It grew by the recordings that came in
    found = _mismatches()
    assert all(set(one["recordings"]) > set(_excluded()) for one in found.values())
    assert "nothing new" in sound_week("refresh", *MACHINE).out
    assert _mismatches() == found


def _predicted(cli: Cli, cutting_time_s: float) -> float:
    done = cli(
        "lookup", *MACHINE, "--material", "steel bar", "--tool", "carbide insert", "--diameter",
        50, "--depth", 1.5, "--feed", 0.2, "--speed", 220, "--cutting-time", cutting_time_s,
        "--json",
    )  # fmt: skip
    return float(json.loads(done.out)["cut"]["force_y_N"]["value"])


def test_confirmed_its_wear_is_learnt_from_all_of_its_recordings(worn_days: Cli) -> None:
    before = _predicted(worn_days, 1200.0) / _predicted(worn_days, 0.0)
    assert_allclose(before, 1.0)
    holding = _excluded()
    number = next(iter(_mismatches()))
    assert "tool_wear: each mm of an edge" in worn_days("mismatch", "confirm", number).out
    assert _predicted(worn_days, 1200.0) > 1.1 * _predicted(worn_days, 0.0)
    store = open_store(URL)
    with store.reading() as session:
        newest = session.scalars(
            select(models.CuttingParameters).order_by(models.CuttingParameters.id.desc())
        ).first()
        assert newest is not None
        learnt_from = {force.cut.recording_id for force in newest.forces}
        stated = [row.id for row in newest.mismatches]
    store.close()
    assert stated == [number]
    assert learnt_from >= set(holding)
    assert sum(_excluded().values()) < sum(holding.values())

    # With both confirmed intervals hold worn cuts, and nothing waits
    assert worn_days("mismatch", "confirm", number + 1).code == 0
    forces, notes = looked_up(worn_days)
    assert not [note for note in notes if "excluded cut" in note]
    for name in "yz":
        assert forces[name][1] <= true_N()[name] <= forces[name][2]


def test_rejected_it_stays_closed_and_the_cuts_are_learnt(worn_days: Cli) -> None:
    for number in _mismatches():
        assert worn_days("mismatch", "reject", number).code == 0
    before = _mismatches()
    rejected = {number for row in before.values() for number in row["recordings"]}
    worn_days("refresh", *MACHINE)
    after = _mismatches()
    assert {number: after[number] for number in before} == before
    for one in _mismatches("open").values():
        assert not rejected & set(one["recordings"])
    assert _excluded() == {}


def test_one_of_two_rejected_is_not_opened_again(worn_days: Cli) -> None:
    found = _mismatches()
    first, second = found
    assert worn_days("mismatch", "reject", first).code == 0
    worn_days("refresh", *MACHINE)
    _later(worn_days)
    worn_days("refresh", *MACHINE)
    open_ones = _mismatches("open")
    assert open_ones[second]["key"][0] == "force.z"
    old = set(found[first]["recordings"])
    worn = [one for one in open_ones.values() if one["key"] == found[first]["key"]]
    assert all(not old & set(one["recordings"]) for one in worn)

    # Nor does a cause stand twice in the same channel
    keys = [(one["key"], *one["recordings"]) for one in open_ones.values()]
    assert len(keys) == len(set(keys))


def _later(cli: Cli, *others: pd.DataFrame) -> None:
    """Import worn cuts of the last edge once more, as another day with another edge."""
    table = pd.read_csv(FILES[-1]).assign(**{"tool.edge": "B4"})
    table["cut"] += 6
    table["cutting.depth"] *= 1.001
    pd.concat([table, *others]).to_csv("later.csv", index=False)
    _import(cli, "later.csv")


def test_a_withdrawn_recording_leaves_it_with_the_others(worn_days: Cli) -> None:
    found = _mismatches()
    number = next(iter(found))
    first, *others = found[number]["recordings"]
    listed = ", ".join(map(str, others))
    assert f"mismatch {number}, open, stays with recordings {listed}" in _withdrawn(first)
    left = _mismatches()[number]
    assert (left["status"], left["recordings"]) == ("open", others)

    # Only the last takes it along
    for recording in others[:-1]:
        _withdrawn(recording)
    assert _mismatches("open")[number]["recordings"] == others[-1:]
    assert f"mismatch {number}, open" in _withdrawn(others[-1])
    last = _mismatches()[number]
    assert (last["status"], last["recordings"]) == ("rejected", others[-1:])

    # What is said next is of the cuts that are left
    assert worn_days("refresh", *MACHINE).code == 0


def _withdrawn(recording: int) -> list[str]:
    store = open_store(URL)
    done = withdraw(store, "lathe-1", recording, why="another bar")
    store.close()
    return done.taken_back


def test_no_other_pair_is_touched(worn_days: Cli, sample_jobs: Path) -> None:
    """Another material in the same file has no part in the mismatch, nor in the wear."""
    week = pd.read_csv(sample_jobs / "stepped_shaft" / "recordings" / "shop-week-1.csv")
    other = week.iloc[:12].assign(**{"work.material": OTHER})
    other["cut"] += 100
    other["t"] += 10_000.0
    _later(worn_days, other)
    before = _mismatches()
    worn_days("refresh", *MACHINE)
    number, found = next(iter(_mismatches().items()))
    assert found["recordings"] == [*before[number]["recordings"], 9]
    assert found["found_in"]["cuts"] == before[number]["found_in"]["cuts"] + 6
    assert "B4" in found["found_in"]["edges"]

    pairs = _versions()
    done = worn_days("mismatch", "confirm", number).out
    assert OTHER not in done
    after = _versions()
    assert after[OTHER] == pairs[OTHER] == [False]
    assert after["steel bar"] == [*pairs["steel bar"], True]


def _versions() -> dict[str, list[bool]]:
    """Return whether each version of a pair has wear in it, by the pair's material."""
    store = open_store(URL)
    found: dict[str, list[bool]] = {}
    with store.reading() as session:
        query = select(models.CuttingParameters).order_by(models.CuttingParameters.id)
        for row in session.scalars(query):
            found.setdefault(row.pair.material.name, []).append(row.terms is not None)
    store.close()
    return found


def test_what_it_was_found_in_is_explained_anew(worn_days: Cli) -> None:
    assert worn_days("doctor").code == 0
    store = open_store(URL)
    with store.reading() as session:
        row = session.get_one(models.Mismatch, next(iter(_mismatches())))
        explained = explain_mismatch(session, row)
    store.close()
    assert explained.explanation.channels["force.y"].missing[0].term == "tool_wear"


def test_a_database_goes_down_with_the_first_recording_and_up_again(worn_days: Cli) -> None:
    before = _mismatches()
    migrate(URL, "0016")
    migrate(URL, head())
    after = _mismatches()
    assert {n: [one["recordings"][0]] for n, one in before.items()} == {
        n: one["recordings"] for n, one in after.items()
    }
    assert [one["found_in"] for one in after.values()] == [None, None]
    assert worn_days("doctor").code == 0


Recorded = Callable[..., list[models.Cut]]


@pytest.fixture
def recorded() -> Recorded:
    """Return a function that makes two recordings of three cuts each, without a database."""

    def make(numbers: list[float], times: list[float], starts: list[str | None]) -> Any:
        cuts = []
        for k, (number, t) in enumerate(zip(numbers, times, strict=True)):
            recording = 1 + k // 3
            start = starts[recording - 1]
            side = {} if start is None else {"recording": {"start": start}}
            row = models.StoredRecording(id=recording, side=side)
            cut = models.Cut(id=k, number=number, conditions={"t": t}, recording_id=recording)
            cut.recording = row
            cuts.append(cut)
        return cuts

    return make


def _stamps(cuts: list[models.Cut]) -> tuple[list[float], list[float]]:
    found = common_stamps(cuts)
    return [found[cut.id][0] for cut in cuts], [found[cut.id][1] for cut in cuts]


def test_days_stay_apart_on_one_clock(recorded: Recorded) -> None:
    again, goes_on = [1.0, 2.0, 3.0, 1.0, 2.0, 3.0], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    own = [0.0, 60.0, 120.0, 0.0, 60.0, 120.0]

    # Nobody says when: a day lies between; numbers that start again are counted on
    numbers, times = _stamps(recorded(again, own, [None, None]))
    assert numbers == goes_on
    assert_allclose(np.subtract(times, own), np.repeat([0.0, DAY_S + 120.0], 3))

    # Times that go on are of one clock, and numbers that go on are the shop's
    one_clock = [0.0, 60.0, 120.0, 5000.0, 5060.0, 5120.0]
    numbers, times = _stamps(recorded([11.0, 12, 13, 21, 22, 23], one_clock, [None, None]))
    assert numbers == [11.0, 12.0, 13.0, 21.0, 22.0, 23.0]
    assert_allclose(times, one_clock)

    # The starts that side files state come first, whichever came in first
    starts = ["2026-01-09T08:00:00+01:00", "2026-01-07T08:00:00+01:00"]
    numbers, times = _stamps(recorded(again, own, starts))
    assert numbers == [4.0, 5.0, 6.0, 1.0, 2.0, 3.0]
    assert_allclose(np.subtract(times, own), np.repeat([2 * DAY_S, 0.0], 3))
