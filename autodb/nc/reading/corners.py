"""Corners that a straight move states: rounded by a radius, or broken by a chamfer.

A corner stands where one straight move meets the next; both are shortened. R is its radius, C (CHR)
how far the chamfer begins from the corner, CHF the chamfer's own length.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.nc.reading.travels import PLANES, Circle, ProgramMove, ToolPlace

Array = NDArray[np.float64]

CORNERS = {"R": "R", ",R": "R", "RND": "R", "C": "C", ",C": "C", "CHR": "C", "CHF": "CHF"}
"""Words of corners, and which kind they are."""
PROFILE_CORNERS = {"A": "R", "C": "CUT"}
"""The same in a profile of LinuxCNC's G70 to G72: a chamfer C begins and ends where an arc of that
radius would (LinuxCNC's G code reference, G71 G72)."""
_STRAIGHT = 1e-9


class CornerRecord:
    """Keeps moves in order, each corner between the two moves that it joins."""

    def __init__(self, keep: Callable[[ProgramMove], None], *, source: str) -> None:
        self.keep = keep
        self.source = source
        self.held: ProgramMove | None = None

    def __call__(self, move: ProgramMove) -> None:
        """Keep a move; one that states a corner waits for the next."""
        first, self.held = self.held, None
        if first is not None:
            before, corner, move = self._joined(first, move)
            self.keep(before)
            if corner is not None:
                self.keep(corner)
        if move.corner is not None:
            self.held = move
        else:
            self.keep(move)

    def finish(self) -> None:
        """Keep what still waits: no move follows its corner."""
        if self.held is not None:
            self.keep(replace(self.held, corner=None))
            self.held = None

    def _joined(
        self, first: ProgramMove, move: ProgramMove
    ) -> tuple[ProgramMove, ProgramMove | None, ProgramMove]:
        """Return both moves shortened, and what stands between them."""
        assert first.corner is not None
        kind, size, plane = first.corner
        first = replace(first, corner=None)
        back, ahead = _unit(first, back=True), _unit(move, back=False)
        cos = float(np.clip(back @ ahead, -1.0, 1.0))
        straight = move.circle is None and move.feed is not None
        if size and (move.circle is not None or first.circle is not None):
            raise UnusableInput(
                f"{self.source}: line {first.line}: a corner between a line and an arc is not "
                "read; write it out as an arc or a line"
            )
        if not straight or size == 0.0 or 1.0 - abs(cos) < _STRAIGHT:
            return first, None, move
        half = 0.5 * np.arccos(cos)
        round_mm = size / np.tan(half)
        trim = {
            "R": round_mm, "CUT": round_mm, "C": size, "CHF": size / (2.0 * np.sin(half)),
        }[kind]  # fmt: skip
        if trim > min(first.length_mm, move.length_mm) + 1e-6:
            raise UnusableInput(
                f"{self.source}: line {first.line}: a corner of {size:g} mm does not fit between "
                "its moves; make it smaller"
            )
        at = np.asarray(first.end)
        begins, ends = ToolPlace(*(at + trim * back)), ToolPlace(*(at + trim * ahead))
        circle = None
        if kind == "R":
            middle = at + (back + ahead) / np.linalg.norm(back + ahead) * size / np.sin(half)
            u, v, _ = PLANES[plane]
            turns = -back[u] * ahead[v] + back[v] * ahead[u]
            circle = Circle(plane, (float(middle[u]), float(middle[v])), bool(turns > 0))
        corner = replace(first, start=begins, end=ends, circle=circle)
        return replace(first, end=begins), corner, replace(move, start=ends)


def _unit(move: ProgramMove, *, back: bool) -> Array:
    """Return the direction of a straight move from its end back, or from its start on."""
    way = np.subtract(move.start, move.end) if back else np.subtract(move.end, move.start)
    return np.asarray(way / max(float(np.linalg.norm(way)), 1e-12))
