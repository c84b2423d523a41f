"""Reads what was sent in a bounded process of its own, which `children` starts.

It takes one request, a line of JSON on the standard input, and says lines of JSON: what it is at,
and last what came of it, or the one line why not. Nothing that is sent or said is unpickled.
"""

import json
import os
import signal
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, BinaryIO

from pydantic import TypeAdapter

from autodb.agent.answer.predicting import JobAnswer, answer_job
from autodb.agent.ingest.importing import Imported
from autodb.agent.operate.receiving import Sent, take_in_sent
from autodb.errors import UnusableInput
from autodb.files.excuses import excuse
from autodb.files.job import Job
from autodb.files.units import SI, presentation_of
from autodb.forward.stability.dynamics import ModeSection, of_modes, read_tool_point
from autodb.store import Store, file_of, on_server, open_store
from autodb.web.http.settings import MIB, ReaderBounds
from autodb.web.receive.looking import FileToLook
from autodb.wording import ENGLISH, Worded, language_of, presented
from autodb.wording.kept import said_again

Tell = Callable[[str], None]
PROGRESS, DONE, REFUSED, AWAY = "progress", "done", "refused", "away"
"""Keys of what it says: a step, an answer, why there is none, and why it could not be sought."""
AFTER_S = 5
"""How long after its time it ends by itself, where nobody is left to end it. Chosen."""


@dataclass(frozen=True)
class Import:
    """Import a recording that was sent."""

    sent: Sent

    @property
    def path(self) -> Path:
        """The file that is read."""
        return self.sent.path

    def do(self, store: Store, tell: Tell) -> bytes:
        """Return what came in, as JSON."""
        with presented(ENGLISH):  # the database is
            return TypeAdapter(Imported).dump_json(take_in_sent(store, self.sent, tell))


@dataclass(frozen=True)
class ProgramToPredict:
    """Predict a job with a program, which lies at ``path``; nothing is kept."""

    machine: str
    job: Job
    path: Path

    def do(self, store: Store, _tell: Tell) -> bytes:
        """Return the answer, as JSON; in it the program is called what the job calls it."""
        assert self.job.program is not None
        program = self.job.program.model_copy(update={"file": str(self.path)})
        job = self.job.model_copy(update={"program": program})
        with presented(ENGLISH):  # programs get the same answer
            answer = answer_job(store, self.machine, job)
        return TypeAdapter(JobAnswer).dump_json(replace(answer, job=self.job))


@dataclass(frozen=True)
class JobStability:
    """Say to what depth a job's cuts are stable; nothing is kept.

    ``dynamics``: the file of the tool point, or what its ``modes`` are called where they are
    stated.
    """

    machine: str
    job: Job
    dynamics: Path
    modes: tuple[ModeSection, ...] = ()

    @property
    def path(self) -> Path:
        """What a message calls it."""
        return self.dynamics

    def do(self, store: Store, _tell: Tell) -> bytes:
        """Return the answer, as JSON."""
        from autodb.agent.answer.bounds.stable import StableCut, stable_cuts
        from autodb.agent.answer.looking_up import PairReader

        stated = of_modes(self.modes, source=self.dynamics.name) if self.modes else None
        point = read_tool_point(self.dynamics) if stated is None else stated
        with presented(ENGLISH), store.reading() as session:  # programs get the same answer
            basis = PairReader(session, self.machine).basis(self.job.material, self.job.tool)
            found = stable_cuts(basis, self.job, point)
        return TypeAdapter(tuple[StableCut, ...]).dump_json(found)


@dataclass(frozen=True)
class MismatchToExplain:
    """Explain a mismatch' recordings against the machine's models now; nothing is kept."""

    mismatch: int
    path: Path

    def do(self, store: Store, _tell: Tell) -> bytes:
        """Return the report, a piece of a page, as JSON."""
        from autodb.agent.answer.pooled.pooling import explain_mismatch
        from autodb.agent.operate.deciding import (
            mismatch,  # what explains is heavy, and seldom asked for
        )
        from autodb.reports.explanation import explanation_fragment

        with presented(ENGLISH), store.reading() as session:  # as it would be kept
            explained = explain_mismatch(session, mismatch(session, self.mismatch))
        return _text(explanation_fragment(explained))


@dataclass(frozen=True)
class RecordingToShow:
    """Draw a recording over time, which lies at ``path``; nothing is kept."""

    machine: str
    recording: int
    path: Path

    def do(self, store: Store, _tell: Tell) -> bytes:
        """Return the plot, a piece of a page, as JSON."""
        from autodb.agent.answer.shown.recorded import course_of
        from autodb.agent.answer.shown.recordings import stored_recording
        from autodb.reports.recorded import plot_of_course

        with store.reading() as session:
            course = course_of(stored_recording(session, self.machine, self.recording))
        return _text(plot_of_course(course))


@dataclass(frozen=True)
class MachineToLearn:
    """Learn from what a machine's database has that is new: refresh it.

    ``calibrate``: its axes before that, on the cuts of which forces were measured.
    """

    machine: str
    calibrate: bool = False

    @property
    def path(self) -> Path:
        """What a message calls it."""
        return Path(self.machine.replace("/", "-"))

    def do(self, store: Store, tell: Tell) -> bytes:
        """Return what was learnt, as JSON; the service's own answers go before."""
        from autodb.agent.operate.refreshing import refresh  # heavy, and seldom asked for
        from autodb.agent.operate.scheduling import NICE
        from autodb.agent.sense.calibrating import calibrate_machine
        from autodb.web.receive.learnt import MachineLearnt

        os.nice(NICE)
        new: int | None = None
        left_out: tuple[str, ...] = ()
        with presented(ENGLISH):  # the database is
            if self.calibrate:
                made = calibrate_machine(store, self.machine, progress=tell)
                new, left_out = sum(made.new), tuple(made.left_out)
            report = refresh(store, self.machine, progress=tell)
            return TypeAdapter(MachineLearnt).dump_json(MachineLearnt(report, new, left_out))


Task = (
    Import | ProgramToPredict | JobStability | MismatchToExplain | RecordingToShow | FileToLook
    | MachineToLearn
)  # fmt: skip


@dataclass(frozen=True)
class Request:
    """What is to be done, with which database, within which bounds, and for whom it is said."""

    url: str
    bounds: ReaderBounds
    task: Task
    language: str = "en"
    units: str = SI


def main() -> None:
    """Do what is asked and say what came of it."""
    says = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print is no answer
    request = TypeAdapter(Request).validate_json(sys.stdin.buffer.readline())
    hold(request.bounds, largest_MiB=_size_MiB(request.url))
    with says, presented(presentation_of(request.language, request.units)):
        do_asked(request, says)


def hold(bounds: ReaderBounds, *, largest_MiB: int = 0) -> None:
    """Hold this process, and all that it starts, within bounds; nothing takes them back.

    ``largest_MiB``: size of the largest file that it writes to.
    """
    import resource  # Unix alone has it; who only imports this module needs none

    for kind, wanted in (
        (resource.RLIMIT_AS, bounds.memory_MiB * MIB),
        (resource.RLIMIT_CPU, bounds.seconds),
        (resource.RLIMIT_NOFILE, bounds.files),
        (resource.RLIMIT_FSIZE, (largest_MiB + bounds.grows_MiB) * MIB),
        (resource.RLIMIT_CORE, 0),
    ):
        hard = resource.getrlimit(kind)[1]
        most = wanted if hard == resource.RLIM_INFINITY else min(wanted, hard)
        resource.setrlimit(kind, (most, hard if kind == resource.RLIMIT_CPU else most))
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.alarm(bounds.seconds + AFTER_S)


def do_asked(request: Request, says: BinaryIO) -> None:
    """Do what is asked, and say how it goes and what came of it."""

    def say(key: str, value: bytes) -> None:
        says.write(b'{"%s":%s}\n' % (key.encode(), value))
        says.flush()

    try:
        store = open_store(request.url)
        try:
            say(DONE, request.task.do(store, lambda step: say(PROGRESS, _text(step))))
        finally:
            store.close()
    except MemoryError:
        say(REFUSED, _refusal(_too_much(request), "en"))
    except BrokenPipeError:
        raise SystemExit(1) from None  # nobody listens any more: nothing was written
    except Exception as error:
        said = excuse(error)
        if said is None:
            raise
        said = Worded(
            said.replace(f"{request.task.path.resolve().parent}/", ""), language_of(error)
        )
        if language_of(said) == "en":
            said = said_again(said)
        refused = REFUSED if isinstance(error, UnusableInput) else AWAY
        say(refused, _refusal(said, language_of(said)))


def _too_much(request: Request) -> str:
    return (
        f"{request.task.path.name}: reading it takes more than the {request.bounds.memory_MiB} "
        "MiB of memory allowed; send it in parts"
    )


def _text(said: str) -> bytes:
    return json.dumps(said).encode()


def _refusal(said: str, language: str) -> bytes:
    """Return why there is no answer, and the language that it is said in."""
    return json.dumps([said, language]).encode()


def _size_MiB(url: str) -> int:
    """Return the size of a database's file, rounded up; of one on a server nothing."""
    if on_server(url) or not file_of(url).is_file():
        return 0
    return file_of(url).stat().st_size // MIB + 1


def received_line(line: bytes) -> tuple[str, Any]:
    """Return a line that the process said: its key, and the value.

    Raises UnusableInput where it lost its way.
    """
    try:
        ((key, value),) = json.loads(line).items()
    except (ValueError, AttributeError):
        raise UnusableInput("the process that read it failed; send another copy") from None
    return str(key), value
