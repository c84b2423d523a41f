"""Rebuild the load pulses of EMPS by a network trained on the file without them.

    python -m benchmarks.emps_network DATA_EMPS.mat DATA_EMPS_PULSES.mat

The network sees motion and place and learns what the drive model leaves of moves in air, in eight
pieces with gaps of a second. Beside it the drive model alone, filtered alike.
"""

import sys
from pathlib import Path

import numpy as np

from autodb import signals
from autodb.sensing.drives.feed_axis import identify
from autodb.sensing.drives.reconstruct import DriveModel
from autodb.sensing.network.drive_loads import LoadedDrive
from autodb.sensing.network.greybox import loads_of
from autodb.sensing.network.learning import train_grey_box
from autodb.sensing.network.recordings import channels_of, pieces_with_forces
from autodb.sensing.network.stream import network_forces
from benchmarks.emps_load import BANDWIDTHS_HZ, DIRECTED, ENDS_S, pulses_N, read


def rows(air_path: Path, cut_path: Path) -> list[tuple[float, str, float]]:
    """Return bandwidth, model and RMSE N of each way."""
    air, cut, added = read(air_path, by_law=False), read(cut_path, by_law=True), pulses_N(cut_path)
    drives = {"x": LoadedDrive(DriveModel.of(identify(air, terms=DIRECTED)), 1.0)}
    known, _ = pieces_with_forces([air], drives)
    box = train_grey_box(known, drives, rate_hz=air.rate_hz)
    tables, channels = box.tables(drives), channels_of(cut, drives)
    loads = {
        "with asymmetry": -loads_of(tables, channels)["x"],
        "and the network": network_forces(box, tables, channels).force_N[:, 0],
    }
    inner = slice(round(ENDS_S * cut.rate_hz), -round(ENDS_S * cut.rate_hz))
    found = []
    for hz in BANDWIDTHS_HZ:
        truth = signals.lowpass(added, rate_hz=cut.rate_hz, cutoff_hz=hz)
        for name, force in loads.items():
            passed = signals.lowpass(force, rate_hz=cut.rate_hz, cutoff_hz=hz)
            found.append((hz, name, float(np.sqrt(np.mean((passed - truth)[inner] ** 2)))))
    return found


if __name__ == "__main__":
    print("| bandwidth | model | RMSE |\n|---|---|---|")
    for hz, name, rmse in rows(Path(sys.argv[1]), Path(sys.argv[2])):
        print(f"| {hz:g} Hz | {name} | {rmse:.2f} N |")
