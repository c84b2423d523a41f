"""What is sent as a form with files (multipart/form-data), written to files as it comes.

A part is written to a file that is called as its field is. What the sender calls it is no path:
``safe`` makes a name of it.
"""

import asyncio
import re
import unicodedata
from collections.abc import Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from fastapi import HTTPException, Request
from python_multipart.exceptions import FormParserError
from python_multipart.multipart import MultipartParser, parse_options_header
from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect

from autodb.errors import UnusableInput, near
from autodb.web.http.settings import MIB
from autodb.wording import phrase

FORM = "multipart/form-data"
CALLED_MOST = 100
"""Characters of a name. Chosen: file systems take 255 bytes."""


@dataclass(frozen=True)
class SentPart:
    """A part that was sent: the file that it lies in, and what its sender calls it."""

    path: Path
    called: str


async def receive_parts(
    request: Request, folder: Path, most: Mapping[str, int], within_s: float
) -> dict[str, SentPart]:
    """Write the parts of a request into a folder; ``most``: bytes of each, by field.

    Raises UnusableInput for what is no such form, a field twice or another, HTTPException for a
    part that is too large, or where it takes too long.
    """
    try:
        async with asyncio.timeout(within_s):
            return await _parts(request, folder, most)
    except TimeoutError:
        said = phrase(
            "sending it takes longer than {most} s; send it in parts", most=f"{within_s:g}"
        )
        raise HTTPException(408, said) from None


async def _parts(request: Request, folder: Path, most: Mapping[str, int]) -> dict[str, SentPart]:
    kind, options = parse_options_header(request.headers.get("content-type", ""))
    boundary = options.get(b"boundary")
    if kind != FORM.encode() or not boundary:
        raise UnusableInput(f"the body is not a form with files; use {FORM}, as curl -F does")
    with ExitStack() as files:
        writer = _Writer(boundary, folder, most, files)
        with suppress(ClientDisconnect):
            async for piece in request.stream():
                await run_in_threadpool(writer.take, piece)
    if not writer.whole:
        raise UnusableInput(phrase("the body was cut off; send it whole"))
    return writer.parts


class _Writer:
    """Writes the parts of a form into files, in pieces."""

    def __init__(
        self, boundary: bytes, folder: Path, most: Mapping[str, int], files: ExitStack
    ) -> None:
        self.parts: dict[str, SentPart] = {}
        self.whole = False
        self._folder, self._most, self._files = folder, most, files
        self._header, self._value, self._disposition = b"", b"", b""
        self._file: IO[bytes] | None = None
        self._left, self._field = 0, ""
        self._parser = _parser(boundary, self)

    def take(self, piece: bytes) -> None:
        """Take the next piece of the body."""
        try:
            self._parser.write(piece)
        except FormParserError:  # where it says it is, is within the piece
            raise UnusableInput(f"the body is not a whole form; use {FORM}") from None

    def begin(self) -> None:
        """Begin a part."""
        self._header, self._value, self._disposition = b"", b"", b""

    def header(self, data: bytes, start: int, end: int) -> None:
        """Take a piece of a header's name."""
        self._header += data[start:end]

    def value(self, data: bytes, start: int, end: int) -> None:
        """Take a piece of a header's value."""
        self._value += data[start:end]

    def header_ends(self) -> None:
        """Keep the header that says what a part is."""
        if self._header.lower() == b"content-disposition":
            self._disposition = self._value
        self._header, self._value = b"", b""

    def headers_end(self) -> None:
        """Open the file of a part."""
        _, options = parse_options_header(self._disposition)
        field = options.get(b"name", b"").decode("utf-8", "replace")
        if field not in self._most:
            raise UnusableInput(f"no part '{field}'{near(field, self._most)}")
        if field in self.parts:
            raise UnusableInput(f"{field}: sent twice; send it once")
        called = options.get(b"filename", b"").decode("utf-8", "replace")
        path = self._folder / field
        self._file = self._files.enter_context(path.open("xb"))
        self._left, self._field = self._most[field], field
        self.parts[field] = SentPart(path, called)

    def data(self, data: bytes, start: int, end: int) -> None:
        """Write a piece of a part."""
        assert self._file is not None
        self._left -= end - start
        if self._left < 0:
            most = self._most[self._field] / MIB
            raise HTTPException(
                413,
                phrase(
                    "{part}: larger than {most} MiB; send it in parts",
                    part=self._field, most=f"{most:g}",
                ),
            )  # fmt: skip
        self._file.write(memoryview(data)[start:end])

    def ends(self) -> None:
        """Close the file of a part."""
        assert self._file is not None
        self._file.close()

    def all_ends(self) -> None:
        """Know that nothing is missing."""
        self.whole = True


def _parser(boundary: bytes, writer: _Writer) -> MultipartParser:
    try:
        return MultipartParser(
            boundary,
            {
                "on_part_begin": writer.begin,
                "on_header_field": writer.header,
                "on_header_value": writer.value,
                "on_header_end": writer.header_ends,
                "on_headers_finished": writer.headers_end,
                "on_part_data": writer.data,
                "on_part_end": writer.ends,
                "on_end": writer.all_ends,
            },
        )
    except FormParserError as error:
        raise UnusableInput(f"the body's boundary: {error}; use a shorter one") from None


def safe(called: str, otherwise: str) -> str:
    """Return a name without a path, of letters, digits, `_`, `-` and `.` that no shell minds.

    ``otherwise``: the name where nothing is left.

    >>> safe("..\\\\..\\\\Dreh probe (1).CSV", "x"), safe("../../etc/passwd", "x"), safe("..", "x")
    ('Dreh-probe-1-.CSV', 'passwd', 'x')
    """
    last = re.split(r"[/\\]", called)[-1]
    plain = unicodedata.normalize("NFKD", last).encode("ascii", "ignore").decode()
    name = re.sub(r"[^A-Za-z0-9_.]+", "-", plain).strip(".-")
    stem, dot, ending = name.rpartition(".")
    short = f"{stem[: CALLED_MOST - len(ending) - 1]}{dot}{ending}" if stem else name
    return short[:CALLED_MOST] if short else otherwise
