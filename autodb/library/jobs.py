"""Cuts that a caller asks for: a job file, a data frame with a row a cut, or one by its keys."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from autodb.agent.learn.usual_cut import STATED
from autodb.errors import UnusableInput
from autodb.files.channels import is_channel
from autodb.files.job import Job, read_job
from autodb.files.job_cut import KEYS, JobCut
from autodb.files.toml import checked
from autodb.library.given import Given
from autodb.pairs.engaged import FEED, RPM, SPEED
from autodb.records.frames import arrow_of, is_frame, is_nothing

OF_EDGE = {"tool.cutting_time": "cutting_time_s", "tool.flank_wear": "flank_wear_mm"}
"""Keys of a job's cut by the channels of a table of cuts that say what edge it is made with."""
SPEEDS = (RPM, SPEED)
"""Channels of which a cut states one; the first is what the machine was told."""
PAIR = {"material": ("material", "work.material"), "tool": ("tool",)}
"""Columns that may say of a data frame what its pair is."""


def job_of(given: Given, *, material: str | None, tool: str | None, lot: str | None) -> Job:
    """Return the job of a job file, or of a data frame with a row a cut.

    Raises UnusableInput naming file or row.
    """
    if isinstance(given, Job | str | os.PathLike):
        if any((material, tool, lot)):
            raise UnusableInput("material, tool and lot go with a data frame: a job states its own")
        return given if isinstance(given, Job) else read_job(Path(given))
    rows = _rows(given, "job")
    material = material or _only(rows, "material")
    tool = tool or _only(rows, "tool")
    return Job(name="cuts", material=material, tool=tool, lot=lot, cut=_cuts(rows, "job"))


def asked_cuts(given: Given, *, name: str) -> tuple[JobCut, ...]:
    """Return the cuts of a data frame, a row each; raises UnusableInput naming the row."""
    return _cuts(_rows(given, name), name)


def asked_cut(said: Mapping[str, Any], *, where: str) -> JobCut:
    """Return a cut of what is said of it, but for what is not known; raises UnusableInput."""
    known = {key: value for key, value in said.items() if not is_nothing(value)}
    numbers = {key: float(value) if type(value) is int else value for key, value in known.items()}
    return checked(numbers, JobCut, where=where)


def _rows(given: Given, name: str) -> list[dict[str, Any]]:
    if not is_frame(given):
        raise UnusableInput(
            f"{name}: is no data frame but of type {type(given).__name__}; use one with a row a cut"
        )
    rows: list[dict[str, Any]] = arrow_of(given, name=name).to_pylist()
    return rows


def _cuts(rows: list[dict[str, Any]], name: str) -> tuple[JobCut, ...]:
    return tuple(
        asked_cut(_with_keys(row), where=f"{name}: row {number}")
        for number, row in enumerate(rows, start=1)
    )


def _with_keys(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row by keys of a job's cut: channels say some of them, other columns nothing."""
    columns = {column for names in PAIR.values() for column in names}
    own = {n: v for n, v in row.items() if n == "operation" or not (is_channel(n) or n in columns)}
    feed = "feed_mm_tooth" if "feed_mm_tooth" in _needs(own) else "feed_mm_rev"
    names = {**STATED, **OF_EDGE, FEED: feed}
    known = [name for name in names if name not in SPEEDS and name in row]
    if not own.keys() & {STATED[name] for name in SPEEDS}:
        known += [name for name in SPEEDS if not is_nothing(row.get(name))][:1]
    said = {names[name]: row[name] for name in known if names[name] not in own}
    return {**own, **said}


def _needs(own: Mapping[str, Any]) -> tuple[str, ...]:
    operation = own.get("operation")
    return KEYS[operation].needs if operation in KEYS else ()


def _only(rows: list[dict[str, Any]], what: str) -> str:
    """Return the material or the tool that all rows state; raises UnusableInput."""
    found = {row[name] for row in rows for name in PAIR[what] if not is_nothing(row.get(name))}
    if len(found) != 1:
        several = f" (they state {', '.join(map(str, sorted(found)))})" if found else ""
        raise UnusableInput(f"job: the cuts of a data frame need one {what}{several}; give {what}=")
    return str(found.pop())
