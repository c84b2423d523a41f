"""A small reader of NC programs in both dialects, which shares no code with what writes them.

It keeps the modal state of a control, refuses a word that it does not know, and gives every motion
in the travel of the axes, X as a radius.
"""

import re
from dataclasses import dataclass, field, replace

Place = dict[str, float]
WORD = re.compile(r"([A-Z]+?)=?(-?\d+(?:\.\d*)?)$")
INCREMENTS = {"U": "X", "V": "Y", "W": "Z"}
IGNORED = {"G40", "G49", "G80", "M9", "M6", "M1"}
PLANES, UNITS = {"G17", "G18"}, {"G21", "G710"}


@dataclass(frozen=True)
class Modes:
    """What is in force at a block."""

    units: str = ""
    plane: str = ""
    feed_per: str = ""
    limit_rpm: float | None = None
    absolute: bool = False
    diameter: bool | None = None
    offset: bool = False
    tool: bool = False
    rpm: float = 0.0
    turning: str = ""
    rapid: bool | None = None
    feed: float | None = None


@dataclass(frozen=True)
class Motion:
    """One motion: from where (axes that moved already) to where, and how many stops before."""

    line: int
    before: Place
    after: Place
    modes: Modes
    machine: bool
    optional: bool
    stops: int


@dataclass(frozen=True)
class Control:
    """What the words of a control mean on a machine."""

    per_rev: frozenset[str]
    per_min: frozenset[str]
    always_absolute: bool
    diameter: bool | None
    zero: Place
    cycles: frozenset[str] = frozenset()


@dataclass
class _Run:
    control: Control
    modes: Modes
    at: Place = field(default_factory=dict)
    motions: list[Motion] = field(default_factory=list)
    stops: int = 0
    stepped: bool = False


def fanuc_lathe(zero: Place, *, diameter: bool) -> Control:
    """Return a Fanuc lathe in G-code system A: G90 would be a turning cycle."""
    rev, minute = frozenset({"G99"}), frozenset({"G98"})
    return Control(rev, minute, True, diameter, zero, frozenset({"G90", "G92", "G94", "G95"}))


def other(zero: Place, *, lathe: bool) -> Control:
    """Return a Fanuc mill or a Sinumerik; on its lathe a program must say how X counts."""
    diameter = None if lathe else False
    return Control(frozenset({"G95"}), frozenset({"G94"}), False, diameter, zero)


def motions(text: str, control: Control, *, skip: bool) -> list[Motion]:
    """Run a program and return its motions; ``skip`` leaves out the blocks that begin with /."""
    run = _Run(control, Modes(diameter=control.diameter, absolute=control.always_absolute))
    ended = False
    for number, raw in enumerate(text.splitlines(), 1):
        assert not ended or raw == "%", f"line {number}: after M30"
        optional = raw.startswith("/")
        words = _words(raw.removeprefix("/"))
        if words and not (optional and skip):
            _block(run, number, words, optional)
            ended = "M30" in words
    assert ended
    return run.motions


def _words(line: str) -> list[str]:
    line = re.sub(r"\([^()]*\)", "", line).split(";")[0]
    assert "(" not in line
    assert line.isascii()
    return [] if re.match(r"%|O\d{4}", line) else line.split()


def _block(run: _Run, number: int, words: list[str], optional: bool) -> None:
    if "G4" in words:
        assert len(words) == 2, f"line {number}: a rest and something else"
        assert re.match(r"P\d+$|F\d+\.\d+$", words[1]), words[1]
        return
    to: Place = {}
    machine = False
    for word in words:
        machine |= word in {"G53", "SUPA"}
        if not _mode(run, word):
            match = WORD.match(word)
            assert match, f"line {number}: {word}"
            letter = "LIMS" if "G50" in words and match[1] == "S" else match[1]
            _value(run, letter, float(match[2]), to, word)
    if to:
        _move(run, number, to, machine, optional)


def _mode(run: _Run, word: str) -> bool:
    """Take a word that is a mode; say whether it was one."""
    control, modes = run.control, run.modes
    assert word not in control.cycles, word
    changes: dict[str, object] = {}
    if word in UNITS:
        changes = {"units": word}
    elif word in PLANES:
        changes = {"plane": word}
    elif word in control.per_rev | control.per_min:
        changes = {"feed_per": "rev" if word in control.per_rev else "min"}
    elif word in {"G0", "G1"}:
        changes = {"rapid": word == "G0"}
    elif word in {"DIAMON", "DIAMOF"}:
        changes = {"diameter": word == "DIAMON"}
    elif word in {"M3", "M4"}:
        changes = {"turning": word}
    elif word == "M5":
        changes = {"turning": ""}
    elif word in {"G90", "G91"}:
        changes = {"absolute": word == "G90"}
    elif word == "G54":
        changes = {"offset": True}
    elif word == "M0":
        assert not modes.turning, "a stop with the spindle on"
        run.stops += 1
    elif word not in IGNORED | {"G50", "G97", "G53", "SUPA", "M30", "G43"}:
        return False
    run.modes = replace(modes, **changes)  # type: ignore[arg-type]
    return True


def _value(run: _Run, letter: str, value: float, to: Place, word: str) -> None:
    if letter in {"X", "Y", "Z"} | INCREMENTS.keys():
        assert "." in word, "a coordinate without a decimal point"
        name = INCREMENTS.get(letter, letter)
        assert letter not in INCREMENTS or run.control.cycles, "a letter of lathes in system A"
        assert name != "X" or run.modes.diameter is not None, "radius or diameter?"
        mm = value / 2 if name == "X" and run.modes.diameter else value
        step = letter in INCREMENTS or not run.modes.absolute
        to[name.lower()] = run.at[name.lower()] + mm if step else mm
        run.stepped = step
    elif letter == "F":
        run.modes = replace(run.modes, feed=value)
    elif letter == "LIMS":
        run.modes = replace(run.modes, limit_rpm=value)
    elif letter == "S":
        run.modes = replace(run.modes, rpm=value)
    elif letter in {"T", "D", "H"}:
        run.modes = replace(run.modes, tool=value > 0)
    else:
        raise AssertionError(word)


def _move(run: _Run, number: int, to: Place, machine: bool, optional: bool) -> None:
    modes = run.modes
    assert modes.rapid is not None
    assert not (machine and run.stepped), f"line {number}: an increment in machine coordinates"
    assert machine or run.stepped or (modes.offset and modes.tool), f"line {number}: no offset"
    zero = {} if machine or run.stepped else run.control.zero
    after = {**run.at, **{axis: mm + zero.get(axis, 0.0) for axis, mm in to.items()}}
    run.motions.append(Motion(number, dict(run.at), after, modes, machine, optional, run.stops))
    run.at = after
