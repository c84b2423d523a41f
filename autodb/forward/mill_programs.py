"""A milling program as cuts: every line that cuts, with the engagement of its real path.

The stock is a block; each step meets what those before have left, so that a corner or a pocket has
the width that it has there. Lines that only go down are not predicted, and said; drills are.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.block import ACROSS, Block, Cutter, MilledSteps, milled
from autodb.errors import UnusableInput
from autodb.files.job import OTHERS, JobProgram, ProgramTool
from autodb.files.job_cut import LEAST, MOST_CUT
from autodb.forward.along import ProgramLine, first_lines
from autodb.forward.line_parts import (
    CalledLine,
    Followed,
    line_rows,
    lines_joined,
    part_begins,
    program_of_job,
    step_conditions,
)
from autodb.forward.stated import left_out_of
from autodb.nc.reading import line_texts
from autodb.nc.reading.cycles.stated import StatedOfProgram
from autodb.nc.reading.travels import PackedMoves, ProgramMove
from autodb.nc.reading.turning_program import ReadProgram, carried_out
from autodb.pairs.engaged import (
    BAND_HIGH,
    BAND_LOW,
    DEPTH,
    DIAMETER,
    DIRECTION,
    FEED,
    RPM,
    SPEED,
    Conditions,
)
from autodb.wording import localized, phrase, phrase_many

Array = NDArray[np.float64]

PLUNGES = 0.98
"""Share of a step that goes down from which it counts as a plunge. Chosen: 79°."""
POINT_DEG = 130.0
"""Angle of a drill's point that nothing is stated of, as ``cutting.tools`` takes it."""


def follow_mill(
    asked: JobProgram, *, units: Literal["mm", "inch"] | None, highest_rpm: float | None = None
) -> Followed:
    """Return a job's milling program as lines that cut.

    Raises UnusableInput naming the program's file, its line and word, where it is not read, a tool
    is not stated, or nothing is cut.
    """
    text, sha256 = program_of_job(asked)
    source = str(Path(asked.file))
    stated = asked.units or units
    inches = None if stated is None else stated == "inch"
    done = carried_out(
        text, source=source, lathe=False, inch=inches, control=asked.control,
        radius_of=lambda move: _beside_mm(move, asked, source), highest_rpm=highest_rpm,
        block_skip=bool(asked.block_skip),
        stated=StatedOfProgram(
            speed_rpm=asked.speed_rpm, left_out=left_out_of(asked), angles=asked.angles,
            plane=asked.plane, centres_are_places=asked.centres == "places",
        ),
    )  # fmt: skip
    tools = done.travels.by_way(lambda travel: _tool_of(travel, asked, source))
    block = _block(asked, tools)
    cutters = {id(tool): _cutter(tool) for tool in tools}
    of_moves = [cutters[id(tool)] for tool in tools]
    steps = milled(done.travels, block, of_moves, source=source)
    _refuse_beyond(steps, done.travels, tools, source)
    lines, plunged = _lines(
        steps, done.travels, tools, lambda which: line_texts(text, which, source=source)
    )
    if not lines and not plunged:
        raise UnusableInput(
            phrase(
                "{source}: the program cuts no stock; state a block that reaches into the path",
                source=source,
            )
        )
    return Followed(
        source, sha256, lines, done.fed_s, _names(done, steps), float(steps.removed_mm3.sum()),
        (*done.notes, *_said(plunged)),
        _spans_mm(done.travels),
    )  # fmt: skip


def _spans_mm(travels: PackedMoves) -> dict[str, float]:
    """Return how far feeds reach, by axis: the widest of what each tool's starts and ends span."""
    feeds = travels.by_way(lambda travel: (travel.tool,) if travel.feed is not None else None)
    tools = {one: k for k, one in enumerate(dict.fromkeys(filter(None, feeds)))}
    which = np.array([-1 if one is None else tools[one] for one in feeds])
    places = travels.ends_mm
    spans = np.zeros(3)
    for k in range(len(tools)):
        its = places[which == k].reshape(-1, 3)
        spans = np.maximum(spans, its.max(axis=0) - its.min(axis=0))
    return dict(zip("xyz", spans.tolist(), strict=True))


def _said(plunged: Sequence[int]) -> Iterator[str]:
    if plunged:
        some = first_lines([f"{line}" for line in plunged])
        yield phrase_many(
            "mills plunge in line {lines}: what that takes is not predicted",
            "mills plunge in lines {lines}: what that takes is not predicted",
            len(plunged),
            lines=some,
        )


def _names(done: ReadProgram, steps: MilledSteps) -> tuple[str, ...]:
    moves = np.unique(steps.move[steps.removed_mm3 > 0]).tolist()
    return tuple(dict.fromkeys(tool for k in moves if (tool := done.travels[k].tool)))


def _tool_of(travel: ProgramMove, asked: JobProgram, source: str) -> ProgramTool:
    """Return what a job states of a move's tool; raises UnusableInput where it states nothing."""
    name = travel.tool or OTHERS
    tool = asked.tools.get(name, asked.tools.get(name.lstrip("0"), asked.tools.get(OTHERS)))
    if tool is not None and tool.diameter_mm is not None:
        return tool
    if travel.tool is None:
        raise UnusableInput(
            phrase(
                "{source}: line {line}: the program calls no tool before this, and nothing is "
                "stated of others; state kind, diameter_mm and teeth as [program.tools.{others}]",
                source=source,
                line=travel.line,
                others=OTHERS,
            )
        )
    raise UnusableInput(
        phrase(
            "{source}: line {line}: nothing is stated of tool '{name}'; state its kind, "
            "diameter_mm and teeth as [program.tools.{name}] or [program.tools.{others}]",
            source=source,
            line=travel.line,
            name=name,
            others=OTHERS,
        )
    )


def _beside_mm(move: ProgramMove, asked: JobProgram, source: str) -> float:
    """Return how far a mill's centre goes beside a compensated contour."""
    tool = _tool_of(move, asked, source)
    return 0.5 * (tool.diameter_mm or 0.0) if tool.offset_mm is None else tool.offset_mm


def _cutter(tool: ProgramTool) -> Cutter:
    diameter = tool.diameter_mm or 0.0
    point = 0.5 * diameter / np.tan(np.radians(0.5 * POINT_DEG)) if tool.kind == "drill" else 0.0
    return Cutter(diameter, tool.corner_radius_mm or 0.0, float(point))


def _block(asked: JobProgram, tools: Sequence[ProgramTool]) -> Block:
    """Return the block that a job states, in cells that are fine beside its smallest tool."""
    assert asked.block_mm is not None
    x0, x1, y0, y1, z0, z1 = asked.block_mm
    smallest = min(tool.diameter_mm or np.inf for tool in tools)
    return Block((x0, y0, z0), (x1, y1, z1), smallest / ACROSS)


def _refuse_beyond(
    steps: MilledSteps, travels: Sequence[ProgramMove], tools: Sequence[ProgramTool], source: str
) -> None:
    """Raise UnusableInput where a feed a tooth or a depth is a slip of the unit."""
    most = MOST_CUT["end_mill"]
    teeth = np.fromiter((tool.teeth or 1 for tool in tools), np.intp, len(tools))
    with np.errstate(invalid="ignore"):
        tooth = steps.feed_of / (steps.speed_of * teeth)
    wrong = (tooth > most["feed_mm_tooth"]) | (tooth < LEAST)
    beyond = np.flatnonzero(wrong[steps.move] & (steps.removed_mm3 > 0))
    if beyond.size:
        at = steps.move[beyond[0]]
        raise UnusableInput(
            phrase(
                "{source}: line {line}: a feed of {tooth} mm a tooth is beyond any tool; use "
                "{least} to {most}",
                source=source,
                line=travels[at].line,
                tooth=localized(f"{tooth[at]:g}"),
                least=localized(f"{LEAST:g}"),
                most=localized(f"{most['feed_mm_tooth']:g}"),
            )
        )


def _lines(
    steps: MilledSteps,
    travels: PackedMoves,
    tools: Sequence[ProgramTool],
    said: Callable[[Collection[int]], Mapping[int, str]],
) -> tuple[tuple[ProgramLine, ...], list[int]]:
    """Return the lines that cut, and those in which a mill only plunges."""
    names: dict[str | None, int] = {}
    of_move = travels.by_way(lambda travel: names.setdefault(travel.tool, len(names)))
    number_of = travels.line_numbers
    drills_in = np.fromiter((tool.kind == "drill" for tool in tools), np.bool_, len(tools))
    rows = np.flatnonzero(steps.removed_mm3 > 0)
    move = steps.move[rows]
    drills = drills_in[move]
    plunges = ~drills & (steps.plunge[rows] > PLUNGES)
    plunged = list(dict.fromkeys(number_of[move[plunges]].tolist()))
    kept = ~plunges & (drills | (steps.depth_mm[rows] > 0))
    rows, move = rows[kept], move[kept]
    found = line_rows(
        rows, number_of[move], drills[kept].astype(np.intp), np.array(of_move, np.intp)[move],
        operations=("mill", "drill"), tools=tuple(names),
    )  # fmt: skip
    lines = tuple(_line(steps, some, tools, called) for called, some in lines_joined(found, said))
    return lines, plunged


def _line(
    steps: MilledSteps,
    rows: NDArray[np.intp],
    tools: Sequence[ProgramTool],
    called: CalledLine,
) -> ProgramLine:
    """Return a line of which some steps cut."""
    tool = tools[int(steps.move[rows[0]])]
    columns = _columns(steps, rows, tool)
    begins = part_begins(np.column_stack(list(columns.values())))
    time_of = steps.time_s(rows)
    time_s = np.add.reduceat(time_of, begins)
    means = {
        channel: np.add.reduceat(values * time_of, begins) / time_s
        for channel, values in columns.items()
    }
    ends = np.append(begins[1:], len(rows))
    chip = steps.removed_mm3[rows]
    at = [b + int(np.argmax(chip[b:e])) for b, e in zip(begins, ends, strict=True)]
    first, last = ({n: float(v[k]) for n, v in columns.items()} for k in (0, -1))
    return ProgramLine(
        name=called.name,
        number=called.number,
        operation=called.operation,
        time_s=time_s,
        steps=step_conditions(means),
        extremes=step_conditions({n: values[at] for n, values in columns.items()}),
        ends=(first, last),
        widest=first,
        fastest_rpm=float(columns[RPM].max()),
        numbers=_numbers(tool),
        tool=called.tool,
    )


def _numbers(tool: ProgramTool) -> Conditions:
    stated = {
        "diameter_mm": tool.diameter_mm, "corner_radius_mm": tool.corner_radius_mm,
        "helix_deg": tool.helix_deg, "teeth": None if tool.kind == "drill" else tool.teeth or 1,
    }  # fmt: skip
    return {name: float(value) for name, value in stated.items() if value is not None}


def _columns(steps: MilledSteps, rows: NDArray[np.intp], tool: ProgramTool) -> dict[str, Array]:
    """Return conditions of steps by channel of a cut table."""
    teeth = 1.0 if tool.kind == "drill" else float(tool.teeth or 1)
    rpm = steps.speed_rpm(rows)
    depth = steps.depth_mm[rows]
    return {
        FEED: steps.feed_mm_min(rows) / (rpm * teeth),
        DIAMETER: np.full_like(depth, tool.diameter_mm or 0.0),
        DEPTH: depth
        if tool.kind != "drill"
        else np.full_like(depth, 0.5 * (tool.diameter_mm or 0)),
        BAND_LOW: steps.low_mm[rows],
        BAND_HIGH: steps.high_mm[rows],
        RPM: rpm,
        SPEED: np.pi * (tool.diameter_mm or 0.0) * rpm / 1000.0,
        DIRECTION: steps.direction_deg[rows],
    }
