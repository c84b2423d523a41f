"""`import autodb`: a machine's life with data frames gives what the commands give."""

import json
import pickle
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from datetime import UTC, datetime
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
from numpy.testing import assert_allclose

import autodb
from autodb.library.given import taken
from autodb.library.machine import ShopMachine
from tests.conftest import ROOT, Cli, learn_by_one_law

pytestmark = pytest.mark.usefixtures("one_law")

JOB = ROOT / "sample_jobs" / "stepped_shaft"
RECORDINGS = JOB / "recordings"
CUTS = pd.DataFrame(
    {
        "diameter_mm": [50.0, 40.0],
        "depth_mm": [2, 1],
        "feed_mm_rev": [0.25, 0.1],
        "speed_m_min": [200.0, 220.0],
    }
)
PAIR = {"material": "steel bar", "tool": "carbide insert"}


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> ShopMachine:
    """Return a machine that learnt from data frames of the sample job."""
    folder = tmp_path_factory.mktemp("library")
    made = autodb.open(folder / "shop.sqlite3", create=True).add_machine(
        "lathe-1", JOB / "machine.toml"
    )
    for name in ("standard-cuts.csv", "shop-week-1.csv"):
        made.import_(pd.read_csv(RECORDINGS / name), name=Path(name).stem)
    assert set(made.calibrate().to_pandas()["axis"]) == {"x", "z", "spindle"}
    with pytest.MonkeyPatch.context() as patch:
        learn_by_one_law(patch)
        made.refresh()
    return made


def test_data_frames_calibrate_as_their_files_do(machine: ShopMachine, tmp_path: Path) -> None:
    made = autodb.open(tmp_path / "a.sqlite3", create=True)
    other = made.add_machine("lathe-1", JOB / "machine.toml")
    for name in ("standard-cuts.csv", "shop-week-1.csv"):
        other.import_(RECORDINGS / name)
    theirs = other.calibrate()
    pd.testing.assert_frame_equal(machine.calibrate().to_pandas(), theirs.to_pandas(), rtol=1e-9)
    assert "<svg" in theirs.plot().html or "plotly" in theirs.plot().html


def test_the_command_and_the_library_say_the_same(machine: ShopMachine, cli: Cli) -> None:
    ran = cli("predict", JOB / "job.toml", "--machine", "lathe-1", "--json", "--db", machine.url)
    theirs, ours = json.loads(ran.out), machine.predict(JOB / "job.toml").to_dict()
    assert ours.pop("prediction_id") == theirs.pop("prediction_id") + 1
    assert ours == theirs
    job = cli("predict", "job.toml", "--machine", "lathe-1", "--db", machine.url)
    with pytest.raises(autodb.UnusableInput) as refused:
        machine.predict("job.toml")
    assert job.err == f"autodb: {refused.value}\n"


def test_a_frame_enters_once_and_grows_by_its_name(machine: ShopMachine) -> None:
    table = pd.read_csv(RECORDINGS / "shop-week-2.csv")
    first = machine.import_(table.iloc[:20], name="week-2").answer
    again = machine.import_(table.iloc[:20]).answer
    grown = machine.import_(table, name="week-2").answer
    assert (first.cuts, first.already_there) == (20, False)
    assert (again.recording_id, again.already_there) == (first.recording_id, True)
    assert (grown.cuts, grown.again) == (len(table) - 20, 20)
    kept = sorted(path.stem for path in (Path(machine.url[10:]).parent / "recordings").iterdir())
    assert [name[:6] for name in kept] == ["shop-w", "standa", "week-2", "week-2"]


def test_a_frame_that_is_refused_leaves_nothing(machine: ShopMachine) -> None:
    folder = Path(machine.url[10:]).parent / "recordings"
    before = sorted(folder.iterdir())
    table = pd.read_csv(RECORDINGS / "shop-week-2.csv")
    bad = table.astype({"z.current.range": object})
    bad.loc[3, "z.current.range"] = "much"
    with pytest.raises(autodb.UnusableInput, match=r"^week-9: .*range', row 4: 'much'"):
        machine.import_(bad, name="week-9")
    assert sorted(folder.iterdir()) == before


def test_any_frame_and_units_by_name_or_argument_are_read_alike(tmp_path: Path) -> None:
    made = autodb.open(tmp_path / "a.sqlite3", create=True).add_machine("m")
    t_s = np.arange(0.0, 2.0, 0.01)
    current_A = np.sin(t_s)
    frames = [
        (pa.table({"t": t_s, "x.current [mA]": 1000.0 * current_A}), {}),
        (pd.DataFrame({"x.current": 1000.0 * current_A}, index=pd.Index(t_s, name="t")),
         {"units": {"x.current": "mA"}}),
        (pd.DataFrame({"Zeit": 1000.0 * t_s, "I": current_A}),
         {"columns": {"t": {"column": "Zeit", "unit": "ms"}, "x.current": "I"}}),
        (pd.DataFrame({"Zeit": t_s, "I": 1000.0 * current_A}),
         {"columns": {"channels": {"t": "Zeit", "x.current": "I"}, "recording": {"kind": "air"}},
          "units": {"x.current": "mA"}}),
    ]  # fmt: skip
    found = [made.import_(frame, **told).answer for frame, told in frames]  # type: ignore[arg-type]
    assert [one.already_there for one in found] == [False, True, True, True]
    assert {one.recording_id for one in found} == {1}


def test_an_index_of_times_is_the_time() -> None:
    when = pd.date_range("2026-11-27 10:00", periods=200, freq="10ms")
    frame = pd.DataFrame({"x.current": np.sin(0.1 * np.arange(200.0))}, index=when)
    found = taken(frame).source().choose().read()
    assert_allclose(np.diff(found["t"]), 0.01, rtol=1e-3)
    lasting = frame.set_index(when - when[0])
    assert_allclose(taken(lasting).source().choose().read()["t"], 0.01 * np.arange(200.0))


def test_cuts_are_predicted_and_looked_up_from_a_frame(machine: ShopMachine) -> None:
    predicted = machine.predict(CUTS, **PAIR)
    looked_up = machine.lookup(**PAIR, cuts=CUTS)
    alone = machine.lookup(**PAIR, cuts=CUTS.iloc[1:])
    assert_allclose(looked_up.to_pandas()["force.y"], predicted.to_pandas()["force.y"])
    assert alone.answer.cuts == looked_up.answer.cuts[1:]
    assert list(machine.pairs().to_pandas()["tool"]) == ["carbide insert"]
    assert len(looked_up.to_dict()["cuts"]) == 2
    assert repr(looked_up).splitlines()[0] == "LookupResult"
    printed = [line.split()[0] for line in repr(looked_up).splitlines()]
    assert printed[:3] == ["LookupResult", "cut", "operation"]
    assert {"force.y", "force.y.low", "force.y.high"} <= {*printed}
    for page in (predicted.plot(), looked_up.plot()):
        assert "<h1>" in page.html
        assert page._repr_html_().startswith("<iframe srcdoc=")


def test_a_table_of_cuts_is_predicted_as_it_is(machine: ShopMachine) -> None:
    table = pd.read_csv(RECORDINGS / "shop-week-2.csv").iloc[:3]
    keys = table.rename(columns={"spindle.speed": "speed_rpm", "cutting.depth": "depth_mm"})
    stated = keys[["operation", "speed_rpm", "depth_mm"]].assign(
        diameter_mm=table["work.diameter"], feed_mm_rev=table["cutting.feed"],
        cutting_time_s=table["tool.cutting_time"],
    )  # fmt: skip
    whole, alone = machine.predict(table), machine.predict(stated, **PAIR)
    assert whole.answer.cuts == alone.answer.cuts
    assert (whole.answer.job.material, whole.answer.job.tool) == tuple(PAIR.values())
    mixed = table.assign(tool=["a", "b", "c"])
    with pytest.raises(autodb.UnusableInput, match=r"one tool \(they state a, b, c\); give tool="):
        machine.predict(mixed)


def test_an_edge_change_is_recorded_listed_and_undone(tmp_path: Path, cli: Cli) -> None:
    made = autodb.open(tmp_path / "edges.sqlite3", create=True).add_machine("lathe-1")
    made.import_(RECORDINGS / "standard-cuts.csv")
    at = datetime(2026, 3, 1, 7, 30, tzinfo=UTC)
    done = made.change_edge(PAIR["tool"], at=at, by="Maria", why="chipped")
    assert (done.answer.number, done.answer.cuts) == (1, 32)
    assert done.to_pandas()[["tool", "cuts"]].to_numpy().tolist() == [[PAIR["tool"], 32]]
    found = made.edges()
    assert found.to_pandas()[["by", "why", "cuts"]].to_numpy().tolist() == [
        ["Maria", "chipped", 32]
    ]
    said = cli("edge", "list", "--json", "--db", made.url).out
    assert found.to_dict() == json.loads(said)
    assert made.undo_edge_change(1).to_dict()["cuts"] == 32
    assert made.edges().to_pandas().empty
    assert len(made.edges(every=True).to_pandas()) == 1
    with pytest.raises(autodb.UnusableInput, match="has no cuts of tool"):
        made.change_edge("none")


def test_the_only_machine_needs_no_name(tmp_path: Path) -> None:
    db = autodb.open(tmp_path / "a.sqlite3", create=True)
    with pytest.raises(autodb.UnusableInput, match="no machine yet"):
        db.machine()
    db.add_machine("m")
    assert db.machine() == db.machine("m")
    db.add_machine("n", {"axes": {"x": {"carries": "tool"}}})
    with pytest.raises(autodb.UnusableInput, match="several machines: name one of m, n"):
        db.machine()
    with pytest.raises(autodb.UnusableInput, match="no machine 'mm'"):
        db.machine("mm")


def test_what_a_machine_says_of_a_frame_is_explained_and_kept(machine: ShopMachine) -> None:
    found = machine.explain(pd.read_csv(RECORDINGS / "shop-week-2.csv"), name="week-2-worn")
    assert "tool_wear" in set(found.to_pandas()["term"])
    assert {cause.status for cause in found.kept.values()} == {"open"}
    assert list(found.corrected())[:2] == ["cut", "force.y"]
    assert found.to_dict()["channels"].keys() == set(found.answer.explanation.channels)


def test_an_axis_is_identified_alike_with_and_without_a_database(machine: ShopMachine) -> None:
    moves = pd.read_csv(RECORDINGS / "air-moves.csv")
    alone, kept = autodb.identify(moves), machine.identify(RECORDINGS / "air-moves.csv")
    assert kept.version == 1
    assert alone.version is None
    pd.testing.assert_frame_equal(alone.to_pandas(), kept.to_pandas(), rtol=1e-9)
    assert alone.to_dict()["unit"] == "A"


REFUSED: dict[str, tuple[Callable[[ShopMachine], object], str]] = {
    "nothing": (lambda m: m.import_(3), "neither a path nor a data frame but of type int"),
    "empty": (lambda m: m.import_(pd.DataFrame({"t": []})), "frame: no rows of data"),
    "twice": (lambda m: m.import_(pd.DataFrame([[1, 2]], columns=["t", "t"])), "twice"),
    "name": (lambda m: m.import_(CUTS, name="a/b"), "is no name of a file"),
    "unit": (lambda m: m.import_(CUTS, units={"q": "A"}), "no column 'q'"),
    "units of a file": (lambda m: m.import_("a.csv", units={"q": "A"}), "go with a data frame"),
    "name of a file": (lambda m: m.import_("a.csv", name="b"), "go with a data frame"),
    "side": (lambda m: m.import_(CUTS, columns={"x.curent": "I"}), "not a channel name"),
    "key": (lambda m: m.lookup("a", "b", dept_mm=3.0), "dept_mm: unknown key"),
    "cut": (lambda m: m.lookup("a", "b"), "one cut by its keys"),
    "row": (lambda m: m.predict(CUTS.assign(depth_mm=[1.0, -1.0]), **PAIR), "row 2: depth_mm"),
    "pair": (lambda m: m.predict(CUTS), "need one material; give material="),
    "job": (lambda m: m.predict("job.toml", material="a"), "a job states its own"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_used_is_said_in_one_line(case: str, machine: ShopMachine) -> None:
    asked, says = REFUSED[case]
    with pytest.raises(autodb.UnusableInput, match=says):
        asked(machine)


def test_a_simulation_with_foreign_columns_is_explained(tmp_path: Path) -> None:
    t_s = np.arange(0.0, 20.0, 0.01)
    friction = 500.0 * np.sign(np.cos(t_s)) + np.random.default_rng(3).normal(0.0, 50.0, len(t_s))
    simulation = pd.DataFrame({"s": t_s, "pos": 50.0 * np.sin(t_s), "I": 20.0 * np.cos(t_s)})
    recording = simulation.assign(I=simulation["I"] + friction)
    columns = {"t": "s", "x.position": "pos", "x.current": "I"}
    found = autodb.explain(
        recording, simulation[["s", "I"]], columns=columns, units={"x.current": "mA"}
    )
    row = found.to_pandas().iloc[0]
    assert row["term"] == "coulomb"
    assert row["low"] < 0.5 < row["high"]
    recording.to_csv(tmp_path / "a.csv", index=False)
    side = {**columns, "x.current": {"column": "I", "unit": "mA"}}
    known = pd.DataFrame({"t": t_s, "x.current [mA]": simulation["I"]})
    mixed = autodb.explain(tmp_path / "a.csv", known, columns=side)
    assert (
        mixed.to_pandas().drop(columns="channel").equals(found.to_pandas().drop(columns="channel"))
    )
    with pytest.raises(autodb.UnusableInput, match="no column 'J'"):
        autodb.explain(recording, simulation, columns=columns, units={"J": "mA"})


def _force(asked: tuple[ShopMachine, float]) -> float:
    machine, depth_mm = asked
    found = machine.lookup(
        **PAIR, depth_mm=depth_mm, diameter_mm=50.0, feed_mm_rev=0.2, speed_m_min=200.0
    )
    return found.answer.cuts[0].force_y_N.value


def test_threads_and_processes_share_a_machine(machine: ShopMachine) -> None:
    asked = [(machine, 1.0 + 0.25 * k) for k in range(6)]
    alone = [_force(one) for one in asked]
    with ThreadPoolExecutor(4) as threads:
        assert list(threads.map(_force, asked)) == alone
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as processes:
        assert list(processes.map(_force, asked[:2])) == alone[:2]
    assert pickle.loads(pickle.dumps(machine)) == machine


def test_threads_that_import_one_frame_keep_it_once(tmp_path: Path) -> None:
    made = autodb.open(tmp_path / "a.sqlite3", create=True).add_machine("m")
    frames = [pd.DataFrame({"cut": [1, 2], "t": [0, 9], "z.current": [k, 2.0]}) for k in (1.0, 3.0)]
    with ThreadPoolExecutor(4) as threads:
        found = list(threads.map(lambda k: made.import_(frames[k % 2]).answer, range(8)))
    assert {one.recording_id for one in found} == {1, 2}
    assert sum(not one.already_there for one in found) == 2
    assert len(list((tmp_path / "recordings").iterdir())) == 2


def test_the_function_stands_also_where_the_room_is_imported() -> None:
    code = (
        "import autodb, sys; import autodb.explain; from autodb.explain import Explained; "
        "assert callable(autodb.explain) and callable(autodb.identify); "
        "assert sys.modules['autodb.explain'].Explained is Explained"
    )
    subprocess.run([sys.executable, "-W", "error", "-c", code], check=True)


def test_importing_the_package_imports_nothing() -> None:
    code = "import sys; before = set(sys.modules); import autodb; print(*set(sys.modules) - before)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    heavy = {"numpy", "pandas", "scipy", "sqlalchemy", "pyarrow", "pydantic", "narwhals"}
    assert not heavy & set(done.stdout.split())
    assert "autodb.library" not in done.stdout


def test_a_page_is_saved_whole(machine: ShopMachine, tmp_path: Path) -> None:
    page = machine.predict(CUTS, **PAIR).plot()
    assert page.save(tmp_path / "p.html").read_text("utf-8") == page.page
    alone = page.save(tmp_path / "alone.html", self_contained=True)
    assert alone.read_text("utf-8") == page.html
    assert len(page.page) < 500_000 < len(page.html)
    with pytest.raises(autodb.UnusableInput, match=r"p\.txt"):
        page.save(tmp_path / "p.txt")
