"""The demo, and the sample recordings it learns from."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from numpy.testing import assert_allclose

from autodb.cli.start import demo
from autodb.proofs.machines.sample import write_sample
from autodb.records import source as records
from autodb.reports.written import LIBRARY
from tests.conftest import Cli

SAMPLE = (
    *(f"stepped_shaft/recordings/{name}" for name in (
        "standard-cuts.csv", "shop-week-1.csv", "shop-week-2.csv", "air-moves.csv",
        "standard-cut-raw.parquet",
    )),
    "facing/recordings/facing-week.csv",
    "contour/recordings/contour-week.csv",
)  # fmt: skip


@pytest.fixture(scope="module")
def rewritten(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sample")
    write_sample(folder)
    return folder


@pytest.mark.parametrize("name", SAMPLE)
def test_the_sample_is_what_the_virtual_lathe_writes(
    rewritten: Path, sample_jobs: Path, name: str
) -> None:
    ours = records.read(sample_jobs / name)
    theirs = records.read(rewritten / name)
    assert list(ours.channels) == list(theirs.channels)
    assert ours.texts == theirs.texts
    for channel, values in ours.channels.items():
        assert_allclose(theirs[channel], values, rtol=1e-5, atol=1e-5)


def test_the_demo_takes_the_place_of_an_earlier_one_and_its_report_needs_no_network(
    cli: Cli,
) -> None:
    """In the place of one that was there already; in an empty folder: tests/whole/test_wheel.py."""
    Path("out").mkdir()
    for name in (demo.MARK, demo.REPORT, "autodb.sqlite3"):
        (Path("out") / name).touch()
    done = cli("demo", "--out", "out")
    assert done.code == 0
    for part in (
        "axis: ",
        " forces measured, ",
        "predicted: rough Ø56",
        "tool_wear",
        "trace: ",
        "report: ",
        "job:       out/job.toml",
    ):
        assert part in done.out
    report = Path("out/report.html").read_text()
    page = re.sub(r"<script.*?</script>", "", report, flags=re.DOTALL)
    assert not re.search(r"""(src|href)=["'](https?:)?//|@import|url\(""", page)
    loaded = re.findall(r"""<script[^>]+src=["']([^"']+)""", report)
    assert loaded == [LIBRARY]
    assert Path("out", LIBRARY).exists()
    assert len(report) < 500_000
    assert "What the simulation left out" in report
    held = re.search(r"(\d+) of (\d+)", report)
    assert held is not None
    assert int(held[1]) >= 0.85 * int(held[2])  # the spindle's reading wanders within the day
    assert cli("predict", "out/job.toml", "--db", "sqlite:///out/autodb.sqlite3").code == 0
    traced = cli("trace", "prediction", 1, "--db", "sqlite:///out/autodb.sqlite3")
    assert "shop-week-1.csv" in traced.out


def test_a_demo_that_ends_early_leaves_the_one_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    earlier = tmp_path / "out"
    earlier.mkdir()
    for name in (demo.MARK, demo.REPORT):
        (earlier / name).touch()

    def ends(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(demo, "learn_from_samples", ends)
    with pytest.raises(KeyboardInterrupt):
        demo.run_demo(earlier, progress=lambda _: None)
    assert sorted(one.name for one in earlier.iterdir()) == [demo.MARK, demo.REPORT]
    assert list(tmp_path.iterdir()) == [earlier]


def test_the_demo_keeps_a_folder_that_is_not_its_own(cli: Cli, refused: Callable[..., str]) -> None:
    del cli
    Path("mine").mkdir()
    Path("mine/thesis.txt").write_text("years of work")
    assert "holds other files" in refused("demo", "--out", "mine")
    assert Path("mine/thesis.txt").exists()
