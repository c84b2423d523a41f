"""A turning program as cuts: every line that cuts, in steps along which its engagement holds.

A line's steps are those in which it cuts; its way through air counts for neither mean nor time.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from autodb.cutting import turning
from autodb.cutting.contour import TOUCH_MM
from autodb.cutting.engaged_steps import ContourEngagement
from autodb.cutting.stock import Stock, bar, profile
from autodb.cutting.tools import FOLLOWS_DEG
from autodb.cutting.working import DEEPEST_MM, KINDS, Worked, WorkTool, solid, worked
from autodb.errors import UnusableInput
from autodb.files.channels import largest_of
from autodb.files.job import OTHERS, JobProgram, ProgramTool
from autodb.files.job_cut import LEAST, MOST_CUT, MOST_PITCH_MM
from autodb.forward.along import ProgramLine, first_lines
from autodb.forward.line_parts import (
    CalledLine,
    Followed,
    feed_spans_mm,
    line_rows,
    lines_joined,
    part_begins,
    program_of_job,
    step_conditions,
)
from autodb.forward.mill_programs import follow_mill
from autodb.forward.sides import above_axis, cut_sideways, inward_deg
from autodb.forward.stated import JobStates
from autodb.nc.reading import (
    Arc,
    CuttingSpeed,
    Linear,
    Move,
    PerRev,
    Rapid,
    line_texts,
    turning_program,
)
from autodb.pairs.engaged import (
    DEPTH,
    DIAMETER,
    DIRECTION,
    FEED,
    RPM,
    SPEED,
    WIDTH,
    Conditions,
)
from autodb.wording import localized, msgid, phrase

Array = NDArray[np.float64]

MOST_CORE_MM = 6.0
"""Radius of a bar's last core up to which a turning tool may cut on the axis. Chosen: deeper than
passes of roughing, thinner than bars that are drilled."""
AT_ONCE = 20_000
"""Steps whose operations are told at once. Chosen: as objects they take 2 MB."""
A_PLACE, A_FEED, A_SPEED = msgid("a place"), msgid("a feed"), msgid("a speed")
SQUARE_DEG = 1e-3
"""Off longitudinal or square to the axis by less, a line turns or faces."""


def follow(
    asked: JobProgram,
    *,
    units: Literal["mm", "inch"] | None,
    diameter: bool | None,
    highest_rpm: float | None = None,
) -> Followed:
    """Return a job's program as lines that cut; ``units``, ``diameter`` and the spindle's highest
    speed of the machine's file.

    Raises UnusableInput naming the program's file, its line and word, where it is not read, its
    tool does what the engagement refuses, or nothing is cut.
    """
    if asked.block_mm is not None:
        return follow_mill(asked, units=units, highest_rpm=highest_rpm)
    path = Path(asked.file)
    text, found = program_of_job(asked)
    stated = asked.units or units
    inches = None if stated is None else stated == "inch"
    by_diameter = next((one for one in (asked.diameter, diameter) if one is not None), None)
    states = JobStates(asked, stock_of(asked))
    program = turning_program(
        text, source=str(path), diameter=by_diameter, inch=inches, control=asked.control,
        highest_rpm=highest_rpm, stated=states.stated(), block_skip=bool(asked.block_skip),
    )  # fmt: skip
    states.refuse_unused()
    for move in program.moves:
        _refuse_beyond(move, str(path))
    _refuse_feeds(program.moves, str(path))
    moves, mirrored = above_axis(program.moves)
    done = _worked(moves, asked, str(path))

    def said(which: Collection[int]) -> Mapping[int, str]:
        return line_texts(text, which, source=str(path))

    arcs = frozenset(move.line for move in program.moves if isinstance(move, Arc))
    lines = tuple(_lines(done, arcs, said, str(path)))
    if not lines:
        raise UnusableInput(
            phrase(
                "{file}: the program cuts no stock; state a stock that reaches beyond the path",
                file=path,
            )
        )
    cuts = {line.number for line in lines}
    tools = dict.fromkeys(move.tool for move in program.moves if move.tool and move.line in cuts)
    fed_s = float(done.steps.step_s.sum())
    return Followed(
        str(path), found, lines, fed_s, tuple(filter(None, tools)), done.removed_mm3,
        (*program.notes, *mirrored, *cut_sideways(done)),
        feed_spans_mm(
            (m.tool, {"x": m.start.x_mm, "z": m.start.z_mm}, {"x": m.end.x_mm, "z": m.end.z_mm})
            for m in program.moves
            if not isinstance(m, Rapid)
        ),
        program.beside,
    )  # fmt: skip


def _worked(moves: Sequence[Move], asked: JobProgram, source: str) -> Worked:
    """Return a program's engagement with the stock and the tools that a job states."""
    tools: dict[str | None, WorkTool] = {
        None: _work_tool(asked.tools.get(OTHERS, ProgramTool())),
        **{name: _work_tool(tool) for name, tool in asked.tools.items()},
    }
    work = solid(stock_of(asked), bore_mm=0.5 * (asked.bore_diameter_mm or 0.0))
    return worked(moves, work, tools, source=source)


def _work_tool(tool: ProgramTool) -> WorkTool:
    """Return a tool as engagement sees it; an edge of unknown angle follows up a shoulder."""
    if tool.kind == "end_mill":
        raise UnusableInput(
            phrase("a lathe's tool of kind 'end_mill'; state block_mm for a mill's program")
        )
    leans_deg = FOLLOWS_DEG if tool.kappa_deg is None else tool.kappa_deg - 90.0
    return WorkTool(
        kind=tool.kind,
        edge_mm=tool.edge_mm or DEEPEST_MM,
        lean=float(np.tan(np.radians(np.clip(leans_deg, 0.0, 80.0)))),
        width_mm=tool.width_mm,
        towards_chuck=tool.corner == "away",
        diameter_mm=tool.diameter_mm,
    )


def stock_of(asked: JobProgram) -> Stock:
    """Return the stock that a job states."""
    if asked.stock_diameter_mm is not None:
        return bar(0.5 * asked.stock_diameter_mm, face_mm=asked.stock_face_mm or 0.0)
    z_mm, diameter_mm = np.array(asked.stock, dtype=np.float64).T
    return profile(z_mm, 0.5 * diameter_mm)


def _refuse_beyond(move: Move, source: str) -> None:
    """Raise UnusableInput for a move that no machine makes: as of a cut that a job states."""
    places = (move.start.x_mm, move.start.z_mm, move.end.x_mm, move.end.z_mm)
    stated = [(A_PLACE, "mm", abs(place), 0.0, "x.position") for place in places]
    if not isinstance(move, Rapid):
        feed, speed = move.feed, move.speed
        if not isinstance(feed, PerRev):
            stated.append((A_FEED, "mm/s", feed.mm / 60.0, LEAST, "x.velocity"))
        if isinstance(speed, CuttingSpeed):
            stated.append((A_SPEED, "m/min", speed.m_min, LEAST, "cutting.speed"))
        else:
            stated.append((A_SPEED, "rpm", speed.rpm, LEAST, "spindle.speed"))
    for what, unit, value, least, channel in stated:
        most = largest_of(channel)
        if not least <= value <= most:
            raise UnusableInput(
                phrase(
                    "{source}: line {line}: {what} of {value} {unit} is beyond any machine; use "
                    "{least} to {most}",
                    source=source,
                    line=move.line,
                    what=phrase(what),
                    value=localized(f"{value:g}"),
                    unit=unit,
                    least=localized(f"{least:g}"),
                    most=localized(f"{most:g}"),
                )
            )


def _refuse_feeds(moves: Sequence[Move], source: str) -> None:
    """Raise UnusableInput for feeds a revolution that are a slip of the unit, all lines at once."""
    beyond = [move for move in moves if _beyond_feed(move)]
    if not beyond:
        return
    first = beyond[0]
    assert not isinstance(first, Rapid)
    said = phrase(
        "{source}: line {line}: a feed of {mm_rev} mm/rev is beyond what a tool cuts "
        'with; use {least} to {most}, or G94, G98 or feeds = "minute" of the job for mm/min',
        source=source,
        line=first.line,
        mm_rev=localized(f"{first.feed.mm:g}"),
        least=localized(f"{LEAST:g}"),
        most=localized(f"{_most_feed(first):g}"),
    )
    others = [f"{line}" for line in dict.fromkeys(move.line for move in beyond)][1:]
    if others:
        said = phrase("{what} (so in line {lines})", what=said, lines=first_lines(others))
    raise UnusableInput(said)


def _beyond_feed(move: Move) -> bool:
    if isinstance(move, Rapid) or not isinstance(move.feed, PerRev):
        return False
    return not LEAST <= move.feed.mm <= _most_feed(move)


def _most_feed(move: Move) -> float:
    thread = isinstance(move, Linear) and move.thread
    return MOST_PITCH_MM if thread else MOST_CUT["turning_insert"]["feed_mm_rev"]


def _lines(
    found: Worked,
    arcs: frozenset[int],
    said: Callable[[Collection[int]], Mapping[int, str]],
    source: str,
) -> Iterator[ProgramLine]:
    done = found.steps
    _refuse_feed_a_minute(done, source)
    cutting = np.flatnonzero(done.depth_mm > TOUCH_MM)
    _refuse_drilling(done, source)
    names: dict[str, int] = {}
    operations = np.empty(len(cutting), dtype=np.intp)
    for at in range(0, len(cutting), AT_ONCE):
        some = _operations(found, cutting[at : at + AT_ONCE], arcs)
        operations[at : at + AT_ONCE] = [names.setdefault(one, len(names)) for one in some]
    rows = line_rows(
        cutting, done.line[cutting], operations, found.tool[cutting],
        operations=tuple(names), tools=found.called,
    )  # fmt: skip
    for called, its in lines_joined(rows, said):
        yield _line(found, its, called)


def _refuse_feed_a_minute(done: ContourEngagement, source: str) -> None:
    """Raise UnusableInput where a feed a minute is too much a revolution at the spindle's speed."""
    most = max(MOST_CUT["turning_insert"]["feed_mm_rev"], MOST_PITCH_MM)
    beyond = np.flatnonzero((done.feed_mm_rev > most) & (done.depth_mm > TOUCH_MM))
    if beyond.size:
        at = beyond[0]
        raise UnusableInput(
            phrase(
                "{source}: line {line}: at {speed} rpm its feed is {feed_mm_rev} mm a "
                "revolution; use at most {most}",
                source=source,
                line=done.line[at],
                speed=localized(f"{done.speed_rpm[at]:.0f}"),
                feed_mm_rev=localized(f"{done.feed_mm_rev[at]:g}"),
                most=localized(f"{most:g}"),
            )
        )


def _refuse_drilling(done: ContourEngagement, source: str) -> None:
    """Raise UnusableInput for a cut on the axis that only a drill makes."""
    core = (np.abs(done.x_mm) < TOUCH_MM) & (done.depth_mm > MOST_CORE_MM)
    if core.any():
        at = int(np.argmax(core))
        raise UnusableInput(
            phrase(
                "{source}: line {line}: on the spindle's axis this cuts {depth} mm deep, as a "
                "drill does; state the kind of this tool",
                source=source,
                line=done.line[at],
                depth=localized(f"{done.depth_mm[at]:.3f}"),
            )
        )


def _operations(found: Worked, rows: NDArray[np.intp], arcs: frozenset[int]) -> list[str]:
    """Return what the tool does at steps: by its kind, and of an outside tool by its way."""
    inward = inward_deg(found, rows)
    # A blade that cuts with its side turns
    beside = found.grooves(rows) & ~(found.width_mm[rows] > 0.0)
    kinds = np.where(beside, KINDS.index("outside"), found.kind[rows])
    return [
        _OF_KIND[kind] or _operation(angle, arc=line in arcs)
        for line, angle, kind in zip(
            found.steps.line[rows].tolist(), inward.tolist(), kinds.tolist(), strict=True
        )
    ]


_OF_KIND = (None, "bore", "groove", "thread", "drill")
"""What a tool of each of ``KINDS`` does; one that turns outside, by its way."""


def _line(found: Worked, rows: NDArray[np.intp], called: CalledLine) -> ProgramLine:
    """Return a line of which ``rows`` of the engagement cut."""
    columns = _columns(found, rows)
    begins = part_begins(np.column_stack(list(columns.values())))
    step_s = 60.0 * found.steps.step_mm[rows] / (columns[FEED] * columns[RPM])
    time_s = np.add.reduceat(step_s, begins)
    means = {
        name: np.add.reduceat(values * step_s, begins) / time_s for name, values in columns.items()
    }
    # The spindle speed that has a part's mean cutting speed at its mean diameter
    means[RPM] = turning.speed_rpm(means[DIAMETER], means[SPEED])
    chip_mm2 = columns[DEPTH] * columns[FEED]
    ends = np.append(begins[1:], len(rows))
    at = [b + int(np.argmax(chip_mm2[b:e])) for b, e in zip(begins, ends, strict=True)]
    return ProgramLine(
        name=called.name,
        number=called.number,
        operation=called.operation,
        time_s=time_s,
        steps=step_conditions(means),
        extremes=step_conditions({name: values[at] for name, values in columns.items()}),
        ends=(_one(columns, 0), _one(columns, -1)),
        widest=_one(columns, int(np.argmax(columns[DIAMETER]))),
        fastest_rpm=float(columns[RPM].max()),
        numbers=_drill_numbers(columns) if called.operation == "drill" else None,
        tool=called.tool,
    )


def _drill_numbers(columns: Mapping[str, Array]) -> dict[str, float]:
    """Return what is known of a drill: the diameter that it makes."""
    return {"diameter_mm": float(columns[DIAMETER].max())}


def _columns(found: Worked, rows: NDArray[np.intp]) -> dict[str, Array]:
    """Return conditions of steps by channel of a cut table; the speed is that at the tool's tip.

    Where the tip is on the axis, which takes off the last core of a bar: in the middle of it.
    """
    done = found.steps
    tip_mm = np.abs(done.x_mm[rows])
    diameter = np.where(tip_mm < TOUCH_MM, done.outer_mm[rows], 2.0 * tip_mm)
    rpm = done.speed_rpm[rows]
    return {
        FEED: done.feed_mm_rev[rows],
        DEPTH: done.depth_mm[rows],
        WIDTH: found.width_mm[rows],
        DIAMETER: diameter,
        RPM: rpm,
        SPEED: turning.speed_m_min(diameter, rpm),
        DIRECTION: inward_deg(found, rows),
    }


def _one(columns: Mapping[str, Array], row: int) -> Conditions:
    return {name: float(values[row]) for name, values in columns.items()}


def _operation(inward_deg: float, *, arc: bool) -> str:
    """Return what an outside tool does on its way: turn, face, a straight or a round contour."""
    if abs(inward_deg) < SQUARE_DEG:
        return "turn"
    if abs(abs(inward_deg) - 90.0) < SQUARE_DEG:
        return "face"
    return "contour" if arc else "taper"
