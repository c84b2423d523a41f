"""The passive force of a cut from its finished part, from file to posterior."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from autodb.sensing.ranges.inspection import RoundBar, held_in_a_chuck
from tests.conftest import Cli, Once

FORCE_N, OFF_MM, REST_MM_N = 240.0, 0.012, 3e-5
PLACES = np.array([15.0, 35.0, 55.0, 75.0, 95.0, 115.0])
NOISE_MM = 0.002
CUT = 3
SECTIONS = (1.5 * 0.25) / (1.0 * 0.13)
"""Section of the chip of the sample job's third cut over that of the recording's."""


def _part(path: Path, *, force_N: float = FORCE_N, diameter_mm: float = 24.0) -> Path:
    """Write a steel bar in a chuck that a force pushed away, measured with noise."""
    bar = RoundBar(24.0, 120.0, 210_000.0)
    pushed = force_N * (held_in_a_chuck(bar, PLACES) + REST_MM_N) + OFF_MM
    noise = NOISE_MM * np.random.default_rng(70).standard_normal(len(PLACES))
    error = ", ".join(f"{one:.5f}" for one in 2.0 * pushed + noise)
    place = ", ".join(f"{one:.1f}" for one in PLACES)
    path.write_text(
        f"machine_compliance_mm_N = {REST_MM_N}\n"
        f"[bar]\ndiameter_mm = {diameter_mm}\nlength_mm = 120.0\nmodulus_MPa = 210000.0\n"
        f"[measured]\nplace_mm = [{place}]\ndiameter_error_mm = [{error}]\n"
        f"noise_mm = {NOISE_MM}\n",
        encoding="utf-8",
    )
    return path


@pytest.fixture
def learnt(cli: Cli, sample_jobs: Path, once: Once) -> Cli:
    """Return the command line on a lathe that nothing but z feels, with its first week learnt."""
    recordings = sample_jobs / "stepped_shaft" / "recordings"

    def learn() -> None:
        cli("init")
        cli("machine", "add", "lathe-1")
        for name in ("standard-cuts.csv", "shop-week-1.csv"):
            table = pd.read_csv(recordings / name).iloc[:24]
            table.drop(columns="force.x", errors="ignore").to_csv(name, index=False)
            assert cli("import", name, "--machine", "lathe-1").code == 0
        assert cli("calibrate", "--machine", "lathe-1").code == 0
        assert cli("refresh", "--machine", "lathe-1").code == 0

    once(learn)
    return cli


def _passive_N(cli: Cli, sample_jobs: Path) -> tuple[float, float]:
    """Return the passive force of the sample job's third cut and its half width."""
    job = sample_jobs / "stepped_shaft" / "job.toml"
    ran = cli("predict", job, "--machine", "lathe-1", "--json")
    assert ran.code == 0, ran.err
    x = json.loads(ran.out)["cuts"][2]["force_x_N"]
    return x["value"], (x["high"] - x["low"]) / 2.0


def test_a_part_tells_its_force_and_what_the_radius_was_off_by(cli: Cli) -> None:
    done = cli("inspect", _part(Path("part.toml")))
    assert done.code == 0, done.err
    said = done.out.split("passive force: ")[1].split()
    assert float(said[0]) == pytest.approx(FORCE_N, abs=float(said[2]) + 1.0)
    assert float(said[2]) < 60.0
    assert "not stored" in done.out


def test_a_stiff_part_tells_nothing_and_says_why(cli: Cli) -> None:
    thick = cli("inspect", _part(Path("part.toml"), diameter_mm=90.0))
    assert thick.code == 0
    assert "not sensed: its 95 % interval is" in thick.out
    printed = json.loads(cli("inspect", "part.toml", "--json").out)
    assert printed["force_N"] is None
    assert printed["why_not"].startswith("its 95 % interval is")


def test_what_the_part_told_is_learnt_and_traced(learnt: Cli, sample_jobs: Path) -> None:
    of = ("--machine", "lathe-1", "--recording", "shop-week-1.csv", "--cut", str(CUT))
    part = _part(Path("part.toml"), force_N=130.0)
    assert "nothing new" in learnt("refresh", "--machine", "lathe-1").out
    alone, half_alone = _passive_N(learnt, sample_jobs)
    kept = learnt("inspect", part, *of)
    assert kept.code == 0, kept.err
    assert "kept as force.x of cut 3" in kept.out
    assert "already there" in learnt("inspect", part, *of).out
    other = learnt("inspect", _part(Path("other.toml"), force_N=400.0), *of)
    assert other.code == 2
    assert "determined from another part" in other.err
    after = learnt("refresh", "--machine", "lathe-1")
    assert after.code == 0, after.err
    assert "version" in after.out
    listed = learnt("sensors", "lathe-1")
    assert "finished part" in listed.out
    assert "version 2" in after.out
    told, half = _passive_N(learnt, sample_jobs)
    assert 130.0 < told < 130.0 * SECTIONS
    assert half / told < 0.7 * half_alone / alone
    traced = learnt("trace", "parameters", "2")
    assert "inspection of force.x, version 1" in traced.out


def test_what_is_no_part_of_a_cut_is_refused_in_one_line(learnt: Cli) -> None:
    def refused(*arguments: object) -> str:
        ran = learnt(*arguments)
        assert ran.code == 2
        assert len(ran.err.strip().splitlines()) == 1
        return ran.err

    part = _part(Path("part.toml"))
    of = ("--machine", "lathe-1", "--recording", "shop-week-1.csv")
    assert "go together" in refused("inspect", part, *of)
    assert "no cut 999" in refused("inspect", part, *of, "--cut", "999")
    Path("new.csv").write_text("cut,force.x\n1,2\n", encoding="utf-8")
    there = refused("inspect", part, *of[:3], "new.csv", "--cut", "1")
    assert "not imported" in there
    short = part.read_text("utf-8").replace("115.0]", "125.0]")
    Path("short.toml").write_text(short, encoding="utf-8")
    assert "measured.place_mm: 125 is beyond" in refused("inspect", "short.toml")
    uneven = part.read_text("utf-8").replace("15.0, 35.0", "15.0")
    Path("uneven.toml").write_text(uneven, encoding="utf-8")
    assert "5 places and 6 errors" in refused("inspect", "uneven.toml")
