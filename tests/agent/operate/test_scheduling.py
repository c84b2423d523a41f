"""What makes a computer refresh a machine by itself: read back as systemd, cron and a shell do."""

import configparser
import re
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest

from autodb.agent.operate.scheduling import (
    EVERY_H,
    EVERY_MIN,
    NICE,
    cron_line,
    slug,
    systemd_units,
)
from autodb.errors import UnusableInput
from tests.conftest import Cli

AWKWARD = ["/opt/my tools/python", "-m", "autodb", "100 % \"Öl\" 'x' $HOME \\n", "a%b"]


@pytest.mark.parametrize("every_min", [*EVERY_MIN, *(60 * hours for hours in EVERY_H)])
def test_a_line_of_cron_comes_as_often_as_asked(every_min: int) -> None:
    minute, hour, *rest = cron_line(["run"], every_min=every_min).split()[:5]
    assert rest == ["*", "*", "*"]
    times = [
        60 * h + m
        for h in range(24)
        for m in range(60)
        if _matches(hour, h) and _matches(minute, m)
    ]
    gaps = {(b - a) % 1440 or 1440 for a, b in zip(times, times[1:] + times[:1], strict=True)}
    assert gaps == {every_min}


def _matches(field: str, value: int) -> bool:
    if field == "*":
        return True
    return value % int(field[2:]) == 0 if field.startswith("*/") else value == int(field)


def test_a_shell_reads_the_words_of_a_cron_line_back() -> None:
    line = cron_line(AWKWARD, every_min=15).split(maxsplit=5)[5]
    assert re.search(r"(?<!\\)%", line) is None  # cron ends the command there
    assert shlex.split(line.replace(r"\%", "%")) == ["nice", "-n", f"{NICE}", *AWKWARD]


@pytest.mark.parametrize("every_min", [7, 25, 90, 300])
def test_what_cron_cannot_say_is_refused(every_min: int) -> None:
    with pytest.raises(UnusableInput, match=rf"--every {every_min}: cron cannot say it"):
        cron_line(["run"], every_min=every_min)


def test_systemd_finds_nothing_wrong_with_the_units(tmp_path: Path) -> None:
    verify = shutil.which("systemd-analyze")
    if verify is None:
        pytest.skip("systemd-analyze is not here")
    python = shutil.which("python3") or "/usr/bin/python3"
    units = systemd_units("Fräse 1 100 %", [python, *AWKWARD[1:]], every_min=15)
    for name, text in units.files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    done = subprocess.run(
        [verify, "verify", "--user", *(str(tmp_path / name) for name in units.files)],
        capture_output=True, text=True, check=False, env={"XDG_RUNTIME_DIR": str(tmp_path)},
    )  # fmt: skip
    said = [line for line in done.stderr.splitlines() if "autodb" in line]
    assert not said


def test_other_machines_have_other_units() -> None:
    names = ["lathe-1", "lathe 1", "lathe/1", "Fräse"]
    assert len({slug(name) for name in names}) == len(names)
    assert all(re.fullmatch(r"[A-Za-z0-9_.-]+", slug(name)) for name in names)


def test_the_command_writes_units_that_name_everything_by_its_whole_path(cli: Cli) -> None:
    cli("init")
    cli("machine", "add", "lathe-1")
    Path("in").mkdir()
    Path("units").mkdir()
    done = cli("schedule", "--machine", "lathe-1", "--inbox", "in", "--out", "units")
    assert done.code == 0, done.err
    assert "systemctl --user" in done.out
    parsed = configparser.ConfigParser(interpolation=None)
    parsed.optionxform = str  # type: ignore[assignment, method-assign]
    parsed.read("units/autodb-refresh-lathe-1.service", encoding="utf-8")
    words = shlex.split(parsed["Service"]["ExecStart"])
    assert words[words.index("--inbox") + 1] == str(Path("in").resolve())
    assert words[words.index("--db") + 1] == f"sqlite:///{Path('autodb.sqlite3').resolve()}"
    printed = cli("schedule", "--machine", "lathe-1", "--inbox", "in", "--cron", "--every", 60).out
    assert printed.startswith("0 * * * * ")

    # What the line runs works from anywhere
    elsewhere = Path("elsewhere")
    elsewhere.mkdir()
    command = printed.split(maxsplit=5)[5].replace(r"\%", "%")
    ran = subprocess.run(
        ["/bin/sh", "-c", command],
        cwd=elsewhere,
        env={},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    assert "nothing new" in ran.stdout


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (("--machine", "lathe-2", "--inbox", "in"), "no machine 'lathe-2'"),
        (("--machine", "lathe-1", "--inbox", "out"), "out: no such folder"),
        (
            ("--machine", "lathe-1", "--inbox", "in", "--cron", "--out", "in"),
            "--out is for systemd",
        ),
    ],
)
def test_what_could_not_run_is_refused(cli: Cli, options: tuple[str, ...], line: str) -> None:
    cli("init")
    cli("machine", "add", "lathe-1")
    Path("in").mkdir()
    done = cli("schedule", *options)
    assert done.code == 2
    assert line in done.err
