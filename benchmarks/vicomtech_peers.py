"""Feed force from currents on tools left out: scikit-learn beside `calibrate`, Vicomtech's table.

    python -m benchmarks.vicomtech_peers Dataset_Machine_tool_wear.csv OUT.json

Every tool is sensed by a calibration on the others, as in `benchmarks.vicomtech_force`.
scikit-learn gets the one current that `calibrate` gets, and then all that drives and control tell
(columns I and CV3 without empty cells: no accelerometer, no sound, no force); settings are its own.
Needs scikit-learn 1.9.1 beside autodb.
"""

import csv
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

import autodb
from benchmarks.vicomtech_force import BEST, TRANSIENT, difference, on_tool, rms, with_current
from benchmarks.vicomtech_wear import read

Array = NDArray[np.float64]

DRIVES = ("I", "CV3")
"""How names of columns begin that a machine has without sensors of its own."""


@dataclass(frozen=True)
class FeedForceError:
    """RMSE of a way on tools left out, N, less autodb's with a 95 % interval over tools."""

    method: str
    version: str
    inputs: str
    rmse_N: float
    tools: int
    less_low_N: float
    less_high_N: float


ROWS: TypeAdapter[tuple[FeedForceError, ...]] = TypeAdapter(tuple[FeedForceError, ...])


def ways() -> dict[str, Callable[[], Any]]:
    """Return scikit-learn's ways by name."""
    from sklearn.ensemble import HistGradientBoostingRegressor, RandomForestRegressor
    from sklearn.linear_model import RidgeCV
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import StandardScaler

    return {
        "ridge": lambda: make_pipeline(StandardScaler(), RidgeCV(np.geomspace(0.1, 1000.0, 9))),
        "random forest": lambda: RandomForestRegressor(random_state=0),
        "boosted trees": lambda: HistGradientBoostingRegressor(random_state=0),
    }


def inputs(path: Path) -> dict[str, Array]:
    """Return columns (n, p) by what they are: one current, and all that drives tell."""
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    named = [n for n in rows[0] if n.startswith(DRIVES) and all(row[n] for row in rows)]
    whole = np.array([[float(row[name]) for name in named] for row in rows])
    return {"one current": whole[:, [named.index(BEST)]], f"{len(named)} columns": whole}


def rows(path: Path) -> tuple[FeedForceError, ...]:
    """Return autodb's row, then scikit-learn's by inputs and way."""
    whole = read(path)
    kept = ~np.isin(whole.cut, TRANSIENT)
    table = with_current(whole, path, BEST)
    edge, force = table["tool.edge"], table["force.z"]
    tools = np.unique(edge)
    ours = [on_tool(table, tool).chosen_N for tool in tools]
    used = f"autodb {autodb.__version__}"
    found = [FeedForceError("calibrate", used, "one current", rms(ours), len(tools), 0.0, 0.0)]
    for what, columns in inputs(path).items():
        for name, made in ways().items():
            errors = []
            for tool in tools:
                left = edge == tool
                model = made().fit(columns[kept][~left], force[~left])
                errors.append(force[left] - model.predict(columns[kept][left]))
            low, high = difference(errors, ours)
            peer = f"scikit-learn {version('scikit-learn')}"
            found.append(FeedForceError(name, peer, what, rms(errors), len(tools), low, high))
    return tuple(found)


if __name__ == "__main__":
    result = rows(Path(sys.argv[1]))
    Path(sys.argv[2]).write_bytes(ROWS.dump_json(result, indent=1) + b"\n")
    for one in result:
        print(
            f"{one.method}, {one.inputs}: {one.rmse_N:.1f} N, less autodb's "
            f"{one.less_low_N:+.1f} to {one.less_high_N:+.1f} N"
        )
