"""What `identify` and `explain` answer to a stamped recording: files on the disk, as a user asks.

The command line stands above the proofs, which are commands of it: it is imported when it runs.
"""

import hashlib
import io
import json
import os
import re
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from autodb.proofs.cases.stamps.axis_rows import LAW
from autodb.proofs.cases.stamps.stamp_cases import StampCase
from autodb.proofs.cases.stamps.stamped import StampedRows

REFUSED = 2
SURE = 0.5
"""Confidence from which a cause counts as named."""
NO_NAME = "unknown"
TIMELY = re.compile(
    r"\b(stamps?|timestamps?|times?|clocks?|gaps?|rates?|sampled|sampling|evenly)\b", re.IGNORECASE
)
"""Words of a line that speaks of the recording's time."""


@dataclass(frozen=True)
class SaidLines:
    """What a command ended with: its exit status, its answer, what it said beside."""

    code: int
    out: str
    err: str

    @property
    def outcome(self) -> str:
        """Say `answered`, `refused` in one line, or `broken`: anything else."""
        lines = [line for line in self.err.splitlines() if line.strip()]
        if self.code == 0:
            return "answered"
        refused = self.code == REFUSED and len(lines) == 1 and not self.out.strip()
        return "refused" if refused else "broken"

    @property
    def of_time(self) -> str:
        """Return a refusal, or the first line outside tables that speaks of time, or nothing."""
        lines = [*self.err.splitlines(), *self.out.splitlines()]
        if self.outcome == "refused":
            return next(line for line in lines if line.strip())
        free = (line for line in lines if not line.startswith((" ", "protocol:")))
        return next((line for line in free if TIMELY.search(line)), "")


@dataclass(frozen=True)
class StampAnswers:
    """Both answers: coefficients by term where `identify` gives them, causes that are named.

    ``explained`` is None of a rotary axis, of which `explain` takes no current. A cause is a term
    that is missing, or `TERM (mistuned)`. ``numbers``: digest of all numbers.
    """

    identified: SaidLines
    explained: SaidLines | None
    coefficients: dict[str, float]
    causes: frozenset[str]
    numbers: str

    def errors_percent(self) -> dict[str, float | None]:
        """Return by term how far its coefficient is off the truth, %; None where there is none."""
        return {
            term: None
            if (value := self.coefficients.get(term)) is None
            else 100 * (value / true - 1)
            for term, true in LAW.items()
        }


def answers_to(case: StampCase, stamped: StampedRows) -> StampAnswers:
    """Write a recording of a case and its simulation, and ask both commands about it."""
    with TemporaryDirectory(prefix="autodb-stamps-") as name:
        folder = Path(name)
        recording = _written(folder, "recording", case.recording(stamped), stamped.side)
        simulation = _written(folder, "simulation", case.simulation(stamped), stamped.side)
        identified = ran_command(folder, "identify", recording)
        explained = None if case.axis.rotary else ran_command(
            folder, "explain", recording, "--simulation", simulation, "--out", f"{folder}/answer"
        )  # fmt: skip
        answer = folder / "answer" / "explanation.json"
        channels = json.loads(answer.read_text("utf-8"))["channels"] if answer.exists() else {}
    return StampAnswers(
        identified, explained, printed_coefficients(identified.out), read_causes(channels),
        _digest(identified.out, channels),
    )  # fmt: skip


def _written(folder: Path, stem: str, text: str, side: str) -> str:
    """Write a table, and a side file where there is one; return the table's path."""
    path = folder / f"{stem}.csv"
    path.write_text(text, encoding="utf-8")
    if side:
        path.with_suffix(".toml").write_text(side, encoding="utf-8")
    return str(path)


def ran_command(folder: Path, *words: str) -> SaidLines:
    """Run a command of this program in this process; what it said has no path of the folder."""
    out, err = io.StringIO(), io.StringIO()
    wide = os.environ.pop("COLUMNS", None)
    try:
        with redirect_stdout(out), redirect_stderr(err):
            code = int(import_module("autodb.cli").run(list(words)))
    except Exception as error:  # a traceback is an answer that nobody can use: it is counted
        code = 1
        print(f"{type(error).__name__}: {error}", file=err)
    finally:
        if wide is not None:
            os.environ["COLUMNS"] = wide
    said = (text.getvalue().replace(f"{folder}{os.sep}", "") for text in (out, err))
    return SaidLines(code, *said)


def printed_coefficients(out: str) -> dict[str, float]:
    """Return the coefficients of the law in the table that `identify` prints first."""
    rows = (re.search(rf"^ +{term} +\w+ +(\S+)", out, re.MULTILINE) for term in LAW)
    return {term: float(row[1]) for term, row in zip(LAW, rows, strict=True) if row}


def read_causes(channels: dict[str, Any]) -> frozenset[str]:
    """Return the causes that an `explanation.json` names surely; one without a name is none."""
    every = [cause for channel in channels.values() for cause in channel["missing"]]
    sure = [one for one in every if one["confidence"] >= SURE and one["term"] != NO_NAME]
    return frozenset(
        one["term"] if one["kind"] == "missing" else f"{one['term']} ({one['kind']})"
        for one in sure
    )


def _digest(out: str, channels: dict[str, Any]) -> str:
    """Return 16 digits that change with any number of both answers; sentences are left out."""
    tables = "\n".join(line for line in out.splitlines() if line.startswith(" "))
    whole = f"{tables}\n{json.dumps(channels, sort_keys=True)}"
    return hashlib.sha256(whole.encode()).hexdigest()[:16]
