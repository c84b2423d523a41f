"""`plan`: the cut that narrows a job's forces most, within the machine's limits."""

import json
from pathlib import Path
from typing import Any

import pytest

from autodb.agent.answer import prediction_basis
from autodb.forward.scored import Width
from tests.conftest import Cli, Once

pytestmark = pytest.mark.usefixtures("one_law")

JOB = """name = "j"
material = "steel bar"
tool = "carbide insert"
[[cut]]
name = "finish"
diameter_mm = 40
depth_mm = 1.0
feed_mm_rev = 0.12
speed_m_min = 200
"""


@pytest.fixture
def calibrated(cli: Cli, sample_jobs: Path, once: Once) -> Cli:
    """Return the command line on a lathe that has learnt six cuts, of those it is calibrated on."""

    def learn() -> None:
        source = sample_jobs / "stepped_shaft" / "recordings" / "standard-cuts.csv"
        cli("init")
        cli("machine", "add", "lathe-1")
        cli("import", source, "--machine", "lathe-1")
        cli("calibrate", "--machine", "lathe-1")
        lines = source.read_text("utf-8").splitlines()
        few = [line.replace("steel bar", "other bar") for line in lines[:7]]
        sensed = [line.rsplit(",", 3)[0] for line in few]  # without the forces that were measured
        Path("few.csv").write_text("\n".join(sensed) + "\n", encoding="utf-8")
        cli("import", "few.csv", "--machine", "lathe-1")
        assert cli("refresh", "--machine", "lathe-1").code == 0
        Path("job.toml").write_text(JOB.replace("steel bar", "other bar"), encoding="utf-8")

    once(learn)
    return cli


def _plan(cli: Cli, *more: object) -> dict[str, Any]:
    done = cli("plan", "job.toml", "--machine", "lathe-1", "--json", *more)
    assert done.code == 0, done.err
    answer: dict[str, Any] = json.loads(done.out)
    return answer


def test_the_best_cut_is_first_and_narrows_what_is_asked(calibrated: Cli) -> None:
    answer = _plan(calibrated)
    left = [one["left"] for one in answer["proposed"]]
    assert left == sorted(left)
    assert left[0] < answer["now"]
    assert {target["component"] for target in answer["targets"]} == {"y", "z"}
    assert all(target["after"] <= target["now"] for target in answer["targets"])


def test_it_keeps_to_the_ranges_and_the_limits(calibrated: Cli) -> None:
    """A spindle that gives little takes no deep cut; where it takes none at all, it is refused."""
    within = _plan(calibrated, "--depth", "1.5:2", "--feed", "0,1:0,2", "--speed", "150:160")
    for one in within["proposed"]:
        cut = one["cut"]
        assert 1.5 <= cut["depth_mm"] <= 2.0
        assert 0.1 <= cut["feed_mm_rev"] <= 0.2
        assert 150 <= cut["speed_m_min"] <= 160
    free = _plan(calibrated)
    _limit_the_spindle(calibrated, 3.5)
    bound = _plan(calibrated)
    assert bound["too_much"] > 0
    assert bound["proposed"] != free["proposed"]
    _limit_the_spindle(calibrated, 0.5)
    refused = calibrated("plan", "job.toml", "--machine", "lathe-1")
    assert refused.code == 2
    assert "may exceed a limit of machine 'lathe-1'" in refused.err


def test_it_is_as_wide_as_a_prediction_is_by_past_ones(
    calibrated: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    stated = _plan(calibrated)
    width = Width(factor=1.5, cuts=30, others=0, upto=30)
    monkeypatch.setattr(prediction_basis, "width_of_next", lambda *_, **__: width)
    wide = _plan(calibrated)
    assert wide["now"] == pytest.approx(1.5 * stated["now"])
    for name in ("now", "after"):
        was, now = ([one[name] for one in some["targets"]] for some in (stated, wide))
        assert now == pytest.approx([1.5 * one for one in was])
    was, now = ([one["left"] for one in some["proposed"]] for some in (stated, wide))
    assert now == pytest.approx([1.5 * one for one in was])
    assert any(one.startswith("intervals × 1.50: past predictions") for one in wide["open"])


def _limit_the_spindle(cli: Cli, torque_N_m: float) -> None:
    file = Path("machine.toml")
    file.write_text(
        '[axes.x]\ncarries = "tool"\n[axes.z]\ncarries = "tool"\n[axes.spindle]\n'
        f'carries = "work"\n[axes.spindle.limits]\ntorque_N_m = {torque_N_m}\n',
        encoding="utf-8",
    )
    done = cli("machine", "update", "lathe-1", "--file", file)
    assert done.code == 0, done.err


def test_what_the_cuts_leave_open_is_named(calibrated: Cli) -> None:
    said = " ".join(calibrated("plan", "job.toml", "--machine", "lathe-1").out.split())
    assert "a measured chip thickness" in said
    assert "; add " in said


@pytest.mark.parametrize("text", ["2", "2:1", "a:b", "0:1"])
def test_a_bad_range_is_one_line(calibrated: Cli, text: str) -> None:
    done = calibrated("plan", "job.toml", "--machine", "lathe-1", "--depth", text)
    assert done.code == 2
    assert "--depth" in done.err
    assert len(done.err.strip().splitlines()) == 1


def test_a_machine_that_senses_nothing_says_so(cli: Cli) -> None:
    cli("init")
    cli("machine", "add", "lathe-1")
    Path("job.toml").write_text(JOB, encoding="utf-8")
    done = cli("plan", "job.toml", "--machine", "lathe-1")
    assert done.code == 2
    assert "has no sensed forces yet" in done.err
