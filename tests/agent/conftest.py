"""The sample lathe after a sound week, and after one of six small files in which edges wear."""

import shutil
from pathlib import Path

import pandas as pd
import pytest

from tests.conftest import Cli, Once

MACHINE = ("--machine", "lathe-1")
DAYS = tuple(f"day-{day}.csv" for day in range(6))


@pytest.fixture
def sound_week(cli: Cli, sample_jobs: Path, once: Once) -> Cli:
    """Return the command line on a lathe that has learnt a week, and the files of the next one.

    Six cuts each, two days an edge.
    """

    def learn() -> None:
        recordings = sample_jobs / "stepped_shaft" / "recordings"
        cli("init")
        cli("machine", "add", "lathe-1")
        for name in ("standard-cuts.csv", "shop-week-1.csv"):
            cli("import", recordings / name, *MACHINE)
        cli("calibrate", *MACHINE)
        done = cli("refresh", *MACHINE)
        assert "version 1 from 72 cuts" in done.out
        assert "usual state" not in done.out
        week = pd.read_csv(recordings / "shop-week-2.csv")
        for day, name in enumerate(DAYS):
            week.iloc[6 * day : 6 * day + 6].to_csv(name, index=False)

    once(learn)
    return cli


@pytest.fixture
def worn_days(sound_week: Cli, once: Once) -> Cli:
    """Return it once the six files came in; `said.txt` is what the refresh said."""
    before = Path.cwd()

    def refresh() -> None:
        shutil.copytree(before, ".", dirs_exist_ok=True)
        for name in DAYS:
            assert sound_week("import", name, *MACHINE).code == 0
        Path("said.txt").write_text(sound_week("refresh", *MACHINE).out)

    once(refresh)
    return sound_week
