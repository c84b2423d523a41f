"""What `explain` answers to a case: two files on the disk, the command, its `explanation.json`."""

import json
import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pandas as pd

from autodb.proofs.cases.real.real_case import RealCase
from autodb.proofs.runs.stamps.stamp_answers import SaidLines, ran_command

NAMED_FROM = 0.5
"""Confidence from which a term counts as named."""
SURE_FROM = 0.9
NO_NAME = "unknown"


@dataclass(frozen=True)
class SaidEntry:
    """One entry of an answer: term, `missing` or `mistuned`, confidence, size in the unit."""

    term: str
    kind: str
    confidence: float
    size: float

    @property
    def named(self) -> bool:
        """Say whether the term is named as missing."""
        return self.kind == "missing" and self.confidence >= NAMED_FROM

    @property
    def sure(self) -> bool:
        """Say whether it is a name of the vocabulary at 0.9 or more."""
        return self.confidence >= SURE_FROM and self.term != NO_NAME


@dataclass(frozen=True)
class RealAnswer:
    """An answer: its entries, held-out errors before and after, and why there is none, if so."""

    entries: tuple[SaidEntry, ...] = ()
    before: float | None = None
    after: float | None = None
    error: str = ""
    seconds: float = 0.0


def explained_real(case: RealCase) -> RealAnswer:
    """Write recording and simulation of a case, and ask the command about them."""
    with TemporaryDirectory(prefix="autodb-real-") as name:
        folder = Path(name)
        pd.DataFrame(case.channels).to_csv(folder / "recording.csv", index=False)
        pd.DataFrame(case.simulation).to_csv(folder / "simulation.csv", index=False)
        includes = ("--includes", ",".join(case.includes)) if case.includes else ()
        begun = time.perf_counter()
        said = ran_command(
            folder, "explain", f"{folder}/recording.csv", "--simulation",
            f"{folder}/simulation.csv", *includes, "--out", f"{folder}/answer",
        )  # fmt: skip
        seconds = time.perf_counter() - begun
        path = folder / "answer" / "explanation.json"
        held = json.loads(path.read_text("utf-8")) if path.exists() else {}
    return read_answer(held, case.channel, said, seconds)


def read_answer(
    held: dict[str, Any], channel: str, said: SaidLines, seconds: float = 0.0
) -> RealAnswer:
    """Return what an `explanation.json` says of a channel; an exit but 0 is an error."""
    if said.code != 0 or channel not in held.get("channels", {}):
        lines = [line for line in said.err.splitlines() if line.strip()]
        return RealAnswer(error=(lines or [f"exit {said.code}, no answer"])[-1], seconds=seconds)
    answer = held["channels"][channel]
    entries = tuple(
        SaidEntry(
            one["term"], one["kind"], float(one["confidence"]),
            abs(float(one["parameters"].get("size", {}).get("value", 0.0))),
        )
        for one in answer["missing"]
    )  # fmt: skip
    fit = answer["fit"]
    return RealAnswer(entries, fit["heldout_before"], fit["heldout_after"], seconds=seconds)
