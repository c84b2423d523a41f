"""Finished runs of a proof in a file: a line of JSON each, so that a proof goes on after a kill.

The first line says what the runs came from; runs of another program, or of another generator, are
never put together with these.
"""

import hashlib
import os
from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Generic, TypeVar

from pydantic import TypeAdapter, ValidationError

from autodb.errors import UnusableInput
from autodb.files.checksums import checksum

T = TypeVar("T")
J = TypeVar("J")


@dataclass(frozen=True)
class Origin:
    """What runs came from: proof, version of autodb, digests of generator and product sources."""

    proof: str
    version: str
    generator: str
    product: str


@dataclass(frozen=True)
class Finished(Generic[J]):
    """A finished run: its seed, and what was judged in it."""

    seed: int
    judged: tuple[J, ...]


ORIGIN: TypeAdapter[Origin] = TypeAdapter(Origin)


def digest(sources: Iterable[Path], *, root: Path) -> str:
    """Return 16 hexadecimal digits that change with any of the files, or with their names."""
    found = hashlib.sha256()
    for path in sorted(sources):
        found.update(f"{path.relative_to(root).as_posix()} {checksum(path)}\n".encode())
    return found.hexdigest()[:16]


def resume(
    path: Path, origin: Origin, kind: TypeAdapter[Finished[J]]
) -> tuple[dict[int, Finished[J]], str]:
    """Return the finished runs of a file by seed, and a line on why it begins anew, or nothing.

    A line that a kill left unfinished is cut off. A file of another origin is replaced.
    Raises UnusableInput on a file that holds no runs of a proof.
    """
    kept, whole = _whole_lines(path)
    if not kept:
        _begin(path, origin)
        return {}, ""
    before = _parsed(ORIGIN, kept[0], path, row=1)
    if before != origin:
        _begin(path, origin)
        return {}, f"{path}: {_changed(before, origin)}; all runs begin anew"
    runs = [_parsed(kind, line, path, row=row) for row, line in enumerate(kept[1:], start=2)]
    os.truncate(path, whole)
    return {run.seed: run for run in runs}, ""


def append(path: Path, run: Finished[J], kind: TypeAdapter[Finished[J]]) -> Finished[J]:
    """Write a run at the end of the file, at once, and return it as it is read back.

    What is no number is written as null, so an end of an interval that is none was not given.
    """
    line = kind.dump_json(run)
    with path.open("ab") as file:
        file.write(line + b"\n")
    return kind.validate_json(line)


def _begin(path: Path, origin: Origin) -> None:
    fresh = path.with_name(f"{path.name}.new")
    fresh.write_bytes(ORIGIN.dump_json(origin) + b"\n")
    fresh.replace(path)


def _whole_lines(path: Path) -> tuple[list[bytes], int]:
    """Return the lines that end, without their ends, and how many bytes they take."""
    held = path.read_bytes() if path.exists() else b""
    whole = held.rfind(b"\n") + 1
    return held[:whole].splitlines(), whole


def _parsed(kind: TypeAdapter[T], line: bytes, path: Path, *, row: int) -> T:
    try:
        return kind.validate_json(line)
    except ValidationError:
        raise UnusableInput(
            f"{path}: row {row}: is not a run of a proof; use a new folder with --out"
        ) from None


def _changed(before: Origin, now: Origin) -> str:
    """Return what is not as it was, with both values."""
    old, new = asdict(before), asdict(now)
    names = [field.name for field in fields(Origin) if old[field.name] != new[field.name]]
    return ", ".join(f"{name} was {old[name]} and is {new[name]}" for name in names)
