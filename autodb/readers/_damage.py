"""Damaged files make a library fail in any way, up to a crash of the process: one line each."""

import faulthandler
import os
import signal
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from autodb.errors import UnusableInput

T = TypeVar("T")

LONGEST_S = 60.0
"""A parser still at work after this, on a file's head or two blocks of it, is lost in damage."""


NO_MEMORY = "it asks for more memory than there is"


def damaged(path: Path, kind: str, reason: str) -> UnusableInput:
    """Return the line for a file that is not whole."""
    why = reason.rstrip(". ")
    return UnusableInput(f"{path}: not a whole {kind} file ({why}); a new copy would work")


def whole(path: Path, kind: str, read: Callable[[], T]) -> T:
    """Return what ``read`` gives; raises UnusableInput whatever went wrong in it."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the library's own doubts about damage
            return read()
    except UnusableInput:
        raise
    except Exception as error:
        raise damaged(path, kind, _reason(error)) from None


def fault_in(read: Callable[[], object]) -> str | None:
    """Run ``read`` in a forked child; return what went wrong in it, or None.

    A crash of the parser, or one that loses its way, ends only the child. Where the system cannot
    fork, nothing is found here.
    """
    if not hasattr(os, "fork"):
        return None
    tells, told = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # the child only reads and leaves
        child = os.fork()
    if child == 0:
        _read_and_tell(read, told)
    os.close(told)
    with os.fdopen(tells, encoding="utf-8", errors="replace") as pipe:
        said = pipe.read()
    crashed = os.waitpid(child, 0)[1] != 0
    return "its parts do not fit together" if crashed else said or None


def _read_and_tell(read: Callable[[], object], told: int) -> None:
    """Read in the child, write what went wrong, and leave."""
    faulthandler.disable()  # a crash is no news to the user
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, LONGEST_S)
    try:
        warnings.simplefilter("ignore")
        read()
    except BaseException as error:  # whatever it is, the parent says it
        os.write(told, _reason(error).encode()[:500])
    os._exit(0)


def _reason(error: BaseException) -> str:
    if isinstance(error, MemoryError):
        return NO_MEMORY
    return (str(error).splitlines() or [type(error).__name__])[0]
