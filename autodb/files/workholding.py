"""What is clamped on a machine today: where the program's zero, the jaws and the tailstock are.

A part of the machine file that only NC programs are made from; it changes with every job, so the
database does not keep it. Positions are those of the axes in their travel (a lathe's X as a
radius), with the tool tip at the place that is named.
"""

from typing import Literal

from pydantic import Field, PositiveInt

from autodb.files.toml import Finite, Positive, Section


class Position(Section):
    """Positions of linear axes in their travel."""

    x_mm: Finite | None = None
    y_mm: Finite | None = None
    z_mm: Finite | None = None


class Body(Section):
    """Jaws or a tailstock: where z is when the tool tip touches its face, and how wide it is."""

    z_mm: Finite
    diameter_mm: Positive | None = None


class Clamping(Section):
    """A clamping.

    ``zero``: axes with the tool tip at the program's zero (a bar's face on the spindle's axis, the
    middle of a block's top). ``retract``: axes where nothing is in the way. ``clearance_mm``: how
    near rapids come to the stock, and anything to jaws and tailstock.
    """

    tool: PositiveInt = Field(le=99)
    spindle: Literal["M3", "M4"]
    clearance_mm: Positive
    max_speed_rpm: Positive | None = None
    zero: Position
    retract: Position
    jaws: Body
    tailstock: Body | None = None
