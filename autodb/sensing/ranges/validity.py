"""What a calibration holds for: gear range, coolant, spindle state and feed direction.

The gear and the warmth of the spindle count for its torque, the direction for a feed axis (its
friction and its screw's losses differ), the coolant for all.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from autodb.wording import stored_msgid

if TYPE_CHECKING:
    from autodb.records.tables import CutTable

LEAST_FEED_MM_S = 0.01
"""Mean velocity of an axis in a cut below which it stands. Chosen: 0.6 mm/min."""
GEARED = "spindle"
"""The axis that changes gear and grows warm."""
STATED = ("gear_range", "coolant", "spindle_state")
"""What a side file's [recording] states of all its cuts; text columns of tables gathered."""
OTHERWISE = stored_msgid("calibrated with {conditions}, not '{other}'")
UNSTATED = stored_msgid("calibrated with {conditions}, and the cut's is not stated")
SEVERAL = stored_msgid("{count} cuts do not state their {conditions}, and others state several")
SPOKEN = {
    "gear_range": "gear range",
    "coolant": "coolant",
    "spindle_state": "spindle state",
    "feed_direction": "feed direction",
}
STATED_AS = (
    stored_msgid("gear range {values}"), stored_msgid("coolant {values}"),
    stored_msgid("spindle state {values}"), stored_msgid("feed direction {values}"),
)  # fmt: skip
"""A condition with what is stated of it, in the order of ``SPOKEN``."""


@dataclass(frozen=True)
class Holds:
    """What a calibration holds for, or a cut was made with; None: any, or not stated."""

    gear_range: str | None = None
    coolant: str | None = None
    spindle_state: str | None = None
    feed_direction: str | None = None

    def against(self, other: "Holds") -> list[str]:
        """Return the names of what both state differently."""
        both = ((f.name, getattr(self, f.name), getattr(other, f.name)) for f in fields(self))
        return [name for name, a, b in both if a is not None and b is not None and a != b]

    def words(self) -> str:
        """Return what is stated, as 'gear range high, coolant flood'; empty: nothing."""
        return ", ".join(self.stated)

    @property
    def stated(self) -> list[str]:
        """What is stated, one after another."""
        every = ((f.name, getattr(self, f.name)) for f in fields(self))
        return [f"{SPOKEN[name]} '{value}'" for name, value in every if value is not None]


ANY = Holds()


def with_stated(table: "CutTable") -> "CutTable":
    """Return a table whose text columns say what its side file states of all its cuts."""
    said = table.side.recording
    texts = {name: [getattr(said, name) or ""] * len(table) for name in STATED}
    return replace(table, texts={**table.texts, **texts})


def holds_of(table: "CutTable", axis: str) -> list[Holds]:
    """Return what each cut of a table (n,) was made with, as far as it counts for an axis."""
    nothing = [""] * len(table)
    of_axis = STATED if axis == GEARED else ("coolant",)
    texts = {name: table.texts.get(name, nothing) for name in of_axis}
    directions = nothing if axis == GEARED else _directions(table, axis)
    return [
        Holds(
            **{name: column[i] or None for name, column in texts.items()},
            feed_direction=directions[i] or None,
        )
        for i in range(len(table))
    ]


def _directions(table: "CutTable", axis: str) -> list[str]:
    velocity = table.get(f"{axis}.velocity")
    if velocity is None:
        return [""] * len(table)
    return ["+" if v >= LEAST_FEED_MM_S else "-" if v <= -LEAST_FEED_MM_S else "" for v in velocity]


def which(known: Sequence[Holds], cut: Holds) -> int | str:
    """Return which of several that exclude each other holds for a cut, or why none does."""
    fit = [i for i, one in enumerate(known) if not one.against(cut)]
    if len(fit) == 1:
        return fit[0]
    if not fit:
        name = known[0].against(cut)[0]
        return OTHERWISE.format(conditions=_either(known, name), other=getattr(cut, name))
    several = [known[i] for i in fit]
    name = next(n for n in SPOKEN if len({getattr(one, n) for one in several}) > 1)
    return UNSTATED.format(conditions=_either(several, name))


def _either(known: Sequence[Holds], name: str) -> str:
    values = sorted({str(v) for one in known if (v := getattr(one, name)) is not None})
    return f"{SPOKEN[name]} " + " or ".join(f"'{value}'" for value in values)


def partition(cuts: Sequence[Holds]) -> dict[Holds, NDArray[np.bool_]]:
    """Return the cuts (n,) that can be calibrated on together, by what they hold for.

    A cut that does not state what all others state alike goes with them; where they state several,
    it goes with none. They hold for one feed direction where every one of them shows it: a gear or
    a coolant is stated on purpose, a velocity just happens to be recorded.
    """
    several = _several(cuts)
    alike = {name: _alike(cuts, name) for name in SPOKEN if name not in several}
    found: dict[Holds, NDArray[np.bool_]] = {}
    for i, cut in enumerate(cuts):
        if all(getattr(cut, name) is not None for name in several):
            own = found.setdefault(replace(cut, **alike), np.zeros(len(cuts), dtype=np.bool_))
            own[i] = True
    return found


def _alike(cuts: Sequence[Holds], name: str) -> str | None:
    """Return the one value that cuts state."""
    values = [getattr(cut, name) for cut in cuts]
    if name == "feed_direction" and None in values:
        return None
    return next((value for value in values if value is not None), None)


def unstated(
    cuts: Sequence[Holds], groups: dict[Holds, NDArray[np.bool_]], moves: NDArray[np.bool_]
) -> str | None:
    """Return how many cuts (n,) are in none of the groups, and what they would have to state.

    A cut in which the axis does not move states nothing of it.
    """
    left = moves.copy()
    for rows in groups.values():
        left &= ~rows
    out = int(left.sum())
    if not out:
        return None
    lacking = " and ".join(SPOKEN[name] for name in SPOKEN if name in _several(cuts))
    return SEVERAL.format(count=out, conditions=lacking)


def _several(cuts: Sequence[Holds]) -> set[str]:
    """Return the names of what cuts state differently."""
    return {name for name in SPOKEN if len({getattr(c, name) for c in cuts} - {None}) > 1}
