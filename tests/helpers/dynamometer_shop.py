"""A virtual shop that measures its forces: Kienzle's law, and effects in forms of their own."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pyarrow import csv

Array = NDArray[np.float64]
Cuts = Mapping[str, Array]
"""Cuts by feed, depth and speed, (n,) each."""
Effect = Callable[[Cuts, Array, Array], tuple[Array, Array]]
"""What an effect makes of force y and z of cuts."""
NOISE = 0.02, 0.03
"""Shares that force y and z of one cut repeated scatter by."""
PAIR = "42CrMo4", "insert"


def drawn(
    seed: int,
    count: int,
    *,
    feed: tuple[float, float] = (0.1, 0.4),
    speed: tuple[float, float] = (100.0, 160.0),
) -> dict[str, Array]:
    """Draw cuts of a range of feeds and speeds."""
    rng = np.random.default_rng(seed)
    return {
        "feed": rng.uniform(*feed, count),
        "depth": rng.uniform(1.0, 3.0, count),
        "speed": rng.uniform(*speed, count),
    }


def joined(*several: Cuts) -> dict[str, Array]:
    return {name: np.concatenate([one[name] for one in several]) for name in several[0]}


def forces(cuts: Cuts, effect: "Effect | None" = None) -> tuple[Array, Array]:
    """Return force y and z of cuts (n,), without scatter."""
    chip = cuts["feed"] * np.sin(np.radians(95.0))
    y = 1900.0 * cuts["depth"] * chip**0.78
    z = 900.0 * cuts["depth"] * chip**0.65
    return (y, z) if effect is None else effect(cuts, y, z)


def blunt(cuts: Cuts, y: Array, z: Array) -> tuple[Array, Array]:
    """An edge that ploughs: force that is there as soon as there is a chip."""
    rubs = cuts["depth"] * np.tanh(cuts["feed"] / 0.02)
    return y + 250.0 * rubs, z + 350.0 * rubs


def thin(cuts: Cuts, y: Array, z: Array) -> tuple[Array, Array]:
    """Thin chips cost more, thick ones do not."""
    more = np.maximum(0.1 / cuts["feed"], 1.0) ** 0.6
    return y * more, z * more


def soft(cuts: Cuts, y: Array, z: Array) -> tuple[Array, Array]:
    """Force falls in a straight line with the logarithm of speed."""
    less = 1.0 - 0.45 * np.log(cuts["speed"] / 130.0)
    return y * less, z * less


def welded(cuts: Cuts, y: Array, z: Array) -> tuple[Array, Array]:
    """A built-up edge between 58 and 140 m/min: a cosine in ln v."""
    off = np.clip(np.abs(np.log(cuts["speed"] / 90.0)) / 0.44, 0.0, 1.0)
    inside = 0.5 * (1.0 + np.cos(np.pi * off))
    return y * (1.0 - 0.25 * inside), z * (1.0 - 0.4 * inside)


def hard(_cuts: Cuts, y: Array, z: Array) -> tuple[Array, Array]:
    """A harder lot."""
    return 1.3 * y, 1.3 * z


def free_cutting(_cuts: Cuts, y: Array, z: Array) -> tuple[Array, Array]:
    """A lot that cuts easily."""
    return 0.75 * y, 0.75 * z


def written(name: str, cuts: Cuts, effect: Effect | None = None, **texts: str) -> Path:
    """Write a table of cuts with measured forces; ``texts``: columns, with __ for a point."""
    rng = np.random.default_rng([len(name), 3])
    count = len(cuts["feed"])
    scatter = [1.0 + share * rng.standard_normal(count) for share in NOISE]
    y, z = (force * one for force, one in zip(forces(cuts, effect), scatter, strict=True))
    columns: dict[str, Any] = {
        "cut": np.arange(1.0, count + 1.0), "t": 60.0 * np.arange(count),
        "operation": ["turn"] * count,
        "work.material": [PAIR[0]] * count, "tool": [PAIR[1]] * count,
        "cutting.feed": cuts["feed"], "cutting.depth": cuts["depth"],
        "cutting.speed": cuts["speed"], "work.diameter": np.full(count, 60.0),
        "force.y": y, "force.z": z,
    }  # fmt: skip
    columns |= {key.replace("__", "."): [text] * count for key, text in texts.items()}
    csv.write_csv(pa.table(columns), name)
    return Path(name)
