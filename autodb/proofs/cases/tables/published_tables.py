"""Tables of cutting forces that were published: figures of papers, cut by cut.

Turning: Aouici and others (2012, hot-work steel), Bartarya and Choudhury (2012, bearing steel),
Borsos and others, Fnides and others (hot-work steel), Lin and others (2001), Mata and others (2009,
PEEK), as F. B. de Souza collected them
(bessafelipe/Redes-neurais-artificiais-e-regress-es-na-usinagem@10656e86). Drilling of cast iron:
HrisheetaRoy/Drilling_Machining_Criteria_Prediction@fecf9f12, its torque over a quarter of the
diameter as ``force.y``. The largest component of turning is ``force.y`` or ``force.x``, as the
papers have it; passive forces that the nose decides, not the depth, are left out (Borsos, Mata).
Rows stand in the order of the collection, and times and edges are made up.
"""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

Array = NDArray[np.float64]
FILE = Path(__file__).with_name("published_tables.csv")
CUT_S = 60.0
"""A minute a cut."""
EDGES = 3
"""Edges that took the cuts of a table, one after the other."""
DRILLING = ("drill",)


@dataclass(frozen=True)
class PublishedTable:
    """Cuts (n,) of one table: speed in m/min, feed in mm, depth in mm, forces (n,) in N by channel.

    ``edge`` is the number of the edge, ``clock_s`` its cutting time when a cut begins.
    """

    name: str
    speed: Array
    feed: Array
    depth: Array
    forces: dict[str, Array]
    edge: NDArray[np.int64]
    clock_s: Array
    t: Array

    def __len__(self) -> int:
        """Return how many cuts there are."""
        return len(self.t)

    @property
    def log_speed(self) -> Array:
        """Return the logarithm of speed over its geometric mean, (n,)."""
        logarithm = np.log(self.speed)
        return np.asarray(logarithm - logarithm.mean())

    @property
    def worn(self) -> Array:
        """Return the cutting time over the longest, (n,)."""
        return np.asarray(self.clock_s / self.clock_s.max())

    @property
    def components(self) -> Array:
        """Return the forces (C, n), in the order of the channels."""
        return np.array(list(self.forces.values()))

    def with_forces(self, components: Array) -> "PublishedTable":
        """Return the same cuts with other forces (C, n)."""
        forces = dict(zip(self.forces, components, strict=True))
        return PublishedTable(
            self.name, self.speed, self.feed, self.depth, forces, self.edge, self.clock_s, self.t
        )

    def rows(self, kept: NDArray[np.intp]) -> "PublishedTable":
        """Return some of the cuts."""
        forces = {name: values[kept] for name, values in self.forces.items()}
        return PublishedTable(
            self.name, self.speed[kept], self.feed[kept], self.depth[kept], forces,
            self.edge[kept], self.clock_s[kept], self.t[kept],
        )  # fmt: skip

    def frame(self) -> pd.DataFrame:
        """Return the table as a shop writes it, a row a cut."""
        known = {
            "cut": np.arange(1, len(self) + 1), "t": self.t,
            "operation": "drill" if self.name in DRILLING else "turn", "tool.edge": self.edge,
            "tool.cutting_time": self.clock_s, "cutting.speed": self.speed,
            "cutting.feed": self.feed, "cutting.depth": self.depth,
        }  # fmt: skip
        return pd.DataFrame({**known, **self.forces})


@cache
def published_tables() -> dict[str, PublishedTable]:
    """Return every table by its name."""
    every = pd.read_csv(FILE)
    return {str(name): _table(str(name), own) for name, own in every.groupby("table", sort=False)}


def _table(name: str, cuts: pd.DataFrame) -> PublishedTable:
    n = len(cuts)
    edge = np.arange(n) * EDGES // n
    place = np.arange(n) - np.searchsorted(edge, edge)
    channels = [c for c in cuts.columns if c.startswith("force.") and cuts[c].notna().all()]
    speed, feed, depth = (cuts[f"cutting.{one}"].to_numpy(float) for one in SETTINGS)
    forces = {channel: cuts[channel].to_numpy(float) for channel in channels}
    clock, t = np.asarray(CUT_S * place), CUT_S * np.arange(n, dtype=np.float64)
    return PublishedTable(name, speed, feed, depth, forces, edge + 1, clock, t)


SETTINGS = ("speed", "feed", "depth")
