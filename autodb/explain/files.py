"""Write an answer: corrected.csv, report.html, explanation.json, all or nothing."""

import shutil
import tempfile
from pathlib import Path

import numpy as np
import pyarrow as pa
from pyarrow import csv

from autodb.errors import UnusableInput
from autodb.explain.answer import Explained
from autodb.explain.report import render_explanation

FILES = frozenset({"corrected.csv", "report.html", "explanation.json"})


def write_answer(explained: Explained, folder: Path) -> None:
    """Write the three files into ``folder``, which is replaced as a whole.

    Raises UnusableInput when ``folder`` is a file or holds anything but an earlier answer.
    """
    folder = folder.resolve()
    if folder.exists() and not folder.is_dir():
        raise UnusableInput(f"{folder}: is a file; --out needs a folder")
    if folder.is_dir() and {p.name for p in folder.iterdir()} - FILES:
        raise UnusableInput(f"{folder}: holds other files, it would be replaced; give a new --out")
    folder.parent.mkdir(parents=True, exist_ok=True)
    new = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
    try:
        new.chmod(0o755)
        _write(explained, new)
        _swap(new, folder)
    except BaseException:
        shutil.rmtree(new, ignore_errors=True)
        raise


def _write(explained: Explained, folder: Path) -> None:
    first = next(iter(explained.traces.values()))
    columns = {first.x_name: first.x, **{n: t.corrected for n, t in explained.traces.items()}}
    csv.write_csv(
        pa.table({k: np.asarray(v) for k, v in columns.items()}), folder / "corrected.csv"
    )
    text = explained.explanation.model_dump_json(indent=1)
    (folder / "explanation.json").write_text(text + "\n", encoding="utf-8")
    (folder / "report.html").write_text(render_explanation(explained), encoding="utf-8")


def _swap(new: Path, folder: Path) -> None:
    """Put ``new`` in the place of ``folder``; the old one is away only between two renames."""
    if not folder.exists():
        new.rename(folder)
        return
    old = new.with_name(new.name + "-old")
    folder.rename(old)
    try:
        new.rename(folder)
    except BaseException:
        old.rename(folder)
        raise
    shutil.rmtree(old)
