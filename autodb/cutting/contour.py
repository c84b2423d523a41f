"""Engagement along a turned contour: how deep the tool is in the stock at every step of its path.

The path of the tool tip is the contour that it leaves: a sharp tip, or a nose whose control or CAM
system has put the contour into the program. Where neither has, a nose of radius r leaves
r (|sin θ| + |cos θ| − 1) more on a cone at the angle θ, nothing on cylinders and faces.

Depth is what the stock is thick on the tool's side, seen along the feed. With the unit feed (d_x,
d_z), the radius R(z) of the stock and z_f(x) its face:

    beside the path     depth = (R(z) − x) |d_z|
    in front of a face  depth = (z_f(x) − z) |d_x|

so X − x on a cylinder turned to x, (X − x) cos θ on a cone, z_f − z in facing, and ∫ depth 2π r ds
is the volume removed, r in the middle of that thickness. Faces are moves inwards, square to the
axis, and those steeper than 45°, away from the chuck, that begin outside the stock and reach to
the face by the end of the edge, which rises by 5° from the tip: others lead into a surface. Where
a tool goes inwards from a surface that it turns, that end lies above what is thinner before it. A
move inwards into the middle of a bar counts as facing too, of all that is in front of it, and a
bore as turning; ``edge_mm`` refuses both.

``lean`` is how far the edge leans back from its tip, tan(κ_r − 90°): of a shoulder's allowance a,
the run towards it then meets a / lean of its height at the most, as far as the edge reaches. At 0
the edge is square to the axis, and meets all of the shoulder at once. On a round
end under an even allowance a depth is less than the allowance the nearer its path is to square: on
a radius of 10 a, by 4 % at 45°, 11 % at 60°, 45 % at 80°. Turning from outside only.
Source: geometry, derived here.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.engaged_steps import ContourEngagement, EngagedSteps
from autodb.cutting.pieces import Piece, pieces, pieces_of
from autodb.cutting.stock import Stock
from autodb.errors import UnusableInput
from autodb.nc.reading import Arc, CuttingSpeed, Linear, Move, Rapid
from autodb.wording import localized, phrase

Array = NDArray[np.float64]

LONGEST_M = 500.0
"""How far moves may go, at feed and rapid. Chosen: a step of 0.05 mm on a cone takes 88 bytes."""
SQUARE_SHARE = 1e-9
"""A direction's cosine off 1 by less is along the axis: rounding."""
STEEPEST_DEG = 70.0
"""How steep a turning tool may go into the stock, towards the chuck. Chosen: above what copying
tools with inserts of 35° can do; what is steeper is a groove."""
ALIKE = 1e-9
"""Share by which steps that do the same may differ: rounding."""
END_SLOPE = float(np.tan(np.radians(5.0)))
"""How an edge's end rises from its tip along the work, away from the chuck. Chosen: rhombic inserts
of 80° in holders of 95°; others rise more."""
TOUCH_MM = 0.001
"""What counts as touching, not as inside: the last decimal of programs."""


def engagement(
    moves: Sequence[Move],
    stock: Stock,
    *,
    source: str,
    step_mm: float = 0.05,
    edge_mm: float = np.inf,
    lean: float = 0.0,
) -> tuple[ContourEngagement, Stock]:
    """Return the engagement along moves, steps of at most ``step_mm``, and the stock they leave.

    Every move meets what those before it have left. Raises UnusableInput naming ``source`` and the
    line of a rapid through the stock, of a depth above ``edge_mm``, the length of the edge, of a
    plunge that a radius over z cannot hold, of G96 without a limit that reaches the axis, and where
    nothing moves at a feed, or moves go farther than ``LONGEST_M``.
    """
    if not any(isinstance(move, Linear | Arc) for move in moves):
        raise UnusableInput(
            phrase("{source}: no move at a feed; use a program with G1, G2 or G3", source=source)
        )
    ends_mm = piece_ends_mm(moves, source=source, step_mm=step_mm)
    stock = stock.divided(ends_mm, cell_mm=step_mm)
    steps = EngagedSteps()
    after = engaged_moves(
        moves, stock, steps, source=source, step_mm=step_mm, edge_mm=edge_mm, lean=lean
    )
    return steps.since()[0], after


def piece_ends_mm(moves: Iterable[Move], *, source: str, step_mm: float) -> Array:
    """Return where the pieces of moves begin and end along the axis, (n,), mm.

    Raises UnusableInput naming ``source`` where moves go farther than ``LONGEST_M``.
    """
    return np.fromiter(_ends_mm(moves, source, step_mm), np.float64)


def _ends_mm(moves: Iterable[Move], source: str, step_mm: float) -> Iterator[float]:
    way_m = 0.0
    for move in moves:
        way_m += 0.001 * move.length_mm
        if way_m > LONGEST_M:
            raise _farther(move, way_m, source)
        yield move.start.z_mm
        yield move.end.z_mm
        if isinstance(move, Arc):
            yield from (float(piece.z_mm[-1]) for piece in pieces(move, step_mm=step_mm))


def engaged_moves(
    moves: Iterable[Move],
    stock: Stock,
    into: EngagedSteps,
    *,
    source: str,
    step_mm: float,
    edge_mm: float = np.inf,
    lean: float = 0.0,
    mirror_mm: float | None = None,
    alike_joined: bool = False,
) -> Stock:
    """Put the engagement along moves that feed ``into`` steps; return the stock they leave.

    The stock is divided at the pieces' ends already. ``mirror_mm``: moves and stock are mirrored
    about this radius, and the rows are not. ``alike_joined``: steps that follow each other and do
    the same are one, which is as long as all of them. Raises as `engagement`.
    """
    before: Piece | None = None
    last_piece: Piece | None = None
    begun, rise = _Begun(stock, 0.0), 0.0
    for piece in pieces_of(moves, step_mm=step_mm):
        if isinstance(piece.move, Rapid):
            _refuse_inside(piece, stock, source, mirror_mm)
            before = last_piece = None
            continue
        if last_piece is None or not last_piece.goes_on_as(piece):
            begun = _Begun(stock, float(piece.z_mm[0]))
        last_piece = piece
        if before is None or not before.steep_inwards:  # else it faces on, as it began to
            rise = 0.0 if before is None else END_SLOPE
        depth_mm, outer_mm, stock = _met(piece, stock, begun, source, lean, rise=rise)
        if np.any(depth_mm > TOUCH_MM):
            _refuse_inwards(piece, before, source)
        last = piece.from_mm == piece.from_mm[-1]
        before = piece if np.any(depth_mm[last] > TOUCH_MM) else None
        _refuse_deeper(piece, depth_mm, edge_mm, source)
        row = engagement_rows(piece, depth_mm, outer_mm, source, mirror_mm=mirror_mm)
        into.add(_with_alike_joined(row) if alike_joined else row)
    return stock


def _with_alike_joined(row: ContourEngagement) -> ContourEngagement:
    """Return a piece's rows, those that follow each other and do the same as one."""
    does = (row.depth_mm, row.outer_mm, row.x_mm, row.feed_mm_rev, row.speed_rpm)
    differs = np.diff(row.line) != 0
    for one in does:
        differs |= np.abs(np.diff(one)) > ALIKE * np.abs(one[1:])
    begins = np.concatenate([[0], 1 + np.flatnonzero(differs)])
    if len(begins) == row.x_mm.size:
        return row
    step_mm = np.add.reduceat(row.step_mm, begins)
    z_mm = np.add.reduceat(row.z_mm * row.step_mm, begins) / step_mm
    firsts = {field.name: getattr(row, field.name)[begins] for field in fields(row)}
    return ContourEngagement(**{**firsts, "z_mm": z_mm, "step_mm": step_mm})


def engaged_beside(
    piece: Piece, stock: Stock, *, source: str, edge_mm: float, mirror_mm: float | None = None
) -> tuple[ContourEngagement, Stock]:
    """Return the engagement of a piece that cuts with its corner alone, however steep it goes."""
    begun = _Begun(stock, float(piece.z_mm[0]))
    depth_mm, outer_mm, after = _beside(piece, stock, begun, 0.0)
    _refuse_deeper(piece, depth_mm, edge_mm, source)
    return engagement_rows(piece, depth_mm, outer_mm, source, mirror_mm=mirror_mm), after


def _farther(move: Move, way_m: float, source: str) -> UnusableInput:
    return UnusableInput(
        phrase(
            "{source}: line {line}: the path is {way_m} m long from the first move on; use "
            "a program of at most {longest_m} m",
            source=source,
            line=move.line,
            way_m=localized(f"{way_m:.0f}"),
            longest_m=localized(f"{LONGEST_M:.0f}"),
        )
    )


@dataclass(frozen=True)
class _Begun:
    """Where along the axis a pass began, however many moves it has, and the stock it met."""

    stock: Stock
    from_mm: float


def _met(
    piece: Piece, stock: Stock, begun: _Begun, source: str, lean: float, *, rise: float
) -> tuple[Array, Array, Stock]:
    """Return depth and outer radius at every step of a piece, (n,), mm, and the stock after it.

    ``rise``: of the edge's end, where it goes inwards from a surface that it turns; else 0.
    """
    plunges = piece.steep_inwards and _begins_outside(piece, stock)
    if piece.steep_inwards and (piece.square or (plunges and piece.away and _faces(piece, stock))):
        return _facing(piece, stock, rise=rise)
    depth_mm, outer_mm, after = _beside(piece, stock, begun, lean)
    if (
        plunges
        and not piece.away
        and piece.steeper_than(STEEPEST_DEG)
        and np.any(depth_mm > TOUCH_MM)
    ):
        raise UnusableInput(
            phrase(
                "{source}: line {line}: this move enters the stock inwards and towards the "
                "chuck, steeper than {steepest_deg}°; move square to the axis or flatter",
                source=source,
                line=piece.move.line,
                steepest_deg=localized(f"{STEEPEST_DEG:g}"),
            )
        )
    return depth_mm, outer_mm, after


def _faces(piece: Piece, stock: Stock) -> bool:
    """Return whether the end of an edge that goes in by a piece reaches to the face before it.

    Where it does not, the piece leads into the surface that is turned from there on.
    """
    ahead_mm = np.array([piece.z_mm[-1] + TOUCH_MM])
    in_mm = float(stock.radius_mm(ahead_mm)[0] - piece.x_mm[-1])
    face_mm = stock.face_mm(piece.z_mm[0], np.maximum(piece.x_mm[-1:], 0.0))[0]
    return bool((face_mm - piece.z_mm[-1]) * END_SLOPE <= max(in_mm, 0.0))


def _begins_outside(piece: Piece, stock: Stock) -> bool:
    ahead_mm = piece.z_mm[0] + (TOUCH_MM if piece.away else -TOUCH_MM)
    return bool(stock.radius_mm(np.array([ahead_mm]))[0] <= piece.x_mm[0] + TOUCH_MM)


def _beside(piece: Piece, stock: Stock, begun: _Begun, lean: float) -> tuple[Array, Array, Stock]:
    """Return depth and outer radius at every step of a piece, (n,), mm, and the stock after it.

    An edge that leans back is still in what the pass has come along since it began, and not in what
    was cut before.
    """
    x_mm = np.maximum(piece.middle_x_mm, 0.0)  # past the axis the edge cuts down to it
    leans = 0.0 if piece.away else lean
    rising = slice(None) if piece.away else slice(None, None, -1)
    after = stock.turned(piece.z_mm[rising], np.maximum(piece.x_mm[rising], 0.0))
    from_mm = np.full(x_mm.size, begun.from_mm)
    edge_mm = begun.stock.edge_mm(piece.middle_z_mm, x_mm, lean=leans, after=after, from_mm=from_mm)
    thick_mm = edge_mm - x_mm
    depth_mm = thick_mm * np.abs(piece.along_z)
    return depth_mm, x_mm + np.where(depth_mm > 0, thick_mm, 0.0), after


def _facing(piece: Piece, stock: Stock, *, rise: float) -> tuple[Array, Array, Stock]:
    """Return depth and outer radius at every step of a piece, and the stock after it.

    ``rise``: of the edge's end from its tip, which is above what is thinner farther away.
    """
    x_mm = piece.middle_x_mm
    face_mm = stock.face_mm(piece.z_mm[0], np.maximum(x_mm, 0.0), rise=rise)
    thick_mm = np.where(x_mm > 0, np.maximum(face_mm - piece.middle_z_mm, 0.0), 0.0)
    after = stock if piece.square else stock.turned(piece.z_mm, piece.x_mm)
    return (
        thick_mm * np.abs(piece.along_x),
        np.abs(x_mm),
        after.grazed(piece.z_mm[-1], piece.x_mm[-1], rise=rise)
        if rise
        else after.faced(piece.z_mm[-1], piece.x_mm[-1]),
    )


def _refuse_inside(piece: Piece, stock: Stock, source: str, mirror_mm: float | None) -> None:
    x_mm, z_mm = piece.middle_x_mm, piece.middle_z_mm
    inside = np.flatnonzero(np.abs(x_mm) < stock.radius_mm(z_mm) - TOUCH_MM)
    if inside.size:
        at = inside[0]
        at_mm = x_mm[at] if mirror_mm is None else mirror_mm - x_mm[at]
        raise UnusableInput(
            phrase(
                "{source}: line {line}: this rapid goes through the stock, at radius {at} and "
                "z {z} mm; go around it or use a feed",
                source=source,
                line=piece.move.line,
                at=localized(f"{at_mm:.3f}"),
                z=localized(f"{z_mm[at]:.3f}"),
            )
        )


def _refuse_inwards(piece: Piece, before: Piece | None, source: str) -> None:
    """Raise UnusableInput for a cut inwards from a surface that this tool has just turned.

    All that it has turned would lie in its way: so a bar does that bores, or a blade.
    """
    turned = before is not None and before.along_z[-1] < -1.0 + SQUARE_SHARE
    if turned and piece.square and piece.steep_inwards:
        raise UnusableInput(
            phrase(
                "{source}: line {line}: this cuts inwards from the surface that was just "
                "turned, as in a bore or a groove; state the kind of this tool",
                source=source,
                line=piece.move.line,
            )
        )


def _refuse_deeper(piece: Piece, depth_mm: Array, edge_mm: float, source: str) -> None:
    deeper = np.flatnonzero(depth_mm > edge_mm)
    if deeper.size:
        line = int(piece.line[deeper[0]])
        raise UnusableInput(
            phrase(
                "{source}: line {line}: {max} mm deep, more than the edge's {edge} mm (a "
                "groove, a bore, or other stock than this?); state the kind of this tool, or "
                "cut shallower",
                source=source,
                line=line,
                max=localized(f"{depth_mm[piece.line == line].max():.3f}"),
                edge=localized(f"{edge_mm:g}"),
            )
        )


def engagement_rows(
    piece: Piece,
    depth_mm: Array,
    outer_mm: Array,
    source: str,
    *,
    mirror_mm: float | None = None,
) -> ContourEngagement:
    """Return the rows of a piece.

    Raises UnusableInput where G96 has no limit and reaches the axis.
    """
    move = piece.move
    ends_mm, x_mm, along_x = piece.x_mm, piece.middle_x_mm, piece.along_x
    if mirror_mm is not None:
        ends_mm, x_mm, along_x = mirror_mm - ends_mm, mirror_mm - x_mm, -along_x
        outer_mm = x_mm
    assert not isinstance(move, Rapid)
    speed = move.speed
    endless = isinstance(speed, CuttingSpeed) and speed.limit_rpm is None
    reaching = np.flatnonzero(ends_mm <= 0)
    if endless and reaching.size:
        raise UnusableInput(
            phrase(
                "{source}: line {line}: G96 reaches the axis without a speed limit; state "
                "max_speed_rpm in the machine's [spindle], or G50 S, G92 S or LIMS before it",
                source=source,
                line=int(piece.line[max(reaching[0] - 1, 0)]),
            )
        )
    rpm = speed.at_rpm(x_mm)
    return ContourEngagement(
        step_mm=piece.step_mm,
        x_mm=x_mm,
        z_mm=piece.middle_z_mm,
        along_x=along_x,
        along_z=piece.along_z,
        depth_mm=depth_mm,
        outer_mm=outer_mm,
        feed_mm_rev=move.feed.mm_rev(rpm),
        speed_rpm=rpm,
        line=piece.line,
    )
