"""A turning program as cuts: every line that cuts, in steps along which its engagement holds.

A line's steps are those in which it cuts; its way through air counts for neither mean nor time.
Steps that are alike are one; where more than MOST are left of a line, they are joined evenly.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import turning
from autodb.cutting.contour import TOUCH_MM, ContourEngagement, engagement
from autodb.cutting.stock import Stock, bar, profile
from autodb.errors import UnusableInput
from autodb.files.channels import largest_of
from autodb.files.checksums import checksum
from autodb.files.job import LEAST, JobProgram
from autodb.forward.along import ProgramLine
from autodb.nc.reading import (
    Arc,
    CuttingSpeed,
    Move,
    PerRev,
    Rapid,
    line_texts,
    program_text,
    turning_program,
)
from autodb.pairs.engaged import DEPTH, DIAMETER, DIRECTION, FEED, RPM, SPEED, Conditions

Array = NDArray[np.float64]

MOST = 32
"""Steps of a line beyond which they are joined. Chosen: means of cones and arcs are off by less
than 0.1 % of what all steps give (a test)."""
ALIKE = 1e-6
"""Difference in mm, mm/rev, rpm or of a direction's cosine below which steps are alike."""
SQUARE_DEG = 1e-3
"""Off longitudinal or square to the axis by less, a line turns or faces."""


@dataclass(frozen=True)
class Followed:
    """A program followed through its stock: the lines that cut, and how long it feeds, s.

    ``tools``: what the program calls the tools that cut.
    """

    source: str
    sha256: str
    lines: tuple[ProgramLine, ...]
    fed_s: float
    tools: tuple[str, ...]

    @property
    def cutting_s(self) -> float:
        """How long the lines cut, s."""
        return float(sum(line.time_s.sum() for line in self.lines))


def follow(
    asked: JobProgram, *, units: Literal["mm", "inch"] | None, diameter: bool | None
) -> Followed:
    """Return a job's program as lines that cut; ``units`` and ``diameter`` of the machine's file.

    Raises UnusableInput naming the program's file, its line and word, where it is not read, its
    tool does what the engagement refuses, or nothing is cut.
    """
    path = Path(asked.file)
    text = program_text(path)
    found = checksum(path)
    if asked.sha256 not in (None, found):
        raise UnusableInput(
            f"{path}: is not the program of this job, its sha256 is {found}; use the file with "
            f"{asked.sha256}"
        )
    inches = (asked.units or units or "mm") == "inch"
    by_diameter = next((one for one in (asked.diameter, diameter) if one is not None), True)
    program = turning_program(text, source=str(path), diameter=by_diameter, inch=inches)
    for move in program.moves:
        _refuse_beyond(move, str(path))
    done, _ = engagement(program.moves, stock_of(asked), source=str(path))
    said = line_texts(text, source=str(path))
    moves = {move.line: move for move in program.moves}
    lines = tuple(_lines(done, moves, said, str(path)))
    if not lines:
        raise UnusableInput(
            f"{path}: the program cuts no stock; state a stock that reaches beyond the path"
        )
    tools = dict.fromkeys(moves[line.number].tool or "" for line in lines)
    return Followed(str(path), found, lines, float(_step_s(done).sum()), tuple(filter(None, tools)))


def stock_of(asked: JobProgram) -> Stock:
    """Return the stock that a job states."""
    if asked.stock_diameter_mm is not None:
        return bar(0.5 * asked.stock_diameter_mm, face_mm=asked.stock_face_mm or 0.0)
    z_mm, diameter_mm = np.array(asked.stock, dtype=np.float64).T
    return profile(z_mm, 0.5 * diameter_mm)


def _refuse_beyond(move: Move, source: str) -> None:
    """Raise UnusableInput for a move that no machine makes: as of a cut that a job states."""
    places = (move.start.x_mm, move.start.z_mm, move.end.x_mm, move.end.z_mm)
    stated = [("a place", "mm", abs(place), 0.0, "x.position") for place in places]
    if not isinstance(move, Rapid):
        feed, speed = move.feed, move.speed
        if isinstance(feed, PerRev):
            stated.append(("a feed", "mm/rev", feed.mm, LEAST, "cutting.feed"))
        else:
            stated.append(("a feed", "mm/s", feed.mm / 60.0, LEAST, "x.velocity"))
        if isinstance(speed, CuttingSpeed):
            stated.append(("a speed", "m/min", speed.m_min, LEAST, "cutting.speed"))
        else:
            stated.append(("a speed", "rpm", speed.rpm, LEAST, "spindle.speed"))
    for what, unit, value, least, channel in stated:
        most = largest_of(channel)
        if not least <= value <= most:
            raise UnusableInput(
                f"{source}: line {move.line}: {what} of {value:g} {unit} is beyond any machine; "
                f"use {least:g} to {most:g}"
            )


def _lines(
    done: ContourEngagement, moves: Mapping[int, Move], said: Mapping[int, str], source: str
) -> Iterator[ProgramLine]:
    step_s = _step_s(done)
    cutting = np.flatnonzero(done.depth_mm > TOUCH_MM)
    on_axis = cutting[np.abs(done.x_mm[cutting]) < TOUCH_MM]
    if on_axis.size:
        raise UnusableInput(
            f"{source}: line {done.line[on_axis[0]]}: the tool's tip cuts on the spindle's "
            "axis, where the cutting speed is 0; turn at a larger X"
        )
    for of_line in np.split(cutting, np.flatnonzero(np.diff(done.line[cutting])) + 1):
        if of_line.size:
            number = int(done.line[of_line[0]])
            yield _line(done, of_line, step_s, moves[number], said[number])


def _line(
    done: ContourEngagement, rows: NDArray[np.intp], step_s: Array, move: Move, said: str
) -> ProgramLine:
    """Return a line of which ``rows`` of the engagement cut."""
    columns = _columns(done, rows)
    begins = _begins(np.column_stack(list(columns.values())))
    time_s = np.add.reduceat(step_s[rows], begins)
    means = {
        name: np.add.reduceat(values * step_s[rows], begins) / time_s
        for name, values in columns.items()
    }
    # The spindle speed that has a part's mean cutting speed at its mean diameter
    means[RPM] = turning.speed_rpm(means[DIAMETER], means[SPEED])
    chip_mm2 = columns[DEPTH] * columns[FEED]
    ends = np.append(begins[1:], len(rows))
    at = [b + int(np.argmax(chip_mm2[b:e])) for b, e in zip(begins, ends, strict=True)]
    return ProgramLine(
        name=f"line {move.line}: {said}",
        number=move.line,
        operation=_operation(move),
        time_s=time_s,
        steps=_conditions(means),
        extremes=_conditions({name: values[at] for name, values in columns.items()}),
        ends=(_one(columns, 0), _one(columns, -1)),
        widest=_one(columns, int(np.argmax(columns[DIAMETER]))),
        fastest_rpm=float(columns[RPM].max()),
    )


def _columns(done: ContourEngagement, rows: NDArray[np.intp]) -> dict[str, Array]:
    """Return conditions of steps by channel of a cut table; the speed is that at the tool's tip."""
    diameter = 2.0 * np.abs(done.x_mm[rows])
    rpm = done.speed_rpm[rows]
    return {
        FEED: done.feed_mm_rev[rows],
        DEPTH: done.depth_mm[rows],
        DIAMETER: diameter,
        RPM: rpm,
        SPEED: turning.speed_m_min(diameter, rpm),
        DIRECTION: np.degrees(np.arctan2(-done.along_x[rows], -done.along_z[rows])),
    }


def _one(columns: Mapping[str, Array], row: int) -> Conditions:
    return {name: float(values[row]) for name, values in columns.items()}


def _begins(columns: Array) -> NDArray[np.intp]:
    """Return at which steps (n, k) parts of a line begin: where something changes, MOST at most."""
    changes = np.any(np.abs(np.diff(columns, axis=0)) > ALIKE, axis=1)
    begins = np.append(0, np.flatnonzero(changes) + 1)
    if len(begins) <= MOST:
        return begins
    return np.unique(np.linspace(0, len(columns), MOST, endpoint=False).astype(np.intp))


def _conditions(columns: Mapping[str, Array]) -> tuple[Conditions, ...]:
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    return tuple(dict(zip(columns, row, strict=True)) for row in rows)


def _operation(move: Move) -> str:
    """Return what a move at a feed is: an arc a contour, a straight line by its direction."""
    if isinstance(move, Arc):
        return "contour"
    inward = np.degrees(
        np.arctan2(move.start.x_mm - move.end.x_mm, move.start.z_mm - move.end.z_mm)
    )
    if abs(inward) < SQUARE_DEG:
        return "turn"
    return "face" if abs(abs(inward) - 90.0) < SQUARE_DEG else "taper"


def _step_s(done: ContourEngagement) -> Array:
    return np.asarray(60.0 * done.step_mm / (done.feed_mm_rev * done.speed_rpm))
