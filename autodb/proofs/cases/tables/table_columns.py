"""What each name would add to a force component: columns with free sizes, at a few shapes each."""

from collections.abc import Callable

import numpy as np

from autodb.proofs.cases.real.full_models import FittedModel
from autodb.proofs.cases.tables.published_tables import Array, PublishedTable
from autodb.proofs.cases.tables.table_models import PublishedModel

POWERS = (0.5, 1.0, 2.0)
"""Of cutting time."""
THIN = (0.3, 1.0)
"""Feeds at which thin chips have lost their extra force, over the median feed."""
NOSES_MM = (0.4, 0.8, 1.2)
"""Depth within which a nose turns force from one component into another."""
SHORTEST = 3
"""Cuts of a run at least."""
OF_ONE_COMPONENT = ("gain", "sensor_drift")
"""What a sensor does: no other component takes part."""
COMMON = (
    "edge_force", "size_effect", "speed_softening", "built_up_edge", "tool_wear", "hard_spot",
    "depth_error", "deflection", "nose_radius",
)  # fmt: skip
TABLE_NAMES = (*COMMON, *OF_ONE_COMPONENT)


class ModelledComponent:
    """One component of a table and its model."""

    def __init__(self, model: PublishedModel, name: str) -> None:
        self.table: PublishedTable = model.table
        self.model: FittedModel = model.channels[name]
        self.force = self.model.whole
        self.shear = self.model.part("shear")
        self.slope = model.slope()[list(model.channels).index(name)]
        self.components = model.components


def shapes_of(term: str, channel: ModelledComponent) -> list[Array]:
    """Return the columns (k, n) of a name at each of its shapes."""
    return SHAPES[term](channel)


def _size_effect(channel: ModelledComponent) -> list[Array]:
    thin = channel.table.feed / np.median(channel.table.feed)
    return [(channel.shear * np.exp(-thin / one))[None] for one in THIN]


def _nose_radius(channel: ModelledComponent) -> list[Array]:
    depth = channel.table.depth
    shallow = [depth * np.exp(-depth / one) for one in NOSES_MM]
    return [(channel.table.feed * one)[None] for one in (np.ones_like(depth), *shallow)]


def _built_up_edge(channel: ModelledComponent) -> list[Array]:
    """Return bands about each speed that has others on both sides."""
    bands = band_places(channel.table)
    return [(channel.shear * speed_bell(channel.table, at, width))[None] for at, width in bands]


def band_places(table: PublishedTable) -> list[tuple[float, float]]:
    """Return middle and width, logarithms of speed, of bands that end on both sides."""
    levels = np.unique(table.log_speed)
    gaps = np.diff(levels)
    return [(float(levels[i]), 0.5 * float(min(gaps[i - 1], gaps[i]))) for i in range(1, len(gaps))]


def speed_bell(table: PublishedTable, at: float, width: float) -> Array:
    """Return a bell (n,) over the logarithm of speed."""
    return np.asarray(np.exp(-(((table.log_speed - at) / width) ** 2)))


def _tool_wear(channel: ModelledComponent) -> list[Array]:
    """Return growth along the edge, one rate for all edges or one for each."""
    grown = [channel.table.depth * channel.table.worn**power for power in POWERS]
    edges = channel.table.edge[None] == np.unique(channel.table.edge)[:, None]
    return [*(one[None] for one in grown), *(one * edges for one in grown)]


def _hard_spot(channel: ModelledComponent) -> list[Array]:
    n = len(channel.table)
    starts = [(i, j) for i in range(n - SHORTEST + 1) for j in range(i + SHORTEST, n + 1)]
    rows = np.arange(n)
    return [
        (channel.force * ((rows >= i) & (rows < j)))[None]
        for i, j in starts
        if j - i <= n - SHORTEST
    ]


def _gain(channel: ModelledComponent) -> list[Array]:
    n, rows = len(channel.table), np.arange(len(channel.table))
    steps = [(channel.force * (rows >= i))[None] for i in range(SHORTEST, n - SHORTEST)]
    return [*steps, (channel.force * rows / n)[None]]


SHAPES: dict[str, Callable[[ModelledComponent], list[Array]]] = {
    "edge_force": lambda one: [one.table.depth[None]],
    "size_effect": _size_effect,
    "speed_softening": lambda one: [-(one.shear * one.table.log_speed)[None]],
    "built_up_edge": _built_up_edge,
    "tool_wear": _tool_wear,
    "hard_spot": _hard_spot,
    "depth_error": lambda one: [one.slope[None]],
    "deflection": lambda one: [-(pushing * one.slope)[None] for pushing in one.components],
    "nose_radius": _nose_radius,
    "gain": _gain,
    "sensor_drift": lambda one: [(one.table.t / one.table.t[-1])[None]],
}
