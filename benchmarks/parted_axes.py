"""Friction of real axes fitted on parts of their recordings: how often the intervals of two agree.

    python -m benchmarks.parted_axes SHARED_DATA

Each recording is cut into three parts of equal time; the EMPS axis has two recordings, one with
pulses beside its moves. Inertia, Coulomb and viscous friction, and friction at a
third and two thirds of the lower top speed both ways, of two parts of one axis agree where their
difference is within 1.96 of its standard deviations. Beside it plain least squares.
"""

import sys
from collections import defaultdict
from itertools import combinations, pairwise
from pathlib import Path

import numpy as np

from autodb.assets import kit
from autodb.errors import UnusableInput
from autodb.records import source as records
from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import identify
from autodb.sensing.drives.fit.axis_model import Identified

PARTS = 3
REAL = ("tx40-j1", "tx40-j4", "laas-acc", "laas-acc40", "smart-x", "smart-y", "tiago-torso")
OWN = ("inertia", "coulomb", "viscous")


def recordings(folder: Path) -> dict[str, list[Recording]]:
    """Return the recordings of each axis."""
    found = {name: [_read(folder / "real" / f"{name}-null" / "recording.csv")] for name in REAL}
    columns = kit("sample_jobs") / "emps" / "columns.toml"
    plain = _read(folder / "emps" / "DATA_EMPS.mat", columns)
    pulsed = _read(folder / "emps" / "DATA_EMPS_PULSES.mat", columns)
    return {"emps": [plain, pulsed], **found}


def _read(path: Path, columns: Path | None = None) -> Recording:
    read = records.read(path, columns=columns)
    if not isinstance(read, Recording):
        sys.exit(f"{path}: not a recording over time")
    return read


def parts(recording: Recording) -> list[Recording]:
    """Return it in parts of equal time."""
    edges = np.linspace(0, len(recording), PARTS + 1).astype(int)
    return [
        Recording(
            path=recording.path,
            channels={name: values[a:b] for name, values in recording.channels.items()},
        )
        for a, b in pairwise(edges.tolist())
    ]


def compared(a: Identified, b: Identified) -> dict[str, tuple[float, float]]:
    """Return the differences of two fits in standard deviations: ours, plain least squares'."""
    found = {}
    for name in OWN:
        own, plain = (
            [next((t for t in terms if t.term == name), None) for terms in both]
            for both in ((a.fitted, b.fitted), (a.plain.terms, b.plain.terms))
        )
        z = [
            (one.value - other.value) / np.hypot(one.sd or 0.0, other.sd or 0.0)
            for one, other in (own, plain)
            if one is not None and other is not None
        ]
        if len(z) == 2:
            found[name] = (float(z[0]), float(z[1]))
    if a.steady is not None and b.steady is not None:
        top = min(a.steady.off_law.highest_mm_s, b.steady.off_law.highest_mm_s)
        speeds = top * np.array([-2.0, -1.0, 1.0, 2.0]) / 3.0
        (one, one_sd), (other, other_sd) = (m.friction(speeds) for m in (a.steady, b.steady))
        for v, z in zip(speeds, (one - other) / np.hypot(one_sd, other_sd), strict=True):
            found[f"friction at {v / top:+.0%}"] = (float(z), np.nan)
    return found


def main(folder: Path) -> None:
    """Print the shares that agree, by axis and by quantity."""
    shares: dict[str, list[tuple[float, float]]] = defaultdict(list)
    for name, axis in recordings(folder).items():
        fits = []
        for part in [part for one in axis for part in parts(one)]:
            try:
                fits.append(identify(part))
            except UnusableInput as error:
                print(f"{name}: {error}")
        for a, b in combinations(fits, 2):
            for quantity, z in compared(a, b).items():
                shares[name].append(z)
                shares[quantity].append(z)
                shares["all"].append(z)
    for name, found in shares.items():
        z = np.abs(np.array(found))
        ours, plain = z[:, 0], z[np.isfinite(z[:, 1]), 1]
        print(
            f"{name:20} {len(z):4} ours agree {np.mean(ours < 1.96):6.1%} (rms "
            f"{np.sqrt(np.mean(ours**2)):.2f} sd), plain {np.mean(plain < 1.96):6.1%} (rms "
            f"{np.sqrt(np.mean(plain**2)) if len(plain) else np.nan:.2f} sd)"
        )


if __name__ == "__main__":
    main(Path(sys.argv[1]))
