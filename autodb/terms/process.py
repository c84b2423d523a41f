"""Cutting forces: what the chip and the edge add.

Over a table of cuts the inputs are arrays over cuts, (n,), one value a cut:

    force          the simulated force of this component [N], signed
    normal_force   the simulated force that bends tool or work off the surface [N] (turning: radial)
    depth          depth of cut a_p [mm]
    feed           feed [mm/rev, milling mm/tooth]
    thickness      uncut chip thickness [mm] of the simulation; turning feed · sin κ_r, milling the
                   mean over the engagement
    speed          cutting speed [m/min]
    diameter       machined diameter [mm]
    edge           code of the edge in use
    cutting_time   time that edge had cut before the cut [s]
    cut            the number of the cut, ascending
    t              clock at the cut [s]

and of another component or edge `other_force`, `other_cutting_time`, as channel.Part reads them. A
force over time has the same inputs, one value a sample.
"""

import numpy as np
from numpy.typing import NDArray

from autodb.terms.term import Contribution, TermParameter

Array = NDArray[np.float64]


def shear(force_N: Array) -> Array:
    """The chip is sheared off with the simulated force, harder or softer: column F [N], (n,).

    Force = factor · F. Source: P1 section 3.
    """
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
    Source: P1 section 2 (process state); linear growth is chosen.
    """
    return depth_mm * cutting_time_s


SHEAR = Contribution(
    name="shear",
    title="the material's cutting force",
    channels=("cuts", "table"),
    inputs=("force",),
    function=shear,
    coefficients=(TermParameter("factor", "1", "factor on the simulated cutting force"),),
    needs=(),
    statement="The work material cuts harder or softer than the simulation assumes.",
    excited_by="cuts at several feeds and depths",
    source="P1 section 3; Armarego's thin shear zone",
    check="Check batch, hardness and heat treatment of the work against the material that the "
    "numbers came from; a force off by one factor over all chips may be the material, and a "
    "repeated standard cut shows it.",
    check_source="P1 sections 2 and 3; ISO 6507-1 for hardness",
    sits=("material", "tool", "pair"),
    belongs_to="pair",
    in_law=("shear_stress", "friction_angle", "chip_ratio"),
)
EDGE_FORCE = Contribution(
    name="edge_force",
    title="the force of the cutting edge",
    channels=("cuts",),
    inputs=("depth",),
    function=edge_force,
    coefficients=(TermParameter("coefficient", "U/mm", "force per engaged edge length"),),
    needs=(),
    statement="The cutting edge rubs with a force that does not depend on chip thickness.",
    excited_by="the same depth at half the feed and at the thinnest possible chip",
    source="P1 section 3 (Armarego's edge coefficients)",
    alike=("size_effect",),
    distinguished_by="Cut at a chip of 0.03 mm or thinner: the edge's force stays, the force of a "
    "thinning chip goes on falling.",
    check="Check the edge's rounding, chamfer and grade of the insert; rubbing that does not fall "
    "with the chip may be another edge preparation, and a cut at a chip of 0.03 mm or less shows "
    "it.",
    check_source="P1 section 3; Altintas, Manufacturing Automation, 2nd ed. (2012), chapter 2",
    sits=("tool", "pair", "material"),
    belongs_to="pair",
    in_law=("K_te", "K_re", "edge_mm"),
)
_RATE = TermParameter("rate", "U/(mm·s)", "force gained per depth and second of cutting")
TOOL_WEAR = Contribution(
    name="tool_wear",
    title="tool wear",
    channels=("cuts",),
    inputs=("depth", "cutting_time"),
    function=tool_wear,
    coefficients=(_RATE,),
    needs=("tool.edge", "tool.cutting_time"),
    statement="The cutting edge wears: force grows as it cuts and falls back with a new edge.",
    excited_by="one repeated cut just before and just after an edge change",
    source="P1 section 2 (process state)",
    alike=("sensor_drift",),
    distinguished_by="Change the edge and repeat the cut: wear falls back, a sensor's drift "
    "does not.",
    check="Check the flank wear of the edge under a magnifier; force that grows with the edge's "
    "cutting time may be wear, and the same cut with a new edge shows it.",
    check_source="P1 section 2; ISO 3685 for turning, ISO 8688-2 for end milling",
    sits=("tool",),
    belongs_to="pair",
)
EDGE_WEAR = Contribution(
    name="tool_wear",
    form="of one edge",
    channels=("cuts",),
    inputs=("depth", "other_cutting_time"),
    function=tool_wear,
    coefficients=(_RATE,),
    needs=("tool.edge", "tool.cutting_time"),
    statement="This one edge wears at a rate of its own.",
    excited_by="one repeated cut early and late in the life of each edge",
    source="P1 section 2 (process state)",
)
