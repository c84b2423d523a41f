"""Read 2 GB of every format under an address-space limit of 1 GiB, beside a plain reader.

`python -m benchmarks.large_files FOLDER [KIND …]` writes one file at a time into FOLDER, looks at
it with `autodb import` in a process of its own, reads it once more and by its library alone (text
by pyarrow, which is told how it is written), prints times and the address space that `import` took,
and removes the file. Of readings it is the processor's time: others may be at work beside it. MAT
is not among them: version 5 keeps no variable that can be read in part.
"""

import io
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
from asammdf import MDF, Signal
from nptdms import ChannelObject, TdmsWriter
from numpy.typing import NDArray
from pyarrow import csv, parquet

BYTES = 2_000_000_000
LIMIT = 1 << 30
RATE_HZ = 1000.0
BLOCK = 1_000_000
CHANNELS = tuple(f"{a}.{c}" for a in "xyz" for c in ("position", "current", "drive_force"))
NAMES = ("t", *CHANNELS)
LOOK = """
import sys
from autodb.cli import run
code = run(["import", sys.argv[1]])
peak = next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmPeak"))
print("VmPeak", peak)
sys.exit(code)
"""
READ = """
import os, sys
from pathlib import Path
from autodb.records.source import open_source
path, begun = Path(sys.argv[1]), sum(os.times()[:4])
for base in open_source(path).usable():
    for _ in base.blocks():
        pass
print("took", sum(os.times()[:4]) - begun)  # with the processes that it started
"""
TEXT = """
import sys, time
from pyarrow import csv
separator, decimal, above = sys.argv[2:]
begun = time.process_time()
encoding = "latin-1" if int(above) else "utf8"
told = csv.ReadOptions(skip_rows=int(above), block_size=1 << 24, encoding=encoding)
parsed = csv.ParseOptions(delimiter=separator)
for _ in csv.open_csv(sys.argv[1], told, parsed, csv.ConvertOptions(decimal_point=decimal)):
    pass
print("took", time.process_time() - begun)
"""
PLAIN = {
    "h5": """
import sys, time, h5py
begun = time.process_time()
with h5py.File(sys.argv[1]) as file:
    for start in range(0, len(file["t"]), 1 << 20):
        for one in file.values():
            one[start : start + (1 << 20)]
print("took", time.process_time() - begun)
""",
    "parquet": """
import sys, time
from pyarrow import parquet
begun = time.process_time()
for _ in parquet.ParquetFile(sys.argv[1]).iter_batches(1 << 20):
    pass
print("took", time.process_time() - begun)
""",
}

Block = dict[str, NDArray[np.float64]]


@dataclass(frozen=True)
class WrittenAs:
    """How a logger writes a text: its marks, and what stands above the rows."""

    separator: str = ","
    decimal: str = "."
    above: str = ""


WRITTEN = {
    "csv": WrittenAs(),
    "semicolons.csv": WrittenAs(";", ","),
    "logger.txt": WrittenAs("\t", ",", "Aufzeichnung Prüfstand\nAbtastrate: 1 kHz\n\n"),
}


def blocks() -> Iterator[Block]:
    """Yield blocks of noise without end."""
    rng, start = np.random.default_rng(0), 0
    while True:
        t = (start + np.arange(BLOCK)) / RATE_HZ
        yield {"t": t, **{name: np.round(rng.normal(0, 10, BLOCK), 6) for name in CHANNELS}}
        start += BLOCK


def _text(path: Path, written: WrittenAs) -> None:
    with path.open("wb") as file:
        file.write(written.above.encode("cp1252"))
        file.write((written.separator.join(NAMES) + "\n").encode())
        for block in blocks():
            text = io.BytesIO()
            options = csv.WriteOptions(include_header=False, delimiter=written.separator)
            csv.write_csv(pa.table(block), text, options)
            file.write(text.getvalue().replace(b".", written.decimal.encode()))
            if file.tell() > BYTES:
                return


def _parquet(path: Path) -> None:
    schema = pa.schema([(name, pa.float64()) for name in NAMES])
    with parquet.ParquetWriter(path, schema, compression="none") as file:
        for block in blocks():
            file.write_table(pa.table(block))
            if path.stat().st_size > BYTES:
                return


def _hdf5(path: Path) -> None:
    rows = BYTES // 8 // len(NAMES) // BLOCK * BLOCK
    with h5py.File(path, "w") as file:
        for name in NAMES:
            file.create_dataset(name, (rows,), dtype="f8")
        for start, block in zip(range(0, rows, BLOCK), blocks(), strict=False):
            for name, values in block.items():
                file[name][start : start + BLOCK] = values


def _tdms(path: Path) -> None:
    with TdmsWriter(path) as file:
        for block in blocks():
            file.write_segment([ChannelObject("log", name, v) for name, v in block.items()])
            if path.stat().st_size > BYTES:
                return


def _mf4(path: Path) -> None:
    rows, rng = BYTES // 8 // len(NAMES), np.random.default_rng(0)
    t = np.arange(rows) / RATE_HZ
    with MDF() as file:
        file.append([Signal(rng.normal(0, 10, rows), t, name=name) for name in CHANNELS])
        file.save(path, overwrite=True)


BINARY: dict[str, Callable[[Path], None]] = {
    "parquet": _parquet, "h5": _hdf5, "tdms": _tdms, "mf4": _mf4,
}  # fmt: skip


def _limited() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (LIMIT, LIMIT))


def _ran(code: str, path: Path, *more: str, limited: bool = False) -> str:
    """Return what a program said; its last line of trouble where it failed."""
    done = subprocess.run(
        [sys.executable, "-c", code, str(path), *more],
        capture_output=True, text=True, check=False, preexec_fn=_limited if limited else None,
    )  # fmt: skip
    if done.returncode:
        return f"exit {done.returncode}: {(done.stderr.strip().splitlines() or [''])[-1]}"
    return done.stdout


def look(path: Path) -> str:
    """Return what a look at the file under the limit took."""
    start = time.perf_counter()
    said = _ran(LOOK, path, limited=True)
    took_s = time.perf_counter() - start
    if "VmPeak" not in said:
        return said
    return f"{took_s:.1f} s, {int(said.split('VmPeak')[1]) / 1024:.0f} MiB of address space"


def read_beside(path: Path, kind: str) -> str:
    """Return how long reading takes under the limit, and a plain reader without it."""
    ours = _ran(READ, path, limited=True)
    if kind in WRITTEN:
        how = WRITTEN[kind]
        plain = _ran(TEXT, path, how.separator, how.decimal, str(how.above.count("\n")))
    elif kind in PLAIN:
        plain = _ran(PLAIN[kind], path)
    else:
        return f"read: {ours.strip()}"
    if not (ours.startswith("took") and plain.startswith("took")):
        return f"read: {ours.strip()}; plain: {plain.strip()}"
    ours_s, plain_s = float(ours.split()[1]), float(plain.split()[1])
    return f"read in {ours_s:.1f} s, plainly in {plain_s:.1f} s: {ours_s / plain_s:.2f} times"


def main(folder: Path, kinds: list[str]) -> None:
    """Write, look at, read and remove a file of each kind."""
    for kind in kinds or [*WRITTEN, *BINARY]:
        large = folder / f"large.{kind}"
        try:
            _text(large, WRITTEN[kind]) if kind in WRITTEN else BINARY[kind](large)
            size = f"{kind}, {large.stat().st_size / 1e9:.2f} GB"
            print(f"{size}: {look(large)}; {read_beside(large, kind)}", flush=True)
        finally:
            large.unlink(missing_ok=True)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit("usage: python -m benchmarks.large_files FOLDER [KIND …]")
    main(Path(sys.argv[1]), sys.argv[2:])
