"""Bytes of a text file, packed or not, as pieces of whole lines in UTF-8."""

import codecs
import gzip
import lzma
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, cast

from autodb.errors import UnusableInput
from autodb.wording import msgid, phrase

BLOCK_BYTES = 1 << 24
LONGEST_LINE = 1 << 24
SAMPLE_BYTES = 1 << 16
"""The beginning of a file that its layout is detected from, up to the end of a line. Chosen."""
_BOMS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
_FORMATS = (
    (b"\x1f\x8b", "packed by gzip", ".csv.gz"),
    (b"PK\x03\x04", "an archive or a workbook", ".zip or .xlsx"),
    (b"\x89HDF", "HDF5", ".h5"),
    (b"PAR1", "Parquet", ".parquet"),
    (b"TDSm", "TDMS", ".tdms"),
    (b"MDF ", "MDF", ".mf4"),
    (b"MATLAB ", "MATLAB", ".mat"),
)
"""How files of other formats begin, what they are, and how their names end."""
_OF_TEXT = bytes([*b"\t\n\r\f\x1a\x1b", *range(0x20, 0x100)])
BINARY = 0.01
"""Share of control characters from which on bytes are no text in any encoding. Chosen."""
WORKS = msgid("use one line a row, and the same separator throughout")


@contextmanager
def unpacked(path: Path) -> Iterator[IO[bytes]]:
    """Open the bytes of a text file, of one in a .gz file, or of the only one in a .zip file.

    Raises UnusableInput for an archive that is damaged or holds several files.
    """
    suffix = path.suffix.lower()
    try:
        if suffix == ".gz":
            with gzip.open(path) as file:
                yield cast("IO[bytes]", file)
        elif suffix == ".zip":
            with zipfile.ZipFile(path) as archive, archive.open(_only(path, archive)) as file:
                yield file
        else:
            with path.open("rb") as file:
                yield file
    except (EOFError, OSError, zipfile.BadZipFile, zlib.error, lzma.LZMAError) as error:
        raise UnusableInput(
            phrase("{file}: not a whole archive ({error}); pack it again", file=path, error=error)
        ) from None
    except (NotImplementedError, RuntimeError) as error:  # another packing, a password
        raise UnusableInput(
            phrase("{file}: cannot be unpacked ({error}); unpack it", file=path, error=error)
        ) from None


def _only(path: Path, archive: zipfile.ZipFile) -> zipfile.ZipInfo:
    files = [one for one in archive.infolist() if not one.is_dir()]
    if len(files) != 1:
        raise UnusableInput(
            phrase(
                "{file}: {n} files in it; unpack it, and give one of them", file=path, n=len(files)
            )
        )
    return files[0]


def encoding_of(beginning: bytes) -> tuple[str, int]:
    """Return the encoding of a text by its first bytes, and how many of them are its mark."""
    for mark, name in _BOMS:
        if beginning.startswith(mark):
            return name, len(mark)
    if beginning[1:200:2].count(0) > 0.4 * len(beginning[1:200:2]):
        return "utf-16-le", 0
    try:
        codecs.getincrementaldecoder("utf-8")().decode(beginning)
    except UnicodeDecodeError:
        return "cp1252", 0
    return "utf-8", 0


def beginning_of(path: Path) -> bytes:
    """Return the beginning of a file, up to the end of a line where there is one."""
    with unpacked(path) as file:
        return file.read(SAMPLE_BYTES) + file.readline(LONGEST_LINE)


def decoded(path: Path, text: bytes, encoding: str) -> str:
    """Return bytes as text, but for a last letter that is cut; raises UnusableInput where they are
    none in this encoding.
    """
    try:
        return codecs.getincrementaldecoder(encoding)().decode(text)
    except (UnicodeDecodeError, LookupError) as error:
        raise not_text(path, encoding, error) from None


def other_format(path: Path, beginning: bytes) -> UnusableInput | None:
    """Return the line for a file of another format that is called as text is, else None."""
    for begins, what, suffix in _FORMATS:
        if beginning.startswith(begins):
            return UnusableInput(
                phrase(
                    "{file}: {what}, not text; rename it to end in {suffix}",
                    file=path,
                    what=what,
                    suffix=suffix,
                )
            )
    return None


def not_text(path: Path, encoding: str, error: Exception) -> UnusableInput:
    """Return the line for bytes that are no text in ``encoding``, or in none."""
    read = error.object if isinstance(error, UnicodeDecodeError) else b""
    if (other := other_format(path, read)) is not None:
        return other
    if len(read.translate(None, _OF_TEXT)) > BINARY * len(read):
        return UnusableInput(
            phrase(
                "{file}: not text in any encoding; export a table of text, or give the "
                "program's own file its own name (docs/formats.md)",
                file=path,
            )
        )
    return UnusableInput(
        phrase(
            '{file}: not text in {encoding} ({error}); state encoding = "…" under [csv] in '
            "the side file",
            file=path,
            encoding=encoding,
            error=error,
        )
    )


def whole_lines(path: Path, encoding: str, skip: int, ends: int | None = None) -> Iterator[bytes]:
    """Yield the lines of a file but the first ``skip``, in UTF-8, in pieces that end with a line.

    ``ends``: the line of a small file that what is below the table begins with.

    Raises UnusableInput for a line without an end, and bytes that are no text.
    """
    if ends is not None:
        text = b"".join(whole_lines(path, encoding, skip)).split(b"\n")
        yield b"\n".join(text[: ends - skip]) + b"\n"
        return
    rest = b""
    for block in _in_utf8(path, encoding):
        if skip:
            rest, skip = _below(rest + block, skip)
            begins = rest.rfind(b"\n") + 1
            if begins and not skip:
                yield rest[:begins]
                rest = rest[begins:]
        elif cut := block.rfind(b"\n") + 1:
            yield rest + block[:cut]
            rest = block[cut:]
        else:
            rest += block
        if len(rest) > LONGEST_LINE:
            raise UnusableInput(
                phrase(
                    "{file}: a line of more than {longest_line} bytes; {works}",
                    file=path,
                    longest_line=LONGEST_LINE,
                    works=phrase(WORKS),
                )
            )
    if rest.strip() and not skip:
        yield rest


def _below(text: bytes, skip: int) -> tuple[bytes, int]:
    """Return text without its first ``skip`` lines, and how many of them it lacked."""
    begins = 0
    while skip and (end := text.find(b"\n", begins) + 1):
        begins, skip = end, skip - 1
    return text[begins:], skip


def _in_utf8(path: Path, encoding: str) -> Iterator[bytes]:
    """Yield the text of a file in blocks of UTF-8, without the mark of its encoding.

    The last block ends with the end of a line, if the file's does or not: a row is whole there.
    """
    decoder = codecs.getincrementaldecoder(encoding)()
    with unpacked(path) as file:
        read = file.read(BLOCK_BYTES)
        mark = encoding_of(read[:SAMPLE_BYTES])[1]
        while read:
            text, mark = read[mark:], 0
            if encoding != "utf-8":
                try:
                    text = decoder.decode(text).encode()
                except UnicodeDecodeError as error:
                    raise not_text(path, encoding, error) from None
            yield text if len(read) == BLOCK_BYTES or text.endswith(b"\n") else text + b"\n"
            read = file.read(BLOCK_BYTES)
