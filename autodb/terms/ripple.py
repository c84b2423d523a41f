"""Cogging of any shape over a pole: as a look-up table, and as harmonics of it."""

import numpy as np
from numpy.typing import NDArray

from autodb.terms.term import Contribution, TermParameter

Array = NDArray[np.float64]

NODES = 36
"""Nodes of a table: every 10 degrees of a pole. Chosen."""
ORDERS = 6
"""Harmonics of a pole. Chosen."""


def cogging_table(position_mm: Array, *, period_mm: float) -> Array:
    """A load periodic in position, of any shape: a column for each node but the last, (n, 35).

    Effort = Σ value_j · (w_j − w_36), j = 1 to 35, w_j the weight of node j, at (j − 1)/36 of the
    period [mm]: between nodes a cubic through four of them, with a continuous slope. The last node
    is minus the sum of the others, which makes the mean over a period 0. Also at standstill, the
    same sign in both directions. Source: P0 section 2.2, F_co as a look-up table; Keys 1981, IEEE
    Trans. Acoust. Speech Signal Process. 29:1153, cubic convolution with a = −1/2.
    """
    at = (position_mm / period_mm % 1.0) * NODES
    node = np.floor(at).astype(np.intp)
    u = at - node
    weights = (
        0.5 * u * (u * (2.0 - u) - 1.0),
        0.5 * (u * u * (3.0 * u - 5.0) + 2.0),
        0.5 * u * (u * (4.0 - 3.0 * u) + 1.0),
        0.5 * u * u * (u - 1.0),
    )
    columns = np.zeros((len(at), NODES))
    rows = np.arange(len(at))
    for step, weight in enumerate(weights):
        columns[rows, (node + step - 1) % NODES] = weight
    return columns[:, :-1] - columns[:, -1:]


def cogging_harmonics(position_mm: Array, *, period_mm: float) -> Array:
    """A load periodic in position: columns cos and sin of 2πkx/period, k = 1 to 6, (n, 12).

    Effort = Σ cosine_k · cos + sine_k · sin, also at standstill, the same sign in both directions.
    Source: P0 section 2.2, F_co as a finite Fourier series.
    """
    angle = np.multiply.outer(2.0 * np.pi * position_mm / period_mm, np.arange(1.0, ORDERS + 1.0))
    waves = np.stack([np.cos(angle), np.sin(angle)], axis=2)
    return np.asarray(waves.reshape(len(position_mm), 2 * ORDERS))


_PERIOD = TermParameter(
    "period", "mm", "distance after which it repeats", 1e-4, 1e4, keyword="period_mm"
)
COGGING_TABLE = Contribution(
    name="cogging",
    form="table",
    channels=("axis", "rotary"),
    inputs=("position",),
    function=cogging_table,
    coefficients=tuple(
        TermParameter(f"node_{node}", "U", f"load at {node - 1}/{NODES} of the period")
        for node in range(1, NODES)
    ),
    shape=(_PERIOD,),
    needs=("position",),
    statement="A load of any shape that repeats from pole to pole, the same in both directions.",
    excited_by="slow constant-speed passes over many periods in both directions",
    source="P0 section 2.2, F_co as a look-up table",
    belongs_to="machine",
)
COGGING_HARMONICS = Contribution(
    name="cogging",
    form="harmonics",
    channels=("axis", "rotary"),
    inputs=("position",),
    function=cogging_harmonics,
    coefficients=tuple(
        TermParameter(f"{part}_{order}", "U", f"{part} part of harmonic {order}")
        for order in range(1, ORDERS + 1)
        for part in ("cosine", "sine")
    ),
    shape=(_PERIOD,),
    needs=("position",),
    statement="Ripples along the travel, each a part of a pole: magnets and what is between them.",
    excited_by="slow constant-speed passes over many periods in both directions",
    source="P0 section 2.2, F_co as a finite Fourier series",
    belongs_to="machine",
)
