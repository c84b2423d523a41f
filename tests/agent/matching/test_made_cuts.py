"""A job is predicted, its cuts are made: they are matched."""

import json
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.conftest import Cli
from tests.helpers.made_cuts import (
    GROOVES,
    JOB,
    MACHINE,
    SHAFT,
    Columns,
    Row,
    import_and_match,
    import_and_refresh,
    links,
    predict_job,
    queried,
    scores,
    write_cuts,
)

if TYPE_CHECKING:
    pass

pytestmark = pytest.mark.usefixtures("one_law")


def test_cuts_without_names_are_told_by_what_was_cut(lathe: Cli) -> None:
    """The last cut of the job comes first, one is missing, one is none of the job."""
    import_and_match(lathe, write_cuts("made", [SHAFT[2], ("other", 30, 3.0, 0.2), SHAFT[0]]))
    by = "conditions"
    assert links() == {1: ("finish 39", by), 3: ("rough 56", by)}
    traced = lathe("trace", "prediction", 1).out
    assert "cut 'finish 39': cut 1 of recording 1, by conditions" in traced


@pytest.mark.parametrize(
    ("said", "columns"),
    [
        ('job = "grooves"\n', {"job.cut": ["right", "left"]}),
        ("", {"job": ["grooves", "grooves"], "job.cut": [2, 1]}),
    ],
    ids=["in the side file", "in columns"],
)
def test_a_recording_names_its_job_and_cuts(lathe: Cli, said: str, columns: Columns) -> None:
    """No condition tells the grooves apart, and another job has the same cuts."""
    predict_job(lathe, "grooves", GROOVES)
    predict_job(lathe, "slots", GROOVES)
    import_and_match(lathe, write_cuts("made", GROOVES, said, **columns))
    assert links() == {1: ("right", "name"), 2: ("left", "name")}
    assert queried("SELECT DISTINCT prediction_id FROM predicted_cut") == [(2,)]
    assert "job.block" not in queried("SELECT measured FROM cut")[0][0]


def test_two_jobs_that_fit_are_asked_about_and_a_word_settles_it(lathe: Cli) -> None:
    predict_job(lathe, "grooves", GROOVES)
    predict_job(lathe, "slots", GROOVES)
    said = import_and_refresh(lathe, write_cuts("made", GROOVES))
    (line,) = [line for line in said.splitlines() if "may be" in line]
    assert "recording 1: cuts 1, 2 may be of job 'slots' (prediction 3) or of job 'grooves'" in line
    assert "autodb predictions match --machine lathe --recording 1 --prediction NUMBER" in line
    assert links() == {}
    assert line in lathe("predictions", "match", *MACHINE).out
    done = lathe("predictions", "match", *MACHINE, "--recording", 1, "--prediction", 2)
    assert done.code == 0
    assert links() == {1: ("left", "stated"), 2: ("right", "stated")}
    assert scores(lathe)["scored"] == 2
    assert "no cut is open" in lathe("predictions", "match", *MACHINE).out


def test_two_cuts_that_fit_are_asked_about_and_a_word_settles_it(lathe: Cli) -> None:
    """One of two grooves was made."""
    predict_job(lathe, "grooves", GROOVES)
    said = import_and_match(lathe, write_cuts("made", GROOVES[:1]))
    assert "recording 1: cut 1 may be 'left' or 'right' of job 'grooves' (prediction 2)" in said
    which = ("--recording", 1, "--prediction", 2, "--cut", "1=right")
    assert lathe("predictions", "match", *MACHINE, *which).code == 0
    assert links() == {1: ("right", "stated")}


def test_a_larger_job_that_fits_more_of_the_cuts_is_the_one(lathe: Cli) -> None:
    predict_job(lathe, "rough only", SHAFT[:1])
    import_and_match(lathe, write_cuts("made", SHAFT))
    assert [name for name, _ in links().values()] == [name for name, *_ in SHAFT]
    assert queried("SELECT DISTINCT prediction_id FROM predicted_cut") == [(1,)]


def test_only_the_newest_prediction_before_a_recording_counts(lathe: Cli) -> None:
    """One of the same job that is younger than the recording, or older than another, does not."""
    predict_job(lathe, "shaft", SHAFT)
    table = write_cuts("made", SHAFT, 'start = "2999-01-01T08:00:00"\n')
    lathe("import", table, *MACHINE)
    predict_job(lathe, "shaft", SHAFT)
    with closing(sqlite3.connect("autodb.sqlite3")) as file:
        _unchecked(file, "UPDATE prediction SET created_at = '2999-01-01' WHERE id = 3")
    lathe("predictions", "match", *MACHINE)
    assert queried("SELECT DISTINCT prediction_id FROM predicted_cut") == [(2,)]


def test_a_recording_that_was_made_before_the_prediction_is_none_of_its(lathe: Cli) -> None:
    said = import_and_match(lathe, write_cuts("made", SHAFT, 'start = "2001-01-01T08:00:00"\n'))
    assert "no cut is open" in said
    assert links() == {}


def test_a_table_that_grows_is_matched_with_what_was_predicted_between(lathe: Cli) -> None:
    """One table a day: its last cut was made an hour after its start, and a job predicted between.

    A clock runs from the prediction at noon on.
    """
    with closing(sqlite3.connect("autodb.sqlite3")) as file:
        _unchecked(file, "UPDATE prediction SET created_at = '2001-01-01T12:00:00+00:00'")
    start = 'start = "2001-01-01T11:59:00+00:00"\n'
    import_and_match(lathe, write_cuts("made", SHAFT, start, t=[0, 30, 3600]))
    assert sorted(links()) == [3]


def _unchecked(file: sqlite3.Connection, statement: str) -> None:
    """Change a database whose rows have checksums as a clock that was set would have."""
    from autodb.store.rowsums import register

    register(file).execute(statement)
    file.commit()


def test_an_unknown_job_is_said_and_keeps_no_measurement_out(lathe: Cli) -> None:
    said = import_and_refresh(lathe, write_cuts("made", SHAFT, 'job = "shfat"\n'))
    assert "no prediction of job 'shfat' was made before it (did you mean shaft?)" in said
    assert "9 forces measured" in said
    assert links() == {}


def test_an_unknown_cut_of_a_named_job_is_said(lathe: Cli) -> None:
    columns = {"job.cut": ["rough 56", "rogh 48", "finish 39"]}
    said = import_and_match(lathe, write_cuts("made", SHAFT, 'job = "shaft"\n', **columns))
    assert "job 'shaft' (prediction 1) has no cut 'rogh 48' (did you mean rough 48" in said
    assert sorted(links()) == [1, 3]


def test_a_job_of_another_tool_is_said(lathe: Cli) -> None:
    table = write_cuts("made", SHAFT, 'job = "shaft"\n')
    side = table.with_suffix(".toml")
    side.write_text(side.read_text("utf-8").replace("insert", "other insert"), encoding="utf-8")
    said = import_and_match(lathe, table)
    assert "job 'shaft' (prediction 1) is for C45 / insert, not for C45 / other insert" in said


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (("--recording", 1), "--recording and --prediction go together"),
        (("--cut", "1=left"), "--cut goes with --recording and --prediction"),
        (("--recording", 1, "--prediction", 9), "machine 'lathe' has no prediction 9"),
        (("--recording", 9, "--prediction", 1), "machine 'lathe' has no recording 9"),
        (("--recording", 1, "--prediction", 1, "--cut", "one"), "--cut one: use NUMBER=NAME"),
        (("--recording", 1, "--prediction", 1, "--cut", "9=rough 56"), "recording 1 has no such"),
        (("--recording", 1, "--prediction", 1, "--cut", "1=rough"), "has no cut 'rough' (did you"),
        (("--recording", 1, "--prediction", 1), "no cut of recording 1 fits one of prediction 1"),
        (("--recording", 1, "--prediction", 2), "prediction 2 had learnt cut 1, 2 already"),
    ],
)
def test_what_cannot_be_matched_is_refused_in_one_line(
    lathe: Cli, refused: Callable[..., str], arguments: Row, line: str
) -> None:
    import_and_refresh(lathe, write_cuts("made", GROOVES))
    predict_job(lathe, "grooves", GROOVES)
    assert line in refused("predictions", "match", *MACHINE, *arguments)
    assert links() == {}


PART = (
    "G21 G18 G40 G95\nG97 S1200 M4\nG0 X56 Z2\nG1 Z-20 F0.2\nX61\nG0 Z2\nG0 X50\nG1 Z-10 F0.15\n"
    "X61\nM30\n"
)


def _predict_part(lathe: Cli) -> list[str]:
    """Predict the program; return its two lines that cut."""
    Path("o0012.nc").write_text(PART, encoding="utf-8")
    text = '\n[program]\nfile = "o0012.nc"\nstock_diameter_mm = 60\n'
    Path("part.toml").write_text(JOB.format(name="part", cuts=text), encoding="utf-8")
    ran = lathe("predict", "part.toml", *MACHINE, "--json")
    assert ran.code == 0, ran.err
    return [cut["name"] for cut in json.loads(ran.out)["cuts"]]


@pytest.mark.parametrize("program", ["O0012", "o12.nc", "C:\\\\nc\\\\O12.NC", "12"])
def test_lines_of_a_program_are_matched_by_their_number(lathe: Cli, program: str) -> None:
    names = _predict_part(lathe)
    cuts = (("", 50, 3.0, 0.15), ("", 56, 2.0, 0.2))
    columns = {"job.block": [8, 4]}
    import_and_match(lathe, write_cuts("made", cuts, f'program = "{program}"\n', **columns))
    assert links() == {1: (names[1], "name"), 2: (names[0], "name")}


@pytest.mark.parametrize(
    ("lasted_s", "fed_mm", "found"),
    [
        ([3.4, 5.1], (0.15, 0.2), [1, 0]),
        ([4.2, 5.1], (0.12, 0.2), [1, 0]),
        ([3.4, 9.0], (0.15, 0.2), [1, None]),
    ],
    ids=["as programmed", "feed overridden", "longer than any line"],
)
def test_lines_of_a_program_are_told_by_speed_and_how_long_they_took(
    lathe: Cli, lasted_s: list[float], fed_mm: tuple[float, float], found: list[int | None]
) -> None:
    """20 mm at 240 mm/min and 10 mm at 180 mm/min: 5 and 3.33 s."""
    names = _predict_part(lathe)
    cuts = (("", 50, 3.0, fed_mm[0]), ("", 56, 2.7, fed_mm[1]))
    columns: Columns = {"cut.duration": lasted_s, "spindle.speed": [1200, 1200]}
    import_and_match(lathe, write_cuts("made", cuts, "", **columns))
    matched = {k: (names[at], "conditions") for k, at in enumerate(found, 1) if at is not None}
    assert links() == matched
    expected = queried("SELECT expected FROM predicted_cut ORDER BY cut_id")
    assert bool(json.loads(expected[0][0])) == (fed_mm[0] == 0.15)
