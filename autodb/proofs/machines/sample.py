"""Writes the sample jobs' recordings: `python -m autodb.proofs.machines.sample sample_jobs`.

Machine `lathe-1`, pair `steel bar / carbide insert`; a made machine and a chosen material truth.
The same bytes every time: seeds are fixed, chosen once.
"""

import csv
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.machines.axis.axis import HORIZONTAL, air_moves
from autodb.proofs.machines.lathe.jobs import cut_at, standard_cuts, week_1_cuts, week_2_cuts
from autodb.proofs.machines.lathe.lathe import Lathe, cut_table
from autodb.proofs.machines.lathe.phases import raw_cut
from autodb.proofs.machines.lathe.process import (
    ENTERING_DEG,
    NOSE_MM,
    STEEL,
    Array,
    TrueCut,
    mean_forces_N,
)
from autodb.proofs.machines.lathe.profiles import contour_week_cuts, facing_week_cuts

SAMPLE_MACHINE = "lathe-1"
SAMPLE_LATHE = Lathe.draw(1)
SAMPLE_PAIR = STEEL
RAW_CUT = cut_at((2.0, 0.20, 1500.0, 62.0), edge="standard-5", duration_s=8.0)
RAKE_DEG, INCLINATION_DEG = -6.0, -7.0  # P1, note under Table 2

SIDE_FILE = f"""\
[recording]
machine = "{SAMPLE_MACHINE}"
kind = "turning"
work = "{RAW_CUT.material}"

[tool]
name = "{SAMPLE_PAIR.tool}"
nose_radius_mm = {NOSE_MM}
kappa_deg = {ENTERING_DEG}
rake_deg = {RAKE_DEG}
inclination_deg = {INCLINATION_DEG}

[cut]
operation = "{RAW_CUT.operation}"
depth_mm = {RAW_CUT.depth_mm}
feed_mm_rev = {RAW_CUT.feed_mm}
speed_rpm = {RAW_CUT.spindle_rpm:.1f}
"""


def job_forces_N(cuts: Sequence[TrueCut]) -> Array:
    """Noise-free mean forces (cuts, 3) of the sample pair on the sample lathe, N, in x, y, z."""
    return SAMPLE_LATHE.work_factor * np.array([mean_forces_N(SAMPLE_PAIR, cut) for cut in cuts])


def text(value: Any) -> str:
    """A cell of a CSV file: numbers with seven digits."""
    return f"{value:.7g}" if isinstance(value, float) else str(value)


def write_csv(path: Path, table: Mapping[str, NDArray[Any]]) -> None:
    """Columns to a CSV file with a header line."""
    with path.open("w", newline="", encoding="utf-8") as file:
        lines = csv.writer(file, lineterminator="\n")
        lines.writerow(table)
        columns = [column.tolist() for column in table.values()]
        lines.writerows([text(value) for value in row] for row in zip(*columns, strict=True))


def write_parquet(path: Path, table: Mapping[str, NDArray[Any]]) -> None:
    """Columns to a Parquet file; all but `t` in single precision, about seven digits."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = {
        name: values if name == "t" else values.astype(np.float32) for name, values in table.items()
    }
    pq.write_table(pa.table(columns), path, compression="zstd")


def write_sample(folder: Path) -> None:
    """All recordings of the sample jobs, each into `JOB/recordings` of a folder."""
    write_shaft(folder / "stepped_shaft" / "recordings")
    for job, week, seed in (
        ("facing", facing_week_cuts(), 26),
        ("contour", contour_week_cuts(), 27),
    ):
        recordings = folder / job / "recordings"
        recordings.mkdir(parents=True, exist_ok=True)
        table = cut_table(SAMPLE_LATHE, SAMPLE_PAIR, week, seed, False)
        write_csv(recordings / f"{job}-week.csv", table)


def write_shaft(folder: Path) -> None:
    """The recordings of the stepped shaft, which the demo learns from."""
    folder.mkdir(parents=True, exist_ok=True)
    measured = {
        "standard-cuts": cut_table(SAMPLE_LATHE, SAMPLE_PAIR, standard_cuts(), 21, True),
        "shop-week-1": cut_table(SAMPLE_LATHE, SAMPLE_PAIR, week_1_cuts(), 22, False),
        "shop-week-2": cut_table(SAMPLE_LATHE, SAMPLE_PAIR, week_2_cuts(), 23, False),
    }
    moves, _ = air_moves(24, slide=HORIZONTAL)
    measured["air-moves"] = {name.replace("x.", "z."): column for name, column in moves.items()}
    for name, table in measured.items():
        write_csv(folder / f"{name}.csv", table)

    raw = raw_cut(SAMPLE_LATHE, SAMPLE_PAIR, RAW_CUT, 25, True)
    write_parquet(folder / "standard-cut-raw.parquet", raw)
    (folder / "standard-cut-raw.toml").write_text(SIDE_FILE, encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python -m autodb.proofs.machines.sample DIR")
    write_sample(Path(sys.argv[1]))
