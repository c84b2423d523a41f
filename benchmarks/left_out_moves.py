"""Loads of real axes in air, on thirds of recordings and on recordings that were left out: error
against plain least squares, and how often 95 % intervals hold.

    python -m benchmarks.left_out_moves SHARED_DATA [EXPERIMENTS]

Nothing loads these axes but their own friction, so that the true load is 0 (a mill's loads while it
cuts wax are small). The first and the last third of each recording are left out in turn.
EXPERIMENTS holds experiment_01.csv to experiment_18.csv of the SMART lab (folder data of
ejhusom/cnc_milling_tool_wear on GitHub): seven are fitted, seven others are left out. Plain least
squares: Coulomb, viscous, weight and inertia, at the same cutoff and with the same direction. Rows
in motion count, but for *all*.
"""

import csv
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb import signals
from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import identify
from autodb.sensing.drives.moves.motion import protocol_of, term_inputs
from autodb.sensing.drives.moves.prepared import effort_axis, effort_channel
from autodb.sensing.drives.reconstruct import DriveLoad, DriveModel, reconstruct
from benchmarks.parted_axes import recordings

Array = NDArray[np.float64]

BANDWIDTHS_HZ = (1.0, 5.0, 20.0)
FITTED, LEFT_OUT = (1, 3, 6, 8, 11, 14, 17), (2, 5, 7, 9, 12, 15, 18)
AIR = {"starting", "prep", "repositioning", "end"}
COLUMNS = {
    "position": "ActualPosition",
    "velocity": "ActualVelocity",
    "acceleration": "ActualAcceleration",
    "current": "CurrentFeedback",
}
STEP_S = 0.1

Rows = tuple[Array, Array, Array]
"""Load of ours, its sd, and what plain least squares leave, (n,) each."""


def plain_load(fitted: Recording, other: Recording, bandwidth_hz: float) -> Array:
    """Return what plain least squares of one recording leave (n,) of another."""
    axis, effort = effort_axis(fitted, None), effort_channel(fitted, None)

    def design(one: Recording) -> Array:
        moved = term_inputs(one, axis, cutoff_hz=protocol_of(one, axis).cutoff_hz)
        names = ("direction", "velocity", "acceleration")
        return np.column_stack([*(moved[name] for name in names), np.ones(len(one))])

    cutoff_hz = protocol_of(fitted, axis).cutoff_hz
    both = np.column_stack([design(fitted), fitted[effort]])
    smooth = [signals.lowpass_pieces(c, fitted.timing, cutoff_hz=cutoff_hz) for c in both.T]
    told = np.linalg.lstsq(np.column_stack(smooth[:-1]), smooth[-1], rcond=None)[0]
    left = other[effort] - design(other) @ told
    return signals.lowpass_pieces(left, other.timing, cutoff_hz=bandwidth_hz)


def compared(fitted: Recording, other: Recording, bandwidth_hz: float) -> tuple[DriveLoad, Rows]:
    """Return the load of a recording by a model of another, and its rows."""
    model = DriveModel.of(identify(fitted, axis=effort_axis(fitted, None)))
    load = reconstruct(other, model, bandwidth_hz=bandwidth_hz)
    return load, (load.value, load.sd, plain_load(fitted, other, bandwidth_hz))


def thirds(recording: Recording) -> Iterator[tuple[Recording, Recording]]:
    """Return what is fitted and what is left out: the first third, then the last."""
    third = len(recording) // 3
    for a, b in ((third, 0), (0, 2 * third)):
        rows = slice(a, a + 2 * third), slice(b, b + third)
        fitted, other = (
            Recording(recording.path, {n: v[r] for n, v in recording.channels.items()})
            for r in rows
        )
        yield fitted, other


def experiment(path: Path, axis: str) -> tuple[Recording, NDArray[np.bool_]]:
    """Return an axis of an experiment, and which rows (n,) are in air by its own words."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    channels = {
        f"{axis.lower()}.{name}": np.array([float(row[f"{axis}1_{column}"]) for row in rows])
        for name, column in COLUMNS.items()
    }
    t: Array = STEP_S * np.arange(len(rows), dtype=np.float64)
    air = np.array([row["Machining_Process"].lower() in AIR for row in rows])
    return Recording(path, {"t": t, **channels}), air


def told(name: str, found: list[tuple[Rows, NDArray[np.bool_]]]) -> None:
    """Print one line of the rows (n,) that count."""
    value, sd, plain = (
        np.concatenate([rows[k][counts] for rows, counts in found]) for k in range(3)
    )
    ours, peer = (float(np.sqrt(np.mean(one**2))) for one in (value, plain))
    held = float(np.mean(np.abs(value) < 1.96 * sd))
    width = float(np.median(sd)) / ours
    print(
        f"{name:32} ours {ours:8.4f} plain {peer:8.4f} ratio {ours / peer:.3f} held {held:6.1%} "
        f"sd over rms {width:.2f}"
    )


def main(data: Path, experiments: Path | None) -> None:
    """Print ratios and shares that hold."""
    for name, (first, *_) in recordings(data).items():
        for hz in BANDWIDTHS_HZ:
            if hz < 0.4 * first.timing.rate_hz:
                both = [compared(a, b, hz) for a, b in thirds(first)]
                told(f"{name}, {hz:g} Hz", [(rows, ~load.standing) for load, rows in both])
    if experiments is None:
        return
    for axis in "XY":
        found: dict[str, list[tuple[Rows, NDArray[np.bool_]]]] = {"air": [], "cut": [], "all": []}
        fitted = [experiment(experiments / f"experiment_{i:02}.csv", axis)[0] for i in FITTED]
        others = [experiment(experiments / f"experiment_{i:02}.csv", axis) for i in LEFT_OUT]
        for one in fitted:
            for other, air in others:
                load, rows = compared(one, other, BANDWIDTHS_HZ[0])
                moves = ~load.standing
                found["air"].append((rows, air & moves))
                found["cut"].append((rows, ~air & moves))
                found["all"].append((rows, np.ones_like(moves)))
        for state, lines in found.items():
            told(f"SMART {axis}, {state}, 1 Hz", lines)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]) if len(sys.argv) > 2 else None)
