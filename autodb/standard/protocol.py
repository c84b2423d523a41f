"""A protocol of standard cuts, and where it is read from: the kit, or a file of one's own.

A reference is a value with lower and upper 95 % bounds and its source; the bounds are an error that
every cut sensed with the calibration shares. Source of the idea: P1 section 9.

The order in which standard cuts are made: random in blocks, so that drift falls on all alike.
"""

from pathlib import Path
from random import Random
from typing import Annotated

from pydantic import Field, PositiveInt, model_validator

from autodb.assets import kit
from autodb.errors import UnusableInput, near_words
from autodb.files.side import Operation
from autodb.files.toml import Finite, NotNegative, Positive, Section, read_toml
from autodb.files.tool import Geometry
from autodb.wording import phrase

PASSIVE = {"turn": "x", "face": "z"}
"""The axis that stands still in a turning operation: its force shows in no current."""


class ReferenceForce(Section):
    """A reference force, N, with 95 % bounds; where it is from, how sure, and since when."""

    value: Finite
    lower: Finite
    upper: Finite
    source: str
    status: str
    date: str

    @model_validator(mode="after")
    def _in_order(self) -> "ReferenceForce":
        if not self.lower <= self.value <= self.upper:
            raise ValueError(f"value {self.value:g} must lie between lower and upper")
        return self


class StandardCut(Section):
    """One cut of a protocol. ``reference`` has the components that were measured.

    ``feed_mm_rev`` or ``feed_mm_tooth``; ``length_mm`` is a slot's length or a hole's depth,
    ``feed_direction_deg`` a slot's direction from +x towards +y. A hole has no ``depth_mm``.
    """

    name: str
    operation: Operation
    speed_rpm: Positive
    feed_mm_rev: Positive | None = None
    feed_mm_tooth: Positive | None = None
    depth_mm: Positive | None = None
    length_mm: Positive | None = None
    feed_direction_deg: Finite | None = None
    repeats: PositiveInt
    reference: dict[str, ReferenceForce] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _one_feed(self) -> "StandardCut":
        if (self.feed_mm_rev is None) == (self.feed_mm_tooth is None):
            raise ValueError("give either feed_mm_rev or feed_mm_tooth, and only one of them")
        return self

    @model_validator(mode="after")
    def _a_depth_but_for_holes(self) -> "StandardCut":
        if (self.depth_mm is None) != (self.operation in HOLES):
            raise ValueError("depth_mm is needed, but in 'drill', where length_mm is the hole's")
        return self

    @property
    def feed_mm(self) -> float:
        """Feed as a table of cuts has it: mm a revolution, or mm a tooth."""
        return self.feed_mm_rev or self.feed_mm_tooth or 0.0


HOLES = ("drill",)


class BarStock(Section):
    """A bar in a chuck; program zero is its face on the spindle's axis.

    It is turned over ``length_mm`` from its first face, down to ``least_diameter_mm``; it is faced
    down to ``hub_diameter_mm``, and as long as ``least_length_mm`` is left to turn.
    """

    diameter_mm: Positive
    least_diameter_mm: Positive
    hub_diameter_mm: NotNegative
    length_mm: Positive
    least_length_mm: Positive

    @model_validator(mode="after")
    def _in_order(self) -> "BarStock":
        if not self.hub_diameter_mm < self.least_diameter_mm < self.diameter_mm:
            raise ValueError("state hub_diameter_mm < least_diameter_mm < diameter_mm")
        if not self.least_length_mm < self.length_mm:
            raise ValueError("state least_length_mm < length_mm")
        return self


class BlockStock(Section):
    """A block in a vice; program zero is the middle of its top. ``wall_mm`` stays between cuts."""

    size_x_mm: Positive
    size_y_mm: Positive
    height_mm: Positive
    wall_mm: Positive


class CutProtocol(Section):
    """A list of standard cuts on one work-tool pair, and the stock that they are made on.

    ``seed`` sets their random order, ``air_s`` how long the tool feeds in air before each.
    """

    name: str
    material: str
    tool: str
    note: str = ""
    seed: int = 1
    air_s: Annotated[float, Field(strict=True, ge=2.0, le=60.0)] = 2.0
    geometry: Geometry = Geometry()
    bar: BarStock | None = None
    block: BlockStock | None = None
    cut: tuple[StandardCut, ...] = Field(min_length=1)

    @model_validator(mode="after")
    def _distinct(self) -> "CutProtocol":
        names = [cut.name for cut in self.cut]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"cut: two cuts have the name '{twice}'")
        if self.bar is not None and self.block is not None:
            raise ValueError("give either [bar] or [block], and only one of them")
        return self


def shipped() -> list[str]:
    """Return the names of the protocols in the calibration kit."""
    return sorted(path.stem for path in kit("calibration").glob("*.toml"))


def read_protocol(name: str) -> CutProtocol:
    """Read a protocol by name from the calibration kit, or from a file.

    Raises UnusableInput naming the protocols that ship, or file and key.
    """
    path = Path(name)
    if path.suffix == ".toml":
        return read_toml(path, CutProtocol)
    if name not in shipped():
        raise UnusableInput(
            phrase("no protocol '{name}'{hint}", name=name, hint=near_words(name, shipped()))
        )
    return read_toml(kit("calibration") / f"{name}.toml", CutProtocol)


def run_order(protocol: CutProtocol) -> tuple[StandardCut, ...]:
    """Return the cuts in the order of the run; the first is made once more at the end.

    As many blocks as the cut that is repeated least has repeats. Each cut's repeats are spread over
    the blocks as evenly as they divide, and each block is shuffled: a slow drift then falls on all
    cuts alike. The cut that opened the run closes it; the difference of the two is the drift.
    The same seed gives the same order.
    """
    random = Random(protocol.seed)
    blocks = min(cut.repeats for cut in protocol.cut)
    order: list[StandardCut] = []
    for block in range(blocks):
        cuts = [
            cut
            for cut in protocol.cut
            for _ in range(_until(cut, block + 1, blocks) - _until(cut, block, blocks))
        ]
        order += sorted(cuts, key=lambda _: random.random())
    return (*order, order[0])


def _until(cut: StandardCut, block: int, blocks: int) -> int:
    """Return how many repeats of a cut come before a block."""
    return cut.repeats * block // blocks
