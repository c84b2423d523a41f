"""Libraries that a damaged file can crash read it in a child; only arrays and text come back.

A child that crashes, or loses its way, or damages its own memory takes nothing else with it.
"""

import contextlib
import faulthandler
import json
import os
import signal
import warnings
from collections.abc import Callable, Iterator, Sequence
from io import BufferedReader
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.readers._base import Blocks, Columns, damaged, reason_of

LONGEST_S = 60.0
"""A parser that is at work for this long on one block is lost in a damaged file."""
PART, REFUSED, DAMAGED, DONE = b"P", b"R", b"D", b"."
_LENGTH_BYTES = 8
ALIGNED = 64
"""Bytes at whose multiples the numbers of a column begin."""


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
    (part,) = _parts(path, kind, lambda: iter([[json.dumps(read()).encode()]]))
    return json.loads(part)


def _pack(columns: Columns, names: list[str]) -> list[Any]:
    """Return columns as buffers: what they are, then the numbers of each, none of them copied."""
    found = [np.ascontiguousarray(columns[name]) for name in names]
    header = json.dumps([(one.dtype.str, len(one)) for one in found]).encode()
    packed = [len(header).to_bytes(_LENGTH_BYTES, "big"), header]
    packed.append(b" " * (-(_LENGTH_BYTES + len(header)) % ALIGNED))
    for one in found:
        packed += [_buffer(one), b" " * (-one.nbytes % ALIGNED)]
    return packed


def _buffer(column: NDArray[Any]) -> Any:
    return column.data.cast("B") if column.dtype.kind in "fiu" and len(column) else column.tobytes()


def _unpack(part: bytearray, names: list[str]) -> Columns:
    """Return the columns that ``_pack`` packed, in the memory of the part."""
    begin = _LENGTH_BYTES + int.from_bytes(part[:_LENGTH_BYTES], "big")
    found = {}
    for name, (kind, count) in zip(names, json.loads(part[_LENGTH_BYTES:begin]), strict=True):
        begin += -begin % ALIGNED
        dtype = np.dtype(kind)
        found[name] = np.ndarray(count, dtype, part, begin)
        begin += count * dtype.itemsize
    return found


def _parts(
    path: Path, kind: str, produce: Callable[[], Iterator[Sequence[Any]]]
) -> Iterator[bytearray]:
    """Yield what ``produce`` yields in a child; where the system cannot fork, here."""
    if not hasattr(os, "fork"):
        yield from (bytearray().join(buffers) for buffers in produce())
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


def _received(path: Path, kind: str, pipe: BufferedReader) -> Iterator[bytearray]:
    while True:
        tag = pipe.read(1)
        size = int.from_bytes(pipe.read(_LENGTH_BYTES), "big") if tag else 0
        try:
            payload = bytearray(size)
        except (MemoryError, OverflowError):
            raise damaged(path, kind, "its parts do not fit together") from None
        whole = pipe.readinto(payload) == size
        if tag == PART and whole:
            yield payload
        elif tag == DONE:
            return
        elif tag == REFUSED:
            raise UnusableInput(payload.decode("utf-8", "replace"))
        elif tag == DAMAGED:
            raise damaged(path, kind, payload.decode("utf-8", "replace"))
        else:
            raise damaged(path, kind, "its parts do not fit together")


def _work(writes: int, produce: Callable[[], Iterator[Sequence[Any]]]) -> None:
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
                _send(pipe, PART, *part)
                signal.setitimer(signal.ITIMER_REAL, LONGEST_S)
            _send(pipe, DONE)
        except UnusableInput as error:
            _send(pipe, REFUSED, str(error).encode())
        except BaseException as error:  # whatever it is, the parent says it
            _send(pipe, DAMAGED, reason_of(error).encode())
    os._exit(0)


def _send(pipe: BinaryIO, tag: bytes, *buffers: Any) -> None:
    size = sum(map(len, buffers))
    pipe.write(tag + size.to_bytes(_LENGTH_BYTES, "big"))
    for one in buffers:
        pipe.write(one)
    pipe.flush()
