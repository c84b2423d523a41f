"""Summarise 2 GB of every format under an address-space limit of 1 GiB.

`python -m benchmarks.large_files FOLDER` writes one file at a time into FOLDER, looks at it with
`autodb import` in a process of its own, prints the time and the address space it took, and removes
the file. MAT is not among them: version 5 keeps no variable that can be read in part.
"""

import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
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
LOOK = """
import resource, sys
from autodb.cli import run
code = run(["import", sys.argv[1]])
peak = next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmPeak"))
print("VmPeak", peak)
sys.exit(code)
"""

Block = dict[str, NDArray[np.float64]]


def blocks() -> Iterator[Block]:
    """Yield blocks of noise without end."""
    rng, start = np.random.default_rng(0), 0
    while True:
        t = (start + np.arange(BLOCK)) / RATE_HZ
        yield {"t": t, **{name: np.round(rng.normal(0, 10, BLOCK), 6) for name in CHANNELS}}
        start += BLOCK


def _csv(path: Path) -> None:
    with path.open("wb") as file:
        for number, block in enumerate(blocks()):
            options = csv.WriteOptions(include_header=number == 0)
            csv.write_csv(pa.table(block), file, options)
            if file.tell() > BYTES:
                return


def _parquet(path: Path) -> None:
    schema = pa.schema([(name, pa.float64()) for name in ("t", *CHANNELS)])
    with parquet.ParquetWriter(path, schema, compression="none") as file:
        for block in blocks():
            file.write_table(pa.table(block))
            if path.stat().st_size > BYTES:
                return


def _hdf5(path: Path) -> None:
    rows = BYTES // 8 // (1 + len(CHANNELS)) // BLOCK * BLOCK
    with h5py.File(path, "w") as file:
        for name in ("t", *CHANNELS):
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
    rows, rng = BYTES // 8 // (1 + len(CHANNELS)), np.random.default_rng(0)
    t = np.arange(rows) / RATE_HZ
    with MDF() as file:
        file.append([Signal(rng.normal(0, 10, rows), t, name=name) for name in CHANNELS])
        file.save(path, overwrite=True)


WRITERS: dict[str, Callable[[Path], None]] = {
    "csv": _csv, "parquet": _parquet, "h5": _hdf5, "tdms": _tdms, "mf4": _mf4,
}  # fmt: skip


def _limited() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (LIMIT, LIMIT))


def look(path: Path) -> str:
    """Return what a look at the file under the limit took."""
    start = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", LOOK, str(path)],
        capture_output=True, text=True, check=False, preexec_fn=_limited,
    )  # fmt: skip
    took_s = time.perf_counter() - start
    if done.returncode:
        return f"exit {done.returncode}: {(done.stderr.strip().splitlines() or [''])[-1]}"
    peak_mib = int(done.stdout.split("VmPeak")[1]) / 1024
    return f"{took_s:.1f} s, {peak_mib:.0f} MiB of address space"


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python -m benchmarks.large_files FOLDER")
    for suffix, writer in WRITERS.items():
        large = Path(sys.argv[1]) / f"large.{suffix}"
        try:
            writer(large)
            print(f"{suffix}, {large.stat().st_size / 1e9:.2f} GB: {look(large)}", flush=True)
        finally:
            large.unlink(missing_ok=True)
