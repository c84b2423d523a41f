"""A turning program read: every move of the tool tip, or all words that are not read."""

import re
from codecs import BOM_UTF8, BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import overload

from autodb.errors import UnusableInput
from autodb.nc.reading.codes import INCH_MM
from autodb.nc.reading.compensation import RadiusOf, beside_contours
from autodb.nc.reading.controls import CONTROLS, LINUXCNC, SINUMERIK, Control, control_of
from autodb.nc.reading.cycles.stated import NOTHING_STATED, StatedOfProgram
from autodb.nc.reading.interpreter import Interpreter
from autodb.nc.reading.lines.blocks import numbered_lines
from autodb.nc.reading.lines.expressions import Key, Number, Values
from autodb.nc.reading.lines.foreign import refuse_other_language
from autodb.nc.reading.lines.instructions import Instructions
from autodb.nc.reading.missing import missing_subprograms
from autodb.nc.reading.paths import Arc, Linear, Move, Point, Rapid
from autodb.nc.reading.planes import why_nothing
from autodb.nc.reading.runner import NO_SUBPROGRAM, Library, Runner
from autodb.nc.reading.state import ProgramState
from autodb.nc.reading.travels import PackedMoves, ProgramMove, ToolPlace

MOST_SAID = 40
"""Refused words that one message names; of more it says how many. Chosen."""
MOST_BESIDE = 2000
"""Files beside a program among which its subprograms are looked for. Chosen."""
_SUFFIXES = (".ngc", ".nc", ".cnc", ".spf", ".mpf", ".tap", ".txt", "")
_FOLLOWS = (
    "the start is not known", "no feed before", "from an unknown place", "the cycle's start",
    "no motion is in force", "no spindle speed",
)  # fmt: skip
"""What is refused because something before was: not said beside it."""


@dataclass(frozen=True)
class ReadProgram:
    """A program's moves in three axes, stops (M0), rests, and what a reader has to know of it.

    ``rests``: line and seconds of each dwell.
    """

    source: str
    control: str
    travels: PackedMoves
    stops: tuple[int, ...]
    rests: tuple[tuple[int, float], ...]
    notes: tuple[str, ...]

    @property
    def fed_s(self) -> float:
        """How long its moves at a feed take, s."""
        return sum(travel.time_s() for travel in self.travels)

    @property
    def rapid_mm(self) -> float:
        """How far it goes fast, mm."""
        return sum(travel.length_mm for travel in self.travels if travel.feed is None)


@dataclass(frozen=True)
class TurningProgram:
    """The moves of a program in order, and the lines at which it stops for the operator (M0).

    ``notes``: what was taken of it that it does not say; ``beside``: lines that are between G41 or
    G42 and G40, so that the nose leaves what they say.
    """

    source: str
    moves: Sequence[Move]
    stops: tuple[int, ...]
    notes: tuple[str, ...] = ()
    beside: frozenset[int] = frozenset()


def read_program(
    path: Path, *, diameter: bool | None = None, inch: bool | None = False, block_skip: bool = False
) -> TurningProgram:
    """Return the moves of a program's file; see `turning_program`."""
    return turning_program(
        program_text(path), source=str(path), diameter=diameter, inch=inch, block_skip=block_skip
    )


def program_text(path: Path) -> str:
    """Return the text of a program's file; raises UnusableInput where there is none.

    It is UTF-16 where it begins so, else UTF-8, else a code of one byte a letter, of which only
    remarks have more than ASCII: which one it is does not matter. Zeros around it are the leader
    and the end of a paper tape.
    """
    try:
        said = path.read_bytes()
    except OSError as error:
        raise UnusableInput(f"{path}: {error.strerror}; give an NC program") from error
    if said.startswith((BOM_UTF16_LE, BOM_UTF16_BE)):
        return said.decode("utf-16", errors="replace")
    said = said.strip(b"\0").removeprefix(BOM_UTF8)
    try:
        return said.decode()
    except UnicodeDecodeError:
        return said.decode("latin-1")


def line_texts(text: str, which: Collection[int], *, source: str) -> dict[int, str]:
    """Return what some lines of a program say, by number, without comment and number."""
    brackets = control_of(text, source=source) is not SINUMERIK
    lines = numbered_lines(text, source=source, brackets=brackets) if which else ()
    return {
        line.line: " ".join(re.sub(r"^N\d+\s*", "", line.text).split())
        for line in lines
        if line.line in which
    }


def turning_program(
    text: str,
    *,
    source: str,
    diameter: bool | None = None,
    inch: bool | None = False,
    block_skip: bool = False,
    control: str | None = None,
    highest_rpm: float | None = None,
    stated: StatedOfProgram = NOTHING_STATED,
) -> TurningProgram:
    """Return the moves of a program's text.

    X counts diameters unless ``diameter`` is False, or None and the file one of LinuxCNC's own
    (.ngc), whose control counts radii; lengths are mm unless ``inch``, until the program says
    otherwise, with a note where ``inch`` is None; ``block_skip`` leaves out the blocks that begin
    with /; ``control``: for which it is written, else told by its words; ``highest_rpm``: of the
    machine's spindle; ``stated``: what a job states of tools, cycles and stock. A move is given
    once both ends are known: not the first ones towards a place, nor those in machine coordinates.
    A rest or a move to where the tool is gives none. Raises UnusableInput naming ``source``, and
    line and word of all not read.
    """
    done = carried_out(
        text, source=source, lathe=True, diameter=diameter, inch=inch, block_skip=block_skip,
        control=control, highest_rpm=highest_rpm, stated=stated,
    )  # fmt: skip
    sides = done.travels.by_way(lambda travel: travel.beside)
    lines = done.travels.line_numbers.tolist()
    beside = frozenset(line for line, side in zip(lines, sides, strict=True) if side is not None)
    return TurningProgram(source, TurnedMoves(done.travels), done.stops, done.notes, beside)


def carried_out(
    text: str,
    *,
    source: str,
    lathe: bool,
    diameter: bool | None = None,
    inch: bool | None = False,
    block_skip: bool = False,
    control: str | None = None,
    radius_of: RadiusOf | None = None,
    highest_rpm: float | None = None,
    stated: StatedOfProgram = NOTHING_STATED,
) -> ReadProgram:
    """Return a program carried out, on a lathe or a mill; see `turning_program`.

    ``radius_of``: of a mill's tools, whose centre then goes beside compensated contours.
    """
    refuse_other_language(text, source=source)
    written = CONTROLS[control] if control else control_of(text, source=source)
    instructions = written.instructions(text, source=source)
    own = written is LINUXCNC and source.lower().endswith(".ngc")
    counts = not own if diameter is None else diameter
    state = _begun(written, lathe=lathe, diameter=counts, inch=bool(inch))
    if stated.per_minute is not None:
        state.feed_word, state.feed_said = "G94" if stated.per_minute else "G95", True
    state.angles, state.looks_at = stated.angles, stated.plane
    if stated.speed_rpm is not None:
        state.speed = state.dial_rpm = stated.speed_rpm
        state.turning = True
    state.highest_rpm, state.centre_absolute = highest_rpm, stated.centres_are_places
    state.changes_tools = bool(_CHANGES.search(_REMARK.sub("", text)))
    values = Values(of_control=_of_control(written, state))
    if written is SINUMERIK:
        values.of_all = _of_channel
    passed: set[str] = set()
    library = _passing(_beside(source, written), stated.left_out, written, passed)
    runner = Runner(instructions, values=values, block_skip=block_skip, library=library)
    interpreter = Interpreter(state, runner, stated, radius_of)
    problems = interpreter.run()
    moves = interpreter.moves
    if radius_of is not None and not (instructions.problems or problems):
        moves, problems = beside_contours(
            moves, radius_of, round_corners=not written.system, source=source
        )
    if any(NO_SUBPROGRAM in str(problem) for problem in problems):
        problems += missing_subprograms(runner)
    _refuse(source, [*instructions.problems, *problems])
    for unit in sorted(stated.left_out - passed):
        raise UnusableInput(
            f"{source}: calls no subprogram '{unit}' that is missing; take it out of left_out"
        )
    if not any(travel.feed is not None for travel in moves):
        raise UnusableInput(f"{source}: {why_nothing(state)}")
    if inch is None and not state.unit_said:
        state.note("nothing says whether lengths are mm or inches: taken as mm")
    return ReadProgram(
        source, written.name, moves, tuple(interpreter.stops),
        tuple(interpreter.rests), tuple(state.notes),
    )  # fmt: skip


_CHANGES = re.compile(r"M0*61?(?![\d.])", re.IGNORECASE)
"""M6 and M61, which change in the tool that T has named."""
_REMARK = re.compile(r"\([^()\n]*\)|;.*")


def _of_channel(name: str) -> bool:
    """Return whether a variable of Sinumerik is of all programs of a channel, as R1 is."""
    return bool(re.fullmatch(r"R\d+|_.*", name))


def _begun(control: Control, *, lathe: bool, diameter: bool, inch: bool) -> ProgramState:
    """Return what is in force before a program's first block."""
    state = ProgramState(
        lathe=lathe,
        diameter=diameter,
        unit_mm=INCH_MM if inch else 1.0,
        control=control,
        plane="G18" if lathe else "G17",
        feed_word=control.feed_word if lathe else "G94",
    )
    if lathe:
        state.place["y"] = 0.0
    return state


def _of_control(control: Control, state: ProgramState) -> Callable[[Key], Number]:
    """Return what the control itself knows: places of the axes, and what is in force.

    LinuxCNC's X is a radius in G7 too: it halves the words and keeps that (``Interp::lookup_
    named_param`` and parameter 5420 of its interpreter).
    """

    def value(key: Key) -> Number:
        axis = _PLACES.get(key)
        if axis is not None and state.place[axis] is not None:
            counts = state.unit_mm if control is LINUXCNC else state.factor(axis)
            return (state.known(axis) - state.shift[axis]) / counts
        if key == "_feed":
            return state.feed
        if key == "_rpm":
            return state.speed
        if control is LINUXCNC:
            setting = None if isinstance(key, int) else _SETTINGS.get(key, _vacant)
            return 0.0 if setting is None else setting(state)
        return _of_sinumerik(key) if control is SINUMERIK else None

    return value


def _vacant(_state: ProgramState) -> Number:
    return None


def _of_sinumerik(key: Key) -> Number:
    """Return what Sinumerik knows of itself; what no program sets is not known."""
    if key in _NOT_RUNNING:
        return 0.0
    raise ValueError(f"nothing in the program has set '{key}'; set it before this line")


_PLACES: dict[Key, str] = {
    5420: "x", 5421: "y", 5422: "z", "_x": "x", "_y": "y", "_z": "z",
    5001: "x", 5002: "y", 5003: "z", 5041: "x", 5042: "y", 5043: "z",
}  # fmt: skip
_NOT_RUNNING = frozenset({"$P_SEARCH", "$P_SIM", "$P_ISTEST", "$P_DRYRUN"})
"""Whether Sinumerik searches a block, simulates, tests or runs dry: not while it cuts."""
_SETTINGS: dict[Key, Callable[[ProgramState], Number]] = {
    "_metric": lambda state: float(state.unit_mm == 1.0),
    "_imperial": lambda state: float(state.unit_mm != 1.0),
    "_absolute": lambda state: float(state.absolute),
    "_incremental": lambda state: float(not state.absolute),
    "_lathe_diameter_mode": lambda state: float(state.diameter),
    "_lathe_radius_mode": lambda state: float(not state.diameter),
}


def _beside(source: str, control: Control) -> Callable[[str], Instructions | None]:
    """Return what finds a subprogram in the folder of the program."""
    folder = Path(source).parent

    def find(unit: str) -> Instructions | None:
        if not unit.replace("_", "").replace("-", "").isalnum():
            return None
        ends = (unit.lower(), f"o{unit.zfill(4)}", f"o{unit.zfill(5)}")
        there = sorted(folder.iterdir())[:MOST_BESIDE] if folder.is_dir() else []
        files = [path for path in there if path.suffix.lower() in _SUFFIXES]
        named = [path for path in files if path.stem.lower() in ends]
        alike = (p for p in files if p.stem.lower().endswith(ends) and p != Path(source))
        path = next(iter(named), next(alike, None))
        return None if path is None else control.instructions(program_text(path), source=str(path))

    return find


_MOST_ARGUMENTS = 40
"""Arguments that a call of a subprogram which is left out may have. Chosen."""


def _passing(
    library: Library, left_out: frozenset[str], control: Control, passed: set[str]
) -> Library:
    """Return a library that has some subprograms that are missing as a way to the reference.

    So the tool's place is not known behind their calls. ``passed``: takes those that are called.
    """

    def find(unit: str) -> Instructions | None:
        found = library(unit)
        if found is not None or unit.upper() not in left_out:
            return found
        passed.add(unit.upper())
        nothing = control.instructions("G28", source=unit)
        names = (f"_{k}" for k in range(_MOST_ARGUMENTS))
        nothing.parameters[""] = tuple((name, None) for name in names)
        return nothing

    return find


def _refuse(source: str, problems: Sequence[UnusableInput]) -> None:
    """Raise one error of all that is refused, each line and reason once."""
    said = list(dict.fromkeys(str(problem) for problem in problems))
    first = [one for one in said if not any(why in one for why in _FOLLOWS)]
    said = first or said[:1]
    if not said:
        return
    alike: dict[str, list[str]] = {}
    for one in said:
        alike.setdefault(re.sub(r"\bline \d+", "line", one), []).append(one)
    told = [some[0] + _also(some[1:]) for some in alike.values()]
    rest = [one.removeprefix(f"{source}: ") for one in told[1:MOST_SAID]]
    more = f" and {len(told) - MOST_SAID} more" if len(told) > MOST_SAID else ""
    raise UnusableInput("; ".join([told[0], *rest]) + more)


def _also(others: Sequence[str]) -> str:
    """Return the lines that are refused for the same word and reason."""
    if not others:
        return ""
    lines = [found[1] for one in others[:6] if (found := re.search(r": line (\d+): ", one))]
    more = " and more" if len(others) > len(lines) else ""
    return f" (so in line {', '.join(lines)}{more})"


class TurnedMoves(Sequence[Move]):
    """A lathe's moves in the plane of the spindle's axis, each made anew where it is asked for."""

    def __init__(self, travels: PackedMoves) -> None:
        self._travels = travels

    def __len__(self) -> int:
        """Return how many moves there are."""
        return len(self._travels)

    @overload
    def __getitem__(self, place: int) -> Move: ...
    @overload
    def __getitem__(self, place: slice) -> list[Move]: ...
    def __getitem__(self, place: int | slice) -> Move | list[Move]:
        """Return a move, or some."""
        if isinstance(place, slice):
            return [_turned(travel) for travel in self._travels[place]]
        return _turned(self._travels[place])

    def __iter__(self) -> Iterator[Move]:
        """Give the moves in order."""
        return map(_turned, self._travels)


def _turned(travel: ProgramMove) -> Move:
    """Return a move in the plane of the spindle's axis."""
    start, end = _point(travel.start), _point(travel.end)
    if travel.feed is None or travel.speed is None:
        return Rapid(start, end, travel.line, travel.tool)
    if travel.circle is None:
        return Linear(
            start, end, travel.feed, travel.speed, travel.line, travel.tool, travel.thread
        )
    z, x = travel.circle.centre
    return Arc(
        start, end, Point(x, z), travel.circle.left, travel.feed, travel.speed, travel.line,
        travel.tool,
    )  # fmt: skip


def _point(place: ToolPlace) -> Point:
    return Point(place.x_mm, place.z_mm)
