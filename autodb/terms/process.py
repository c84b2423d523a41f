"""Cutting forces of a table of cuts."""

import numpy as np
from numpy.typing import NDArray

from autodb.terms._term import Contribution, Parameter

Array = NDArray[np.float64]


def shear(force_N: Array) -> Array:
    """The chip is sheared off with the simulated force, harder or softer: column F [N], (n,)."""
    return force_N


def edge_force(depth_mm: Array) -> Array:
    """The edge ploughs with a force per engaged edge length whatever the chip: column a_p, (n,).

    Force = coefficient [N/mm] · a_p. Source: P1 section 3 (Armarego);
    the engaged length is taken as the depth of cut (entering angle near 90°).
    """
    return depth_mm


def tool_wear(depth_mm: Array, cutting_time_s: Array) -> Array:
    """A worn edge adds force that grows with its cutting time: column a_p · T, (n,).

    Force = rate [N/(mm·s)] · a_p · T with T the time this edge has cut; T starts again at an edge
    change, so the force does too. First-order growth: run-in and end of life are not in it.
    """
    return depth_mm * cutting_time_s


SHEAR = Contribution(
    name="shear",
    channels=("cuts",),
    inputs=("force",),
    function=shear,
    coefficients=(Parameter("factor", "1", "factor on the simulated cutting force"),),
    needs=(),
    statement="The work material cuts harder or softer than the simulation assumes.",
    excited_by="cuts at several feeds and depths",
    source="P1 section 3; Armarego's thin shear zone",
)
EDGE_FORCE = Contribution(
    name="edge_force",
    channels=("cuts",),
    inputs=("depth",),
    function=edge_force,
    coefficients=(Parameter("coefficient", "U/mm", "force per engaged edge length"),),
    needs=(),
    statement="The cutting edge rubs with a force that does not depend on chip thickness.",
    excited_by="the same depth at half the feed and at the thinnest possible chip",
    source="P1 section 3 (Armarego's edge coefficients)",
)
TOOL_WEAR = Contribution(
    name="tool_wear",
    channels=("cuts",),
    inputs=("depth", "cutting_time"),
    function=tool_wear,
    coefficients=(Parameter("rate", "U/s", "force gained per second of cutting at mean depth"),),
    needs=("tool.edge", "tool.cutting_time"),
    statement="The cutting edge wears: force grows as it cuts and falls back with a new edge.",
    excited_by="one repeated cut just before and just after an edge change",
    source="P1 section 2 (process state)",
)
