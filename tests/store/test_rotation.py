"""Backups by date: one when it is due, the oldest away after it is proven, one restored aside."""

from collections.abc import Callable
from contextlib import closing
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path

import pytest

from autodb.errors import UnusableInput
from autodb.store import create_store, head
from autodb.store.copies import connect
from autodb.store.rotation import Every, Rotated, age_words, dated, rotate
from tests.conftest import Cli
from tests.helpers.children import at_once

NOON = datetime(2026, 1, 1, 12, tzinfo=UTC)


@pytest.fixture
def url(tmp_path: Path) -> str:
    made = f"sqlite:///{tmp_path / 'a.sqlite3'}"
    create_store(made)
    (tmp_path / "backups").mkdir()
    return made


def _at(url: str, folder: Path, hours: float, *, keep: int | None, every: Every | None) -> Rotated:
    return rotate(url, folder, keep=keep, every=every, now=NOON + timedelta(hours=hours))


def test_one_is_made_when_it_is_due_and_the_oldest_go(url: str, tmp_path: Path) -> None:
    folder = tmp_path / "backups"
    (folder / "monday.sqlite3").touch()
    made = []
    for hours in range(0, 24 * 12, 6):  # a timer that is a minute early or late each time
        early = -1 / 60 if hours % 12 else 1 / 60
        if _at(url, folder, hours + early, keep=7, every=Every.DAY).copied:
            made.append(hours)
    assert made == [24 * day for day in range(12)]
    assert [one.at.day for one in dated(folder)] == [6, 7, 8, 9, 10, 11, 12]
    assert (folder / "monday.sqlite3").exists()
    assert _at(url, folder, 24 * 12, keep=2, every=None).removed == tuple(
        folder / f"autodb-202601{day:02}T120100Z.sqlite3" for day in range(6, 12)
    )
    assert len(_at(url, folder, 24 * 13, keep=None, every=None).there) == 3


@pytest.mark.parametrize(
    ("every", "early", "due"),
    [(Every.HOUR, 0.9, 0.91), (Every.DAY, 21.5, 21.7), (Every.WEEK, 151.0, 151.3)],
)
def test_it_is_due_a_tenth_early(
    url: str, tmp_path: Path, every: Every, early: float, due: float
) -> None:
    folder = tmp_path / "backups"
    assert _at(url, folder, 0.0, keep=3, every=every).copied
    assert not _at(url, folder, early - 0.01, keep=3, every=every).copied
    assert _at(url, folder, due, keep=3, every=every).copied


def test_a_clock_that_was_wrong_stops_no_backups(url: str, tmp_path: Path) -> None:
    folder = tmp_path / "backups"
    assert _at(url, folder, 24 * 365, keep=1, every=Every.DAY).copied
    done = _at(url, folder, 0.0, keep=1, every=Every.DAY)
    assert done.copied
    assert [one.at for one in dated(folder)] == [NOON]


def test_nothing_goes_before_the_new_one_is_proven(url: str, tmp_path: Path) -> None:
    folder = tmp_path / "backups"
    for hours in range(3):
        _at(url, folder, hours, keep=3, every=None)
    before = dated(folder)
    with closing(connect(tmp_path / "a.sqlite3")) as file:
        file.execute("CREATE VIEW foreign_to_it AS SELECT 1")
    with pytest.raises(UnusableInput, match="foreign_to_it"):
        _at(url, folder, 5.0, keep=1, every=Every.HOUR)
    assert dated(folder) == before


def test_what_a_killed_one_left_goes_although_none_is_due(url: str, tmp_path: Path) -> None:
    folder = tmp_path / "backups"
    for hours in range(4):
        _at(url, folder, hours, keep=None, every=None)
    done = _at(url, folder, 3.5, keep=3, every=Every.DAY)
    assert done.copied is None
    assert [one.name for one in done.removed] == ["autodb-20260101T120000Z.sqlite3"]
    assert dated(folder) == list(done.there)
    assert len(done.there) == 3


def test_what_a_killed_one_was_writing_goes_with_the_next(url: str, tmp_path: Path) -> None:
    folder = tmp_path / "backups"
    left = ".0123456789abcdef.partial.autodb-20260101T110000Z.sqlite3"
    others = {".0123456789abcdef.partial.monday.sqlite3", ".mine"}
    for name in (left, f"{left}-journal", ".autodb-20260101T110000Z.sqlite3.lock", *others):
        (folder / name).touch()
    assert _at(url, folder, 0.0, keep=2, every=Every.DAY).copied
    assert {one.name for one in folder.iterdir() if one.name.startswith(".")} == others


@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded")
def test_two_at_once_leave_as_many_as_are_kept(url: str, tmp_path: Path) -> None:
    folder = tmp_path / "backups"
    for hours in range(3):
        _at(url, folder, hours, keep=None, every=None)
    done = at_once(*(partial(_at, url, folder, hours, keep=3, every=None) for hours in (5.0, 6.0)))
    assert done == [0, 0]
    assert len(dated(folder)) == 3
    assert not [one for one in folder.iterdir() if one.name.startswith(".")]


def test_the_command_says_what_it_did(cli: Cli, refused: Callable[..., str]) -> None:
    cli("init")
    assert "no such folder" in refused("backup", "kept", "--keep", "2", "--every", "day")
    Path("kept").mkdir()
    done = cli("backup", "kept", "--keep", "2", "--every", "day")
    assert done.out == f"kept: a new one, 0 rows of 41 tables, schema {head()}; 1 there\n"
    assert (
        "1 there, the newest 0 min old: none is due" in cli("backup", "kept", "--every", "day").out
    )
    (one,) = dated(Path("kept"))
    one.path.rename("kept/autodb-20250101T000000Z.sqlite3")
    one.path.with_name("autodb-20250102T000000Z.sqlite3").write_bytes(
        Path("kept/autodb-20250101T000000Z.sqlite3").read_bytes()
    )
    assert "autodb-20250101T000000Z.sqlite3: removed" in cli("backup", "kept", "--keep", "2").out
    assert "use hour, day, week" in refused("backup", "kept", "--every", "year")
    assert "dated backups replace none" in refused("backup", "kept", "--keep", "2", "--replace")
    assert "use a new name, or a folder with --keep" in refused("backup", "kept")


def test_the_doctor_restores_the_newest_and_says_its_age(cli: Cli) -> None:
    cli("init")
    cli("machine", "add", "m")
    Path("kept").mkdir()
    none = cli("doctor", "--backups", "kept")
    assert none.code == 1
    assert (
        "kept: no backup there; make one with 'autodb backup kept --keep 7 --every day'" in none.out
    )
    cli("backup", "kept", "--keep", "2")
    (one,) = dated(Path("kept"))
    done = cli("doctor", "--backups", "kept")
    assert done.code == 0
    assert "restore of the newest backup: kept: 4 rows of one that is 0 min old" in done.out
    assert list(Path("kept").iterdir()) == [one.path]
    with closing(connect(one.path)) as file:
        file.execute("UPDATE row_checksum SET digest = digest + 1")
    spoilt = cli("doctor", "--backups", "kept")
    assert spoilt.code == 1
    assert "restore of the newest backup" in spoilt.out
    assert "axis, rows of id 1 to 255 changed after they were written" in spoilt.out
    with closing(connect(Path("autodb.sqlite3"))) as file:
        file.execute("CREATE VIEW foreign_to_it AS SELECT 1")
    assert "restore of the newest backup" in cli("doctor", "--backups", "kept").out
    assert "no such folder" in cli("doctor", "--backups", "none").out


@pytest.mark.parametrize(
    ("age", "words"),
    [
        (timedelta(seconds=20), "0 min"),
        (timedelta(minutes=119), "119 min"),
        (timedelta(hours=71), "71 h"),
        (timedelta(days=9.5), "9 days"),
    ],
)
def test_ages_are_said_in_words(age: timedelta, words: str) -> None:
    assert age_words(age) == words
