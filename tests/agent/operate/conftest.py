"""A machine that has learnt from recordings in its folder, and one with a symmetric axis."""

import shutil
from pathlib import Path

import pytest

from tests.conftest import Cli, Once
from tests.helpers.uneven_axis import write_uneven


@pytest.fixture
def recordings(cli: Cli, sample_jobs: Path, once: Once) -> Path:
    """Return a folder of our own with recordings that the machine in the database has learnt."""

    def learn() -> None:
        source = sample_jobs / "stepped_shaft" / "recordings"
        folder = Path("recordings").absolute()
        folder.mkdir()
        for name in ("standard-cuts.csv", "air-moves.csv"):
            shutil.copy(source / name, folder / name)
        cli("init")
        cli("machine", "add", "lathe-1", "--file", sample_jobs / "stepped_shaft" / "machine.toml")
        cli("import", *sorted(folder.iterdir()), "--machine", "lathe-1")
        cli("calibrate", "--machine", "lathe-1")
        cli("identify", folder / "air-moves.csv", "--machine", "lathe-1")
        cli("refresh", "--machine", "lathe-1")
        job = sample_jobs / "stepped_shaft" / "job.toml"
        assert cli("predict", job, "--machine", "lathe-1").code == 0

    return once(learn) / "recordings"


@pytest.fixture
def machine(cli: Cli, once: Once) -> Cli:
    """Return the command line beside a machine whose first model is symmetric."""

    def identify() -> None:
        Path("m.toml").write_text("[axes.x]\n")
        cli("init")
        cli("machine", "add", "mill", "--file", "m.toml")
        done = cli("identify", write_uneven("a.csv", 1), "--machine", "mill")
        assert "x.current: version 1 of machine 'mill'" in done.out

    once(identify)
    return cli
