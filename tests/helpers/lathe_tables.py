"""Tables of cuts of virtual lathes, and what may be wrong with one."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.files.side import SideFile
from autodb.proofs.machines.lathe.jobs import standard_cuts
from autodb.proofs.machines.lathe.lathe import Lathe, cut_table
from autodb.proofs.machines.lathe.process import ALUMINIUM, BRASS, STEEL
from autodb.records.mistaken import Mistake
from autodb.records.tables import CutTable
from autodb.standard import CutProtocol

Array = NDArray[np.float64]

AXES = ("x", "z", "spindle")
MACHINES = 20
SEEDS = range(400, 400 + MACHINES)
"""Fixed before any was seen."""
TEXTS = ("operation", "work.material", "tool", "tool.edge")
FORCES = ("force.x", "force.y", "force.z")


@cache
def lathe_cuts(seed: int) -> CutTable:
    """32 standard cuts, turned and faced, of one of three pairs on a lathe, with a dynamometer."""
    pair = (STEEL, BRASS, ALUMINIUM)[seed % 3]
    return as_table(cut_table(Lathe.draw(seed), pair, standard_cuts(), seed, dynamometer=True))


def as_table(columns: dict[str, NDArray[np.generic]]) -> CutTable:
    numbers = {n: v.astype(np.float64) for n, v in columns.items() if n not in TEXTS}
    texts = {n: [str(v) for v in columns[n]] for n in TEXTS}
    return CutTable(path=Path("cuts.csv"), channels=numbers, texts=texts)


def forces_of(table: CutTable) -> dict[str, Array]:
    return {c: table[f"force.{c}"] for c in "xyz" if f"force.{c}" in table}


def names_of(table: CutTable) -> list[str]:
    return [f"cut {number:g}" for number in table.cut]


def with_channels(table: CutTable, **changed: Array) -> CutTable:
    new = {name.replace("__", "."): values for name, values in changed.items()}
    return replace(table, channels={**table.channels, **new})


def wrong(table: CutTable, mistake: Mistake) -> CutTable:
    """The table as it is logged when some channels are in another unit."""
    logged = {n: table[n] / mistake.factor for n in mistake.channels if n in table}
    return replace(table, channels={**table.channels, **logged})


def unplugged(table: CutTable, axis: str, seed: int, level_A: float) -> CutTable:
    rng = np.random.default_rng([seed, 77])
    noise = np.abs(level_A + 0.004 * rng.standard_normal((2, len(table))))
    names = (f"{axis}.current.range", f"{axis}.current.air")
    return replace(table, channels={**table.channels, **dict(zip(names, noise, strict=True))})


CURRENTS = tuple((f"{axis}.current.range", f"{axis}.current.air") for axis in AXES)


def protocol_of(table: CutTable) -> CutProtocol:
    """A protocol whose references are the dynamometer's means of equal cuts."""
    keys = [
        (o, n, f, a)
        for o, n, f, a in zip(
            table.texts["operation"], np.round(table["spindle.speed"], 3),
            table["cutting.feed"], table["cutting.depth"], strict=True,
        )
    ]  # fmt: skip
    cuts = []
    for key in dict.fromkeys(keys):
        rows = [k == key for k in keys]
        means = {c: float(np.mean(table[f"force.{c}"][rows])) for c in "xyz"}
        bounds = {
            c: {"value": v, "lower": 0.95 * v, "upper": 1.05 * v, **SOURCE}
            for c, v in means.items()
        }
        cuts.append(
            {
                "name": str(key), "operation": key[0], "speed_rpm": float(key[1]),
                "feed_mm_rev": float(key[2]), "depth_mm": float(key[3]), "repeats": 1,
                "reference": bounds,
            }
        )  # fmt: skip
    whole = {"name": "mine", "material": "m", "tool": "t", "cut": cuts}
    return CutProtocol.model_validate(whole)


SOURCE = {"source": "test", "status": "known", "date": "2026-01-01"}


def without_forces(table: CutTable) -> CutTable:
    channels = {name: v for name, v in table.channels.items() if name not in FORCES}
    return replace(table, channels=channels)


def side_of(operation: str, depth_mm: float, feed_mm: float) -> SideFile:
    cut = {"operation": operation, "depth_mm": depth_mm, "feed_mm_rev": feed_mm}
    return SideFile.model_validate({"cut": cut})
