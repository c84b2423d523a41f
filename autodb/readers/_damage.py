"""Damaged files make a library fail in any way, up to a crash of the process: one line each."""

import contextlib
import faulthandler
import os
import signal
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from autodb.errors import UnusableInput

T = TypeVar("T")

LONGEST_S = 20.0
"""A parser that is still at work after this is taken to be lost in a damaged file."""


def damaged(path: Path, kind: str, reason: str) -> UnusableInput:
    """Return the line for a file that is not whole."""
    first = (reason.splitlines() or ["damaged"])[0]
    return UnusableInput(f"{path}: not a whole {kind} file ({first})")


def whole(path: Path, kind: str, read: Callable[[], T]) -> T:
    """Return what ``read`` gives; raises UnusableInput whatever went wrong in it."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the library's own doubts about damage
            return read()
    except UnusableInput:
        raise
    except MemoryError:
        raise damaged(path, kind, "or it needs more memory than there is") from None
    except Exception as error:
        raise damaged(path, kind, str(error) or type(error).__name__) from None


def survives(read: Callable[[], object]) -> bool:
    """Run ``read`` in a forked child first; False where it crashed the process or lost its way.

    An ordinary exception is no crash: the caller meets it again and says what it is.
    """
    if not hasattr(os, "fork"):
        return True
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # the child only reads and leaves
        child = os.fork()
    if child == 0:
        with contextlib.suppress(BaseException):
            faulthandler.disable()  # a crash is no news to the user
            os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
            signal.setitimer(signal.ITIMER_REAL, LONGEST_S)
            read()
        os._exit(0)
    return os.waitpid(child, 0)[1] == 0
