"""Tool paths in program coordinates: moves, the path of one cut, and how numbers are rounded."""

from collections.abc import Mapping
from dataclasses import dataclass

from autodb.standard import StandardCut

Place = Mapping[str, float]
"""Coordinates by axis, mm; x of a lathe as a radius."""
DECIMALS = 3


@dataclass(frozen=True)
class StraightMove:
    """A straight move of the axes in ``to``; a rapid where there is no ``feed``.

    The feed is in mm/rev on a lathe and in mm/min on a mill.
    """

    to: Place
    feed: float | None = None


@dataclass(frozen=True)
class CutPath:
    """One cut from its approach to where the tool is clear of the stock again.

    ``lift_mm`` along ``lift_axis`` brings all of it into the air. ``new_stock``: a new bar or block
    comes before it.
    """

    cut: StandardCut
    moves: tuple[StraightMove, ...]
    lift_axis: str
    lift_mm: float
    new_stock: bool

    def lifted(self) -> tuple[StraightMove, ...]:
        """Return the same moves in air, for the dry run."""
        return tuple(
            StraightMove({axis: self._up(axis, mm) for axis, mm in move.to.items()}, move.feed)
            for move in self.moves
        )

    def _up(self, axis: str, mm: float) -> float:
        return round(mm + self.lift_mm, DECIMALS) if axis == self.lift_axis else mm


def rapid(**to_mm: float) -> StraightMove:
    """Return a rapid to coordinates by axis, mm."""
    return StraightMove(_rounded(to_mm))


def feed(per: float, /, **to_mm: float) -> StraightMove:
    """Return a move at a feed to coordinates by axis, mm."""
    return StraightMove(_rounded(to_mm), per)


def _rounded(to_mm: Mapping[str, float]) -> dict[str, float]:
    return {axis: round(mm, DECIMALS) + 0.0 for axis, mm in to_mm.items()}
