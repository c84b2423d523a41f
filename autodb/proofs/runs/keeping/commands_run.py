"""Every command that writes: killed at a random moment and run again, and run twice at once.

Twice undisturbed, from the same beginning, a command shows what it leaves and where that carries
a clock; then a third time, after itself, what it leaves when it is repeated. Whatever is done to
it, it must end in one of the two. SIGKILL comes at a moment drawn uniformly over the time of an
undisturbed run, or, twice as often, over what follows its first write.
"""

import importlib
import pkgutil
import shutil
import tempfile
import time
from functools import cache
from pathlib import Path

import numpy as np
from sqlalchemy.orm import configure_mappers

import autodb
from autodb.proofs.runs.keeping.commands_summary import FINE, KilledCommand, Twice
from autodb.proofs.runs.keeping.folders import DATABASE, State, faults_of, folder_state, masks_of
from autodb.proofs.runs.keeping.forked import (
    Step,
    finished,
    killed,
    needs_forks,
    said,
    timed,
    two_at_once,
)
from autodb.proofs.runs.keeping.writing_commands import COMMANDS, FIRST, Command, furnish, grow

TURNS_A_TWICE = 6
"""Every so many kills of a command come with two of it at once."""
WHOLE = 3
"""Of so many kills of a command one is drawn over the whole of it."""
ROTA = (*(3 * [one for one in COMMANDS if not one.seldom]), *(c for c in COMMANDS if c.seldom))
"""The order in which commands have their turn, over and over."""
CLOCK_S = 1.1
"""After which a time in whole seconds is another."""
NOT_NEEDED = ("autodb.web.client", "autodb.agent.fleet.clusters", "autodb.sensing.network")


def run_commands(seed: int) -> list[KilledCommand | Twice]:
    """Kill the command whose turn it is, and now and then run two of it at once.

    Raises UnusableInput where no process can be forked.
    """
    needs_forks()
    command, turn = drawn(seed)
    bench = _bench(command)
    judged: list[KilledCommand | Twice] = [bench.killed(seed, from_write=turn % WHOLE > 0)]
    if turn % TURNS_A_TWICE == 0:
        judged.append(bench.twice())
    return judged


def drawn(seed: int) -> tuple[Command, int]:
    """Return the command whose turn it is, and how often it has been so before."""
    before = [ROTA[k % len(ROTA)] for k in range(seed)]
    return before[-1], before.count(before[-1]) - 1


@cache
def _bench(command: Command) -> "Bench":
    start = shop(large=command.large)
    return Bench(command, start, work())


@cache
def _home() -> "tempfile.TemporaryDirectory[str]":
    return tempfile.TemporaryDirectory(prefix="autodb-commands-")


def work() -> Path:
    """Return the folder of all commands: recordings are known by where they lie."""
    return Path(_home().name) / "work"


@cache
def shop(*, large: bool) -> Path:
    """Make the shop that commands begin in; with a large database, or not. Return its folder."""
    _import_all()
    if large:
        _copied(shop(large=False), work())
        _do(work(), grow)
        return _copied(work(), Path(_home().name) / "large")
    work().mkdir()
    furnish(work())
    for step in FIRST:
        _do(work(), step)
    return _copied(work(), Path(_home().name) / "small")


class Bench:
    """A command, the folder that it begins in, and what it leaves there undisturbed."""

    def __init__(self, command: Command, start: Path, work: Path) -> None:
        self._command, self._work = command, work
        home = Path(tempfile.mkdtemp(prefix="bench-", dir=start.parent))
        self._base, self._copies = home / "base", home
        self._masks: dict[str, frozenset[str]] = {}
        _copied(start, self._work)
        for step in command.before:
            _do(self._work, step)
        _copied(self._work, self._base)
        self._learn(home / "once")

    def _learn(self, once: Path) -> None:
        """Run the command undisturbed: twice from the beginning, and once more after itself."""
        _do(self._work, self._command.words)
        _copied(self._work, once)
        _copied(self._base, self._work)
        time.sleep(CLOCK_S)
        status, self._times = timed(self._work, self._command.words)
        assert status == 0, said(self._work)
        self._masks = masks_of(once, self._work)
        self._before = folder_state(self._base, self._masks)
        self._wanted = [folder_state(once, self._masks)]
        assert self._state() == self._wanted[0], self._command.name
        assert finished(self._work, self._command.words) in FINE, said(self._work)
        again = self._state()
        assert self._command.again or again == self._wanted[0], self._command.name
        self._wanted.append(again)
        shutil.rmtree(once)

    def killed(self, seed: int, *, from_write: bool) -> KilledCommand:
        """Kill the command at the moment that a seed draws, look, run it again and compare."""
        _copied(self._base, self._work)
        to_write_s = self._times.to_write_s if from_write else 0.0
        draw = np.random.default_rng([seed, 32])
        delay_s = float(draw.uniform(0.0, self._times.took_s - to_write_s))
        case = killed(self._work, self._command.words, delay_s, from_write=from_write)
        unsound = faults_of(self._work, self._copies) + self._halves()
        status = finished(self._work, self._command.words)
        words = "" if status in FINE else said(self._work)[-500:]
        rows, files = self._compared()
        return KilledCommand(self._command.name, case, tuple(unsound), rows, files, status, words)

    def twice(self) -> Twice:
        """Run two of the command at once and compare."""
        _copied(self._base, self._work)
        statuses = two_at_once(self._work, self._command.words)
        words = "" if set(statuses) <= set(FINE) else said(self._work)[-500:]
        unsound = faults_of(self._work, self._copies)
        rows, files = self._compared()
        rows = tuple(name for name in rows if name.rpartition(": ")[2] not in self._command.shared)
        return Twice(
            self._command.name,
            tuple(statuses),
            tuple(unsound),
            rows,
            files,
            words,
            self._left_out(),
        )

    def _left_out(self) -> tuple[str, ...]:
        """Return the columns that are not compared, and the files with such lines."""
        names = {
            file if column.startswith(".") else column
            for file, columns in self._masks.items()
            for column in columns
        }
        return tuple(sorted(names))

    def _state(self) -> State:
        return folder_state(self._work, self._masks)

    def _halves(self) -> list[str]:
        """Return files in sight that are neither as before the command nor as after it."""
        return [
            f"{name}: neither as it was nor as it is to be"
            for name, digest in folder_state(self._work, self._masks, is_in_sight).items()
            if not any(state.get(name) == digest for state in (self._before, *self._wanted))
        ]

    def _compared(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Return what holds something else than wanted, and which files are too many or too few.

        Each file must be as the command leaves it run once, or run again: of two at once that write
        one more row each, either may be the last to write its page.
        """
        now, wanted = _by_file(self._state()), [_by_file(want) for want in self._wanted]
        every = {name for want in wanted for name in want}
        always = {name for name in every if all(name in want for want in wanted)}
        other = {
            part
            for name in now.keys() & every
            if now[name] not in [want.get(name) for want in wanted]
            for part in now[name].keys() | wanted[-1].get(name, {}).keys()
            if now[name].get(part) != wanted[-1].get(name, {}).get(part)
        }
        stray = (now.keys() - every) | (always - now.keys())
        return tuple(sorted(other)), tuple(sorted(stray))


def _by_file(state: State) -> dict[str, dict[str, str]]:
    """Return a state by file: a database's tables together."""
    found: dict[str, dict[str, str]] = {}
    for name, digest in state.items():
        found.setdefault(name.partition(": ")[0], {})[name] = digest
    return found


def is_in_sight(name: str) -> bool:
    """Say whether a file is no database, nor its log, and neither it nor its folder is hidden."""
    return DATABASE not in name and not any(part.startswith(".") for part in Path(name).parts)


def _do(folder: Path, step: Step) -> None:
    """Run a step that must work."""
    status = finished(folder, step)
    assert status == 0, f"{step}: exit {status}: {said(folder)}"


def _copied(source: Path, target: Path) -> Path:
    """Make a folder another's copy; return it."""
    if target.exists():
        shutil.rmtree(target)
    shutil.copytree(source, target)
    return target


def _import_all() -> None:
    """Import the program, so that no child has to: its time is the command's."""
    importlib.import_module("alembic.command")
    configure_mappers()
    for module in pkgutil.walk_packages(autodb.__path__, "autodb."):
        if not module.name.startswith(NOT_NEEDED) and not module.name.endswith("__main__"):
            importlib.import_module(module.name)
