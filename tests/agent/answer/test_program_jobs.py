"""A turning program as a job: its lines take what cuts of their conditions take; broken ones."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.errors import UnusableInput
from autodb.files.job import JobProgram, read_job
from autodb.files.job_cut import JobCut
from autodb.files.machine import AxisLimits
from autodb.fitting.gaussian import Gaussian
from autodb.forward import along, job_cuts, line_parts, programs
from autodb.forward.limits import exceeding
from autodb.forward.line_parts import Followed
from autodb.forward.prediction import Interval, PredictedCut, ToolOf
from autodb.pairs.engaged import BY_NAME
from autodb.pairs.forecast import expected_means, forecast
from autodb.pairs.posterior import law_error
from tests.conftest import Cli
from tests.helpers.known_pairs import INSERT, known
from tests.helpers.remedies import has_remedy

HEAD = "G95 G97 S1000 M3\n"
FORCES = ("force_x_N", "force_y_N", "force_z_N", "torque_N_m")
SAME = 1e-6
JOINED = 0.001
"""Tolerance of means over joined steps, a share of the tangential force."""
PEAK = 0.01
"""That of peaks: the direction of an arc turns by 2.8° within a part of a quarter."""
ARM_M = 0.03
JOB = 'name = "a"\nmaterial = "steel bar"\ntool = "insert"\n'


SQUARE = {"other": {"kappa_deg": 90.0}}


def _follow(folder: Path, body: str, *, head: str = HEAD, **said: Any) -> Followed:
    """Return a program followed in a bar of Ø60, if nothing else is said."""
    (folder / "p.nc").write_text(head + body, encoding="utf-8")
    stock = {} if "stock" in said else {"stock_diameter_mm": 60.0}
    asked = JobProgram.model_validate({"file": str(folder / "p.nc"), **stock, **said})
    return programs.follow(asked, units=None, diameter=None)


def _predict(found: Followed, tool: ToolOf = INSERT) -> tuple[PredictedCut, ...]:
    return along.predict_lines(known(), tool, found.lines, source=found.source)


def _ends(one: Interval) -> tuple[float, float, float]:
    return one.value, one.low, one.high


def test_a_longitudinal_line_takes_what_its_cut_takes(tmp_path: Path) -> None:
    """Through air first, of which nothing counts; the edge's way over the land is all alike."""
    (line,) = _predict(_follow(tmp_path, "G0 X56 Z2\nG1 Z-30 F.2\n", tools=SQUARE))
    cut = JobCut(diameter_mm=56, depth_mm=2, feed_mm_rev=0.2, speed_rpm=1000)
    (same,) = job_cuts.predict(known(), INSERT, [cut])
    assert (line.operation, line.passive) == ("turn", "x")
    assert_allclose([line.speed_rpm, line.speed_m_min], [same.speed_rpm, same.speed_m_min])
    for name in (*FORCES, "power_W"):
        assert_allclose(_ends(getattr(line, name)), _ends(getattr(same, name)), rtol=SAME)
    turning = np.array(_ends(line.torque_N_m)) * 1000 * np.pi / 30
    assert_allclose(_ends(line.power_W), turning, rtol=1e-9)
    assert line.peaks is not None
    for name in FORCES:
        assert_allclose(_ends(getattr(line.peaks, name)), _ends(getattr(same, name)), rtol=SAME)


def test_a_facing_line_at_one_speed_takes_the_forces_of_its_cut(tmp_path: Path) -> None:
    """Its torque is largest outside: there it is the cut's, and the mean half way to the inside."""
    found = _follow(tmp_path, "G96 S200\nG0 X62 Z-1\nG1 X20 F.2\n")
    (line,) = _predict(found)
    cut = JobCut(operation="face", diameter_mm=60, depth_mm=1, feed_mm_rev=0.2, speed_m_min=200)
    (same,) = job_cuts.predict(known(), INSERT, [cut])
    assert line.operation == "face"
    for name in FORCES[:3]:
        assert_allclose(_ends(getattr(line, name)), _ends(getattr(same, name)), rtol=SAME)
    assert line.peaks is not None
    assert line.peaks.speed_rpm is not None
    assert_allclose(line.peaks.torque_N_m.value, same.torque_N_m.value, rtol=0.025 / 30)
    # At one cutting speed the time at a radius goes with it: ∫r² dr / ∫r dr
    mean_mm = 2 / 3 * (30**3 - 10**3) / (30**2 - 10**2)
    assert_allclose(line.torque_N_m.value, line.force_y_N.value * mean_mm / 1000, rtol=JOINED)
    fastest_rpm = 200_000 / (2 * np.pi * 10)
    assert_allclose(
        [line.peaks.speed_rpm, line.speed_rpm], [fastest_rpm, fastest_rpm / 3], rtol=0.003
    )


PROFILE = "G96 S200\nG0 X40 Z1\nG1 Z-5 F.2\nX50 Z-25\nG3 X56 Z-28 R3\nG1 Z-40 F.1\n"


def test_steps_that_are_joined_give_the_means_of_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    joined = _follow(tmp_path, PROFILE)
    monkeypatch.setattr(line_parts, "MOST", 10**6)
    every = _follow(tmp_path, PROFILE)
    assert [line.operation for line in joined.lines] == ["turn", "taper", "contour", "turn"]
    assert max(len(line.steps) for line in joined.lines) == 32
    assert max(len(line.steps) for line in every.lines) > 400
    assert_allclose(joined.cutting_s, every.cutting_s, rtol=1e-12)
    for some, whole in zip(_predict(joined), _predict(every), strict=True):
        assert some.peaks is not None
        assert whole.peaks is not None
        for ours, theirs, share in ((some, whole, JOINED), (some.peaks, whole.peaks, PEAK)):
            size_N = abs(theirs.force_y_N.value)
            for name in FORCES:
                atol = share * size_N * (ARM_M if name == "torque_N_m" else 1.0)
                assert_allclose(_ends(getattr(ours, name)), _ends(getattr(theirs, name)), atol=atol)


def test_the_time_is_that_of_the_way_in_the_stock(tmp_path: Path) -> None:
    found = _follow(tmp_path, "G0 X56 Z2\nG1 Z-30 F.2\nX64\n")
    assert [line.name for line in found.lines] == ["line 3: G1 Z-30 F.2"]
    assert_allclose(found.cutting_s, 30 / 200 * 60)
    assert_allclose(found.fed_s, 36 / 200 * 60)


def test_of_a_shoulder_counts_what_the_edge_reaches(tmp_path: Path) -> None:
    """Of 8 mm with 0.3 mm on them, an edge at 94° meets 0.3/tan 4° at the most."""
    stock = [[-60, 40], [-29.7, 40], [-29.7, 25], [0, 25]]
    found = _follow(tmp_path, "G0 X24 Z1\nG1 Z-30 F.1\nX42\n", stock=stock)
    most = found.lines[0].ranges()["cutting.depth"][1]
    assert_allclose(most, (0.3 - 0.025) / np.tan(np.radians(4.0)), rtol=0.01)


def test_a_shoulder_met_at_once_is_a_peak_that_is_spoken_of(tmp_path: Path) -> None:
    """0.5 mm along the land, 8 mm over the shoulder's last 0.3 mm; its limit is of that peak."""
    stock = [[-60, 40], [-29.7, 40], [-29.7, 25], [0, 25]]
    found = _follow(tmp_path, "G0 X24 Z1\nG1 Z-30 F.1\nX42\n", stock=stock, tools=SQUARE)
    assert len(found.lines) == 1
    assert_allclose(found.lines[0].ranges()["cutting.depth"], [0.5 + 7.5 * 0.01, 8.0])
    (line,) = cuts = _predict(found)
    assert line.peaks is not None
    assert line.peaks.torque_N_m.value > 8 * line.torque_N_m.value
    (said,) = along.peaked(cuts)
    assert "its largest torque is" in said
    most = AxisLimits(torque_N_m=0.5 * line.peaks.torque_N_m.value, speed_rpm=999.0)
    assert [one.unit for one in exceeding(cuts, {"spindle": most})] == ["N·m", "rpm"]
    assert not list(along.peaked(_predict(_follow(tmp_path, "G0 X56 Z2\nG1 Z-30 F.2\n"))))


def test_units_and_diameter_are_the_jobs_else_the_machines_else_mm(tmp_path: Path) -> None:
    (tmp_path / "p.nc").write_text(HEAD + "G0 X2.2 Z.1\nG1 Z-1 F.01\n", encoding="utf-8")
    bar = {"file": str(tmp_path / "p.nc"), "stock_diameter_mm": 60.0}
    inch = programs.follow(JobProgram.model_validate(bar), units="inch", diameter=None)
    assert_allclose(inch.lines[0].widest["work.diameter"], 2.2 * 25.4)
    thin = {**bar, "stock_diameter_mm": 6.0, "units": "mm"}
    radii = programs.follow(JobProgram.model_validate(thin), units="inch", diameter=False)
    assert_allclose(radii.lines[0].widest["work.diameter"], 4.4)
    stated = {**thin, "diameter": True}
    both = programs.follow(JobProgram.model_validate(stated), units="inch", diameter=False)
    assert_allclose(both.lines[0].widest["work.diameter"], 2.2)


def test_the_largest_is_what_is_expected_there_not_what_the_law_says(tmp_path: Path) -> None:
    """Where the pair's law was learnt to be off by the engaged edge: a forecast's means, alone."""
    found = _follow(tmp_path, PROFILE)
    posterior = known().also((law_error("turn"), law_error("contour")))
    mean = posterior.state.mean.copy()
    mean[posterior.columns(law_error("turn").key)] = [0.1, -0.2, 0.1, 0.05, -0.4, 0.3]
    off = replace(posterior, state=Gaussian(mean, posterior.state.covariance))
    for tool in (INSERT, ToolOf("unknown", {})):
        rows = found.lines[0].steps + found.lines[1].steps
        cuts = BY_NAME["turn"].cuts(tool.numbers, rows, called=tool.name)
        some = off.also(cuts.assumed)
        moved = replace(some, state=Gaussian(some.state.mean + 0.01, some.state.covariance))
        assert_allclose(
            expected_means(moved, cuts), forecast(moved, cuts).mean, rtol=1e-9, atol=1e-9
        )
    for line in along.predict_lines(off, INSERT, found.lines[-1:], source="p.nc"):
        assert line.peaks is not None
        for name in FORCES:
            most, mean_of = getattr(line.peaks, name).value, getattr(line, name).value
            assert abs(most) >= abs(mean_of) * (1 - SAME)


REFUSED = {
    "word": ({}, "G0 X56 Z2\nG1 Z-30 F.2 Q9\n", r"p\.nc: line 3: 'Q9': "),
    "rapid": ({}, "G0 X56 Z2\nG1 Z-3 F.2\nG0 X50\n", r"p\.nc: line 4: this rapid goes"),
    "air": ({}, "G0 X66 Z2\nG1 Z-30 F.2\n", r"p\.nc: the program cuts no stock; "),
    "axis": (
        {"stock_diameter_mm": 40}, "G0 X0 Z2\nG1 Z-3 F.2\n", r"line 3: on the spindle's axis",
    ),
    "sha256": ({"sha256": "0" * 64}, "G0 X56 Z2\nG1 Z-30 F.2\n", r"p\.nc: is not the program of"),
}  # fmt: skip


@pytest.mark.parametrize(("said", "body", "says"), REFUSED.values(), ids=REFUSED)
def test_a_broken_program_is_refused(
    tmp_path: Path, said: dict[str, Any], body: str, says: str
) -> None:
    with pytest.raises(UnusableInput, match=says) as caught:
        _follow(tmp_path, body, **said)
    assert has_remedy(str(caught.value))


@pytest.mark.parametrize(
    ("head", "body", "says"),
    [
        ("", "G0 X56 Z2\nG1 Z-30 F100000\n", "line 3: a feed of 100000 mm/rev is beyond"),
        ("G94\n", f"G0 X56 Z2\nG1 Z-30 F{9 * 10**99}\n", "line 4: a feed of 1.5e+98 mm/s is"),
        ("", f"G0 X56 Z2\nG1 Z-30 F0.{'0' * 310}1\n", "line 3: a feed of 1e-311 mm/rev is"),
        (f"S{10**300}\n", "G0 X56 Z2\nG1 Z-30 F.2\n", "line 4: a speed of 1e+300 rpm is"),
        (f"G96 S{10**6}\n", "G0 X56 Z2\nG1 Z-30 F.2\n", "line 4: a speed of 1e+06 m/min is"),
        ("", f"G0 X56 Z2\nG1 Z-{10**300} F.2\n", "line 3: a place of 1e+300 mm is beyond"),
    ],
)
def test_a_line_that_no_machine_makes_is_refused(
    tmp_path: Path, head: str, body: str, says: str
) -> None:
    with pytest.raises(UnusableInput) as caught:
        _follow(tmp_path, body, head=HEAD + head)
    assert says in str(caught.value)


def test_a_line_that_the_edge_cannot_follow_is_named(tmp_path: Path) -> None:
    stock = [[-50, 30], [-20, 30], [-20, 60], [0, 60]]
    body = "G0 X31 Z-22\nG1 Z-21 F.2\nX50 Z-18\n"
    found = _follow(tmp_path, "G0 X58 Z2\nG1 Z-10 F.2\nG0 X62\nZ-22\n" + body, stock=stock)
    with pytest.raises(UnusableInput, match=r"p\.nc: line 8: an edge at 93° cannot follow a feed"):
        _predict(found)


BOTH = "give either [[cut]] or [program], and only one of them"
STOCKS = (
    "program: give one of stock_diameter_mm (a bar), stock, or block_mm of a mill, and no other"
)
JOBS = {
    "neither": ("", BOTH),
    "both": (
        "[[cut]]\ndiameter_mm = 9\ndepth_mm = 1\nfeed_mm_rev = 0.1\nspeed_rpm = 9\n"
        '[program]\nfile = "p.nc"\nstock_diameter_mm = 9\n', BOTH,
    ),
    "no stock": ('[program]\nfile = "p.nc"\n', STOCKS),
    "two stocks": (
        '[program]\nfile = "p.nc"\nstock_diameter_mm = 9\nstock = [[-9, 9], [0, 9]]\n', STOCKS,
    ),
    "face of a profile": (
        '[program]\nfile = "p.nc"\nstock_face_mm = 1\nstock = [[-9, 9], [0, 9]]\n',
        "program: stock_face_mm goes with stock_diameter_mm",
    ),
    "falling": ('[program]\nfile = "p.nc"\nstock = [[0, 9], [-9, 9]]\n', "with z rising"),
    "key": ('[program]\nfile = "p.nc"\nstock_diameter = 9\n', "stock_diameter: unknown key"),
}  # fmt: skip


@pytest.mark.parametrize(("text", "says"), JOBS.values(), ids=JOBS)
def test_a_job_that_says_too_much_or_too_little_is_refused(
    tmp_path: Path, text: str, says: str
) -> None:
    (tmp_path / "job.toml").write_text(JOB + text, encoding="utf-8")
    with pytest.raises(UnusableInput) as caught:
        read_job(tmp_path / "job.toml")
    assert str(caught.value).startswith(f"{tmp_path / 'job.toml'}: ")
    assert says in str(caught.value)


def test_a_job_of_a_program_is_answered_as_others_are(
    cli: Cli, refused: Callable[..., str], sample_jobs: Path, tmp_path: Path
) -> None:
    """Predicted, written, drawn and traced; its file is relative to the job, wherever one works."""
    for command in ("init", "machine add lathe-1"):
        assert cli(*command.split()).code == 0
    job = sample_jobs / "nc_profile" / "job.toml"
    done = cli("predict", job, "--machine", "lathe-1", "--csv", "a.csv", "--plot", "a.html")
    assert done.code == 0
    assert "peak along the cut" in done.out
    assert "11 lines cut for 45.9 s, of 47.9 s at a feed" in done.out
    assert "'line 28: G90 G1 Z-40': its largest torque is" in done.out
    assert len((tmp_path / "a.csv").read_text(encoding="utf-8").splitlines()) == 12
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert "diamonds peaks along the cut" in page
    assert page.count(", peak along the cut</th>") == 11
    answer = json.loads(cli("predict", job, "--machine", "lathe-1", "--json").out)
    assert len(answer["cuts"]) == 11
    assert all(cut["peaks"]["torque_N_m"] for cut in answer["cuts"])
    assert "part.nc, sha256 " in cli("trace", "prediction", 1).out
    assert "a plan is made for cuts" in refused("plan", job, "--machine", "lathe-1")
    (tmp_path / "job.toml").write_text(
        JOB + '[program]\nfile = "none.nc"\nstock_diameter_mm = 60\n', encoding="utf-8"
    )
    assert "none.nc: No such file" in refused("predict", "job.toml", "--machine", "lathe-1")


def test_a_job_says_the_course_of_its_cuts_and_one_power(cli: Cli, tmp_path: Path) -> None:
    """Power is torque times angular speed, at the radius where the force acts, 6 mm."""
    for command in ("init", "machine add lathe-1"):
        assert cli(*command.split()).code == 0
    cut = "depth_mm = 2\nfeed_mm_rev = 0.2\nspeed_rpm = 1000\n"
    job = tmp_path / "job.toml"
    job.write_text(
        f'{JOB}[[cut]]\ndiameter_mm = 10\n{cut}[[cut]]\noperation = "face"\ndiameter_mm = 60\n'
        f'end_diameter_mm = 20\n{cut}[[cut]]\noperation = "face"\ndiameter_mm = 60\n{cut}',
        encoding="utf-8",
    )
    done = cli("predict", job, "--machine", "lathe-1")
    for said in ("face: mean", "start", "end", "peak along the cut"):
        assert said in done.out
    assert "cut 3: its torque and power are those at its start, 60 mm" in done.out
    answer = json.loads(cli("predict", job, "--machine", "lathe-1", "--json").out)
    turn, face, _ = answer["cuts"]
    assert_allclose(turn["torque_N_m"]["value"], 0.006 * turn["force_y_N"]["value"])
    for one in (turn, face, face["start"], face["end"], face["peaks"]):
        omega = 1000 * np.pi / 30
        assert_allclose(one["power_W"]["value"], one["torque_N_m"]["value"] * omega)
    assert_allclose(face["torque_N_m"]["value"], 0.02 * face["force_y_N"]["value"], rtol=1e-3)


FAILURES = {
    "17_boring.nc": "line 5: this cuts inwards from the surface that was just turned",
    "18_partoff.nc": "line 4: 40.000 mm deep, more than the edge's 25 mm",
    "19_groove.nc": "line 4: 40.000 mm deep",
    "24_noM3.nc": "line 4: 'G1': nothing has started the spindle; use M3",
    "30_feedhuge.nc": "line 4: a feed of 200 mm/rev is beyond what a tool cuts with",
}
PROGRAMS = {
    "17_boring.nc": "G97 S800 M3\nG0 X22 Z2\nG1 Z-40 F0.15\nX20\nG0 Z2\nX24\nG1 Z-40\nX22\nG0 Z2\n",
    "18_partoff.nc": "G97 S800 M3\nG0 X62 Z-40\nG1 X0 F0.08\nG0 X70\n",
    "19_groove.nc": "G97 S800 M3\nG0 X62 Z-40\nG1 X54 F0.08\nG0 X70\nG0 Z-43\nG1 X54\nG0 X70\n",
    "24_noM3.nc": "G97 S800\nG0 X56 Z2\nG1 Z-40 F0.2\n",
    "30_feedhuge.nc": "G97 S1000 M3\nG0 X56 Z2\nG1 Z-40 F200\n",
}


@pytest.mark.parametrize("name", FAILURES)
def test_what_no_tool_explains_or_no_machine_does_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(UnusableInput) as caught:
        _follow(tmp_path, PROGRAMS[name], head="G18 G21 G90 G95\n")
    assert FAILURES[name] in str(caught.value)
    assert has_remedy(str(caught.value))


def test_a_stated_tool_has_its_own_edge(tmp_path: Path) -> None:
    """A blade of 3 mm takes 3 mm, a boring bar the ring, whichever is turned elsewhere."""
    head = "G18 G21 G90 G95\n"
    blade = {"other": {"kind": "grooving", "width_mm": 3.0}}
    found = _follow(tmp_path, PROGRAMS["18_partoff.nc"], head=head, tools=blade)
    (line,) = _predict(found)
    assert line.operation == "groove"
    cut = JobCut(operation="groove", diameter_mm=60, width_mm=3, feed_mm_rev=0.08, speed_rpm=800)
    (same,) = job_cuts.predict(known(), INSERT, [cut])
    assert_allclose(line.force_y_N.value, same.force_y_N.value, rtol=0.03)  # slower inside
    bar = {"other": {"kind": "boring"}}
    bored = _follow(tmp_path, PROGRAMS["17_boring.nc"], head=head, tools=bar, bore_diameter_mm=20.0)
    assert [line.operation for line in bored.lines] == ["bore", "bore"]
    assert_allclose(bored.removed_mm3, np.pi * (12**2 - 10**2) * 40, rtol=1e-3)


def test_a_mill_s_program_meets_its_block(tmp_path: Path) -> None:
    """A slot of 10 mm, then half of it beside: widths and volume as drawn."""
    body = "S1000 M3\nG0 X-10 Y10 Z5\nG1 Z-2 F200\nX60\nG0 Z5\nX-10 Y15\nG1 Z-2\nX60\n"
    mill = {"other": {"kind": "end_mill", "diameter_mm": 10.0, "teeth": 4}}
    (tmp_path / "p.nc").write_text("G21 G90 G17\n" + body, encoding="utf-8")
    said = {"file": str(tmp_path / "p.nc"), "block_mm": [0, 50, 0, 50, -10, 0], "tools": mill}
    found = programs.follow(JobProgram.model_validate(said), units=None, diameter=None)
    assert_allclose(found.removed_mm3, 50 * 10 * 2 + 50 * 5 * 2, rtol=0.005)
    slot, side = _predict(found)
    pairs: tuple[tuple[PredictedCut, str, dict[str, float]], ...] = (
        (slot, "slot", {}),
        (side, "side-up", {"width_mm": 5}),
    )
    for line, operation, more in pairs:
        cut = JobCut.model_validate(
            {
                "operation": operation,
                "depth_mm": 2,
                "feed_mm_tooth": 0.05,
                "speed_rpm": 1000,
                **more,
            }
        )
        (same,) = job_cuts.predict(known(), ToolOf("m", {"diameter_mm": 10, "teeth": 4}), [cut])
        assert line.peaks is not None
        assert same.peaks is not None
        ours, theirs = line.peaks.torque_N_m.value, same.peaks.torque_N_m.value
        assert_allclose(ours, theirs, rtol=0.01)


def test_the_one_mill_of_a_program_is_the_job_s_tool(cli: Cli) -> None:
    body = "G21 G90 G17\nS1000 M3\nG0 X-10 Y10 Z5\nG1 Z-2 F200\nX60\nM30\n"
    Path("p.nc").write_text(body, encoding="utf-8")
    job = 'name = "a"\nmaterial = "C45"\ntool = "T1"\n[program]\nfile = "p.nc"\n'
    block = "block_mm = [0, 50, 0, 50, -10, 0]\n[program.tools.other]\n"
    mill = 'kind = "end_mill"\ndiameter_mm = 10\nteeth = 4\n'
    Path("job.toml").write_text(job + block + mill, encoding="utf-8")
    cli("init")
    cli("machine", "add", "m")
    (line,) = json.loads(cli("predict", "job.toml", "--json").out)["cuts"]
    asked = ("--operation", "slot", "--depth", 2, "--feed", 0.05, "--rpm", 1000)
    same = json.loads(cli("lookup", "--material", "C45", "--tool", "T1", *asked, "--json").out)
    ours, theirs = (one["peaks"]["torque_N_m"]["value"] for one in (line, same["cut"]))
    assert_allclose(ours, theirs, rtol=0.01)
