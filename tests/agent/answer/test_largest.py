"""The largest feed, depth or speed that keeps a machine's limits, asked of command and service."""

import csv
import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from numpy.testing import assert_allclose

from autodb.agent.answer.bounds.largest import largest_value
from autodb.agent.answer.looking_up import PairReader
from autodb.agent.answer.prediction_basis import PredictionBasis
from autodb.agent.rows.machines import add_machine, as_file, find_machine
from autodb.files.job_cut import JobCut
from autodb.files.machine import AxisFile, AxisLimits, MachineFile, SpindleFile
from autodb.forward.prediction import chance_beyond
from autodb.store import Store, create_store, models, open_store
from tests.conftest import Cli

URL = "sqlite:///autodb.sqlite3"
CUT = JobCut(operation="turn", diameter_mm=50.0, depth_mm=2.0, feed_mm_rev=0.25, speed_m_min=220.0)
SPINDLE = AxisLimits(
    torque_N_m=90.0, power_curve=((1000.0, 9000.0), (5000.0, 9000.0)), efficiency=0.9
)
FILE = MachineFile(
    spindle=SpindleFile(max_speed_rpm=3000.0),
    axes={"z": AxisFile(limits=AxisLimits(force_N=6000.0)), "spindle": AxisFile(limits=SPINDLE)},
)
ASKED = (
    *("lookup", "--machine", "m", "--material", "C45", "--tool", "insert"),
    *("--diameter", 50, "--speed", 220),
)


@pytest.fixture
def store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Store]:
    monkeypatch.chdir(tmp_path)
    create_store(URL)
    opened = open_store(URL)
    add_machine(opened, "m", FILE)
    add_machine(opened, "bare", MachineFile(axes={"spindle": AxisFile()}))
    yield opened
    opened.close()


def _basis(store: Store, machine: str = "m") -> PredictionBasis:
    with store.reading() as session:
        return PairReader(session, machine).basis("C45", "insert")


def test_a_machine_keeps_its_spindle_s_curves(store: Store) -> None:
    """Read again they are what the file says, and the spindle's own speed is a limit of it."""
    assert not add_machine(store, "m", FILE)
    with store.reading() as session:
        assert as_file(find_machine(session, "m")) == FILE
    assert _basis(store).limits["spindle"].speed_rpm == 3000.0


@pytest.mark.parametrize("what", ["feed", "depth"])
def test_just_at_the_largest_the_chance_is_what_is_allowed(store: Store, what: str) -> None:
    """Of 80 % of the torque or power, whichever is nearer; a little more is too much."""
    found = largest_value(_basis(store), CUT, what, share=0.8, sure=0.95)
    cut = found.answer.cut
    chances = [chance_beyond(cut.torque_N_m, 72.0), chance_beyond(cut.power_W, 0.8 * 0.9 * 9000.0)]
    assert 0.045 < max(chances) <= 0.05
    assert found.ends is not None
    assert found.ends.quantity == "power"


def test_the_largest_speed_ends_where_the_spindle_does(store: Store) -> None:
    light = CUT.model_copy(update={"depth_mm": 0.1, "feed_mm_rev": 0.05})
    found = largest_value(_basis(store), light, "speed", share=0.8, sure=0.95)
    assert found.ends is not None
    assert (found.ends.axis, found.ends.quantity) == ("spindle", "speed")
    assert_allclose(found.answer.cut.speed_rpm, 3000.0, rtol=1e-3)
    assert found.answer.cut.speed_rpm <= 3000.0


def test_surer_is_less_and_a_smaller_share_too(store: Store) -> None:
    basis = _basis(store)
    some = [(0.8, 0.95), (0.8, 0.5), (0.4, 0.95)]
    usual, less_sure, half = (
        largest_value(basis, CUT, "feed", share=share, sure=sure).value for share, sure in some
    )
    assert half < usual < less_sure


def test_the_command_answers_with_the_cut_and_one_line(store: Store, cli: Cli) -> None:
    del store
    done = cli(*ASKED, "--depth", 2, "--largest", "feed", "--share", 80, "--sure", 90)
    assert done.code == 0
    said = r"largest feed within 80 % of each limit with 90 % probability: (0\.\d+) mm/rev; what"
    found = re.search(said, done.out)
    assert found is not None
    asked = (*ASKED, "--depth", 2, "--largest", "feed", "--share", 80, "--sure", 90, "--json")
    answer = json.loads(cli(*asked).out)
    assert answer["value"] == answer["cut"]["feed_mm_rev"] == float(found[1])
    assert answer["answer"]["cut"]["feed_mm_min"] > 0.0


JOB = """name = "{name}"
material = "C45"
tool = "insert"
[[cut]]
name = "rough"
diameter_mm = 50
depth_mm = {depth}
feed_mm_rev = 0.3
speed_m_min = 220
length_mm = 60
"""


def test_two_jobs_stand_beside_each_other(store: Store, cli: Cli) -> None:
    """Times and volumes of both, and one answer that is kept; the table has the question."""
    for name, depth in (("deep", 3.0), ("light", 1.0)):
        Path(f"{name}.toml").write_text(JOB.format(name=name, depth=depth), "utf-8")
    asked = ("predict", "deep.toml", "--machine", "m", "--beside", "light.toml", "--csv", "p.csv")
    said = cli(*asked).out
    assert re.search(r"time +8\.6 s +8\.6 s", said)
    assert re.search(r"removed +30\.0 cm³ +9\.6 cm³", said)
    both = json.loads(cli(*asked, "--json").out)
    assert [one["job"]["name"] for one in both] == ["deep", "light"]
    with store.reading() as session:
        jobs = [one.job["name"] for one in session.query(models.Prediction)]
    assert jobs == ["deep", "deep"]
    with Path("p.csv").open(encoding="utf-8", newline="") as file:
        (row,) = csv.DictReader(file)
    assert (row["Fp"], row["Fc"], row["Ff"], row["passive"]) == (
        "force.x",
        "force.y",
        "force.z",
        "x",
    )
    assert row["asked"].startswith("rough: turn, diameter 50 mm")
    assert (row["force.x.standing"], row["force.z.standing"]) == ("", "within")
    assert (row["spindle.power.limit"], row["work.material"]) == ("8100", "C45")


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--depth", 2, "--feed", 0.2, "--largest", "feed"), "--feed exclude each other"),
        (("--depth", 2, "--largest", "feet"), "did you mean feed?"),
        (("--feed", 0.2, "--depth", 2, "--share", 80), "go with --largest"),
        (("--feed", 0.2, "--operation", "drill", "--largest", "depth"), "--depth"),
    ],
)
def test_a_question_that_is_none_is_refused(
    store: Store, refused: Callable[..., str], more: tuple[object, ...], said: str
) -> None:
    del store
    assert said in refused(*ASKED, *more)


def test_without_limits_nothing_is_the_largest(store: Store, refused: Callable[..., str]) -> None:
    del store
    asked = [("bare" if one == "m" else one) for one in ASKED]
    assert "states no limit" in refused(*asked, "--depth", 2, "--largest", "feed")
