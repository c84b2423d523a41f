"""Feed force from the z drive's current on tools left out: the Vicomtech table.

`python -m benchmarks.vicomtech_force Dataset_Machine_tool_wear.csv [COLUMN]`; COLUMN, the current,
is CV3.Z_RMS (the best single one) unless given. Every tool is sensed by a calibration on the
others. Printed: errors of a straight line, of rules over the current, and of `calibrate`, which
chooses; how
they differ from the line's, with a bootstrap interval over tools; how many rows the 95 % intervals
hold, tool by tool.
"""

import csv
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.records.tables import CutTable
from autodb.sensing.ranges import calibration
from autodb.sensing.ranges.forms import LINE, OF_CURRENT, CurrentForm, MeasuredCuts
from autodb.sensing.ranges.sensed_force import sense
from benchmarks.vicomtech_wear import read

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

BEST = "CV3.Z_RMS"
TRANSIENT = (371, 452, 1563, 1564)
"""Rows of the z drive that the data's notes call transients."""
DRAWS = 10_000
SEED = 1
HALF_WIDTH = 1.96


@dataclass(frozen=True)
class OnTool:
    """One tool sensed by the others: errors (n,), N, of the three, and rows that intervals hold."""

    tool: float
    line_N: Array
    rules_N: Array
    chosen_N: Array
    held: Mask


def main(path: Path, column: str) -> None:
    table = with_current(read(path), path, column)
    tools = [on_tool(table, tool) for tool in np.unique(table["tool.edge"])]
    line = rms([t.line_N for t in tools])
    print(f"{column} → F_f, {len(tools)} tools left out one by one\n  line: {line:.1f} N")
    for name, errors in (
        ("rules over the current", [t.rules_N for t in tools]),
        ("calibrate, which chooses", [t.chosen_N for t in tools]),
    ):
        low, high = difference(errors, [t.line_N for t in tools])
        better = sum(rms([e]) < rms([t.line_N]) for e, t in zip(errors, tools, strict=True))
        print(
            f"  {name}: {rms(errors):.1f} N; less the line's: {rms(errors) - line:+.1f} N "
            f"(95 % over tools {low:+.1f} to {high:+.1f}), better on {better} tools"
        )
    held = np.concatenate([t.held for t in tools])
    print(f"  95 % intervals hold {100.0 * held.mean():.1f} % of {len(held)} rows; by tool:")
    print("   ", ", ".join(f"{t.tool:g}: {100.0 * t.held.mean():.0f} %" for t in tools))


def with_current(table: CutTable, path: Path, column: str) -> CutTable:
    """Return the sound rows with a column of the file as the z drive's current."""
    with path.open(newline="", encoding="utf-8") as file:
        current = np.array([float(row[column]) for row in csv.DictReader(file)])
    kept = ~np.isin(table.cut, TRANSIENT)
    channels = {**table.channels, "z.current": current}
    return replace(table, channels={name: values[kept] for name, values in channels.items()})


def on_tool(table: CutTable, tool: float) -> OnTool:
    """Sense a tool by a calibration on the others."""
    own = table["tool.edge"] == tool
    others, left = _rows(table, ~own), _rows(table, own)
    found = calibration.calibrate(others, "z")
    sensed = sense(left, found)
    shared = np.einsum("ij,jk,ik->i", sensed.common, found.shared_covariance, sensed.common)
    error = left["force.z"] - sensed.force_N
    return OnTool(
        tool,
        _errors(LINE, others, left),
        _errors(OF_CURRENT, others, left),
        error,
        np.abs(error) <= HALF_WIDTH * np.sqrt(sensed.sd_N**2 + shared),
    )


def _rows(table: CutTable, kept: Mask) -> CutTable:
    return replace(table, channels={name: values[kept] for name, values in table.channels.items()})


def _errors(form: CurrentForm, others: CutTable, left: CutTable) -> Array:
    law = form.fit(_sensed(others), others["force.z"])
    return left["force.z"] - law.form.value(law.coefficients, _sensed(left))


def _sensed(table: CutTable) -> MeasuredCuts:
    unknown = np.full(len(table), np.nan)
    return MeasuredCuts(table["z.current"], *[unknown] * 5)


def rms(errors: list[Array]) -> float:
    """Return the root mean square of all errors together."""
    return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))


def difference(errors: list[Array], others: list[Array]) -> tuple[float, float]:
    """Return the 95 % interval of a difference in rms: tools are drawn, both errors of each."""
    rng = np.random.default_rng(SEED)
    rows, squares, other = (
        np.array([f(one) for one in many])
        for f, many in ((len, errors), (_sum_of_squares, errors), (_sum_of_squares, others))
    )
    drawn = rng.integers(0, len(rows), (DRAWS, len(rows)))
    count = rows[drawn].sum(axis=1)
    found = np.sqrt(squares[drawn].sum(axis=1) / count) - np.sqrt(other[drawn].sum(axis=1) / count)
    low, high = np.quantile(found, [0.025, 0.975])
    return float(low), float(high)


def _sum_of_squares(errors: Array) -> float:
    return float(errors @ errors)


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit("usage: python -m benchmarks.vicomtech_force FILE [COLUMN]")
    main(Path(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else BEST)
