"""Damaged files make a library fail in any way: one line each."""

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from autodb.errors import UnusableInput

T = TypeVar("T")


def damaged(path: Path, kind: str, reason: str) -> UnusableInput:
    """Return the line for a file that is not whole, or for which there is no memory."""
    if reason == NO_MEMORY:
        return UnusableInput(
            f"{path}: this {kind} file {NO_MEMORY}; CSV, Parquet or HDF5 ('-v7.3') are read in "
            "blocks and would work"
        )
    why = reason.rstrip(". ")
    return UnusableInput(f"{path}: not a whole {kind} file ({why}); a new copy would work")


NO_MEMORY = "asks for more memory than there is"


def undamaged(path: Path, kind: str, read: Callable[[], T]) -> T:
    """Return what ``read`` gives; raises UnusableInput whatever went wrong in it."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the library's own doubts about damage
            return read()
    except UnusableInput:
        raise
    except Exception as error:
        raise damaged(path, kind, reason_of(error)) from None


def reason_of(error: BaseException) -> str:
    """Return the first line of what went wrong."""
    if isinstance(error, MemoryError):
        return NO_MEMORY
    return (str(error).splitlines() or [type(error).__name__])[0]
