"""What the forces of a worn tool say of its wear: the Vicomtech table with `Vb` hidden.

`python -m benchmarks.vicomtech_wear Dataset_Machine_tool_wear.csv`. The simulation is the force of
a fresh edge: the mean of each tool's first ten rows, by component. Printed: what is named; the
error of force.z in the last 30 % of every tool's rows from the first 70 %; flank wear of a tool
left out from the force that wear is found to give; the scores of wear and of sensor drift; what is
named when the cutting times of each tool are shuffled.
"""

import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.assets import kit
from autodb.explain.cuts.cut_search import FoundInCuts, look_in_cuts, stack_of
from autodb.explain.cuts.fit import fit_cuts
from autodb.records import source as records
from autodb.records.tables import CutTable
from benchmarks.wear_law import wear_law

Array = NDArray[np.float64]

COMPONENTS = ("force.x", "force.y", "force.z")
FRESH = 10
"""Rows of a tool that give its fresh-edge force."""
SEEN = 0.7
"""Share of every tool's rows that the law is found in."""


@dataclass(frozen=True)
class Extrapolated:
    """Errors of force.z [N] in rows that the law was not found in, root mean square."""

    fresh_N: float
    line_N: float
    law_N: float
    power: float


@dataclass(frozen=True)
class FlankWear:
    """Errors of flank wear [µm] of tools left out, root mean square."""

    clock_um: float
    raw_rise_um: float
    wear_force_um: float


def read(path: Path) -> CutTable:
    """Return the table with the columns of the sample job."""
    columns = kit("sample_jobs") / "vicomtech_turning_wear" / "columns.toml"
    table = records.read(path, columns=columns)
    if not isinstance(table, CutTable):
        sys.exit(f"{path}: not a table of cuts")
    return table


def rows_of(table: CutTable) -> list[NDArray[np.intp]]:
    """Return the rows of every tool."""
    edge = table["tool.edge"]
    return [np.flatnonzero(edge == e) for e in np.unique(edge)]


def hidden(table: CutTable, rows: NDArray[np.intp] | None = None) -> CutTable:
    """Return some rows of the table without flank wear."""
    kept = np.arange(len(table)) if rows is None else rows
    channels = {n: v[kept] for n, v in table.channels.items() if n != "tool.flank_wear"}
    texts = {n: [v[i] for i in kept] for n, v in table.texts.items()}
    return replace(table, channels=channels, texts=texts)


def fresh_edge(table: CutTable) -> dict[str, Array]:
    """Return the mean force of each tool's first rows at all of its rows."""
    made = {name: np.zeros(len(table)) for name in COMPONENTS}
    for rows in rows_of(table):
        for name, force in made.items():
            force[rows] = table[name][rows[:FRESH]].mean()
    return made


def searched(table: CutTable, simulation: dict[str, Array]) -> FoundInCuts:
    """Return what is found in a table against a simulation of shear alone."""
    return look_in_cuts(stack_of(table, simulation, ["shear"]), ["shear"])


def shuffled(table: CutTable, seed: int = 0) -> CutTable:
    """Return the table with the cutting times of each tool in another order."""
    rng, time_s = np.random.default_rng(seed), table["tool.cutting_time"].copy()
    for rows in rows_of(table):
        time_s[rows] = rng.permutation(time_s[rows])
    return replace(table, channels={**table.channels, "tool.cutting_time": time_s})


def extrapolation(table: CutTable) -> Extrapolated:
    """Find the law in the first rows of every tool and judge it by force.z of its last rows."""
    whole, fresh = hidden(table), fresh_edge(table)
    first = [rows[: int(SEEN * len(rows))] for rows in rows_of(table)]
    last = [rows[int(SEEN * len(rows)) :] for rows in rows_of(table)]
    kept, rest = np.concatenate(first), np.concatenate(last)
    kept.sort()
    result = searched(hidden(table, kept), {n: f[kept] for n, f in fresh.items()})
    law = wear_law(result, COMPONENTS.index("force.z"))
    time_s, force = whole["tool.cutting_time"], whole["force.z"]
    predicted = fresh["force.z"][rest] + law.force(
        depth_mm=np.ones(len(rest)), cutting_time_s=time_s[rest], edge=whole["tool.edge"][rest]
    )
    lines = [
        np.polyval(np.polyfit(time_s[a], force[a], 1), time_s[b])
        for a, b in zip(first, last, strict=True)
    ]
    return Extrapolated(
        fresh_N=_rms(force[rest] - fresh["force.z"][rest]),
        line_N=_rms(force[rest] - np.concatenate(lines)),
        law_N=_rms(force[rest] - predicted),
        power=law.power,
    )


def flank_wear(table: CutTable) -> FlankWear:
    """Infer the flank wear of each tool from all others', by a straight line."""
    simulation = fresh_edge(table)
    result = searched(hidden(table), simulation)
    stack, choices = result.stack, result.found.choices
    fitted = fit_cuts(stack, result.own, choices)
    z = COMPONENTS.index("force.z")
    worn = np.zeros(len(table))
    for part, choice in zip(fitted.parts[len(result.own) :], choices, strict=True):
        if choice.candidate.term == "tool_wear":
            worn += part[z]
    rise = table["force.z"] - simulation["force.z"]
    return FlankWear(
        clock_um=_left_out(table, table["tool.cutting_time"]),
        raw_rise_um=_left_out(table, rise),
        wear_force_um=_left_out(table, worn),
    )


def _left_out(table: CutTable, feature: Array) -> float:
    """Return the error of flank wear [µm] from a feature, a tool left out at a time."""
    wear_mm, edge = table["tool.flank_wear"], table["tool.edge"]
    errors = []
    for e in np.unique(edge):
        test = edge == e
        line = np.polyfit(feature[~test], wear_mm[~test], 1)
        errors.append(wear_mm[test] - np.polyval(line, feature[test]))
    return 1000.0 * _rms(np.concatenate(errors))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def scores(result: FoundInCuts) -> tuple[float, float]:
    """Return the score of the set with wear, and of the best one with drift in its place."""
    falls = result.search.rivals(result.found, "tool_wear")
    drift = min(fall for key, fall in falls.items() if key.startswith("sensor_drift"))
    return result.found.score, result.found.score - drift


def terms(result: FoundInCuts) -> list[str]:
    """Return what was found, in the order of its evidence."""
    pairs = zip(result.found.evidence, result.found.choices, strict=True)
    return [c.candidate.key for _, c in sorted(pairs, key=lambda pair: -pair[0])]


def main(path: Path) -> None:
    """Print the figures."""
    table = read(path)
    result = searched(hidden(table), fresh_edge(table))
    print(f"named: {', '.join(terms(result))}")
    wear, drift = scores(result)
    print(f"score with tool_wear {wear:.0f}, with sensor_drift in its place {drift:.0f}")
    found = extrapolation(table)
    print(
        f"force.z in the last 30 % of rows: fresh edge {found.fresh_N:.0f} N, straight line "
        f"{found.line_N:.0f} N, law found (power {found.power:.2f}) {found.law_N:.0f} N"
    )
    worn = flank_wear(table)
    print(
        f"flank wear of a tool left out: clock {worn.clock_um:.0f} µm, rise of force.z "
        f"{worn.raw_rise_um:.0f} µm, force of wear {worn.wear_force_um:.0f} µm"
    )
    mixed = searched(shuffled(hidden(table)), fresh_edge(table))
    print(f"cutting times shuffled within tools: named {', '.join(terms(mixed)) or 'nothing'}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
