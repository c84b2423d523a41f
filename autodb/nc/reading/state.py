"""What is in force while a program runs: how numbers count, motion, feed, spindle, tool, place."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import cos, sin
from typing import NamedTuple

from autodb.nc.reading.codes import INCH_MM
from autodb.nc.reading.controls import PLAIN, Control
from autodb.nc.reading.lines.blocks import ProgramBlock, Word
from autodb.nc.reading.paths import CuttingSpeed, Feed, FeedPerMinute, PerRev, Revolutions, Speed
from autodb.nc.reading.travels import Beside

_FOOT_M = 12 * INCH_MM / 1000
AXES = ("x", "y", "z")
Places = dict[str, float | None]
Tilt = tuple[tuple[float, ...], ...]
"""What a program says of a tilted plane, call by call; nothing: it is upright."""


@dataclass(frozen=True)
class TurnedPlane:
    """Coordinates turned in the plane of X and Y: about a place, mm, to the left by an angle."""

    x_mm: float
    y_mm: float
    angle_rad: float

    def placed(self, x_mm: float, y_mm: float, *, back: bool = False) -> tuple[float, float]:
        """Return where a programmed place lies, mm; ``back``: what is programmed for a place."""
        x, y = self.along(x_mm - self.x_mm, y_mm - self.y_mm, back=back)
        return self.x_mm + x, self.y_mm + y

    def along(self, x_mm: float, y_mm: float, *, back: bool = False) -> tuple[float, float]:
        """Return a programmed way as it is gone, mm; ``back``: the reverse."""
        c, s = cos(self.angle_rad), sin(self.angle_rad) * (-1.0 if back else 1.0)
        return c * x_mm - s * y_mm, s * x_mm + c * y_mm


@dataclass(frozen=True)
class PolarPlace:
    """The pole that G16 counts from, mm, and the radius, mm, and angle, degrees, said last."""

    pole: tuple[float, float]
    radius_mm: float | None = None
    angle_deg: float | None = None


class CalledContour(NamedTuple):
    """A contour that a block names: the unit that has it, none for that which runs, and its first
    and last label, none for the whole unit."""

    unit: str | None
    first: str | None = None
    last: str | None = None


@dataclass
class ProgramState:
    """What is in force.

    ``place``: mm by axis, x of a lathe as a radius, None where the program has not said it;
    ``shift``: what is added to programmed places; ``feed`` in mm/rev or mm/min as ``feed_word``
    says, ``feed_said``: the program does, and ``diameter_said``,
    ``unit_said``; ``speed`` in rpm or, with
    ``surface``, m/min; ``dial_rpm``: where S is 0, as a job states it; ``limit_rpm`` holds in G96,
    ``highest_rpm`` always; ``turning``: whether the spindle does, and since which line it stands;
    ``spindle``: the P that has chosen it;
    ``step_diameter``: how increments of X count,
    None as places do; ``changes_tools``: whether an M6 does, anywhere; ``cycle``: that in force,
    with what it has ``taken``;
    ``side``: that of compensation, ``side_mm``: how far, where the program says it; ``turned``:
    coordinates that are; ``polar``: X and Y are radius and angle, ``polar_place`` what was said;
    ``contours``: what CYCLE62 has called since a cycle took some; ``in_profile``: the contour of a
    cycle of LinuxCNC runs, where A and C are corners; ``angles``: of rotary axes, degrees, at which
    moves are kept, None where none may turn, ``rotary``: at which they are; ``turning_rotary``: one
    turns in the block; ``tilt``: of the plane, ``tilted_in``: which lines have, ``looks_at``: the
    line of the plane in which moves are kept, 0 upright, None where none may be tilted.
    """

    lathe: bool
    diameter: bool
    unit_mm: float
    control: Control = PLAIN
    absolute: bool = True
    step_diameter: bool | None = None
    motion: str | None = None
    plane: str = "G17"
    side: str | None = None
    side_mm: float | None = None
    centre_absolute: bool = False
    to_start: bool = True
    feed_word: str = "G94"
    feed_said: bool = False
    diameter_said: bool = False
    unit_said: bool = False
    feed: float | None = None
    surface: bool = False
    speed: float | None = None
    dial_rpm: float | None = None
    limit_rpm: float | None = None
    highest_rpm: float | None = None
    turning: bool = False
    spindle: str | None = None
    stopped: int | None = None
    tool: str | None = None
    called: str | None = None
    changes_tools: bool = True
    offset: str | None = None
    edge: str | None = None
    place: Places = field(default_factory=lambda: dict.fromkeys(AXES))
    turned: TurnedPlane | None = None
    polar: bool = False
    polar_place: PolarPlace | None = None
    shift: dict[str, float] = field(default_factory=lambda: dict.fromkeys(AXES, 0.0))
    cycle: str | None = None
    taken: dict[str, float] = field(default_factory=dict)
    contours: tuple[CalledContour, ...] = ()
    in_profile: bool = False
    angles: Mapping[str, float] | None = None
    rotary: dict[str, float] = field(default_factory=dict)
    turning_rotary: bool = False
    tilt: Tilt = ()
    tilted_in: dict[int, Tilt] = field(default_factory=dict)
    looks_at: int | None = None
    notes: dict[str, None] = field(default_factory=dict)

    def factor(self, axis: str, *, step: bool = False) -> float:
        """Return mm for one programmed unit of an axis; of a lathe's X mm of radius."""
        counts = self.step_diameter if step and self.step_diameter is not None else self.diameter
        return self.unit_mm * (0.5 if axis == "x" and self.lathe and counts else 1.0)

    @property
    def beside(self) -> Beside | None:
        """On which side of the contour a tool goes, and how far; None where it does not."""
        return None if self.side is None else (self.side, self.side_mm)

    def known(self, axis: str) -> float:
        """Return where an axis is, mm; it is known."""
        found = self.place[axis]
        assert found is not None
        return found

    def note(self, said: str) -> None:
        """Keep what a reader has to know; once, whatever how often it is said."""
        self.notes.setdefault(said)

    def forget(self, *axes: str) -> None:
        """Let places of axes not be known any more."""
        for axis in axes or AXES:
            self.place[axis] = None

    def set_surface_speed(self, said: float) -> None:
        """Take a speed S: m/min in G96, feet with inches, else rpm."""
        self.speed = said * (_FOOT_M if self.surface and self.unit_mm == INCH_MM else 1.0)


def feed_in_force(state: ProgramState, block: ProgramBlock) -> Feed:
    """Return the feed of a cutting move; raises UnusableInput saying what is not stated."""
    word = state.cycle or state.motion or block.words[0].text
    if state.feed is None:
        raise block.refusal(
            word, f"no feed before this cutting move; state F after {state.feed_word}"
        )
    if not state.feed_said and state.lathe:
        per = "a revolution" if state.feed_word == "G95" else "a minute"
        state.note(f"nothing says what feeds count: taken {per} ({state.feed_word})")
    return PerRev(state.feed) if state.feed_word == "G95" else FeedPerMinute(state.feed)


def speed_in_force(state: ProgramState, block: ProgramBlock) -> Speed:
    """Return the spindle speed of a cutting move; raises UnusableInput where there is none."""
    word = state.cycle or state.motion or block.words[0].text
    if state.stopped is not None:
        raise block.refusal(
            word, f"the spindle stopped with M5 in line {state.stopped}; start it with M3 or M4"
        )
    if not state.speed:
        raise block.refusal(
            word,
            "no spindle speed before this cutting move; state S with G97 or G96, or speed_rpm in "
            "the job",
        )
    if not state.turning:
        raise block.refusal(word, "nothing has started the spindle; use M3 or M4 before this move")
    highest = [limit for limit in (state.limit_rpm, state.highest_rpm) if limit is not None]
    if state.surface and state.lathe:
        return CuttingSpeed(state.speed, min(highest, default=None))
    return Revolutions(min(state.speed, state.highest_rpm or state.speed))


def word_value(word: Word) -> float:
    """Return the number of a word that has one."""
    assert word.number is not None  # sorted_words() refused
    return word.number


def feed_value(word: Word, unit_mm: float, block: ProgramBlock) -> float | None:
    """Return a feed F in mm; none for F0, which no move can be cut with; refused where negative."""
    return positive_value(word, block) * unit_mm if word_value(word) else None


def positive_value(word: Word, block: ProgramBlock) -> float:
    """Return a word's number; raises UnusableInput where it is not above 0."""
    if word_value(word) <= 0:
        raise block.refusal(word.text, "use a number above 0")
    return word_value(word)
