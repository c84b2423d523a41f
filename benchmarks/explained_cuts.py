"""What explaining a table of cuts costs: seconds of the processor and peak memory by its length.

`python -m benchmarks.explained_cuts`: three components, wear of many edges left out; each length in
a process of its own. Growth is what twice as many cuts cost times as much, from length to length.
"""

import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.records.tables import CutTable
from benchmarks.by_length import print_cost, print_growth

Array = NDArray[np.float64]
Columns = Mapping[str, Array]

LENGTHS = (100, 1_000, 10_000, 100_000)
STRENGTH_N_MM2 = {"force.x": 700.0, "force.y": 2100.0, "force.z": 1100.0}
EDGE_N_MM = {"force.x": 25.0, "force.y": 40.0, "force.z": 35.0}
WEAR_N_MM_S = 0.06
CUTS_AN_EDGE = 40
SCATTER_N, SCATTER = 6.0, 0.02


def made(count: int) -> tuple[Columns, Columns, Columns]:
    """Return the conditions of so many cuts, their recorded and their simulated forces."""
    rng = np.random.default_rng(0)
    begun_s = np.concatenate([[0.0], np.cumsum(rng.uniform(5.0, 25.0, count))[:-1]])
    edge = np.arange(count) // CUTS_AN_EDGE
    worn_s = begun_s - begun_s[edge * CUTS_AN_EDGE]
    table = {
        "cut": np.arange(count) + 1.0,
        "t": 2.0 * begun_s,
        "cutting.feed": rng.choice([0.05, 0.1, 0.15, 0.2, 0.3], count),
        "cutting.depth": rng.choice([0.4, 0.7, 1.0, 1.5, 2.0, 3.0], count),
        "cutting.speed": np.exp(rng.uniform(np.log(60.0), np.log(300.0), count)),
        "tool.edge": edge + 1.0,
        "tool.cutting_time": worn_s,
        "z.position": rng.uniform(-200.0, -10.0, count),
    }
    depth, area = table["cutting.depth"], table["cutting.depth"] * table["cutting.feed"]
    simulated = {n: k * area + EDGE_N_MM[n] * depth for n, k in STRENGTH_N_MM2.items()}
    wear = WEAR_N_MM_S * depth * worn_s
    sensed = {
        name: force + wear + np.hypot(SCATTER_N, SCATTER * force) * rng.normal(size=count)
        for name, force in simulated.items()
    }
    return table, sensed, simulated


def explained(count: int) -> None:
    """Explain a table of so many cuts; print seconds of processor, GiB, and what is named."""
    table, sensed, simulated = made(count)
    recording = CutTable(Path("recording"), {**table, **sensed})
    simulation = CutTable(Path("simulation"), {"cut": table["cut"], **simulated})
    print_cost(recording, simulation)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        explained(int(sys.argv[1]))
    else:
        print_growth(__spec__.name, LENGTHS, "cuts")
