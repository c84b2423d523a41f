"""Writes small recordings in every format that is read, for the tests and the page of refusals."""

import gzip
import json
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pyarrow as pa
from asammdf import MDF, Signal
from nptdms import ChannelObject, TdmsWriter
from openpyxl import Workbook
from pyarrow import csv, parquet
from scipy.io import savemat

Groups = Mapping[str, Mapping[str, Any]]
"""Columns of each time base by its name."""


def write(path: Path, columns: Mapping[str, Any]) -> Path:
    """Write one time base in the format of the file's name; return the path."""
    if path.suffix == ".csv":
        csv.write_csv(pa.table(dict(columns)), path)
    elif path.suffix in (".gz", ".zip"):
        text = write(path.with_suffix(".csv"), columns).read_bytes()
        if path.suffix == ".gz":
            path.write_bytes(gzip.compress(text))
        else:
            with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
                archive.writestr("a.csv", text)
    elif path.suffix == ".xlsx":
        write_workbook(path, {"only": [list(columns), *zip(*columns.values(), strict=True)]})
    elif path.suffix == ".parquet":
        parquet.write_table(pa.table(dict(columns)), path)
    elif path.suffix == ".xml":
        write_trace(path, columns)
    elif path.suffix == ".json":
        write_edge(path, columns)
    elif path.suffix == ".mat":
        savemat(path, {k: np.asarray(v)[:, None] for k, v in columns.items()} | {"gain": 3.0})
    else:
        write_groups(path, {"only": columns})
    return path


def write_trace(path: Path, columns: Mapping[str, Any], interval_s: float = 0.01) -> Path:
    """Write signals of one interval, time left out, as a trace of a SINUMERIK; return the path."""
    names = [name for name in columns if name != "t"]
    rows = len(next(iter(columns.values())))
    signals = "".join(
        f'<dataSignal interval="{interval_s}" id="f{k}" description="{name}" '
        f'datapointCount="{rows}" name="/Nck/{k}"/>\n'
        for k, name in enumerate(names)
    )
    said = ["" for _ in names]
    records = []
    for row in range(rows):
        new = [f"{columns[name][row]:.9g}" for name in names]
        changed = [f'f{k}="{n}"' for k, (n, o) in enumerate(zip(new, said, strict=True)) if n != o]
        records.append(f'<rec time="{row * interval_s:.6f}" {" ".join(changed)}/>\n')
        said = new
    frame = f"<dataFrame>\n{signals}{''.join(records)}</dataFrame>"
    path.write_text(f"<traceSession><traceData>{frame}</traceData></traceSession>")
    return path


def write_edge(path: Path, columns: Mapping[str, Any], cycle_ms: float = 10.0) -> Path:
    """Write signals, time left out, as a recording of a SINUMERIK Edge; return the path."""
    names = [name for name in columns if name != "t"]
    signals = [{"Name": "Cycle", "Axis": "CYCLE", "Address": "CYCLE"}]
    signals += [{"Name": name, "Axis": "", "Address": f"{name}|1"} for name in names]
    values = np.column_stack([np.asarray(columns[name], dtype=float) for name in names]).tolist()
    rows = [[700 + number, *row] for number, row in enumerate(values)]
    parts = [{"HFData": rows[at : at + 16]} for at in range(0, len(rows), 16)]
    header = {"SignalListHFData": signals, "CycleTimeMs": cycle_ms}
    path.write_text(json.dumps({"Header": header, "Payload": parts}))
    return path


def write_workbook(path: Path, sheets: Mapping[str, Sequence[Sequence[Any]]]) -> Path:
    """Write rows of cells as sheets of a workbook; return the path."""
    book = Workbook()
    book.remove(book.worksheets[0])
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append([cell.item() if isinstance(cell, np.generic) else cell for cell in row])
    book.save(path)
    return path


def write_groups(path: Path, groups: Groups) -> Path:
    """Write several time bases, each with a column `t`, as HDF5, TDMS or MF4; return the path."""
    if path.suffix == ".h5":
        with h5py.File(path, "w") as file:
            for group, columns in groups.items():
                for name, values in columns.items():
                    file[f"{group}/{name}"] = np.asarray(values)
    elif path.suffix == ".tdms":
        with TdmsWriter(path) as file:
            file.write_segment(
                [
                    ChannelObject(group, name, np.asarray(values))
                    for group, columns in groups.items()
                    for name, values in columns.items()
                ]
            )
    else:
        with MDF() as file:
            for group, columns in groups.items():
                t = np.asarray(columns["t"], dtype=float)
                named = {name: values for name, values in columns.items() if name != "t"}
                file.append(
                    [Signal(np.asarray(v), t, name=name) for name, v in named.items()],
                    comment=group,
                )
            file.save(path, overwrite=True)
    return path
