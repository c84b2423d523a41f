"""The path of a mill's centre beside a compensated contour (G41, G42).

Between G41 or G42 and G40 a program states the contour; the centre goes beside it, a radius to the
left or the right. It comes to the contour's first line square to its begin, and leaves square to
its end. In an inner corner it turns where both offset lines meet. Around an outer one it goes by an
arc about the corner, or on Fanuc's controls straight on along both tangents until they meet, above
90° a radius far along each. Places are complex numbers, x + i y. Source: geometry, derived here;
corners as the operator's manuals of these controls describe them.
"""

from cmath import phase
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import sqrt, tau

from autodb.errors import UnusableInput
from autodb.nc.reading.travels import Circle, PackedMoves, ProgramMove, ToolPlace

RadiusOf = Callable[[ProgramMove], float]
"""What gives the distance of a move's centre from the contour where the program does not, mm."""
_SAME_MM = 1e-6
_STRAIGHT = 1e-9
_BACK_RAD = 0.05
_BACK_MM = 1e-3
"""How far rounding of a program may let an offset line run back. Chosen: its last decimal."""


@dataclass(frozen=True)
class _Way:
    """A compensated move seen in the plane: ends of the contour, and its arc's centre or None."""

    move: ProgramMove
    begin: complex
    end: complex
    off: complex
    """The offset, mm: i r for a mill to the left, -i r to the right; turns a tangent outwards."""

    @property
    def centre(self) -> complex | None:
        """The middle of an arc, None of a straight move."""
        circle = self.move.circle
        return None if circle is None else complex(*circle.centre)

    def tangent(self, at: complex) -> complex:
        """Return the direction of the way at a place of it."""
        centre, circle = self.centre, self.move.circle
        if centre is None or circle is None:
            return (self.end - self.begin) / abs(self.end - self.begin)
        return (at - centre) / abs(at - centre) * (1j if circle.left else -1j)

    def beside(self, at: complex) -> complex:
        """Return the centre's place beside a place of the contour."""
        return at + self.off * self.tangent(at)

    def offset_radius(self) -> float:
        """Return the radius of the arc beside an arc; at most 0 where the mill does not fit."""
        assert self.centre is not None
        along = self.tangent(self.begin)
        outwards = (self.begin - self.centre) / abs(self.begin - self.centre)
        return abs(self.begin - self.centre) + (self.off * along * outwards.conjugate()).real

    @property
    def in_a_point(self) -> bool:
        """Whether this is an arc whose radius is that of the mill: its centre stays in a point."""
        return self.centre is not None and abs(self.offset_radius()) <= _SAME_MM

    def runs_on(self, begin: complex, end: complex) -> bool:
        """Return whether the offset way from place to place goes the way of the contour."""
        centre, circle = self.centre, self.move.circle
        if centre is None or circle is None:
            return ((end - begin) * self.tangent(begin).conjugate()).real > -_BACK_MM
        if self.offset_radius() <= _SAME_MM:
            return self.in_a_point
        sign = 1.0 if circle.left else -1.0
        contour, offset = (
            phase((last - centre) / (first - centre)) * sign % tau
            for first, last in ((self.begin, self.end), (begin, end))
        )
        return abs(self.end - self.begin) < _SAME_MM or offset < contour + _BACK_RAD


def beside_contours(
    moves: PackedMoves, radius_of: RadiusOf, *, round_corners: bool, source: str
) -> tuple[PackedMoves, list[UnusableInput]]:
    """Return moves of the centre, and what does not fit: a line for each.

    ``round_corners``: whether outer corners are gone around by an arc.
    """
    if not moves.compensated:
        return moves, []
    out = PackedMoves()
    problems: list[UnusableInput] = []
    away: complex | None = None
    k = 0
    while k < len(moves):
        move = moves[k]
        if k and move.start != moves[k - 1].end:
            away = None
        if move.beside is None:
            if away is not None and move.circle is not None:
                problems.append(_no_line(move, source, "G40"))
            moved, away = _uncompensated(move, away)
            out.append(moved)
            k += 1
            continue
        last = k + 1
        while last < len(moves) and _goes_on(moves[last - 1], moves[last]):
            last += 1
        try:
            radius = radius_of(move) if move.beside[1] is None else move.beside[1]
            if radius <= _SAME_MM:  # the program is the centre's path
                out.extend(replace(one, beside=None) for one in moves[k:last])
                away, k = None, last
                continue
            run = _Run(moves[k:last], radius, round_corners=round_corners, source=source)
            found, away = run.moved(away)
            out.extend(found)
        except UnusableInput as error:
            problems.append(error)
        k = last
    return out, problems


def _goes_on(before: ProgramMove, move: ProgramMove) -> bool:
    same = (before.beside, before.tool, before.end) == (move.beside, move.tool, move.start)
    return same and move.beside is not None


def _uncompensated(move: ProgramMove, away: complex | None) -> tuple[ProgramMove, complex | None]:
    """Return a move behind G40: it begins where the centre still is beside the contour."""
    if away is None:
        return move, None
    if abs(_flat(move.end) - _flat(move.start)) < _SAME_MM and move.circle is None:
        return _placed(move, away, away), away
    return _placed(move, away, _flat(move.end)), None


def _flat(place: ToolPlace) -> complex:
    return complex(place.x_mm, place.y_mm)


def _placed(move: ProgramMove, begin: complex, end: complex) -> ProgramMove:
    start = ToolPlace(begin.real, begin.imag, move.start.z_mm)
    return replace(move, start=start, end=ToolPlace(end.real, end.imag, move.end.z_mm), beside=None)


def _no_line(move: ProgramMove, source: str, word: str) -> UnusableInput:
    return UnusableInput(
        f"{source}: line {move.line}: '{word}': compensation begins or ends in an arc; use a "
        "straight move"
    )


class _Run:
    """Moves from G41 or G42 on that one tool makes, and the path of its centre."""

    def __init__(
        self, moves: Sequence[ProgramMove], radius: float, *, round_corners: bool, source: str
    ) -> None:
        self.moves = moves
        self.radius = radius
        self.round_corners = round_corners
        self.source = source
        assert moves[0].beside is not None
        off = radius * (1j if moves[0].beside[0] == "left" else -1j)
        flat = [(one, _flat(one.start), _flat(one.end)) for one in moves]
        self.ways = [
            _Way(one, begin, end, off)
            for one, begin, end in flat
            if one.circle is not None or abs(end - begin) > _SAME_MM
        ]

    def moved(self, away: complex | None) -> tuple[list[ProgramMove], complex | None]:
        """Return the moves of the centre from where it is, and where it is then."""
        if self.ways and self.ways[0].centre is not None:
            raise _no_line(self.ways[0].move, self.source, "G41")
        at = _flat(self.moves[0].start) if away is None else away
        ends, joins = self._corners()
        found: list[ProgramMove] = []
        count = 0
        for move in self.moves:
            if count == len(self.ways) or move is not self.ways[count].move:
                found.append(_placed(move, at, at))
                continue
            way, to = self.ways[count], ends[count]
            if count and not way.runs_on(at, to):
                raise self._refusal(move)
            found.append(_placed(replace(move, circle=None) if way.in_a_point else move, at, to))
            at = to
            for piece in joins[count]:
                z_mm = move.end.z_mm
                start = ToolPlace(at.real, at.imag, z_mm)
                end = ToolPlace(piece[0].real, piece[0].imag, z_mm)
                found.append(replace(move, start=start, end=end, circle=piece[1], beside=None))
                at = piece[0]
            count += 1
        return found, at if self.ways else None

    def _corners(self) -> tuple[list[complex], list[list[tuple[complex, Circle | None]]]]:
        """Return where the centre is at the end of each way, and what follows around a corner."""
        ends: list[complex] = []
        joins: list[list[tuple[complex, Circle | None]]] = []
        for k, way in enumerate(self.ways):
            following = self.ways[k + 1] if k + 1 < len(self.ways) else None
            join: list[tuple[complex, Circle | None]] = []
            if following is None:
                end = way.beside(way.end)
            elif k == 0:
                end = following.beside(following.begin)
            else:
                end, join = self._corner(way, following)
            ends.append(end)
            joins.append(join)
        return ends, joins

    def _corner(
        self, way: _Way, following: _Way
    ) -> tuple[complex, list[tuple[complex, Circle | None]]]:
        """Return where a way's offset ends, and the pieces from there to where the next begins."""
        before, after = way.tangent(way.end), following.tangent(following.begin)
        turned = before.conjugate() * after
        to_tool = turned.imag * (1.0 if way.off.imag > 0 else -1.0)
        end, begin = way.beside(way.end), following.beside(following.begin)
        if abs(turned.imag) < 1e-4 and turned.real > 0:
            return end, [] if abs(end - begin) < _BACK_MM else [(begin, None)]
        if to_tool > 0:
            places = list(_meetings(way, following))
            if not places:
                raise self._refusal(following.move)
            return min(places, key=lambda one: abs(one - way.end)), []
        if self.round_corners:
            left = self.ways[0].off.imag < 0
            return end, [(begin, Circle("G17", (way.end.real, way.end.imag), left))]
        if turned.real > -_STRAIGHT:
            reach = self.radius * (1.0 - turned.real) / max(abs(turned.imag), _STRAIGHT)
            return end, [(end + reach * before, None), (begin, None)]
        out, back = end + self.radius * before, begin - self.radius * after
        return end, [(out, None), (back, None), (begin, None)]

    def _refusal(self, move: ProgramMove) -> UnusableInput:
        side = "G41" if self.moves[0].beside == ("left", None) else "G41 or G42"
        return UnusableInput(
            f"{self.source}: line {move.line}: '{side}': a mill {self.radius:g} mm beside this "
            "contour does not fit into it; state another diameter_mm, or offset_mm = 0 where the "
            "program is the path of the mill's centre"
        )


def _meetings(one: _Way, other: _Way) -> Iterator[complex]:
    """Yield where the offsets of two ways meet."""
    first, second = one.beside(one.end), other.beside(other.begin)
    if one.centre is None and other.centre is None:
        a, b = one.tangent(one.end), other.tangent(other.begin)
        cross = (a.conjugate() * b).imag
        if abs(cross) > _STRAIGHT:
            yield first + a * ((second - first).conjugate() * b).imag / cross
    elif one.centre is None or other.centre is None:
        line, arc = (one, other) if one.centre is None else (other, one)
        at, along = (first, one.tangent(one.end)) if line is one else (
            second, other.tangent(other.begin),
        )  # fmt: skip
        assert arc.centre is not None
        yield from _line_and_circle(at, along, arc.centre, arc.offset_radius())
    else:
        assert one.centre is not None and other.centre is not None
        yield from _circles(one.centre, one.offset_radius(), other.centre, other.offset_radius())


def _line_and_circle(
    at: complex, along: complex, centre: complex, radius: float
) -> Iterator[complex]:
    to = (centre - at) * along.conjugate()
    half = radius**2 - to.imag**2
    if half >= 0:
        yield from (at + along * (to.real + sign * sqrt(half)) for sign in (1.0, -1.0))


def _circles(c: complex, r: float, d: complex, s: float) -> Iterator[complex]:
    apart = abs(d - c)
    if apart < _SAME_MM:
        return
    way = (r**2 - s**2 + apart**2) / (2.0 * apart)
    half = r**2 - way**2
    if half >= 0:
        unit = (d - c) / apart
        yield from (c + unit * (way + sign * 1j * sqrt(half)) for sign in (1.0, -1.0))
