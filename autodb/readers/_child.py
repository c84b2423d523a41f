"""Libraries that a damaged file can crash read it in a child; only arrays and text come back.

A child that crashes, or loses its way, or damages its own memory takes nothing else with it.
"""

import contextlib
import faulthandler
import io
import json
import os
import signal
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from autodb.errors import UnusableInput
from autodb.readers._base import Blocks, Columns, damaged, reason_of

LONGEST_S = 60.0
"""A parser that is at work for this long on one block is lost in a damaged file."""
PART, REFUSED, DAMAGED, DONE = b"P", b"R", b"D", b"."
_LENGTH_BYTES = 8


def isolated(path: Path, kind: str, blocks: Blocks) -> Blocks:
    """Return the same blocks, read in a child."""

    def apart(numbers: Sequence[str], labels: Sequence[str]) -> Iterator[Columns]:
        names = [*numbers, *labels]
        parts = _parts(path, kind, lambda: (_pack(b, names) for b in blocks(numbers, labels)))
        for part in parts:
            yield _unpack(part, names)

    return apart


def isolated_value(path: Path, kind: str, read: Callable[[], Any]) -> Any:
    """Return what ``read`` gives, as JSON brings it back, read in a child.

    Raises UnusableInput where the file is damaged, or does not fit into the memory.
    """
    (part,) = _parts(path, kind, lambda: iter([json.dumps(read()).encode()]))
    return json.loads(part)


def _pack(columns: Columns, names: list[str]) -> bytes:
    packed = io.BytesIO()
    for name in names:
        np.save(packed, columns[name], allow_pickle=False)
    return packed.getvalue()


def _unpack(part: bytes, names: list[str]) -> Columns:
    packed = io.BytesIO(part)
    return {name: np.load(packed, allow_pickle=False) for name in names}


def _parts(path: Path, kind: str, produce: Callable[[], Iterator[bytes]]) -> Iterator[bytes]:
    """Yield what ``produce`` yields in a child; where the system cannot fork, here."""
    if not hasattr(os, "fork"):
        yield from produce()
        return
    reads, writes = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # the child only reads and leaves
        child = os.fork()
    if child == 0:
        os.close(reads)
        _work(writes, produce)
    os.close(writes)
    try:
        with os.fdopen(reads, "rb") as pipe:
            yield from _received(path, kind, pipe)
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)


def _received(path: Path, kind: str, pipe: BinaryIO) -> Iterator[bytes]:
    while True:
        tag = pipe.read(1)
        size = int.from_bytes(pipe.read(_LENGTH_BYTES), "big") if tag else 0
        payload = pipe.read(size)
        if tag == PART and len(payload) == size:
            yield payload
        elif tag == DONE:
            return
        elif tag == REFUSED:
            raise UnusableInput(payload.decode("utf-8", "replace"))
        elif tag == DAMAGED:
            raise damaged(path, kind, payload.decode("utf-8", "replace"))
        else:
            raise damaged(path, kind, "its parts do not fit together")


def _work(writes: int, produce: Callable[[], Iterator[bytes]]) -> None:
    """Produce in the child, write every part, say how it ended, and leave."""
    faulthandler.disable()  # a crash is no news to the user
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    warnings.simplefilter("ignore")
    with contextlib.suppress(BaseException), os.fdopen(writes, "wb") as pipe:
        try:
            signal.setitimer(signal.ITIMER_REAL, LONGEST_S)
            for part in produce():
                _send(pipe, PART, part)
                signal.setitimer(signal.ITIMER_REAL, LONGEST_S)
            _send(pipe, DONE, b"")
        except UnusableInput as error:
            _send(pipe, REFUSED, str(error).encode())
        except BaseException as error:  # whatever it is, the parent says it
            _send(pipe, DAMAGED, reason_of(error).encode())
    os._exit(0)


def _send(pipe: BinaryIO, tag: bytes, payload: bytes) -> None:
    pipe.write(tag + len(payload).to_bytes(_LENGTH_BYTES, "big"))
    pipe.write(payload)
    pipe.flush()
