"""The doctor passes what is sound and names what is ill."""

import shutil
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from autodb.store.copies import connect
from tests.conftest import Cli
from tests.helpers.kept import DB

pytestmark = pytest.mark.usefixtures("one_law")


def test_the_doctor_passes_what_is_sound(cli: Cli, recordings: Path) -> None:
    del recordings
    done = cli("doctor")
    assert done.code == 0
    assert "FAILED" not in done.out
    assert done.out.count("passed") == 13


def _ill(statement: str) -> None:
    with closing(connect(DB)) as connection:
        connection.execute(statement)


@pytest.mark.parametrize(
    ("statement", "says"),
    [
        ("DELETE FROM recording WHERE id = 1", "rows that point to no row: "),
        ("UPDATE cut SET measured = '{' WHERE id = 3", "unreadable JSON: cut 3: measured"),
        ("DELETE FROM calibration_recording", "derived rows without a source: calibration 1"),
        ("DELETE FROM prediction_parameters", "derived rows without a source: prediction 1"),
        ("UPDATE cut SET pair_id = NULL", "pairs nobody cut: pair 1: steel bar"),
        ("UPDATE alembic_version SET version_num = '0001'", "schema: 'autodb init'"),
    ],
)
def test_the_doctor_names_what_is_ill(
    cli: Cli, recordings: Path, statement: str, says: str
) -> None:
    del recordings
    _ill(statement)
    done = cli("doctor")
    assert done.code == 1
    assert says in done.out


def test_the_doctor_finds_recordings_missing_and_altered(cli: Cli, recordings: Path) -> None:
    with (recordings / "standard-cuts.csv").open("a") as file:
        file.write("\n")
    (recordings / "air-moves.csv").unlink()
    done = cli("doctor")
    assert done.code == 1
    assert f"recordings not on the disk: recording 1: {recordings / 'air-moves.csv'}" in done.out
    assert f"altered on the disk: recording 2: {recordings / 'standard-cuts.csv'}" in done.out


def test_a_stored_copy_stands_in_for_a_recording_that_is_gone(cli: Cli, recordings: Path) -> None:
    moved = recordings.parent / "kept.csv"
    shutil.move(recordings / "air-moves.csv", moved)
    assert cli("doctor").code == 1
    _ill(f"UPDATE recording SET stored_path = '{moved}', stored_sha256 = sha256 WHERE id = 1")
    assert cli("doctor").code == 0
    moved.write_text("something else")
    assert "altered on the disk: recording 1" in cli("doctor").out


def test_the_doctor_needs_a_database(refused: Callable[..., str]) -> None:
    assert "make one with 'autodb init'" in refused("doctor")
