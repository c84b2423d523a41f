"""A machine that has learnt the sample's first week."""

from pathlib import Path

import pytest

from tests.conftest import Cli, Once


@pytest.fixture
def recordings(sample_jobs: Path) -> Path:
    return sample_jobs / "stepped_shaft" / "recordings"


@pytest.fixture
def learnt(cli: Cli, recordings: Path, once: Once) -> Cli:
    """Return the command line on a machine that has learnt the sample's first week."""

    def learn() -> None:
        assert cli("init").code == 0
        assert cli("machine", "add", "lathe-1").code == 0
        files = ("standard-cuts.csv", "standard-cut-raw.parquet", "shop-week-1.csv")
        assert cli("import", *(recordings / f for f in files), "--machine", "lathe-1").code == 0
        assert cli("calibrate", "--machine", "lathe-1").code == 0
        assert cli("refresh", "--machine", "lathe-1").code == 0

    once(learn)
    return cli
