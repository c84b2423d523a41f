"""Commands in forked processes: run to their end, killed at a moment, or two at once.

A process takes seconds to start and a fork of one that has imported everything a hundredth of that.
What is imported and not yet used is all that they share: each opens the database by itself.
"""

import os
import signal
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from autodb.errors import UnusableInput

Step = tuple[str, ...] | Callable[[], object]
"""The words of a command line, or what else is to be done in a folder."""
LONGEST_S = 300
"""After which a command is taken to hang: SIGALRM ends it. Chosen: ten times the longest."""
LOOK_S = 0.0005
SHARED = "-shm"
"""Ending of the file by which those who have a database open share its log: also of readers."""
LOG = "-wal"
Seen = dict[str, tuple[int, int, int]]
CASES = ("before its first write", "after its first write", "it had ended")


@dataclass(frozen=True)
class Times:
    """Seconds from the fork to the first write of a command that nobody disturbs, and in all."""

    to_write_s: float
    took_s: float


def needs_forks() -> None:
    """Raise UnusableInput where no process can be forked."""
    if not hasattr(os, "fork"):
        raise UnusableInput("this proof needs a system that can fork; use Linux or macOS")


def finished(folder: Path, step: Step) -> int:
    """Run a step in a folder to its end; return its exit status, negative for a signal."""
    return _status(_begun(folder, step))


def timed(folder: Path, step: Step) -> tuple[int, Times]:
    """Run a step to its end; return its exit status, and when it first wrote and was done."""
    before, start = seen_now(folder), time.perf_counter()
    child = _begun(folder, step)
    status, to_write_s = _until_it_writes(child, folder, before), time.perf_counter() - start
    if status is None:
        status = _status(child)
    return status, Times(to_write_s, time.perf_counter() - start)


def killed(folder: Path, step: Step, delay_s: float, *, from_write: bool) -> str:
    """Kill a step, a delay after its start or its first write; return which of CASES it was."""
    before = seen_now(folder)
    child = _begun(folder, step)
    if from_write and _until_it_writes(child, folder, before) is not None:
        return CASES[2]
    time.sleep(delay_s)
    os.kill(child, signal.SIGKILL)  # of one that has ended, and was not waited for, nothing
    if _status(child) != -signal.SIGKILL:
        return CASES[2]
    return CASES[seen_now(folder) != before]


def two_at_once(folder: Path, step: Step) -> list[int]:
    """Run a step twice at the same time; return both exit statuses."""
    reads, writes = os.pipe()
    children = [_begun(folder, step, gate=(reads, writes)) for _ in range(2)]
    os.close(reads)
    os.close(writes)  # both read the end of the pipe now, and begin
    return [_status(child) for child in children]


def seen_now(folder: Path) -> Seen:
    """Return what lies in a folder, but for what those who only read a database make."""
    seen: Seen = {}
    folders = [str(folder)]
    while folders:
        with suppress(FileNotFoundError), os.scandir(folders.pop()) as entries:  # it has just gone
            for entry in entries:
                found = entry.stat(follow_symlinks=False)
                if entry.is_dir(follow_symlinks=False):
                    folders.append(entry.path)
                elif not entry.name.endswith(SHARED) and (
                    found.st_size or not entry.name.endswith(LOG)
                ):
                    seen[entry.path] = (found.st_size, found.st_mtime_ns, found.st_ino)
    return seen


def _until_it_writes(child: int, folder: Path, before: Seen) -> int | None:
    """Wait until a folder changes; return a child's exit status where it ends without."""
    while seen_now(folder) == before:
        done, how = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(how)
        time.sleep(LOOK_S)
    return None


def _status(child: int) -> int:
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def _begun(folder: Path, step: Step, gate: tuple[int, int] | None = None) -> int:
    """Fork a step; it begins once nobody can write to its gate any more."""
    child = os.fork()
    if child:
        return child
    status = 1
    try:
        signal.alarm(LONGEST_S)
        os.environ.pop("AUTODB_DB", None)
        os.chdir(folder)
        _say_beside(folder)
        if gate is not None:
            os.close(gate[1])
            os.read(gate[0], 1)
        status = _done(step)
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(status)


def _done(step: Step) -> int:
    """Run a step; the command line stands above the proofs, which are commands of it."""
    if callable(step):
        step()
        return 0
    return int(import_module("autodb.cli").run(list(step)))


def said(folder: Path) -> str:
    """Return what the last steps in a folder said of errors."""
    return _beside(folder).read_text("utf-8", errors="replace")


def _beside(folder: Path) -> Path:
    return folder.with_name(f"{folder.name}-said.txt")


def _say_beside(folder: Path) -> None:
    """Send answers nowhere, and errors into a file beside the folder."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    os.dup2(os.open(_beside(folder), os.O_WRONLY | os.O_CREAT | os.O_TRUNC), 2)
