"""A client of the service: what the library answers, over HTTP.

    with Client("http://127.0.0.1:8321") as shop:
        found = shop.look_up("lathe-1", "C45", "CNMG 120408", cut)
        print(found.cut.force_y_N.value)

Answers are kept with their entity tags: asked again, and nothing written meanwhile, the service
sends none.
"""

import time
from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from functools import cache
from pathlib import Path
from types import TracebackType
from typing import IO, Any
from urllib.parse import quote

import httpx
from pydantic import TypeAdapter

from autodb.agent.answer.bounds.stable import StableCut
from autodb.agent.answer.looking_up import Listed
from autodb.agent.answer.overview import CalibrationSaid, MachineSaid, MachineSeen, MismatchSaid
from autodb.agent.answer.predicting import JobAnswer, Predicted
from autodb.agent.answer.prediction_basis import LookedUp
from autodb.agent.ingest.importing import Imported
from autodb.agent.matching.scoring import PredictionScores
from autodb.agent.operate.changed_edges import EdgeChanged, EdgesOfMachine
from autodb.errors import NotThere, UnusableInput
from autodb.files.job import Job
from autodb.files.job_cut import JobCut
from autodb.web.http.said import BatchLine, Decision, End, Importing, Machines, Senses, Step

API = "/api/v1"
KEPT = 1000
"""Answers that are kept. Chosen: some 2 kB each."""
SEND_S = 600.0
"""How long one part of a recording on its way may take. Chosen."""
ASKED_S = 0.2
"""How often it is asked how far an import is. Chosen: the command line shows as much."""
NOT_THERE = 404
NOT_MODIFIED = 304


class Unanswered(Exception):  # noqa: N818 - the name says what it is to the reader of the message
    """No answer: the service is away, or does not let the client in."""


class Client:
    """Asks one service; ``token`` where it needs one, ``ca`` a certificate (PEM) to trust."""

    def __init__(
        self,
        url: str,
        *,
        token: str | None = None,
        ca: Path | None = None,
        timeout_s: float = 30.0,
        transport: httpx.BaseTransport | None = None,
    ) -> None:
        self._http = httpx.Client(
            base_url=url.rstrip("/") + API,
            headers={} if token is None else {"Authorization": f"Bearer {token}"},
            verify=True if ca is None else _trusting(ca),
            timeout=timeout_s,
            transport=transport,
        )
        self._kept: OrderedDict[str, tuple[str, bytes]] = OrderedDict()

    def __enter__(self) -> "Client":
        """Return itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        where: TracebackType | None,
    ) -> None:
        """Give its connections back."""
        self._http.close()

    def machines(self) -> Iterator[MachineSeen]:
        """Give all machines, by name."""
        after: str | None = ""
        while after is not None:
            found: Machines = self._get(Machines, "/machines", {"after": after})
            yield from found.machines
            after = found.next

    def machine(self, name: str) -> MachineSaid:
        """Return one machine; raises NotThere."""
        said: MachineSaid = self._get(MachineSaid, _of(name))
        return said

    def senses(self, machine: str) -> Senses:
        """Return the forces that a machine can sense, and those that it cannot."""
        found: Senses = self._get(Senses, f"{_of(machine)}/sensors")
        return found

    def calibrations(self, machine: str) -> list[CalibrationSaid]:
        """Return a machine's calibrations that hold now."""
        path = f"{_of(machine)}/calibrations"
        found: list[CalibrationSaid] = self._get(list[CalibrationSaid], path)
        return found

    def pairs(self, machine: str) -> list[Listed]:
        """Return the pairs that a machine has learnt."""
        found: list[Listed] = self._get(list[Listed], f"{_of(machine)}/pairs")
        return found

    def scores(self, machine: str) -> PredictionScores:
        """Return how far off a machine's past predictions were, and what that widens."""
        found: PredictionScores = self._get(PredictionScores, f"{_of(machine)}/scores")
        return found

    def mismatches(self, machine: str) -> list[MismatchSaid]:
        """Return a machine's mismatches that nobody decided on."""
        path = f"{_of(machine)}/mismatches"
        found: list[MismatchSaid] = self._get(list[MismatchSaid], path)
        return found

    def trace(self, kind: str, number: int) -> Step:
        """Return where a stored row came from; raises NotThere."""
        found: Step = self._get(Step, f"/trace/{_in_path(kind)}/{number}")
        return found

    def look_up(
        self, machine: str, material: str, tool: str, cut: JobCut, *, lot: str | None = None
    ) -> LookedUp:
        """Return what a cut of a pair, or of one lot of its material, will take.

        Raises UnusableInput, NotThere of the machine.
        """
        query = {"material": material, "tool": tool} | cut.model_dump(exclude_none=True)
        query |= {} if lot is None else {"lot": lot}
        found: LookedUp = self._get(LookedUp, f"{_of(machine)}/lookup", query)
        return found

    def look_up_many(
        self, machine: str, material: str, tool: str, cuts: Iterable[JobCut]
    ) -> Iterator[BatchLine]:
        """Give what each of many cuts of a pair will take, in their order.

        Raises Unanswered where the answer is cut off.
        """
        lines = (cut.model_dump_json(exclude_none=True).encode() + b"\n" for cut in cuts)
        path = f"{_of(machine)}/lookup/batch"
        query = {"material": material, "tool": tool}
        try:
            with self._http.stream("POST", path, params=query, content=lines) as response:
                if response.is_error:
                    response.read()
                    _refuse(response)
                for line in response.iter_lines():
                    found = _adapter(BatchLine | End).validate_json(line)
                    if isinstance(found, End):
                        return
                    yield found
        except httpx.HTTPError as error:
            raise _unanswered(error) from error
        raise Unanswered("the service's answer was cut off")

    def predict(self, machine: str, job: Job) -> JobAnswer:
        """Return what each cut of a job will take; nothing is kept."""
        found: JobAnswer = self._post(JobAnswer, f"{_of(machine)}/predict", job)
        return found

    def keep_prediction(self, machine: str, job: Job) -> Predicted:
        """Return what each cut of a job will take, kept; needs a token of role operate."""
        path = f"{_of(machine)}/predictions"
        found: Predicted = self._post(Predicted, path, job)
        return found

    def predict_program(self, machine: str, job: Job) -> JobAnswer:
        """Return what each line of a job's program that cuts will take; nothing is kept.

        Raises UnusableInput, also where the job has no program or its file cannot be read.
        """
        if job.program is None:
            raise UnusableInput(f"job '{job.name}': no program; 'predict' takes cuts")
        path = Path(job.program.file)
        with _opened(path) as program:
            files = {
                "job": (None, job.model_dump_json(exclude_none=True, exclude={"cut"})),
                "program": (path.name, program),
            }
            response = self._asked("POST", f"{_of(machine)}/predict/program", files=files)
        found: JobAnswer = _adapter(JobAnswer).validate_json(response.content)
        return found

    def stability(self, machine: str, job: Job, dynamics: Path) -> tuple[StableCut, ...]:
        """Return to what depth a job's cuts are stable; ``dynamics``: the tool point's file.

        Raises UnusableInput, also where the file cannot be read.
        """
        with _opened(dynamics) as point:
            files = {
                "job": (None, job.model_dump_json(exclude_none=True)),
                "dynamics": (dynamics.name, point),
            }
            response = self._asked("POST", f"{_of(machine)}/stability", files=files)
        found: tuple[StableCut, ...] = _adapter(tuple[StableCut, ...]).validate_json(
            response.content
        )
        return found

    def import_recording(
        self,
        machine: str,
        recording: Path,
        *,
        side: Path | None = None,
        progress: Callable[[str], None] = lambda _: None,
    ) -> Imported:
        """Send a recording with its side file, beside it if none is named, and wait until it is in.

        Needs a token of role operate. Raises UnusableInput where it is refused.
        """
        beside = recording.with_suffix(".toml")
        side = beside if side is None and beside.is_file() else side
        with ExitStack() as files:
            parts = {"recording": (recording.name, files.enter_context(_opened(recording)))}
            if side is not None:
                parts["side"] = (side.name, files.enter_context(_opened(side)))
            path = f"{_of(machine)}/recordings"
            response = self._asked("POST", path, files=parts, timeout=SEND_S)
        said: Importing = _adapter(Importing).validate_json(response.content)
        while said.came_in is None and said.refused is None:
            progress(said.progress or said.state)
            time.sleep(ASKED_S)
            said = self._get(Importing, f"/imports/{said.number}")
        if said.came_in is None:
            raise UnusableInput(said.refused or "refused")
        return said.came_in

    def confirm(
        self,
        mismatch: int,
        term: str | None = None,
        *,
        lot: str | None = None,
        why: str | None = None,
    ) -> Decision:
        """Confirm a mismatch, as an alternative ``term`` or as named; needs role operate.

        ``lot``: of the material that a hard spot is of; ``why``: the reason that is kept.
        """
        return self._decided(mismatch, "confirm", term=term, lot=lot, why=why)

    def reject(self, mismatch: int, *, why: str | None = None) -> Decision:
        """Reject a mismatch, and take back what confirming it changed; needs role operate."""
        return self._decided(mismatch, "reject", why=why)

    def reopen(self, mismatch: int, *, why: str | None = None) -> Decision:
        """Take back the decision on a mismatch, and what it changed; needs role operate."""
        return self._decided(mismatch, "reopen", why=why)

    def edges(self, machine: str, *, every: bool = False) -> EdgesOfMachine:
        """Return the last change of each tool's edge on a machine; or ``every`` change."""
        query = {"every": every}
        found: EdgesOfMachine = self._get(EdgesOfMachine, f"{_of(machine)}/edges", query)
        return found

    def change_edge(
        self,
        machine: str,
        tool: str,
        *,
        at: str | None = None,
        by: str | None = None,
        why: str | None = None,
    ) -> EdgeChanged:
        """Record that a tool has a new edge, now or ``at`` an ISO 8601 time; needs role operate."""
        said = {"tool": tool, "at": at, "by": by, "why": why}
        return self._edge(f"{_of(machine)}/edges", json=said)

    def undo_edge_change(self, number: int) -> EdgeChanged:
        """Have a recorded edge change count no more; needs role operate."""
        return self._edge(f"/edges/{number}/undo")

    def _edge(self, path: str, **more: Any) -> EdgeChanged:
        response = self._asked("POST", path, **more)
        found: EdgeChanged = _adapter(EdgeChanged).validate_json(response.content)
        return found

    def _decided(self, mismatch: int, word: str, **said: str | None) -> Decision:
        response = self._asked("POST", f"/mismatches/{mismatch}/{word}", json=said)
        found: Decision = _adapter(Decision).validate_json(response.content)
        return found

    def _get(self, kind: Any, path: str, query: dict[str, Any] | None = None) -> Any:
        url = str(self._http.build_request("GET", path, params=query).url)
        tag, body = self._kept.get(url, ("", b""))
        response = self._asked("GET", url, headers={"If-None-Match": tag} if tag else {})
        if response.status_code != NOT_MODIFIED:
            body = response.content
            self._kept[url] = response.headers.get("etag", ""), body
            if len(self._kept) > KEPT:
                self._kept.popitem(last=False)
        return _adapter(kind).validate_json(body)

    def _post(self, kind: Any, path: str, job: Job) -> Any:
        body = job.model_dump(mode="json", exclude_none=True)
        return _adapter(kind).validate_json(self._asked("POST", path, json=body).content)

    def _asked(self, method: str, path: str, **more: Any) -> httpx.Response:
        try:
            response = self._http.request(method, path, **more)
        except httpx.HTTPError as error:
            raise _unanswered(error) from error
        if response.is_error:
            _refuse(response)
        return response


def _refuse(response: httpx.Response) -> None:
    """Raise what a response says that is no answer."""
    try:
        said = str(response.json()["detail"])
    except (ValueError, KeyError, TypeError):
        said = f"{response.url}: status {response.status_code}, not from autodb"
        raise Unanswered(said) from None
    if response.status_code == NOT_THERE:
        raise NotThere(said)
    if response.status_code in (400, 413, 422):
        raise UnusableInput(said)
    raise Unanswered(said)


def _unanswered(error: httpx.HTTPError) -> Unanswered:
    return Unanswered(f"{error.request.url}: no answer ({error}); start it with 'autodb serve'")


def _of(machine: str) -> str:
    return f"/machines/{_in_path(machine)}"


def _opened(path: Path) -> IO[bytes]:
    """Open a file that is to be sent; raises UnusableInput."""
    try:
        return path.open("rb")
    except OSError as error:
        raise UnusableInput(f"{path}: {error.strerror}; give a file that exists") from None


def _in_path(name: str) -> str:
    return quote(name, safe="")


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)


def _trusting(ca: Path) -> Any:
    import ssl

    return ssl.create_default_context(cafile=ca)
