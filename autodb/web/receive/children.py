"""Processes that read what was sent: started, listened to, and ended in time."""

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import IO, Any

from autodb.errors import UnusableInput
from autodb.files.units import shown_system
from autodb.web.http.logs import LOG
from autodb.web.http.responses import adapter
from autodb.web.http.settings import MIB, ReaderBounds
from autodb.web.receive.apart import AWAY, DONE, PROGRESS, REFUSED, Request, Task, received_line
from autodb.wording import Worded, language_of, msgid, phrase, presentation

STARTS = "import gc; gc.disable(); from autodb.web.receive import apart; gc.enable(); apart.main()"
"""What is loaded is no garbage: searched for, it takes a sixth of the time until a file is read."""
COMMAND = (sys.executable, "-P", "-c", STARTS)
LINE_MOST = 64 * MIB
"""Bytes of a line that a process says. Chosen: a program of some 50 000 lines that cut."""
TAIL = 4000
"""Characters of what it printed that are logged where it failed."""
THREADS = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")


@dataclass(frozen=True)
class FailedWords:
    """What is said of a process that broke (``{what}``, ``{how}``), took too long (``{what}``,
    ``{most}``), or was ended with the service.
    """

    broke: str
    late: str
    ended: str


OF_A_FILE = FailedWords(
    broke=msgid(
        "{what}: reading it broke the process that read it ({how}); send another copy, or run "
        "'autodb import' on the service's computer"
    ),
    late=msgid(
        "{what}: reading it takes longer than the {most} s that it may take; send it in parts"
    ),
    ended=msgid("the service ended before it was read; send it again"),
)


WHERE_NONE = msgid(
    "{what}: a service reads files on Unix alone (Linux, macOS); use the commands of 'autodb' on "
    "the service's computer"
)


class Unable(Exception):  # noqa: N818 - the name says what it is to the reader of the message
    """It could not be tried: the database is away, or the service ends.

    ``language``: the one that it is said in.
    """

    def __init__(self, line: str) -> None:
        self.language = language_of(line)
        super().__init__(line)


class Children:
    """Processes at work for one service; all of them end with it."""

    def __init__(self, url: str) -> None:
        self._url = url
        self._lock = threading.Lock()
        self._running: set[int] = set()
        self._closed = False

    @property
    def closed(self) -> bool:
        """Whether none is begun any more."""
        return self._closed

    def do(
        self,
        task: Task,
        kind: Any,
        bounds: ReaderBounds,
        tell: Callable[[str], None] = lambda _: None,
        *,
        failed: FailedWords = OF_A_FILE,
    ) -> Any:
        """Return what came of a task, of a type.

        Raises UnusableInput where it was refused, took too much or broke the process, and on a
        system that cannot bound one; Unable where it could not be tried.
        """
        if not hasattr(os, "killpg"):
            raise UnusableInput(phrase(WHERE_NONE, what=task.path.name))
        said: dict[str, Any] = {}
        with tempfile.TemporaryFile() as printed:
            with self._started(printed) as process, self._in_time(process.pid, bounds) as late:
                _ask(
                    process,
                    Request(self._url, bounds, task, presentation().language, shown_system()),
                )
                for key, value in _lines(process):
                    tell(value) if key == PROGRESS else said.update({key: value})
                os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
            if not said:
                status, name = process.returncode, task.path.name
                if not self._closed and (late.is_set() or status == -signal.SIGXCPU):
                    raise UnusableInput(phrase(failed.late, what=name, most=bounds.seconds))
                raise self._broken(name, status, printed, failed)
        if AWAY in said:
            raise Unable(Worded(*said[AWAY]))
        if REFUSED in said:
            raise UnusableInput(Worded(*said[REFUSED]))
        return adapter(kind).validate_python(said[DONE])

    @contextmanager
    def _started(self, printed: IO[bytes]) -> Iterator[subprocess.Popen[bytes]]:
        """Give a process, and end it with all that it started."""
        env = {name: value for name, value in os.environ.items() if name != "AUTODB_DB"} | THREADS
        with self._lock:
            if self._closed:
                raise Unable(phrase("the service ends; send it again when the service answers"))
            process = subprocess.Popen(
                COMMAND, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=printed,
                start_new_session=True, env=env,
            )  # fmt: skip
            self._running.add(process.pid)
        try:
            yield process
        finally:
            self._end(process.pid)
            with self._lock:  # from now on its number may be another's
                self._running.discard(process.pid)
                process.wait()
            for pipe in (process.stdin, process.stdout):
                assert pipe is not None
                with contextlib.suppress(BrokenPipeError):
                    pipe.close()

    @contextmanager
    def _in_time(self, pid: int, bounds: ReaderBounds) -> Iterator[threading.Event]:
        """Have a process ended when its time is over; give what says that it was."""
        late = threading.Event()

        def end() -> None:
            late.set()
            self._end(pid)

        timer = threading.Timer(bounds.seconds, end)
        timer.start()
        try:
            yield late
        finally:
            timer.cancel()

    def _end(self, pid: int) -> None:
        with self._lock, contextlib.suppress(ProcessLookupError):
            if pid in self._running:
                os.killpg(pid, signal.SIGKILL)

    def _broken(self, name: str, status: int, printed: IO[bytes], failed: FailedWords) -> Exception:
        """Return why a process said nothing of what came of its task."""
        if self._closed:
            return Unable(phrase(failed.ended))
        printed.seek(max(0, printed.seek(0, os.SEEK_END) - TAIL))
        text = printed.read().decode("utf-8", "replace")
        LOG.error("%s: status %d: %s", name, status, text)
        how = signal.Signals(-status).name if status < 0 else f"status {status}"
        return UnusableInput(phrase(failed.broke, what=name, how=how))

    def close(self) -> None:
        """End all of them, and begin none."""
        with self._lock:
            self._closed = True
            running = list(self._running)
        for pid in running:
            self._end(pid)


def _ask(process: subprocess.Popen[bytes], request: Request) -> None:
    assert process.stdin is not None
    with contextlib.suppress(BrokenPipeError):  # its status says how it ended
        process.stdin.write(adapter(Request).dump_json(request, exclude_defaults=True) + b"\n")
        process.stdin.close()


def _lines(process: subprocess.Popen[bytes]) -> Iterator[tuple[str, Any]]:
    """Give what a process says, until it says no more."""
    assert process.stdout is not None
    while line := process.stdout.readline(LINE_MOST):
        yield received_line(line)
