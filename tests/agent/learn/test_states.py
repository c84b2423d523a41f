"""Cuts that are not of a pair's usual state are excluded, are explained, and become a state."""

import contextlib
import json
import shutil
import sqlite3
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from pyarrow import csv
from sqlalchemy import select

import autodb
from autodb.agent.rows.posteriors import as_posterior
from autodb.fitting.gaussian import NORMAL_95
from autodb.pairs.engaged import BY_NAME
from autodb.pairs.forecast import forecast
from autodb.pairs.posterior import DAY
from autodb.proofs.machines.lathe.process import STEEL, TrueCut, mean_forces_N
from autodb.sensing.ranges.error_kinds import ErrorKinds, day_moves
from autodb.store import migrate, models, open_store
from tests.conftest import ROOT, Cli, Once

pytestmark = pytest.mark.usefixtures("one_law")

Array = NDArray[np.float64]
URL = "sqlite:///autodb.sqlite3"


@pytest.fixture
def worn(sound_week: Cli, sample_jobs: Path) -> Iterator[Cli]:
    """Return it after a week in which edges wear out."""
    recordings = sample_jobs / "stepped_shaft" / "recordings"
    sound_week("import", recordings / "shop-week-2.csv", "--machine", "lathe-1")
    yield sound_week


@pytest.fixture
def excluded(worn: Cli, once: Once) -> Cli:
    """Return it once they are excluded; `said.txt` is what was said then."""
    before = Path.cwd()

    def refresh() -> None:
        shutil.copytree(before, ".", dirs_exist_ok=True)
        Path("said.txt").write_text(worn("refresh", "--machine", "lathe-1").out)

    once(refresh)
    return worn


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


def test_outlying_cuts_are_named_and_once_confirmed_are_a_state(excluded: Cli) -> None:
    worn = excluded
    done = Path("said.txt").read_text()
    assert "are outliers from its normal cutting state" in done
    assert "force.y: tool_wear (missing)" in done
    usual = _rows()[-1]
    assert (usual["version"], usual["state"]) == (2, None)

    # Left alone they stay excluded, and nothing is explained again
    again = worn("refresh", "--machine", "lathe-1").out
    assert "nothing new" in again
    assert "2 mismatches are undecided" in again
    assert "tool_wear" not in again
    assert len(_rows()) == 2

    # Confirmed they are a state, and the usual one is as it was
    _may_also_be("hard_spot")
    done = worn("mismatch", "confirm", "1", "--as", "hard_spot").out
    assert "carbide insert, hard_spot: version 3 from " in done
    assert "it is in parameters 3: " in worn("trace", "mismatch", 1).out
    assert "of the state 'hard_spot'" in worn("trace", "parameters", 3).out
    first, second, state = _rows()
    assert state["state"] == "hard_spot"
    assert not state["cuts"] & (first["cuts"] | second["cuts"])
    assert "nothing new" in worn("refresh", "--machine", "lathe-1").out
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


JOB = """
name = "two cuts"
material = "steel bar"
tool = "carbide insert"
[[cut]]
name = "fresh"
diameter_mm = 50.0
depth_mm = 1.5
feed_mm_rev = 0.2
speed_m_min = 220.0
cutting_time_s = 0.0
[[cut]]
name = "late"
diameter_mm = 50.0
depth_mm = 1.5
feed_mm_rev = 0.2
speed_m_min = 220.0
cutting_time_s = 1200.0
"""

PART = """[[cut]]
diameter_mm = 50.0
depth_mm = 1.5
feed_mm_rev = 0.2
speed_m_min = 220.0
length_mm = 60.0
"""


def _kept(recording: str, channel: str = "force.y", term: str = "tool_wear") -> int:
    """Keep a cause as explain would have, and return the mismatch' number."""
    store = open_store(URL)
    with store.writing() as session:
        named = select(models.StoredRecording).where(
            models.StoredRecording.path.endswith(recording)
        )
        row = models.Mismatch(
            recording_id=session.scalars(named).one().id, channel=channel, term=term,
            kind="missing", confidence=0.9, parameters={}, statement="It wears.",
        )  # fmt: skip
        session.add(row)
        session.flush()
        number = row.id
    store.close()
    return number


def _predicted(cli: Cli) -> tuple[list[dict[str, Any]], list[str], int]:
    found = json.loads(cli("predict", "job.toml", "--machine", "lathe-1", "--json").out)
    return found["cuts"], found["notes"], found["prediction_id"]


def _true_N(cutting_time_s: float) -> dict[str, float]:
    """Return the truth of the job's cut with an edge that nobody has seen."""
    cut = TrueCut(220.0, 0.2, 1.5, 50.0, "turn", "unseen", cutting_time_s, 0.0, "steel bar")
    return dict(zip("xyz", mean_forces_N(STEEL, cut).tolist(), strict=True))


def test_confirmed_wear_is_in_the_next_prediction(
    worn: Cli, refused: Callable[..., str], tmp_path: Path
) -> None:
    Path("job.toml").write_text(JOB)
    (_, blind), notes, _ = _predicted(worn)
    (room,) = [note for note in notes if "edge" in note and "cut " in note]
    assert "cut 2 'late': no edge had cut for more than 124.9 s" in room
    number = _kept("shop-week-2.csv")
    done = worn("mismatch", "confirm", number, "--by", "Ann").out
    assert "carbide insert: version 2 from 10" in done
    assert "tool_wear: each mm of an edge takes " in done
    assert [(row["version"], row["state"]) for row in _rows()] == [(1, None), (2, None)]

    # A worn edge's forces are those of the truth now, a fresh one's still
    (fresh, late), notes, prediction = _predicted(worn)
    for component in "yz":
        key = f"force_{component}_N"
        for made, seconds in ((fresh, 0.0), (late, 1200.0)):
            assert made[key]["low"] < _true_N(seconds)[component] < made[key]["high"]
        true = _true_N(1200.0)[component]
        assert blind[key]["low"] < true < blind[key]["high"]  # wide enough while it is open
        assert abs(late[key]["value"] - true) < 0.5 * abs(blind[key]["value"] - true)
    grown = late["force_y_N"]["value"] / fresh["force_y_N"]["value"]
    for key in ("torque_N_m", "power_W"):
        assert_allclose(late[key]["value"] / fresh[key]["value"], grown, rtol=0.01)

    # One that is said to be older than any was perhaps changed, and its counter not set back
    Path("job.toml").write_text(JOB.replace("1200.0", "3000.0"))
    (new, oldest), told, _ = _predicted(worn)
    assert oldest["force_z_N"]["low"] == new["force_z_N"]["low"] == fresh["force_z_N"]["low"]
    assert oldest["force_z_N"]["high"] > late["force_z_N"]["high"]
    assert [note for note in told if "its intervals hold a new one, too" in note]

    # So are those of other edges, none of them seen: how far off in the mean, and how many inside
    bias, inside = _of_unseen_edges()
    assert_allclose(bias, 0.0, atol=0.05)
    assert inside.min() >= 0.9

    # And edges that nobody has seen last as long as is said
    _last_as_long_as_is_said(worn)

    # It is said, and where it came from
    assert [note for note in notes if "cut 2 'late': its edge has cut 1200 s before; tool_" in note]
    assert not [note for note in notes if "cut 1 'fresh'" in note]
    traced = worn("trace", "prediction", prediction).out
    assert f"mismatch {number}: force.y: tool_wear (missing, confirmed by Ann on" in traced
    assert "confirmed, it is in parameters 2: " in worn("trace", "mismatch", number).out
    assert "insert version 2 (parameters 2)" in worn("mismatch", "show", number).out

    # The same wear in another component changes nothing; decisions stand; the store is sound
    other = _kept("shop-week-2.csv", "force.z")
    assert "carbide insert: version 2 from" in worn("mismatch", "confirm", other).out
    assert "already confirmed as tool_wear" in worn("mismatch", "confirm", number).out
    _may_also_be("hard_spot")
    assert "was confirmed as tool_wear by Ann" in refused(
        "mismatch", "confirm", number, "--as", "hard_spot"
    )
    assert len(_rows()) == 2
    assert worn("doctor").code == 0

    # Under the schema before, what holds wear is forgotten with what was predicted from it
    shutil.copy("autodb.sqlite3", "down.sqlite3")
    migrate("sqlite:///down.sqlite3", "0006")
    with contextlib.closing(sqlite3.connect("down.sqlite3")) as down:
        assert down.execute("SELECT version FROM cutting_parameters").fetchall() == [(1,)]
        assert down.execute("SELECT id FROM prediction").fetchall() == [(1,)]
        assert down.execute("PRAGMA foreign_key_check").fetchall() == []

    # Cuts that do not say how worn their edge was would be taken for other work
    _without_time(Path("shop-week-1.csv"), tmp_path / "unsaid.csv")
    worn("import", tmp_path / "unsaid.csv", "--machine", "lathe-1")
    said = worn("refresh", "--machine", "lathe-1").out
    assert (
        "36 cuts are not used: its edges wear, and the cuts do not state tool.cutting_time" in said
    )
    assert len(_rows()) == 2


def _of_unseen_edges() -> tuple[Array, Array]:
    """Compare worn cuts of six edges, past 900 s, with the newest posterior: force y and z.

    Returns by what share it is off in the mean, and the share inside the 95 % intervals, (2,).
    """
    rng, rows, true = np.random.default_rng(20260101), [], []
    for edge in range(6):
        for seconds in np.linspace(900.0, 1250.0, 7).tolist():
            feed, speed = rng.uniform(0.1, 0.4), rng.uniform(150.0, 280.0)
            depth, diameter = rng.uniform(1.0, 2.5), rng.uniform(40.0, 80.0)
            rows.append({
                "cutting.feed": feed, "cutting.depth": depth, "cutting.speed": speed,
                "work.diameter": diameter, "tool.cutting_time": seconds,
            })  # fmt: skip
            cut = TrueCut(
                speed, feed, depth, diameter, "turn", f"unseen-{edge}", seconds, 0.0, "steel bar"
            )
            true.append(mean_forces_N(STEEL, cut)[1:])
    store = open_store(URL)
    with store.reading() as session:
        newest = select(models.CuttingParameters).order_by(models.CuttingParameters.id.desc())
        posterior = as_posterior(session.scalars(newest.limit(1)).one())
    store.close()
    found = forecast(posterior, BY_NAME["turn"].cuts({}, rows, called="carbide insert"))
    off = found.mean[:, 1:3] - np.array(true)
    bias = (off / np.array(true)).mean(axis=0)
    return bias, (np.abs(off) < NORMAL_95 * found.sd[:, 1:3]).mean(axis=0)


def _last_as_long_as_is_said(cli: Cli) -> None:
    """Hold the life until a limit between a fresh edge's force and an old one's to the truth."""
    Path("part.toml").write_text(JOB.split("[[cut]]", maxsplit=1)[0] + PART)
    limit_N = 0.5 * (_true_N(0.0)["y"] + _true_N(1200.0)["y"])
    ages = np.linspace(0.0, 2400.0, 481)
    passed = [_true_N(age)["y"] > limit_N for age in ages.tolist()]
    true_min = ages[passed.index(True)] / 60.0
    asked = ("life", "part.toml", "--machine", "lathe-1", "--limit", f"force.y={limit_N}")
    (one,) = json.loads(cli(*asked, "--json").out)["edges"][0]["lives"]
    assert one["minutes"]["low"] < true_min < (one["minutes"]["high"] or np.inf)
    assert_allclose(one["minutes"]["value"], true_min, rtol=0.4)
    assert 0.0 < one["sure_min"] < one["minutes"]["value"]
    said = cli(*asked).out
    assert "change the edge after" in said
    found = autodb.open("autodb.sqlite3").machine("lathe-1").tool_life(
        "part.toml", limits={"force.y": limit_N}
    )  # fmt: skip
    assert "\n".join(found.lines).split() == said.split()
    (row,) = found.to_pandas().to_dict("records")
    assert row["parts_low"] < row["parts"] < row["parts_high"]
    assert found.to_dict()["edges"][0]["lives"] == [one]
    # Two edges of that tool, of which the second makes the same again: either may end first
    Path("again.toml").write_text(Path("part.toml").read_text().replace("two cuts", "again"))
    both = cli("life", "part.toml", "again.toml", *asked[2:]).out
    assert "again, carbide insert: an edge lasts" in both
    assert "the first edge to end is that of" in both
    rows = autodb.open("autodb.sqlite3").machine("lathe-1").tool_life(
        "part.toml", "again.toml", limits={"force.y": limit_N}
    ).to_pandas()  # fmt: skip
    assert rows["edge"].tolist() == ["two cuts, carbide insert", "again, carbide insert"]
    # So does a program that makes that cut
    Path("part.nc").write_text("G21 G99 G97 S1400.563 M3\nG0 X50 Z0\nG1 Z-60 F0.2\nG0 X60\nM30\n")
    program = "[program]\nfile = 'part.nc'\nstock_diameter_mm = 53.0\ndiameter = true\n"
    Path("nc.toml").write_text(JOB.split("[[cut]]", maxsplit=1)[0] + program)
    (of_line,) = json.loads(cli("life", "nc.toml", *asked[2:], "--json").out)["edges"][0]["lives"]
    assert_allclose(of_line["minutes"]["value"], one["minutes"]["value"], rtol=0.02)
    # With a machine's limit it stands in the prediction, too
    file = (ROOT / "sample_jobs" / "stepped_shaft" / "machine.toml").read_text()
    Path("limit.toml").write_text(file.replace("torque_N_m = 105", "torque_N_m = 17"))
    assert cli("machine", "update", "lathe-1", "--file", "limit.toml").err == ""
    assert "an edge lasts" in cli("predict", "part.toml", "--machine", "lathe-1").out


def _without_time(name: Path, to: Path) -> None:
    table = csv.read_csv(ROOT / "sample_jobs" / "stepped_shaft" / "recordings" / name)
    csv.write_csv(table.drop_columns(["tool.cutting_time"]).slice(4), to)


def test_a_cause_that_too_few_cuts_show_changes_no_pair(sound_week: Cli) -> None:
    done = sound_week("mismatch", "confirm", _kept("shop-week-1.csv", term="hard_spot")).out
    assert "it is noted, no prediction changes: fewer than five of its cuts are outliers" in done
    assert len(_rows()) == 1


def test_wear_that_no_cutting_time_tells_makes_a_state_as_any_cause(
    sound_week: Cli, tmp_path: Path
) -> None:
    _without_time(Path("shop-week-2.csv"), tmp_path / "unsaid.csv")
    sound_week("import", tmp_path / "unsaid.csv", "--machine", "lathe-1")
    done = sound_week("mismatch", "confirm", _kept("unsaid.csv")).out
    assert "carbide insert, tool_wear: version 3 from" in done
    assert [row["state"] for row in _rows()] == [None, None, "tool_wear"]


def test_rejected_they_are_learnt_after_all(excluded: Cli) -> None:
    worn = excluded
    before = _rows()[-1]
    for number in (1, 2):
        assert worn("mismatch", "reject", number).code == 0
    assert "version 3 from 108 cuts" in worn("refresh", "--machine", "lathe-1").out
    assert not _rows()[-1]["cuts"] & before["cuts"]


def test_the_errors_of_days_are_not_kept(sound_week: Cli) -> None:
    del sound_week
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
