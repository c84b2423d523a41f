"""A turning program read block by block: every move of the tool tip, or the word that is not read.

Written here because the readers on the package registries (tried: nc-gcode-interpreter 0.1.9 and
gcodeparser) know no diameters and no arcs by radius, and take an unknown word for nothing.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from autodb.errors import UnusableInput
from autodb.nc.reading.blocks import ProgramBlock, Word, blocks
from autodb.nc.reading.coordinates import carry_out_motion
from autodb.nc.reading.modes import INCH_MM, MACHINE, OFFSETS, Modes, changed_modes, surface_m_min
from autodb.nc.reading.paths import Arc, Linear, Move
from autodb.nc.reading.values import (
    AXES,
    nothing_left,
    positive_value,
    sorted_words,
    without,
    word_value,
)


@dataclass(frozen=True)
class TurningProgram:
    """The moves of a program in order, and the lines at which it stops for the operator (M0)."""

    source: str
    moves: tuple[Move, ...]
    stops: tuple[int, ...]


def read_program(
    path: Path, *, diameter: bool = True, inch: bool = False, block_skip: bool = False
) -> TurningProgram:
    """Return the moves of a program's file; see `turning_program`."""
    return turning_program(
        program_text(path), source=str(path), diameter=diameter, inch=inch, block_skip=block_skip
    )


def program_text(path: Path) -> str:
    """Return the text of a program's file; raises UnusableInput where there is none."""
    try:
        return path.read_bytes().decode("utf-8-sig", errors="replace")
    except OSError as error:
        raise UnusableInput(f"{path}: {error.strerror}; give an NC program") from error


def turning_program(
    text: str,
    *,
    source: str,
    diameter: bool = True,
    inch: bool = False,
    block_skip: bool = False,
) -> TurningProgram:
    """Return the moves of a program's text.

    X counts diameters unless ``diameter`` is False, lengths are mm unless ``inch``, until the
    program says otherwise; ``block_skip`` leaves out the blocks that begin with /. A move is given
    once both ends are known: not the first ones towards a place, nor those in machine coordinates.
    A rest or a move to where the tool is gives none. Raises UnusableInput naming ``source``, line
    and word.
    """
    modes = Modes(diameter=diameter, unit_mm=INCH_MM if inch else 1.0)
    moves: list[Move] = []
    stops: list[int] = []
    ended: int | None = None
    for block in blocks(text, source=source):
        if block_skip and block.optional:
            continue
        if ended is not None:
            raise block.refusal(
                block.words[0].text,
                f"this stands after the program's end in line {ended}; use one end",
            )
        after = _run(modes, block, moves)
        codes = {word.code for word in block.words}
        stops += [block.line] if "M0" in codes else []
        ended = block.line if codes & {"M2", "M30"} else None
        modes = replace(after, stopped=block.line) if "M5" in codes else after
    if not any(isinstance(move, Linear | Arc) for move in moves):
        raise UnusableInput(f"{source}: no cutting move; use a program with G1, G2 or G3")
    return TurningProgram(source, tuple(moves), tuple(stops))


def _run(modes: Modes, block: ProgramBlock, moves: list[Move]) -> Modes:
    """Carry out a block: its modes, values and motion, in the order of a control."""
    codes, values = sorted_words(block)
    if "G4" in codes:
        nothing_left(without(values, "P", "X", "U", "F", "S"), block, modes)
        return modes
    machine = codes.keys() & MACHINE
    modes = changed_modes(modes, codes if machine else {**codes, **values}, block)
    modes = _spindle(modes, codes, values, block)
    modes = _tool(modes, codes, values)
    if "F" in values:
        modes = replace(modes, feed=positive_value(values["F"], block) * modes.unit_mm)
    rest = without(values, "F", "S", "T", "D", "LIMS", "N", "O")
    if machine:
        return _in_machine(modes, codes, rest, block)
    return carry_out_motion(modes, rest, block, moves)


def _spindle(
    modes: Modes, codes: Mapping[str, Word], values: Mapping[str, Word], block: ProgramBlock
) -> Modes:
    """Take speed, limits and whether the spindle turns."""
    if "LIMS" in values:
        modes = replace(modes, highest_rpm=positive_value(values["LIMS"], block))
    if codes.keys() & {"M3", "M4"}:
        modes = replace(modes, stopped=None)
    limits = next((codes[code] for code in ("G50", "G92") if code in codes), None)
    if limits is not None:
        if "S" not in values or values.keys() & set(AXES):
            raise block.refusal(
                limits.text,
                "this shifts coordinates or starts a cycle; use it alone with S, as a speed limit",
            )
        return replace(modes, limit_rpm=positive_value(values["S"], block))
    if "S" not in values:
        return modes
    speed = word_value(values["S"])
    if speed < 0:
        raise block.refusal(values["S"].text, "use a speed of at least 0")
    return replace(modes, speed=surface_m_min(modes, speed) if modes.surface else speed)


def _tool(modes: Modes, codes: Mapping[str, Word], values: Mapping[str, Word]) -> Modes:
    """Take tool and offsets; others shift the program's coordinates by what it does not say."""
    if not (codes.keys() & OFFSETS or values.keys() & {"T", "D"}):
        return modes
    after = replace(
        modes,
        tool=values["T"].written if "T" in values else modes.tool,
        edge=values["D"].text if "D" in values else modes.edge,
        offset=next((code for code in codes if code in OFFSETS), modes.offset),
    )
    return after if after == modes else replace(after, x_mm=None, z_mm=None)


def _in_machine(
    modes: Modes, codes: Mapping[str, Word], values: Mapping[str, Word], block: ProgramBlock
) -> Modes:
    """Move the axes that are named to machine coordinates: they are not known in the program's."""
    word = next(codes[code] for code in codes if code in MACHINE)
    if word.code in {"G53", "SUPA"} and modes.motion != "G0":
        raise block.refusal(word.text, "this cuts in machine coordinates; use it with G0")
    nothing_left(without(values, *AXES, "P"), block, modes)
    x = None if values.keys() & {"X", "U"} else modes.x_mm
    z = None if values.keys() & {"Z", "W"} else modes.z_mm
    return replace(modes, x_mm=x, z_mm=z)
