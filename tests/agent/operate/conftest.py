"""A machine that has learnt from recordings in a folder of its own."""

import shutil
from pathlib import Path

import pytest

from tests.conftest import Cli, Once


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
