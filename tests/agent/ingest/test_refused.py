"""What the command line refuses of a machine, and the line that says so."""

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.conftest import Cli

pytestmark = pytest.mark.usefixtures("one_law")

REFUSALS: list[tuple[tuple[str, ...], str]] = [
    (("refresh", "--machine", "lathe-2"), "no machine 'lathe-2' (did you mean lathe-1?)"),
    (("predict", "none.toml", "--machine", "lathe-1"), "none.toml: no such file"),
    (("trace", "predicton", "1"), "did you mean prediction"),
    (("trace", "prediction", "77"), "there is no prediction 77"),
    (("explain", "a.csv", "--machine", "lathe-1", "--includes", "coulomb"), "--includes goes with"),
    (("calibrate", "--machine", "lathe-1", "--protocol", "nope"), "no protocol 'nope'"),
]


@pytest.mark.parametrize(("arguments", "says"), REFUSALS)
def test_refusals(
    learnt: Cli, refused: Callable[..., str], arguments: tuple[str, ...], says: str
) -> None:
    del learnt
    assert says in refused(*arguments)


BAD_JOBS = [
    ("", "name: is missing"),
    ('name = "a"\nmaterial = "b"\ntool = "c"\n', "give either [[cut]] or [program]"),
    (
        'name = "a"\nmaterial = "b"\ntool = "c"\n[[cut]]\ndiameter_mm = 50\ndepth_mm = -1\n'
        "feed_mm_rev = 0.2\nspeed_rpm = 900\n",
        "cut.1.depth_mm",
    ),
    (
        'name = "a"\nmaterial = "b"\ntool = "c"\n[[cut]]\ndiameter_mm = 50\ndepth_mm = 1\n'
        "feed_mm_rev = 0.2\n",
        "give either speed_rpm or speed_m_min",
    ),
    ("name = \n", "not a readable TOML file"),
]


@pytest.mark.parametrize(("text", "says"), BAD_JOBS)
def test_bad_jobs_name_the_key(
    learnt: Cli, refused: Callable[..., str], tmp_path: Path, text: str, says: str
) -> None:
    del learnt
    job = tmp_path / "job.toml"
    job.write_text(text)
    assert says in refused("predict", job, "--machine", "lathe-1")


def test_before_init_the_way_out_is_named(refused: Callable[..., str]) -> None:
    assert "make one with 'autodb init'" in refused("refresh", "--machine", "a")


def test_a_machine_file_gives_the_axes(cli: Cli, refused: Callable[..., str]) -> None:
    Path("m.toml").write_text(
        '[axes.x]\ncarries = "work"\ncurrent_sign = -1\n[axes.z]\n[axes.spindle]\n'
    )
    assert cli("init").code == 0
    assert "added (x, z, spindle)" in cli("machine", "add", "m", "--file", "m.toml").out
    assert "there already and differs (axes.x.carries: work → tool" in refused(
        "machine", "add", "m"
    )
    Path("m.toml").write_text('[axes.x]\ncarries = "everything"\n')
    assert "axes.x.carries" in refused("machine", "add", "n", "--file", "m.toml")


def test_what_cannot_be_written_says_so(
    learnt: Cli, refused: Callable[..., str], recordings: Path
) -> None:
    del learnt
    Path("file.txt").write_text("a file")
    worn = recordings / "shop-week-2.csv"
    line = refused("explain", worn, "--machine", "lathe-1", "--out", "file.txt/answer")
    assert "file.txt" in line


def test_machines_need_a_name_and_axes(cli: Cli, refused: Callable[..., str]) -> None:
    cli("init")
    assert "needs a name" in refused("machine", "add", "  ")
    Path("m.toml").write_text("[axes]\n")
    assert "needs axes" in refused("machine", "add", "m", "--file", "m.toml")
    assert "in memory keeps nothing" in refused("init", "--db", "sqlite://")


def test_a_misspelt_column_is_pointed_at(refused: Callable[..., str], tmp_path: Path) -> None:
    typo = tmp_path / "typo.csv"
    typo.write_text("t,x.position,x.curent\n0,1,1\n1,2,1\n2,3,1\n")
    assert "did you mean x.curent?" in refused("identify", typo)
    bare = tmp_path / "bare.csv"
    bare.write_text("cut,t,z.current\n1,0,2\n2,1,3\n")
    assert "no channel force.x, force.y or force.z" in refused("calibrate", bare)
    short = tmp_path / "short.csv"
    short.write_text("t,x.position,x.current\n0,1,1\n1,2,1\n2,3,1\n")
    assert "record at least 100" in refused("identify", short)


def test_what_is_no_recording_is_not_read_as_its_side_file(
    cli: Cli, refused: Callable[..., str], sample_jobs: Path
) -> None:
    cli("init")
    cli("machine", "add", "lathe-1")
    job = sample_jobs / "stepped_shaft" / "job.toml"
    assert "a side file; give the recording" in refused("import", job, "--machine", "lathe-1")


def test_usage_errors_exit_with_2(cli: Cli) -> None:
    assert cli("import").code == 2
    assert cli("nonsense").code == 2
    assert cli("--help").code == 0
