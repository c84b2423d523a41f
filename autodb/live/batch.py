"""What a machine said since the last time, in the form in which it is journalled."""

from dataclasses import dataclass, field
from typing import Any

Value = float | str | None
"""A number, a text, or None where the machine does not know."""
Said = dict[str, tuple[list[float], list[Value]]]
"""Instants and values by item."""
Position = dict[str, Any]
"""From where a source goes on; only the source knows what it means."""


@dataclass(frozen=True)
class Batch:
    """Values by item: instants (s since 1970, rising) and what was said at each.

    ``upto_s``: all that was said before it is in this batch or an earlier one. ``gap``: something
    may be missing between the batch before and this one, and ``why``, which is not journalled;
    ``lost``: how many values are known to be.
    ``position``: where to go on after it. ``jump``: the machine's clock was set; what it says is
    no longer comparable with what it said before.
    """

    values: Said
    upto_s: float
    position: Position = field(default_factory=dict)
    gap: bool = False
    lost: int = 0
    jump: bool = False
    why: str = ""

    @property
    def count(self) -> int:
        """How many values it holds."""
        return sum(len(instants) for instants, _ in self.values.values())

    def as_row(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        return {
            "values": self.values,
            "upto_s": self.upto_s,
            "position": self.position,
            "gap": self.gap,
            "lost": self.lost,
            "jump": self.jump,
        }


def from_row(row: dict[str, Any]) -> Batch:
    """Return what ``as_row`` gave."""
    values = {item: (list(said[0]), list(said[1])) for item, said in row["values"].items()}
    return Batch(values, row["upto_s"], row["position"], row["gap"], row["lost"], row["jump"])
