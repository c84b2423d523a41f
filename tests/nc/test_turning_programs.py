"""Turning programs read: known points, one contour said in many ways, and what is refused."""

import itertools
from collections.abc import Sequence
from math import hypot, isclose, pi
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.errors import UnusableInput
from autodb.nc import DIALECTS, turning
from autodb.nc.reading import (
    Arc,
    CuttingSpeed,
    FeedPerMinute,
    Linear,
    Move,
    PerRev,
    Point,
    Rapid,
    Revolutions,
    read_program,
    turning_program,
)
from autodb.standard import run_order
from tests.helpers.nc_cases import CLEAR_MM, Case, bar_case, case_of, changed
from tests.helpers.remedies import has_remedy

HEAD = "G21 G18 G40 G99\nG97 S1000 M4\n"
CONTOUR = f"""%
O0101 (A STEPPED PIN; WITH ARCS)
{HEAD}T0303
N10 G0 X24. Z2. ; in front
N20 G1 X20 Z0 F.2
N30 G3 X30 Z-5 R5
N40 G1 Z-20
N50 G1 X36 Z-26
N60 G2 X46. Z-31 R5.
/N70 G1 X60
M5
M30
%
"""
POINTS = [(10, 0), (15, -5), (15, -20), (18, -26), (23, -31), (30, -31)]


def _moves(text: str, *, diameter: bool = True, block_skip: bool = False) -> tuple[Move, ...]:
    found = turning_program(text, source="p.nc", diameter=diameter, block_skip=block_skip)
    return tuple(found.moves)


def _cuts(text: str, *, diameter: bool = True) -> list[Linear | Arc]:
    return [m for m in _moves(text, diameter=diameter) if isinstance(m, Linear | Arc)]


def _assert_same(ours: list[Linear | Arc], theirs: list[Linear | Arc], atol: float) -> None:
    """Assert equal kinds, ends, centres, feeds and speeds, mm."""
    assert [type(move) for move in ours] == [type(move) for move in theirs]
    for mine, other in zip(ours, theirs, strict=True):
        assert_allclose([mine.start, mine.end], [other.start, other.end], atol=atol)
        assert_allclose(mine.feed.mm, other.feed.mm, rtol=1e-12)
        assert mine.speed == other.speed
        if isinstance(mine, Arc) and isinstance(other, Arc):
            assert mine.left == other.left
            assert_allclose(mine.centre, other.centre, atol=atol)


def test_a_contour_of_lines_cones_and_arcs_has_the_known_points() -> None:
    moves = _moves(CONTOUR)
    assert [type(move) for move in moves] == [Linear, Arc, Linear, Linear, Arc, Linear]
    assert_allclose([move.end for move in moves], POINTS, atol=1e-9)
    assert all(isinstance(move, Linear | Arc) and move.feed == PerRev(0.2) for move in moves)
    assert [move.line for move in moves] == [7, 8, 9, 10, 11, 12]
    assert {move.tool for move in moves} == {"0303"}
    outer, inner = moves[1], moves[4]
    assert isinstance(outer, Arc)
    assert isinstance(inner, Arc)
    assert_allclose(outer.centre, (10, -5), atol=1e-9)
    assert_allclose(inner.centre, (23, -26), atol=1e-9)
    lengths = [hypot(2, 2), 2.5 * pi, 15, hypot(3, 6), 2.5 * pi, 7]
    assert_allclose([move.length_mm for move in moves], lengths, atol=1e-9)


def test_every_point_of_an_arc_lies_on_its_circle() -> None:
    """In the middle of a quarter: 45° on, on the outer side of G3, the inner one of G2."""
    shares = np.linspace(0.0, 1.0, 21)
    for arc in (m for m in _moves(CONTOUR) if isinstance(m, Arc)):
        x, z = arc.points(shares)
        assert_allclose(np.hypot(x - arc.centre.x_mm, z - arc.centre.z_mm), 5.0, atol=1e-9)
        side = 1 if arc.left else -1
        off = 5 * np.sqrt(0.5)
        middle = (arc.centre.x_mm + side * off, arc.centre.z_mm + side * off)
        assert_allclose((x[10], z[10]), middle, atol=1e-9)


def test_block_skip_leaves_out_what_begins_with_a_slash() -> None:
    assert len(_moves(CONTOUR)) == len(_moves(CONTOUR, block_skip=True)) + 1


def test_the_end_of_an_arc_above_180_degrees_needs_a_negative_radius() -> None:
    ball = HEAD + "G0 X0 Z0\nG1 X0 Z0 F.1\nG3 X12 Z-18 R{}\n"
    short, long = _cuts(ball.format("10"))[-1], _cuts(ball.format("-10"))[-1]
    half = np.arcsin(hypot(6, 18) / 20)
    assert_allclose([short.length_mm, long.length_mm], [20 * half, 20 * (pi - half)], atol=1e-9)


def test_an_arc_rounded_by_less_than_a_hundredth_still_meets_its_ends() -> None:
    """R 5 µm below half the chord; an end 6 µm off the circle of I and K."""
    for body, radius in (("G3 X20 Z-10 R4.995", 5.0), ("G3 X30.012 Z-5 K-5", 5.003)):
        arc = _cuts(f"{HEAD}G0 X20 Z0\n{body} F.1\n")[0]
        ends = arc.points(np.array([0.0, 1.0]))
        assert_allclose(np.transpose(ends), [arc.start, arc.end], atol=1e-9)
        assert_allclose(arc.length_mm, radius * np.pi / (1 if "R" in body else 2), rtol=1e-3)


SAID = {
    "increments U W": "G0 X24 Z2\nG1 U-4 W-2 F.2\nG3 U10 W-5 R5\nG1 W-15\nU6 W-6\nG2 U10 W-5 R5\n"
    "G1 U14\n",
    "I and K": "G0 X24 Z2\nG1 X20 Z0 F.2\nG3 X30 Z-5 K-5\nG1 Z-20\nX36 Z-26\nG2 X46 Z-31 I5 K0\n"
    "G1 X60\n",
    "words in any order, small letters, no blanks": "g00z2x24\nf0.2x20.g1z+0\nr5z-5g03x30(arc)"
    "\nz-20g01\nz-26.0x36\ng2r5z-31x46\ng1x60\n",
}


@pytest.mark.parametrize("body", SAID.values(), ids=SAID)
def test_one_contour_said_otherwise_is_the_same(body: str) -> None:
    _assert_same(_cuts(HEAD + body), _cuts(CONTOUR), 1e-9)


def test_increments_inches_and_radii_are_the_same() -> None:
    system_b = "G95\nG97 S1000 M3\n"
    ends = [(12, 2), *POINTS]
    steps = [(x1 - x0, z1 - z0) for (x0, z0), (x1, z1) in itertools.pairwise(ends)]
    arcs = {1: "G3 {} R{}", 4: "G2 {} R{}"}

    def program(places: Sequence[tuple[float, float]], unit: float, x_factor: float) -> str:
        lines = []
        for i, (x, z) in enumerate(places):
            to = f"X{x_factor * x / unit:.10f} Z{z / unit:.10f}"
            lines.append(arcs.get(i, "G1 {}").format(to, f"{5 / unit:.10f}"))
        return "\n".join(lines) + "\n"

    absolute = f"G0 X24 Z2 F0.2\n{program(ends[1:], 1, 2)}"
    stepped = f"G90 G0 X24 Z2 F0.2\nG91\n{program(steps, 1, 2)}"
    inches = f"G20 G0 X{24 / 25.4:.10f} Z{2 / 25.4:.10f} F{0.2 / 25.4:.14f}\n" + program(
        ends[1:], 25.4, 2
    )
    known = _cuts(CONTOUR)
    _assert_same(_cuts(system_b + absolute), known, 1e-9)
    _assert_same(_cuts(system_b + stepped), known, 1e-9)
    _assert_same(_cuts(system_b + inches), known, 1e-8)  # ten decimals of an inch
    radii = f"G0 X12 Z2 F0.2\n{program(ends[1:], 1, 1)}"
    _assert_same(_cuts(system_b + radii, diameter=False), known, 1e-9)
    _assert_same(_cuts(f"DIAMOF\n{system_b}{radii}"), known, 1e-9)
    _assert_same(_cuts(f"DIAMON\n{system_b}{absolute}", diameter=False), known, 1e-9)


def test_feeds_and_speeds_are_kept_as_they_were_said() -> None:
    text = (
        "G98 G97 S800 M3\nG0 X40 Z2\nG1 Z-5 F120\nG50 S3000\nG99 G96 S180\nG1 Z-9 F.25\n"
        "G20\nG96 S600\nG1 Z-.6 F.01\nG21 G97 S450\nG1 Z-20 F.3\n"
    )
    feeds = [(move.feed, move.speed) for move in _cuts(text)]
    assert feeds[0] == (FeedPerMinute(120), Revolutions(800))
    assert feeds[1] == (PerRev(0.25), CuttingSpeed(180, 3000))
    assert isclose(feeds[2][0].mm, 0.254)
    assert isinstance(feeds[2][1], CuttingSpeed)
    assert isclose(feeds[2][1].m_min, 182.88)  # 600 ft/min
    assert feeds[3] == (PerRev(0.3), Revolutions(450))
    at_rpm = feeds[1][1].at_rpm(np.array([20.0, 1.0]))
    assert_allclose(at_rpm, [180_000 / (40 * pi), 3000])


def test_a_rest_and_machine_coordinates_move_nothing_that_is_read() -> None:
    text = (
        f"{HEAD}G28 U0 W0\nT0101\nG0 Z2\nG0 X40\nG4 U1.5\nG4 P500\nG1 Z-5 F.2\nG0 X44\n"
        "G0 G53 X300\nG0 X50 Z2\nG0 Z1\n"
    )
    assert [type(move) for move in _moves(text)] == [Linear, Rapid, Rapid]
    assert _moves(text)[-1] == Rapid(Point(25, 2), Point(25, 1), 13, "0101")


def test_a_program_stops_where_the_operator_is_asked() -> None:
    text = f"{HEAD}G0 X40 Z2\nG1 Z-5 F.2\nM5\nM0\nM3\nG1 Z-6\nM1\n"
    assert turning_program(text, source="p.nc").stops == (6,)


REFUSED = {
    "no start": ("start", "G0 X20\nG3 X30 Z-5 R5 F.1", "'G3': the start is not known in Z"),
    "short radius": (
        "at", "G3 X30 Z-15 R5 F.1", "'R5': the radius is shorter than half the distance from",
    ),
    "off its circle": ("at", "G3 X30.6 Z-5 K-5 F.1", "'K-5': the arc's end is 0.300 mm off"),
    "two circles": ("at", "G2 X30 Z-5 R5 I5 F.1", "'I5': state an arc with either R, or I and"),
    "centre on start": ("at", "G2 X30 Z-5 I0 F.1", "'I0': the arc's centre is its start"),
    "closed arc": ("at", "G2 X20 Z0 R5 F.1", "'R5': the arc ends where it begins"),
    "no feed": ("at", "G1 Z-5", "'G1': no feed before this cutting move"),
    "feed 0": ("at", "F0\nG1 Z-5", "'G1': no feed before this cutting move"),
    "feed below 0": ("at", "G1 Z-5 F-1", "'F-1': use a number above"),
    "other feed": ("at", "F.1\nG98\nG1 Z-5", "'G1': no feed before this cutting move"),
    "no speed": ("start", "G0 X20 Z0\nG96\nG1 Z-5 F.1", "'G1': no spindle speed"),
    "stopped": ("at", "M5\nG1 Z-5 F.1", "'G1': the spindle stopped with M5 in line 4"),
    "no number": ("at", "G1 X Z-5 F.1", "'X': a word without a number"),
    "no sign": ("at", "G1 X--5", "'X--5': not a letter and a number"),
    "two points": ("at", "G1 X1.2.3", "'X1.2.3': not a letter and a number"),
    "function": ("at", "G1 X[BIN[#1]]", "'X[BIN[#1]]': 'BIN[#1]]' is no value"),
    "root": ("at", "G1 X[SQRT[0-4]]", "'[SQRT[0-4]]': the root of -4"),
    "division": ("at", "G1 X[1/0]", "'[1/0]': a division by 0"),
    "jump": ("at", "GOTO 7", "'N7': there is no block of this label"),
    "loop": ("at", "END1", "'END1': no DO of this number is open"),
    "bracket": ("at", "G1 Z-5 (open", "'(OPEN': a bracket does not close or opens twice"),
    "two motions": ("at", "G0 G1 Z-5 F.1", "'G1': 'G0' stands in this block too"),
    "two X": ("at", "G1 X5 X6 F.1", "'X6': this is a second X in the block"),
    "X and U": ("at", "G1 X5 U6 F.1", "'U6': 'X5' moves this axis too"),
    "unknown G": ("at", "G777 X5", "'G777': this G is not read"),
    "thread": ("at", "G76 X20 Z-9 P900 F1.5", "'G76': height and first depth are missing"),
    "cycle or inches": ("at", "G71", "'G71': this means inches or mm on some controls and a"),
    "contour": ("at", "G71 U2 R1\nG71 P10 Q20 F.2", "'N10': there is no block of this number"),
    "probing": ("at", "G31 Z-5 F.1", "'G31': this probes until the work is touched"),
    "unknown M": ("at", "M96", "'M96': this M is not read"),
    "subprogram": ("at", "M98 P1000", "'1000': there is no subprogram of this name"),
    "rotary": ("at", "G1 Z-5 B45 F.1", "'B45': this turns a rotary axis or"),
    "system": ("at", "G91 X30 Z-5 F.1", "'G91': this belongs to the G-code systems B and C"),
    "machine": ("at", "G1 G53 X5", "'G53': this cuts in machine coordinates"),
    "no motion": ("start", "X5", "'X5': no motion is in force"),
    "no place": ("start", "G0 U5", "'U5': this is an increment from an unknown place"),
    "tool": ("at", "T0202\nG1 Z-5 F.1", "'G1': the start is not known in X (nothing states it, or"),
    "plane": ("at", "G17 G2 X30 Z-5 R5 F.1", "'G17': this selects another plane than that of X"),
    "not started": ("start", "M5\nG97 S100\nG0 X20 Z0\nG1 Z-5 F.1", "'G1': the spindle stopped"),
}  # fmt: skip


@pytest.mark.parametrize(("begins", "body", "says"), REFUSED.values(), ids=REFUSED)
def test_a_broken_program_is_refused_with_line_and_word(begins: str, body: str, says: str) -> None:
    text = HEAD + ("G0 X20 Z0\n" if begins == "at" else "") + body
    line = text.count("\n") + 1
    with pytest.raises(UnusableInput) as caught:
        _moves(text)
    assert str(caught.value).startswith(f"p.nc: line {line}: {says}")
    assert has_remedy(str(caught.value))


def test_what_feeds_count_is_said_or_taken_as_the_control_is_switched_on() -> None:
    text = "S1000 M3\nG0 X20 Z0\nG1 Z-5 F.1"
    assert [move.feed for move in _cuts(text)] == [PerRev(0.1)]
    notes = turning_program(text, source="p.nc").notes
    assert notes == ("nothing says what feeds count: taken a revolution (G95)",)
    ours = turning_program(text.replace(".1", "50"), source="p.ngc")
    assert isinstance(ours.moves[-1], Linear)
    assert ours.moves[-1].feed == FeedPerMinute(50)
    assert turning_program(f"{HEAD}G0 X20 Z0\nG1 Z-5 F.1", source="p.nc").notes == ()


def test_nothing_cuts_before_the_spindle_turns() -> None:
    with pytest.raises(UnusableInput, match="line 4: 'G1': nothing has started the spindle"):
        _moves("G21 G99\nG97 S800\nG0 X56 Z2\nG1 Z-40 F0.2\nM30")


def test_all_that_is_not_read_is_said_at_once() -> None:
    body = "G0 X20 Z0\nG777 X5\nM96\nG1 Z-5 F.1\nG1 X5 Q3\n"
    with pytest.raises(UnusableInput) as caught:
        _moves(HEAD + body)
    for said in ("line 4: 'G777': this G", "; line 5: 'M96': this M", "; line 7: 'Q3': nothing"):
        assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_file_is_read_whatever_letters_its_comments_have(tmp_path: Path) -> None:
    path = tmp_path / "p.nc"
    path.write_bytes("\ufeff".encode() + f"{HEAD}(".encode() + b"\xd860)\r\n" + b"G0 X40 Z2\r\n")
    with pytest.raises(UnusableInput, match="no cutting move"):
        read_program(path)
    path.write_bytes(path.read_bytes() + b"G1 Z-5 F.2\r\n")
    assert len(read_program(path).moves) == 1
    with pytest.raises(UnusableInput, match=r"absent\.nc: No such file"):
        read_program(tmp_path / "absent.nc")


def _written(case: Case) -> list[tuple[float, float, float | None, float]]:
    """Return what the cuts of a program were made from: ends, feed, speed of every move."""
    bar = case.protocol.bar
    assert bar
    paths = turning.turning_paths(
        case.protocol, bar, run_order(case.protocol), clearance_mm=CLEAR_MM
    )
    rows = []
    for path in paths:
        x = z = np.nan
        for move in path.moves:
            x, z = move.to.get("x", x), move.to.get("z", z)
            rows.append((x, z, move.feed, path.cut.speed_rpm))
    return rows


def _check_read_back(case: Case) -> None:
    """Every move at a feed of every cut is read with its end, feed and speed; X to a thousandth."""
    program = turning_program(
        case.text, source="p.nc", diameter=bool(case.machine.diameter), block_skip=True
    )
    read = [move for move in program.moves if isinstance(move, Linear)]
    fed = [(x, z, feed, rpm) for x, z, feed, rpm in _written(case) if feed is not None]
    assert len(read) == len(fed)
    assert_allclose([m.end for m in read], [row[:2] for row in fed], atol=0.000501)
    assert_allclose([m.feed.mm for m in read], np.array([row[2] for row in fed]), atol=0.000501)
    assert [m.speed for m in read] == [Revolutions(row[3]) for row in fed]
    assert all(isinstance(m.feed, PerRev) for m in read)


@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize("diameter", [True, False])
def test_the_standard_cuts_that_we_write_are_read_back(dialect: str, diameter: bool) -> None:
    _check_read_back(changed(case_of("turning-aluminium", dialect), "diameter", to=diameter))


@pytest.mark.parametrize("dialect", DIALECTS)
def test_drawn_standard_cuts_are_read_back(dialect: str) -> None:
    draw = np.random.default_rng(7)
    made = 0
    for case in (bar_case(draw, dialect) for _ in range(10)):
        try:
            _ = case.text
        except UnusableInput:
            continue
        _check_read_back(case)
        made += 1
    assert made > 3


BITS = (
    "G91", "U3", "W-2", "X4", "Z-9", "R-5", "I2", "K-4", "F0", "S0", "G96", "G50 S900", "G20", "T1",
    "G28 U0", "M5", "G2", "G3 X20 Z-4 R9", "G0", "(c)", "G4 P1", "X", "%", "(", "M30", "#1", "CR=",
)  # fmt: skip


def test_a_program_that_was_damaged_is_read_or_refused_in_one_line() -> None:
    draw = np.random.default_rng(5)
    read = 0
    for _ in range(300):
        lines = CONTOUR.splitlines()
        for _ in range(draw.integers(1, 4)):
            lines.insert(int(draw.integers(4, len(lines) - 3)), str(draw.choice(BITS)))
        try:
            moves = _moves("\n".join(lines))
        except UnusableInput as error:
            assert str(error).startswith("p.nc: ")
            assert has_remedy(str(error))
        else:
            assert np.isfinite([(move.start, move.end) for move in moves]).all()
            read += 1
    assert 0 < read < 300
