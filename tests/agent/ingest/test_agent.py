"""One machine's life through the command line, on the sample recordings."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sqlalchemy import select

from autodb.agent.ingest import importing
from autodb.agent.ingest.importing import import_file
from autodb.agent.sense import identifying
from autodb.records.source import RecordingSource
from autodb.records.summary import summarise
from autodb.store import models, open_store
from tests.conftest import Cli, Ran

pytestmark = pytest.mark.usefixtures("one_law")

URL = "sqlite:///autodb.sqlite3"


def _rows(model: type[models.Base]) -> list[models.Base]:
    store = open_store(URL)
    with store.reading() as session:
        rows = list(session.scalars(select(model)))
        session.expunge_all()
    store.close()
    return rows


def test_repeats_say_already_there(learnt: Cli, recordings: Path) -> None:
    for arguments, says in (
        (("init",), "already there"),
        (("machine", "add", "lathe-1"), "already there"),
        (("import", recordings / "shop-week-1.csv", "--machine", "lathe-1"), "already there"),
        (("calibrate", "--machine", "lathe-1"), "already there"),
        (("refresh", "--machine", "lathe-1"), "nothing new"),
    ):
        done = learnt(*arguments)
        assert done.code == 0
        assert says in done.out
    assert len(_rows(models.CuttingParameters)) == 1


def test_two_that_identify_an_axis_at_once_keep_one_version(
    learnt: Cli, recordings: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def other_first(*asked: object, **how: object) -> object:
        monkeypatch.setattr(identifying, "import_file", import_file)
        assert learnt("identify", recordings / "air-moves.csv", "--machine", "lathe-1").code == 0
        return import_file(*asked, **how)  # type: ignore[arg-type]

    monkeypatch.setattr(identifying, "import_file", other_first)
    done = learnt("identify", recordings / "air-moves.csv", "--machine", "lathe-1")
    assert done.code == 0
    assert "already there" in done.out
    assert len(_rows(models.ChannelModel)) == 1


def test_a_file_that_came_with_another_side_file_says_so(learnt: Cli, recordings: Path) -> None:
    side = Path("side.toml")
    side.write_text('[recording]\nmachine = "lathe-1"\ncoolant = "flood"\n')
    file = recordings / "shop-week-1.csv"
    done = learnt("import", file, "--machine", "lathe-1", "--columns", side)
    assert "already there (with another side file" in done.out


def test_two_agents_that_import_one_file_keep_it_once(
    learnt: Cli, recordings: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another agent imports the same file while this one is reading it."""
    file = recordings / "shop-week-2.csv"

    def overtaken(source: RecordingSource, **options: Any) -> Any:
        monkeypatch.setattr(importing, "summarise", summarise)
        assert learnt("import", file, "--machine", "lathe-1").code == 0
        return summarise(source, **options)

    monkeypatch.setattr(importing, "summarise", overtaken)
    assert "already there, 36 rows" in learnt("import", file, "--machine", "lathe-1").out
    assert len(_rows(models.StoredRecording)) == 4


def test_raw_phase_currents_give_the_same_ranges_as_the_cut_table(
    learnt: Cli, recordings: Path
) -> None:
    """The raw recording repeats a standard cut; its demodulated rise is within 10 % of the table's.

    Two cuts differ by process scatter (5 % at one sd in z) besides the demodulation.
    """
    del learnt
    from autodb.records import source as records

    raw = next(r for r in _rows(models.Cut) if isinstance(r, models.Cut) and r.recording_id == 2)
    table = records.read(recordings / "standard-cuts.csv")
    alike = (
        (np.abs(table["cutting.feed"] - 0.2) < 1e-9)
        & (np.abs(table["cutting.depth"] - 2.0) < 1e-9)
        & (np.array(table.texts["operation"]) == "turn")
    )
    rise = (table["z.current.range"] - table["z.current.air"])[alike].mean()
    found = raw.measured["z.current.range"] - raw.measured["z.current.air"]
    assert_allclose(found, rise, rtol=0.10)
    assert_allclose(raw.measured["force.z"], table["force.z"][alike].mean(), rtol=0.2)


def test_not_sensed_is_never_zero(learnt: Cli) -> None:
    del learnt
    forces = [row for row in _rows(models.SensedForce) if isinstance(row, models.SensedForce)]
    passive = [f for f in forces if f.component == "x" and f.value_N is None]
    assert passive
    assert all("stands still" in str(f.reason) for f in passive)


def test_a_new_calibration_makes_new_parameters(learnt: Cli, recordings: Path) -> None:
    assert learnt("calibrate", recordings / "standard-cuts.csv", "--machine", "lathe-1").code == 0
    done = learnt("refresh", "--machine", "lathe-1")
    assert "version 2" in done.out
    rows = [r for r in _rows(models.CuttingParameters) if isinstance(r, models.CuttingParameters)]
    assert [r.previous_id for r in rows if r.version == 2] == [None]


def test_new_cuts_build_on_the_last_version(learnt: Cli, recordings: Path) -> None:
    again = Path("more.csv")
    lines = (recordings / "shop-week-1.csv").read_text().splitlines()
    again.write_text("\n".join([lines[0], *(f"9{line}" for line in lines[1:11])]) + "\n")
    assert learnt("import", again, "--machine", "lathe-1").code == 0
    assert "version 2 from" in learnt("refresh", "--machine", "lathe-1").out
    store = open_store(URL)
    with store.reading() as session:
        first, second = session.scalars(
            select(models.CuttingParameters).order_by(models.CuttingParameters.version)
        )
        new = {force.cut_id for force in second.forces}
        assert second.previous_id == first.id
        assert second.n_cuts == first.n_cuts + len(new)
        assert 5 <= len(new) <= 10, "ten cuts came, of which some may be no longer usual"
    store.close()


def test_a_passive_force_that_was_measured_is_not_of_the_law_alone(
    learnt: Cli, sample_jobs: Path
) -> None:
    done = learnt("predict", sample_jobs / "stepped_shaft" / "job.toml", "--machine", "lathe-1")
    assert done.code == 0
    assert "* passive force: no drive senses it" not in done.out
    assert "autodb trace prediction 1" in done.out


def test_trace_goes_from_a_prediction_down_to_recordings(learnt: Cli, sample_jobs: Path) -> None:
    learnt("predict", sample_jobs / "stepped_shaft" / "job.toml", "--machine", "lathe-1")
    done = learnt("trace", "prediction", 1)
    for part in (
        "force.z", "parameters", "K_te", "began as", "calibration", "sha256", "shop-week-1.csv",
        "standard-cuts.csv", "standard-cut-raw.parquet", "cuts 1, 2",
    ):  # fmt: skip
        assert part in done.out, part
    for kind in ("parameters", "force", "calibration", "recording"):
        assert learnt("trace", kind, 1).code == 0


def test_worn_tools_are_named_against_the_machines_own_model(learnt: Cli, recordings: Path) -> None:
    done = learnt("explain", recordings / "shop-week-2.csv", "--machine", "lathe-1", "--json")
    channels = json.loads(done.out)["channels"]
    causes = [c for answer in channels.values() for c in answer["missing"]]
    named = {c["term"]: c for c in causes if c["kind"] == "missing"}
    assert {"tool_wear"} <= named.keys() <= {"tool_wear", "unknown"}
    assert any("rate edge B2" in c["parameters"] for c in causes)
    kept = [m for m in _rows(models.Mismatch) if isinstance(m, models.Mismatch)]
    second = max(m.recording_id for m in kept)
    of_it = [m for m in kept if m.recording_id == second]
    assert {m.term for m in of_it if m.kind == "missing"} == named.keys()
    count = len(kept)
    learnt("explain", recordings / "shop-week-2.csv", "--machine", "lathe-1")
    assert len(_rows(models.Mismatch)) == count


def test_an_axis_is_explained_against_its_own_model(learnt: Cli, recordings: Path) -> None:
    moves = recordings / "air-moves.csv"
    assert "version 1" in learnt("identify", moves, "--machine", "lathe-1").out
    done = learnt("explain", moves, "--machine", "lathe-1", "--json")
    fit = json.loads(done.out)["channels"]["z.current"]["fit"]
    assert fit["rms_before"] < 0.1


def test_an_axis_current_takes_the_sign_of_its_axis(cli: Cli, recordings: Path) -> None:
    Path("m.toml").write_text("[axes.z]\ncurrent_sign = -1\n")
    cli("init")
    cli("machine", "add", "mirrored", "--file", "m.toml")
    sound = (recordings / "air-moves.csv").read_text("utf-8").splitlines()
    at = sound[0].split(",").index("z.current")
    turned = [row.split(",") for row in sound[1:]]
    for cells in turned:
        cells[at] = f"{-float(cells[at])!r}"
    Path("turned.csv").write_text("\n".join([sound[0], *map(",".join, turned)]) + "\n")
    refused = cli("identify", recordings / "air-moves.csv", "--machine", "mirrored")
    assert refused.code == 2
    assert "its sign is reversed" in " ".join(refused.err.split())
    assert cli("identify", "turned.csv", "--machine", "mirrored").code == 0
    (row,) = _rows(models.ChannelModel)
    assert isinstance(row, models.ChannelModel)
    coulomb = next(term for term in row.terms if term["term"] == "coulomb")
    assert coulomb["value"] > 0.5


def test_machine_show_lists_what_is_sensed(learnt: Cli) -> None:
    done = learnt("machine", "show", "lathe-1")
    assert "force.z: usable" in done.out
    assert "lathe-1" in learnt("machine", "list").out


@pytest.mark.parametrize(
    ("material", "tool", "begun"),
    [
        ("unobtainium", "none", "what any metal may have: no conventional values of 'unobtainium'"),
        ("ti-6al-4v", "none", "conventional values of Ti6Al4V"),
        ("steel bar", "none", "steel bar / carbide insert, the same material with another tool"),
    ],
)
def test_a_pair_never_cut_is_predicted_from_what_is_nearest_and_says_so(
    learnt: Cli, tmp_path: Path, material: str, tool: str, begun: str
) -> None:
    """Wider than of the pair that was cut, and with what the machine has learnt beside it."""
    job = tmp_path / "job.toml"
    cut = "[[cut]]\ndiameter_mm = 50\ndepth_mm = 1\nfeed_mm_rev = 0.2\nspeed_rpm = 900\n"
    known = ("steel bar", "carbide insert")
    width = {}
    for pair in (known, (material, tool)):
        job.write_text(f'name = "a"\nmaterial = "{pair[0]}"\ntool = "{pair[1]}"\n{cut}')
        answer = json.loads(learnt("predict", job, "--machine", "lathe-1", "--json").out)
        force = answer["cuts"][0]["force_y_N"]
        width[pair] = (force["high"] - force["low"]) / force["value"]
    assert width[material, tool] > 1.5 * width[known]
    assert answer["behind"]["cuts"] == 0
    said = " ".join(answer["notes"])
    assert f"has no parameters of {material} / {tool}" in said
    assert f"predicted from {begun}" in said
    assert "steel bar / carbide insert" in said.partition("predicted from")[0]
    traced = " ".join(learnt("trace", "prediction", answer["prediction_id"]).out.split())
    assert f"the pair was not learnt: {begun}" in traced
    assert learnt("doctor").code == 0


def test_an_interrupt_ends_with_130(
    cli: Cli, monkeypatch: pytest.MonkeyPatch, recordings: Path
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    cli("init")
    cli("machine", "add", "lathe-1")
    monkeypatch.setattr("autodb.agent.ingest.cuts_in_file._cut_row", interrupted)
    done: Ran = cli("import", recordings / "shop-week-1.csv", "--machine", "lathe-1")
    assert done.code == 130
    assert done.err.strip().splitlines()[-1].startswith("autodb: interrupted")
    assert _rows(models.StoredRecording) == []


def test_cuts_outside_what_was_learnt_are_not_trusted(learnt: Cli) -> None:
    cut = "[[cut]]\nname = 'deep'\ndiameter_mm = 50\ndepth_mm = 20\nfeed_mm_rev = 0.2\n"
    Path("deep.toml").write_text(
        f'name = "a"\nmaterial = "steel bar"\ntool = "carbide insert"\n{cut}speed_rpm = 900\n'
    )
    done = learnt("predict", "deep.toml", "--machine", "lathe-1")
    assert "cut 1 'deep': depth 20 mm was never cut" in done.out


def test_an_answer_replaces_what_a_link_points_to(learnt: Cli, recordings: Path) -> None:
    Path("real").mkdir()
    Path("link").symlink_to("real")
    worn = recordings / "shop-week-2.csv"
    assert learnt("explain", worn, "--machine", "lathe-1", "--out", "link").code == 0
    assert Path("link").is_symlink()
    assert Path("real/report.html").exists()


@pytest.mark.parametrize("rate_hz", [2.0, 50.0, 99.0, 125.0])
def test_a_spread_over_filters_needs_a_fast_recording(cli: Cli, rate_hz: float) -> None:
    """M 0.002 A·s²/mm, Coulomb 0.7 A on a slow sine; no filter of the spread fits below 100 Hz."""
    t = np.arange(int(60 * max(rate_hz, 10.0))) / rate_hz
    period_s = 8.0 * max(1.0, 10.0 / rate_hz)
    phase = 2 * np.pi * t / period_s
    velocity = 50 * np.cos(phase)
    current = 0.7 * np.sign(velocity) + 0.01 * velocity
    rows = np.column_stack([t, 50 * period_s / 2 / np.pi * np.sin(phase), current])
    np.savetxt("slow.csv", rows, delimiter=",", header="t,x.position,x.current", comments="")
    done = cli("identify", "slow.csv")
    assert done.code == 0, done.err
    assert "coulomb" in done.out
    assert ("Plain least squares over filters" in done.out) == (rate_hz > 100)
