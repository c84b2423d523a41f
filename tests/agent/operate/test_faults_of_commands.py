"""What judges the kills of every command: it finds what a careless command leaves."""

import sqlite3
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest

from autodb.cli import commands
from autodb.proofs.runs.keeping import commands_run
from autodb.proofs.runs.keeping.commands_run import Bench
from autodb.proofs.runs.keeping.commands_summary import KilledCommand, Twice, commands_summary_of
from autodb.proofs.runs.keeping.folders import folder_state, masks_of
from autodb.proofs.runs.keeping.forked import CASES
from autodb.proofs.runs.keeping.writing_commands import COMMANDS, Command
from autodb.proofs.runs.run_file import Finished, Origin
from autodb.store import create_store
from tests.helpers.campaigns import first

pytestmark = [
    pytest.mark.filterwarnings("ignore:This process .* is multi-threaded"),
    pytest.mark.usefixtures("made_anew"),
]
PAUSE_S = 0.1
ONLY_READ = {
    *(
        "look",
        "lookup",
        "plan",
        "life",
        "stability",
        "trace",
        "doctor",
        "sensors",
        "prove",
        "list",
        "show",
    ),
    *("agent", "serve"),  # go on until they are stopped, and are tested by themselves
}


@pytest.fixture
def judged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Callable[[Callable[[], object]], Bench]:
    """Return what makes a bench of a function, as if it were a command."""
    monkeypatch.setattr(commands_run, "CLOCK_S", 0.0)
    start = tmp_path / "start"
    start.mkdir()
    create_store(f"sqlite:///{start / 'autodb.sqlite3'}")
    with closing(_there(start)) as file:
        file.execute("CREATE TABLE notes (n INTEGER, at REAL)")
        file.commit()
    return lambda step: Bench(Command("careless", step), start, tmp_path / "work")


def _there(folder: Path) -> sqlite3.Connection:
    return sqlite3.connect(folder / "notes.sqlite3", timeout=10.0)


def _kills(bench: Bench) -> list[KilledCommand]:
    return [bench.killed(seed, from_write=True) for seed in range(3)]


def _careful() -> None:
    """Tell one row and its time, in one transaction."""
    with closing(_there(Path())) as file, file:
        file.execute("BEGIN IMMEDIATE")
        file.execute("DELETE FROM notes")
        file.execute("INSERT INTO notes VALUES (1, ?)", (time.time(),))
        time.sleep(PAUSE_S)


def test_a_careful_command_is_sound(judged: Callable[..., Bench]) -> None:
    bench = judged(_careful)
    for one in _kills(bench):
        assert not (one.unsound or one.other or one.stray or one.status), one
    twice = bench.twice()
    assert twice.sound
    assert twice.left_out == ("notes.at",)


def test_a_file_that_is_left_is_found(judged: Callable[..., Bench]) -> None:
    def leaves() -> None:
        part = Path(f".part-{time.time_ns()}")
        part.write_text("a")
        time.sleep(PAUSE_S)
        part.replace("a.txt")

    kills = _kills(judged(leaves))
    assert any(one.stray for one in kills)
    assert all(name.startswith(".part-") for one in kills for name in one.stray)
    assert all(bool(one.stray) == (one.case == CASES[1]) for one in kills)


def test_a_file_half_written_in_sight_is_found(judged: Callable[..., Bench]) -> None:
    def halves() -> None:
        with Path("a.txt").open("w") as file:
            for _ in range(3):
                file.write("a" * 100)
                file.flush()
                time.sleep(PAUSE_S)

    kills = _kills(judged(halves))
    assert [one.unsound for one in kills if one.unsound] == (
        [("a.txt: neither as it was nor as it is to be",)]
        * sum(one.case == CASES[1] for one in kills)
    )
    assert not any(one.other or one.stray for one in kills)


def test_rows_that_are_lost_or_count_twice_are_found(judged: Callable[..., Bench]) -> None:
    def adds() -> None:
        with closing(_there(Path())) as file:
            if file.execute("SELECT count(*) FROM notes").fetchone() == (2,):
                return
            for n in (1, 2):
                file.execute("INSERT INTO notes VALUES (?, 0.0)", (n,))
                file.commit()
                time.sleep(PAUSE_S)

    bench = judged(adds)
    assert {"notes.sqlite3: notes"} in [set(one.other) for one in _kills(bench)]
    assert not bench.twice().sound


def test_a_row_without_its_checksum_is_not_sound(judged: Callable[..., Bench]) -> None:
    def alters() -> None:
        with closing(sqlite3.connect("autodb.sqlite3")) as file:
            file.execute("DELETE FROM row_checksum")
            file.execute("INSERT OR REPLACE INTO row_checksum VALUES ('axis', 0, 1, 1)")
            file.commit()

    assert any("axis" in fault for fault in judged(alters).twice().unsound)


def test_every_command_that_writes_is_killed() -> None:
    """A new command stands in the list, or among those that only read."""
    asked = {one.words[:2] for one in COMMANDS if isinstance(one.words, tuple)}
    words = {word for pair in asked for word in pair}
    named: set[str] = set()
    for name, command in commands().commands.items():
        named |= set(getattr(command, "commands", {name}))
    assert {name for name in named if name not in words} == ONLY_READ & named
    assert len({one.name for one in COMMANDS}) == len(COMMANDS)


@pytest.mark.parametrize("name", first(1, ["import", "backup --replace", "mismatch confirm"]))
def test_kills_and_two_at_once_leave_what_one_leaves(name: str) -> None:
    """Some; `autodb prove faults-commands` has five hundred kills, of all commands."""
    command = next(one for one in COMMANDS if one.name == name)
    bench = Bench(command, commands_run.shop(large=False), commands_run.work())
    for seed in range(2):
        one = bench.killed(seed, from_write=seed > 0)
        assert not (one.unsound or one.other or one.stray), one
        assert one.status == 0, one
    twice = bench.twice()
    assert twice.sound, twice


def test_columns_that_differ_are_left_out_and_no_others(tmp_path: Path) -> None:
    folders = tmp_path / "a", tmp_path / "b"
    for at, folder in enumerate(folders):
        folder.mkdir()
        with closing(_there(folder)) as file:
            file.execute("CREATE TABLE notes (n INTEGER, at REAL)")
            file.executemany("INSERT INTO notes VALUES (?, ?)", [(1, at), (2, 0.5 + at)])
            file.commit()
        (folder / "page.html").write_text(f"<p>\nmade {at}\n</p>")
        (folder / "same.txt").write_text("same")
    masks = masks_of(*folders)
    assert masks == {"notes.sqlite3": {"notes.at"}, "page.html": {".line 2"}}
    assert folder_state(folders[0], masks) == folder_state(folders[1], masks)
    (folders[1] / "page.html").write_text("<b>\nmade 1\n</p>")
    assert folder_state(folders[0], masks) != folder_state(folders[1], masks)


def test_the_summary_fails_where_anything_was_found() -> None:
    killed = KilledCommand("refresh", CASES[1], (), (), (), 2, "")
    twice = Twice("refresh", (0, 2), (), (), (), "", ("notes.at",))
    origin = Origin("faults-commands", "1", "g", "p")

    def passes(*judged: KilledCommand | Twice) -> bool:
        return commands_summary_of([Finished(1, judged)], origin).passed

    assert passes(killed, twice)
    for worse in (
        {"unsound": ("x",)}, {"other": ("x",)}, {"stray": ("x",)}, {"status": 1},
        {"case": CASES[2]}, {"case": CASES[0]},
    ):  # fmt: skip
        assert not passes(replace(killed, **worse), twice)
    for codes in ((2, 2), (0, 1), (0, -14)):
        assert not passes(killed, replace(twice, statuses=codes))
    assert not passes(killed, replace(twice, stray=("x",)))
