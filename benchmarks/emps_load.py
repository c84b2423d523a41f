"""Rebuild the load pulses of EMPS from position and reference, the pulses' channel unread.

    python -m benchmarks.emps_load DATA_EMPS.mat DATA_EMPS_PULSES.mat

The drive's effort is that of the controller's law, gtau (kp kv (qg − qm) − kv v), whose gains the
data state; it lacks the pulses, which the axis therefore shows as a load. Fitted to the first file.
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.io import loadmat

from autodb import signals
from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import identify, predict_effort
from autodb.sensing.drives.fit.axis_model import IdentifiedTerm
from autodb.sensing.drives.reconstruct import DriveModel, observe, reconstruct

Array = NDArray[np.float64]

NEWTONS_PER_VOLT, KP, KV = 35.15065188, 160.18, 243.45
PULSES = 1.014 * NEWTONS_PER_VOLT
"""Newtons a unit of pulses_N, by the data's own description."""
BANDWIDTHS_HZ = (2.0, 10.0, 50.0)
ENDS_S = 0.5
DIRECTED = ("inertia", "viscous", "coulomb", "gravity", "asymmetry")


def read(path: Path, *, by_law: bool) -> Recording:
    """Return a file in s, mm and N; ``by_law``: with the effort of the controller's law."""
    table = loadmat(path)
    t, q, goal = (table[name].ravel().astype(np.float64) for name in ("t", "qm", "qg"))
    law = KP * KV * (goal - q) - KV * np.gradient(q, t)
    volts = law if by_law else table["vir"].ravel().astype(np.float64)
    channels = {
        "t": t - t[0],
        "x.position": 1000.0 * q,
        "x.drive_force": NEWTONS_PER_VOLT * volts,
    }
    return Recording(path=path, channels=channels)


def pulses_N(path: Path) -> Array:
    """Return the load that was added, N: what is to be rebuilt."""
    return np.asarray(PULSES * loadmat(path)["pulses_N"].ravel())


def _plain(cut: Recording, terms: list[IdentifiedTerm], bandwidth_hz: float) -> Array:
    whole = cut["x.drive_force"] - predict_effort(cut, "x", terms)
    return signals.lowpass(whole, rate_hz=cut.rate_hz, cutoff_hz=bandwidth_hz)


def main(air_path: Path, cut_path: Path) -> None:
    """Print error and slope at each bandwidth, beside the symmetric model by least squares."""
    air, cut, added = read(air_path, by_law=False), read(cut_path, by_law=True), pulses_N(cut_path)
    symmetric, directed = identify(air), identify(air, terms=DIRECTED)
    inner = slice(round(ENDS_S * cut.rate_hz), -round(ENDS_S * cut.rate_hz))
    print("| bandwidth | model | RMSE | slope | 95 % intervals hold |")
    print("|---|---|---|---|---|")
    for hz in BANDWIDTHS_HZ:
        truth = signals.lowpass(added, rate_hz=cut.rate_hz, cutoff_hz=hz)[inner]
        plain = _plain(cut, [*symmetric.plain.terms, *symmetric.plain.given], hz)
        _row(hz, "symmetric, plain least squares", -plain[inner], truth, None)
        for name, model in (("symmetric", symmetric), ("with asymmetry", directed)):
            load = reconstruct(cut, DriveModel.of(model), bandwidth_hz=hz)
            _row(hz, name, -load.value[inner], truth, load.sd[inner])
        seen = observe(cut, DriveModel.of(directed), bandwidth_hz=hz)
        late = round(np.sqrt(2.0) / (2.0 * np.pi * hz) * cut.rate_hz)
        passed = -np.roll(seen.value, -late)[inner]
        _row(hz, f"with asymmetry, observer, {late} ms late", passed, truth, None)


def _row(hz: float, name: str, found: Array, truth: Array, sd: Array | None) -> None:
    error = found - truth
    slope = float(np.polyfit(truth, found, 1)[0])
    rmse = float(np.sqrt(np.mean(error**2)))
    held = "" if sd is None else f"{100.0 * float(np.mean(np.abs(error) < 1.96 * sd)):.1f} %"
    print(f"| {hz:g} Hz | {name} | {rmse:.2f} N | {slope:.4f} | {held} |")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
