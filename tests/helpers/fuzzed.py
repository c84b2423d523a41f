"""What is done with bytes from outside: read, or refused in one line, never anything else.

`python -m tests.by_hand.fuzz` looks for bytes for which that is not so, and keeps those in the
corpus that lead somewhere new; `test_fuzzed.py` does it with what is kept, and with mutations of
it.
"""

import asyncio
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from fastapi import HTTPException, Request
from starlette.types import Message

from autodb.errors import UnusableInput
from autodb.files.job import JobProgram, read_job
from autodb.files.machine import flat, lasting_part, read_machine_file
from autodb.files.part import read_part
from autodb.files.side import read_sidefile
from autodb.files.tool import geometry_of, read_tool
from autodb.forward.programs import follow
from autodb.live.agentfile import read_agentfile
from autodb.nc.reading import read_program
from autodb.sensing.ranges.inspection import as_measured
from autodb.standard.protocol import read_protocol
from autodb.web.receive.sent import receive_parts
from autodb.web.routes.recordings import RECORDING, SIDE, named_as_sent

CORPUS = Path(__file__).parent / "corpus"
Target = Callable[[bytes, Path], None]


@contextmanager
def _refused(path: Path) -> Iterator[None]:
    """Take a refusal that names the file for an answer."""
    try:
        yield
    except UnusableInput as refusal:
        assert str(refusal).startswith(f"{path}: "), refusal


def nc(data: bytes, folder: Path) -> None:
    """Read bytes as a turning program, in diameters and in radii, and cut a bar with it."""
    path = folder / "part.nc"
    path.write_bytes(data)
    for diameter in (True, False):
        with _refused(path):
            for move in read_program(path, diameter=diameter, inch=not diameter).moves:
                assert np.isfinite([*move.start, *move.end]).all()
    with _refused(path):
        bar = JobProgram(file=str(path), stock_diameter_mm=60.0, stock_face_mm=2.0)
        done = follow(bar, units=None, diameter=None)
        assert 0.0 < done.cutting_s <= (1.0 + 1e-9) * done.fed_s < np.inf
        for line in done.lines:
            assert all(np.isfinite(list(one.values())).all() for one in line.steps)


def toml(data: bytes, folder: Path) -> None:
    """Read bytes as every file that is TOML."""
    path = folder / "file.toml"
    path.write_bytes(data)
    for read in (read_job, read_sidefile, read_agentfile):
        with _refused(path):
            read(path)
    with _refused(path):
        read_protocol(str(path))
    with _refused(path):
        geometry_of(read_tool(path))
    with _refused(path):
        as_measured(read_part(path))
    with _refused(path):
        machine = read_machine_file(path)
        assert flat(lasting_part(machine))


def upload(data: bytes, folder: Path) -> None:
    """Receive bytes as a request that sends a recording: its Content-Type, a new line, its body.

    In one piece or in many, the same files come of it, or none.
    """
    kind, _, body = data.partition(b"\n")
    came = []
    for k, length in enumerate((len(body) + 1, 7)):
        place = folder / str(k)
        place.mkdir()
        pieces = [body[at : at + length] for at in range(0, len(body), length)]
        came.append(_sent(kind, pieces, place))
    assert came[0] == came[1]


def _sent(kind: bytes, pieces: list[bytes], place: Path) -> dict[str, bytes] | None:
    """Return the files, by name, that a request leaves; None where it was refused."""
    left = iter(pieces)

    async def receive() -> Message:
        piece = next(left, b"")
        return {"type": "http.request", "body": piece, "more_body": bool(piece)}

    scope = {"type": "http", "method": "POST", "headers": [(b"content-type", kind)]}
    try:
        parts = asyncio.run(
            receive_parts(Request(scope, receive), place, {RECORDING: 4096, SIDE: 512}, 60.0)
        )
        path = named_as_sent(parts)
    except (UnusableInput, HTTPException):
        return None
    kept = [one for one in place.rglob("*") if one.is_file()]
    assert {one.parent for one in kept} == {place} == {path.parent}
    assert {one.stem for one in kept} == {path.stem}
    assert sum(one.stat().st_size for one in kept) <= sum(map(len, pieces))
    return {one.name: one.read_bytes() for one in kept}


TARGETS: dict[str, Target] = {"nc": nc, "toml": toml, "upload": upload}
