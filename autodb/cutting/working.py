"""Engagement of a program whose tools differ: outside and inside turning, grooves, threads, drills.

Each tool meets the stock as those before have left it, and has an engaged edge of its own:

- outside: as ``contour`` says;
- boring: the same seen in a mirror, x' = C − x, in which the bore is turned from outside;
- grooving and parting: the blade's front, as wide as there is stock before it: [z, z + w] where the
  program states the corner towards the chuck; in the mirror where it begins within the bore;
- a thread: the two flanks of a V of 60°, each pass as deep as it is beyond the one before;
- a drill on the axis: its whole width, where there is no hole yet.

Source: geometry, derived here.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.contour import (
    TOUCH_MM,
    engaged_beside,
    engaged_moves,
    engagement_rows,
    piece_ends_mm,
)
from autodb.cutting.engaged_steps import ContourEngagement, EngagedSteps
from autodb.cutting.pieces import Piece, pieces
from autodb.cutting.stock import Stock, hollow_mm3, nothing_around
from autodb.errors import UnusableInput
from autodb.nc.reading import Arc, Linear, Move, Point, Rapid
from autodb.wording import phrase

Array = NDArray[np.float64]
WorkKind = Literal["outside", "boring", "grooving", "threading", "drill"]
KINDS: tuple[WorkKind, ...] = get_args(WorkKind)

MIRROR_MM = 10_000.0
"""The radius about which a bore is mirrored: larger than any work. Chosen."""
DEEPEST_MM = 25.0
"""Longest edge of a tool that nothing is stated of: inserts of ISO 1832 have edges of 6 to 25 mm.
Chosen."""
FLANK_RAD = np.pi / 6.0
"""Half the angle of a thread's V (ISO 68, UN)."""
_OFF_AXIS_MM = 0.05


@dataclass(frozen=True)
class WorkTool:
    """A tool of a program: what it does, and what of its shape decides the engaged edge.

    ``edge_mm``: its longest depth; ``lean`` as in ``contour``; ``width_mm`` of a blade, which
    reaches from its corner away from the chuck unless ``towards_chuck``; ``diameter_mm`` of a
    drill.
    """

    kind: WorkKind = "outside"
    edge_mm: float = DEEPEST_MM
    lean: float = 0.0
    width_mm: float | None = None
    towards_chuck: bool = False
    diameter_mm: float | None = None


@dataclass(frozen=True)
class Work:
    """What is there to cut: the outer surface, and the bore as it looks in the mirror.

    ``thread_mm``: radius down to which the last thread goes, None without one.
    """

    outer: Stock
    bored: Stock
    thread_mm: float | None = None

    def volume_mm3(self, *, from_mm: float) -> float:
        """Return the volume of the work in front of z, its bore left out, mm³."""
        inner = replace(
            self.bored,
            low_mm=MIRROR_MM - self.bored.low_mm,
            high_mm=MIRROR_MM - self.bored.high_mm,
            behind_mm=MIRROR_MM - self.bored.behind_mm,
        )
        return hollow_mm3(self.outer, inner, from_mm=from_mm)


@dataclass(frozen=True)
class Worked:
    """Engagement of a whole program.

    Steps that do the same are one, as long as they follow each other. ``width_mm`` (n,): of a
    groove's chip, and the height of a thread, at every step; ``kind`` and ``tool`` (n,): which of
    ``KINDS`` it is, and which of ``called``, what the program calls its tools, makes it;
    ``removed_mm3`` of all.
    """

    steps: ContourEngagement
    width_mm: Array
    kind: NDArray[np.int16]
    removed_mm3: float
    tool: NDArray[np.int16]
    called: tuple[str | None, ...]

    def grooves(self, rows: NDArray[np.intp]) -> NDArray[np.bool_]:
        """Return which of some steps (k,) a blade makes."""
        return np.asarray(self.kind[rows] == KINDS.index("grooving"))


def solid(outer: Stock, *, bore_mm: float = 0.0) -> Work:
    """Return a work from its outer surface, with a through hole of a radius along it or none."""
    inner = replace(
        outer,
        low_mm=np.full_like(outer.low_mm, MIRROR_MM - bore_mm),
        high_mm=np.full_like(outer.high_mm, MIRROR_MM - bore_mm),
        behind_mm=MIRROR_MM - bore_mm,
    )
    return Work(outer, inner)


def worked(
    moves: Sequence[Move],
    work: Work,
    tools: Mapping[str | None, WorkTool],
    *,
    source: str,
    step_mm: float = 0.05,
) -> Worked:
    """Return the engagement along moves, each with its tool; see `contour.engagement`.

    ``tools``: by what the program calls them, None the one of all others. Raises UnusableInput
    naming ``source`` and the line that its tool cannot cut: a bore or a groove that none explains.
    """
    if not any(isinstance(move, Linear | Arc) for move in moves):
        raise UnusableInput(
            phrase("{source}: no move at a feed; use a program with G1, G2 or G3", source=source)
        )
    at_mm = piece_ends_mm(moves, source=source, step_mm=step_mm)
    widths = [tool.width_mm for tool in tools.values() if tool.width_mm]
    at_mm = np.concatenate([at_mm, *(at_mm + sign * w for w in widths for sign in (1, -1))])
    work = replace(
        work,
        outer=work.outer.divided(at_mm, cell_mm=step_mm),
        bored=work.bored.divided(at_mm, cell_mm=step_mm),
    )
    called: dict[str | None, int] = {}
    runs: list[tuple[int, int, int]] = []
    begun = work.volume_mm3(from_mm=float(at_mm.min()))
    threads_mm3 = 0.0
    done = EngagedSteps()
    for (tool, name), some in _by_tool(moves, tools):
        first = len(done)
        work = _MADE[tool.kind](some, work, _Run(tool, source, step_mm, done))
        place = called.setdefault(name, len(called))
        runs.append((place, KINDS.index(tool.kind), len(done) - first))
        if tool.kind == "threading":
            threads_mm3 += _thread_mm3(*done.since(first))
    left = work.volume_mm3(from_mm=float(at_mm.min()))
    which, kind = np.array([one[:2] for one in runs], dtype=np.int16).T
    count = [one[2] for one in runs]
    steps, width_mm = done.since()
    return Worked(
        steps, width_mm, np.repeat(kind, count), begun - left + threads_mm3,
        np.repeat(which, count), tuple(called),
    )  # fmt: skip


def _by_tool(
    moves: Sequence[Move], tools: Mapping[str | None, WorkTool]
) -> Iterator[tuple[tuple[WorkTool, str | None], Iterator[Move]]]:
    """Yield runs of moves that one tool makes in one way, and what the program calls it.

    A thread tells that it is one; the rapids behind its passes begin in it.
    """
    thread, plain = WorkTool("threading"), WorkTool()

    def of_moves() -> Iterator[tuple[WorkTool, Move]]:
        before: WorkTool | None = None
        for move in moves:
            stated = tools.get(move.tool, tools.get(tool_number(move.tool), tools[None]))
            threads = isinstance(move, Linear) and move.thread
            behind = isinstance(move, Rapid) and before is thread
            cuts = plain if stated.kind == "threading" else stated
            before = thread if threads or behind else cuts
            yield before, move

    for which, pairs in groupby(of_moves(), lambda pair: (pair[0], pair[1].tool)):
        yield which, (move for _, move in pairs)


def tool_number(tool: str | None) -> str | None:
    """Return a tool's number without its offset and zeros: 3 of 0303."""
    if tool is None or not tool.isdigit():
        return tool
    return str(int(tool[:-2])) if len(tool) > 2 and int(tool[:-2] or 0) else str(int(tool))


@dataclass(frozen=True)
class _Run:
    """What a run of moves is made with, and where its steps go."""

    tool: WorkTool
    source: str
    step_mm: float
    into: EngagedSteps


def _outside(moves: Iterator[Move], work: Work, run: _Run) -> Work:
    outer = engaged_moves(
        moves, work.outer, run.into, source=run.source, step_mm=run.step_mm,
        edge_mm=run.tool.edge_mm, lean=run.tool.lean, alike_joined=True,
    )  # fmt: skip
    return replace(work, outer=outer)


def _boring(moves: Iterator[Move], work: Work, run: _Run) -> Work:
    gone = nothing_around(work.bored, work.outer, mirror_mm=MIRROR_MM)
    nothing = work.bored.turned(work.bored.edges_mm[[0, -1]], np.zeros(2))
    bored = engaged_moves(
        map(_mirrored, moves), work.bored.put(gone, nothing), run.into, source=run.source,
        step_mm=run.step_mm, edge_mm=run.tool.edge_mm, mirror_mm=MIRROR_MM, alike_joined=True,
    )  # fmt: skip
    return replace(work, bored=bored.put(gone, work.bored))


def _mirrored(move: Move) -> Move:
    start, end = _seen(move.start), _seen(move.end)
    if isinstance(move, Arc):
        return replace(move, start=start, end=end, centre=_seen(move.centre), left=not move.left)
    return replace(move, start=start, end=end)


def _seen(place: Point) -> Point:
    return Point(MIRROR_MM - place.x_mm, place.z_mm)


def _grooving(moves: Iterator[Move], work: Work, run: _Run) -> Work:
    tool = run.tool
    if tool.width_mm is None:
        raise UnusableInput(
            phrase(
                "{source}: line {line}: the blade's width is not known; state width_mm",
                source=run.source,
                line=next(moves).line,
            )
        )
    feeds = [move for move in moves if not isinstance(move, Rapid)]
    bores = _in_bore(feeds, tool, work.bored)
    stock = work.bored if bores else work.outer
    for move in feeds:
        for piece in pieces(_mirrored(move) if bores else move, step_mm=run.step_mm):
            found, width, stock = _plunged(
                piece, stock, tool, run.source, mirror_mm=MIRROR_MM if bores else None
            )
            run.into.add(found, width)
    return replace(work, bored=stock) if bores else replace(work, outer=stock)


def _in_bore(feeds: Sequence[Move], tool: WorkTool, bored: Stock) -> bool:
    """Return whether a blade begins within the bore, where it first has stock beside it."""
    for move in feeds:
        cells = _under(tool, move.start.z_mm, bored)
        seen_mm = np.maximum(bored.low_mm[cells], bored.high_mm[cells])
        if seen_mm.size:
            bore_mm = MIRROR_MM - float(seen_mm.max())
            return bore_mm > TOUCH_MM and 0 <= move.start.x_mm < bore_mm + TOUCH_MM
    return False


def _plunged(
    piece: Piece, stock: Stock, tool: WorkTool, source: str, *, mirror_mm: float | None
) -> tuple[ContourEngagement, Array, Stock]:
    """Return what a blade does on a piece of its way: in, or along with its side.

    ``mirror_mm``: piece and stock are mirrored about this radius, in which a bore is an outside.
    """
    width = tool.width_mm or 0.0
    if not piece.square:
        deep = int(np.argmin(piece.x_mm))
        below = _under(tool, float(piece.z_mm[deep]), stock)
        row, after = engaged_beside(
            _seen_at_corner(piece, tool), stock, source=source, edge_mm=max(width, tool.edge_mm),
            mirror_mm=mirror_mm,
        )  # fmt: skip
        after = _lowered(after, below, float(piece.x_mm[deep]))
        return row, np.zeros(row.x_mm.size), after
    cells = _under(tool, float(piece.z_mm[0]), stock)
    inside = np.minimum(stock.low_mm[cells], stock.high_mm[cells])
    sizes = np.diff(stock.edges_mm)[cells]
    chip = (inside[None, :] > np.abs(piece.middle_x_mm)[:, None] + 1e-9) @ sizes
    inwards = piece.x_mm[-1] < piece.x_mm[0]
    chip = np.where(piece.middle_x_mm > 0, chip, 0.0)  # beyond the axis all has been cut
    chip = chip if inwards else np.zeros_like(chip)
    after = _lowered(stock, cells, max(float(piece.x_mm[-1]), 0.0)) if inwards else stock
    outer = np.abs(piece.middle_x_mm)
    return engagement_rows(piece, chip, outer, source, mirror_mm=mirror_mm), chip, after


def _under(tool: WorkTool, z_mm: float, stock: Stock) -> slice:
    """Return the cells of the stock that are under a blade, its programmed corner at z."""
    width = tool.width_mm or 0.0
    low, high = (z_mm - width, z_mm) if tool.towards_chuck else (z_mm, z_mm + width)
    first, last = np.searchsorted(stock.edges_mm, [low - 1e-9, high - 1e-9])
    return slice(int(first), int(last))


def _lowered(stock: Stock, cells: slice, x_mm: float) -> Stock:
    """Return a stock that a blade's front has cut down to a radius in some cells."""
    span = stock.edges_mm[[cells.start, min(cells.stop, stock.edges_mm.size - 1)]]
    return stock.turned(span, np.full(2, x_mm)) if span[1] > span[0] else stock


def _seen_at_corner(piece: Piece, tool: WorkTool) -> Piece:
    """Return a blade's way seen at the corner that cuts along it.

    Towards the chuck along the axis, or outwards with it, that is the corner there; inwards it is
    the other one, which makes the flank that it goes down. The other way round away from the chuck.
    """
    inwards = piece.x_mm[-1] < piece.x_mm[0] - TOUCH_MM
    at_chuck = piece.away == inwards
    if at_chuck != tool.towards_chuck:  # the programmed corner is that one
        return piece
    off_mm = (tool.width_mm or 0.0) * (-1.0 if at_chuck else 1.0)
    return replace(piece, z_mm=piece.z_mm + off_mm, middle_z_mm=piece.middle_z_mm + off_mm)


def _threading(moves: Iterator[Move], work: Work, run: _Run) -> Work:
    for move in moves:
        if isinstance(move, Rapid):
            continue
        for piece in pieces(move, step_mm=max(run.step_mm, 0.02 * move.length_mm)):
            x_mm = piece.middle_x_mm
            outer = work.outer.radius_mm(piece.middle_z_mm)
            bore = MIRROR_MM - work.bored.radius_mm(piece.middle_z_mm)
            inside = bool(np.median(bore) > 0 and np.median(x_mm - bore) < np.median(outer - x_mm))
            height = np.where(outer > 0, (x_mm - bore) if inside else (outer - x_mm), 0.0)
            height = np.maximum(height, 0.0)
            last = work.thread_mm
            again = last is not None and abs(last - float(x_mm[-1])) < 2.0
            reached = np.abs(x_mm - last) if again and last is not None else height
            depth = np.minimum(reached, height)
            largest = np.maximum(np.abs(x_mm), outer * (not inside))
            run.into.add(engagement_rows(piece, depth, largest, run.source), height)
            work = replace(work, thread_mm=float(x_mm[-1]))
    return work


def _thread_mm3(row: ContourEngagement, height: Array) -> float:
    """Return what a pass of a thread removes: A = d (2 h − d) tan 30° along the helix, mm³."""
    area = row.depth_mm * (2.0 * height - row.depth_mm) * np.tan(FLANK_RAD)
    turns = row.step_mm / row.feed_mm_rev
    return float(np.sum(area * 2.0 * np.pi * np.abs(row.x_mm) * turns))


def _drilling(moves: Iterator[Move], work: Work, run: _Run) -> Work:
    if run.tool.diameter_mm is None:
        raise UnusableInput(
            phrase(
                "{source}: line {line}: the drill's diameter is not known; state diameter_mm",
                source=run.source,
                line=next(moves).line,
            )
        )
    radius = 0.5 * run.tool.diameter_mm
    for move in moves:
        if isinstance(move, Rapid):
            continue
        if max(abs(move.start.x_mm), abs(move.end.x_mm)) > _OFF_AXIS_MM:
            raise UnusableInput(
                phrase(
                    "{source}: line {line}: a drill off the axis; state another kind of tool",
                    source=run.source,
                    line=move.line,
                )
            )
        for piece in pieces(move, step_mm=run.step_mm):
            bore = MIRROR_MM - work.bored.radius_mm(piece.middle_z_mm)
            there = work.outer.radius_mm(piece.middle_z_mm) > 0
            cuts = there & (bore < radius - TOUCH_MM) & (not piece.away)
            row = engagement_rows(
                piece, np.where(cuts, radius - bore, 0.0), np.full_like(bore, radius), run.source
            )
            run.into.add(replace(row, x_mm=np.full_like(bore, radius)))
            if not piece.away:
                down = piece.z_mm[::-1]
                bored = work.bored.turned(down, np.full_like(down, MIRROR_MM - radius))
                work = replace(work, bored=bored)
    return work


_MADE = {
    "outside": _outside, "boring": _boring, "grooving": _grooving, "threading": _threading,
    "drill": _drilling,
}  # fmt: skip
