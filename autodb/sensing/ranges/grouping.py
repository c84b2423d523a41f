"""Which cuts are independent of each other: groups that are left out, or differ, as a whole."""

import numpy as np
from numpy.typing import NDArray

from autodb.records import CutTable

MIN_GROUPS = 3
MIN_MATERIALS = 3
CONDITION = "cutting condition"
"""Groups that other cuts never share: what they show is a cut's own error."""


def materials_of(table: CutTable) -> NDArray[np.str_]:
    """Return the material of every row (n,), empty where it is not said."""
    return np.array(table.texts.get("work.material", [""] * len(table)))


def several(materials: NDArray[np.str_]) -> bool:
    """Say whether there are enough materials to leave each out in turn."""
    return len(set(materials)) >= MIN_MATERIALS and "" not in materials


def grouping(table: CutTable, used: NDArray[np.bool_]) -> tuple[NDArray[np.generic], str]:
    """Return independent groups of the used rows: materials, tool edges, or equal conditions.

    The first of which there are enough. What is learned of one material must hold for another; rows
    of one edge, or repeats of one cut, share their error.
    """
    materials = materials_of(table)[used]
    if several(materials):
        return materials, "work material"
    edges = table["tool.edge"][used] if "tool.edge" in table else np.array([np.nan])
    if np.isfinite(edges).all() and len(np.unique(edges)) >= MIN_GROUPS:
        return edges, "tool edge"
    conditions = ("spindle.speed", "cutting.feed", "cutting.depth")
    names = [n for n in conditions if n in table and np.isfinite(table[n][used]).all()]
    if names:
        rows = np.round(np.column_stack([table[n][used] for n in names]), 3)
        return np.unique(rows, axis=0, return_inverse=True)[1].ravel(), CONDITION
    return np.arange(int(used.sum())) * 10 // max(1, int(used.sum())), "tenth of the rows"
