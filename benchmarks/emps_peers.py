"""Rebuild the load pulses of EMPS by a Kalman filter as a disturbance observer, beside autodb.

    python -m benchmarks.emps_peers DATA_EMPS.mat DATA_EMPS_PULSES.mat OUT.json

filterpy's filter has the states place, speed and load; the load walks at random. Mass, friction and
offset are those of plain least squares on the file without pulses, as for autodb. How much place
and load scatter is what makes the innovations likeliest: no load is looked at. The smoother sees
what comes later, as `reconstruct` does. Needs filterpy 2.0.0 beside autodb.
"""

import sys
from dataclasses import dataclass
from importlib.metadata import version
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

import autodb
from autodb import signals
from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import identify
from autodb.sensing.drives.fit.axis_model import PlainFit
from autodb.sensing.drives.reconstruct import DriveModel, observe, reconstruct
from benchmarks.emps_load import DIRECTED, ENDS_S, pulses_N, read

Array = NDArray[np.float64]

BANDWIDTH_HZ = 10.0
PLACE_MM = (1e-3, 3e-3, 1e-2)
WALKS_N = (0.3, 1.0, 3.0, 10.0)
"""What the load walks in a step of 1 ms, one standard deviation."""
ROUNDS_MM_S = 1.0
"""Speed within which friction turns, so that a filter does not chatter at rest."""


@dataclass(frozen=True)
class LoadError:
    """Error of a way to rebuild the pulses up to 10 Hz: RMSE in N."""

    method: str
    version: str
    rmse_N: float


ROWS: TypeAdapter[tuple[LoadError, ...]] = TypeAdapter(tuple[LoadError, ...])


def walked(cut: Recording, plain: PlainFit, place_mm: float, walk_N: float) -> tuple[float, Array]:
    """Return the log-likelihood of the innovations, and the load (n,), N."""
    from filterpy.kalman import KalmanFilter

    step_s, mass = 1.0 / cut.rate_hz, plain.value("inertia")
    place, effort = cut["x.position"], cut["x.drive_force"]
    offset = sum(one.value for one in plain.terms if one.term == "gravity")
    seen = KalmanFilter(dim_x=3, dim_z=1, dim_u=1)
    seen.x = np.array([[place[0]], [0.0], [0.0]])
    seen.F = np.array([[1.0, step_s, 0.0], [0.0, 1.0, step_s / mass], [0.0, 0.0, 1.0]])
    seen.B = np.array([[0.0], [step_s / mass], [0.0]])
    seen.H = np.array([[1.0, 0.0, 0.0]])
    seen.P = np.diag([1.0, 1e4, 1e4])
    seen.Q = np.diag([0.0, 1e-6, walk_N**2])
    seen.R = np.array([[place_mm**2]])
    loads, likely = [], 0.0
    for measured, drive in zip(place, effort, strict=True):
        speed = float(seen.x[1, 0])
        friction = plain.value("coulomb") * np.tanh(speed / ROUNDS_MM_S)
        friction += plain.value("viscous") * speed
        seen.predict(u=np.array([[drive - friction - offset]]))
        seen.update(np.array([[measured]]))
        likely += float(seen.log_likelihood)
        loads.append(float(seen.x[2, 0]))
    return likely, np.array(loads)


def rows(air_path: Path, cut_path: Path) -> tuple[LoadError, ...]:
    """Return the errors of autodb and of the filter."""
    air, cut, added = read(air_path, by_law=False), read(cut_path, by_law=True), pulses_N(cut_path)
    model = identify(air, terms=DIRECTED)
    inner = slice(round(ENDS_S * cut.rate_hz), -round(ENDS_S * cut.rate_hz))

    def low(values: Array) -> Array:
        return signals.lowpass(values, rate_hz=cut.rate_hz, cutoff_hz=BANDWIDTH_HZ)[inner]

    def error(found: Array) -> float:
        return float(np.sqrt(np.mean((found - low(added)) ** 2)))

    plain = identify(air).plain
    _, filtered = max(
        (walked(cut, plain, *sizes) for sizes in product(PLACE_MM, WALKS_N)),
        key=lambda one: one[0],
    )
    ours, used = DriveModel.of(model), f"autodb {autodb.__version__}"
    whole = reconstruct(cut, ours, bandwidth_hz=BANDWIDTH_HZ).value[inner]
    seen = observe(cut, ours, bandwidth_hz=BANDWIDTH_HZ).value
    delay = round(np.sqrt(2.0) / (2.0 * np.pi * BANDWIDTH_HZ) * cut.rate_hz)
    return (
        LoadError("reconstruct", used, error(-whole)),
        LoadError("observe", used, error(-np.roll(seen, -delay)[inner])),
        LoadError("Kalman filter", f"filterpy {version('filterpy')}", error(low(filtered))),
    )


if __name__ == "__main__":
    found = rows(Path(sys.argv[1]), Path(sys.argv[2]))
    Path(sys.argv[3]).write_bytes(ROWS.dump_json(found, indent=1) + b"\n")
    for one in found:
        print(f"{one.method} ({one.version}): {one.rmse_N:.2f} N")
