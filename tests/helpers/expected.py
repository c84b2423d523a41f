"""Learns each sample job from its recordings and predicts it.

`python -m tests.helpers.expected` writes every `sample_jobs/JOB/expected.json` anew, or those of
the jobs that are named; a test compares.
"""

import json
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from autodb import __version__
from autodb.agent.answer.predicting import Predicted, predict_job
from autodb.agent.ingest.importing import import_file
from autodb.agent.operate.refreshing import refresh
from autodb.agent.rows.machines import add_machine
from autodb.agent.sense.calibrating import calibrate_machine
from autodb.assets import kit
from autodb.files.job import read_job
from autodb.files.machine import LATHE
from autodb.store import create_store, open_store

_SHAFT = "stepped_shaft/recordings/"
_FIRST_WEEK = tuple(
    _SHAFT + name for name in ("standard-cuts.csv", "standard-cut-raw.parquet", "shop-week-1.csv")
)
LEARNT_FROM = {
    "stepped_shaft": _FIRST_WEEK,
    "facing": (f"{_SHAFT}standard-cuts.csv", "facing/recordings/facing-week.csv"),
    "contour": (f"{_SHAFT}standard-cuts.csv", "contour/recordings/contour-week.csv"),
    "nc_profile": _FIRST_WEEK,
}
OF_CUTS = tuple(job for job in LEARNT_FROM if job != "nc_profile")
"""Jobs whose cuts have one condition each; a program's lines have not."""
MACHINE = "lathe-1"
DIGITS = 9


def answer(job: str, folder: Path, files: Sequence[Path] = ()) -> dict[str, Any]:
    """Return the prediction of a sample job, learnt in a new database in ``folder``.

    ``files``: what it is learnt from, in place of its own recordings.
    """
    url = f"sqlite:///{folder / 'autodb.sqlite3'}"
    create_store(url)
    store = open_store(url)
    try:
        add_machine(store, MACHINE, LATHE)
        for path in files or [kit("sample_jobs") / name for name in LEARNT_FROM[job]]:
            import_file(store, path, machine=MACHINE)
        calibrate_machine(store, MACHINE)
        refresh(store, MACHINE)
        predicted = predict_job(store, MACHINE, read_job(kit("sample_jobs") / job / "job.toml"))
    finally:
        store.close()
    found: dict[str, Any] = TypeAdapter(Predicted).dump_python(predicted, mode="json")
    return found


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    if isinstance(value, dict):
        return {key: _rounded(part) for key, part in value.items()}
    return value


def _write(job: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        cuts = [_rounded(cut) for cut in answer(job, Path(folder))["cuts"]]
    expected = {
        "computed_by": f"autodb {__version__}",
        "learnt_from": LEARNT_FROM[job],
        "cuts": cuts,
    }
    path = Path(str(kit("sample_jobs"))) / job / "expected.json"
    path.write_text(json.dumps(expected, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    for name in sys.argv[1:] or LEARNT_FROM:
        _write(name)
