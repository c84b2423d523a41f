"""What a job states that its program does not: of the tools, the stock, and cycles of the mask."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple


class Blade(NamedTuple):
    """A blade that cuts grooves: its width, and where its programmed corner is from that towards
    the chuck, mm."""

    width_mm: float
    corner_mm: float


class StatedStock(NamedTuple):
    """How far the stock reaches, mm: its largest radius, its face along z, the radius of its
    bore."""

    outer_mm: float
    face_mm: float
    bore_mm: float


class StatedTurning(NamedTuple):
    """What a call of CYCLE952 does: its cuts go across, towards the axis, or along it; it roughs,
    finishes; its allowances are those by axes (UX, UZ), or that of the contour (U), None where
    nobody says which."""

    across: bool
    roughs: bool
    finishes: bool
    by_axes: bool | None


def _outside(_tool: str | None) -> str:
    """Return what tools do of which nothing is stated."""
    return "outside"


def _no_blade(_tool: str | None) -> Blade | None:
    """Return that nothing is known of a tool's blade."""


def _no_turning(_line: int) -> StatedTurning | None:
    """Return that nothing is stated of a call."""


@dataclass(frozen=True)
class StatedOfProgram:
    """What a job states.

    ``kind_of`` a tool and ``blade_of`` it, None where nobody has stated it, as the program calls
    it; ``turning_of`` the call of CYCLE952 in a line; ``stock``, None where the program is read
    without one; ``per_minute``: what feeds count until the program says it, None as the control
    does; ``speed_rpm``: what the spindle turns at until the program says a speed;
    ``left_out``: subprograms, in capitals, that are missing and cut nothing; ``angles``: of a
    mill's rotary axes, degrees by letter, at which its moves are kept, None where none may turn;
    ``plane``: the line that tilts the one in which moves are kept, 0 upright, None where none may;
    ``centres_are_places``: I, J and K are places until the program says that they are none.
    """

    kind_of: Callable[[str | None], str] = _outside
    blade_of: Callable[[str | None], Blade | None] = _no_blade
    turning_of: Callable[[int], StatedTurning | None] = _no_turning
    stock: StatedStock | None = None
    per_minute: bool | None = None
    speed_rpm: float | None = None
    left_out: frozenset[str] = frozenset()
    angles: Mapping[str, float] | None = None
    plane: int | None = None
    centres_are_places: bool = False


NOTHING_STATED = StatedOfProgram()
