"""A program carried out block by block: what is in force, and the moves that follow from it.

Written here because the readers on the package registries (tried: nc-gcode-interpreter 0.1.9 and
gcodeparser) know no diameters, no arcs by radius and no cycles, and take an unknown word for
nothing.
"""

from collections.abc import Callable, Mapping

from autodb.errors import UnusableInput
from autodb.nc.reading.codes import (
    BOXES,
    DRILLED,
    GROOVING,
    HARMLESS,
    LENGTHS,
    MACHINE,
    MODE_LETTERS,
    OF_OKUMA,
    OFFSETS,
    ROUGHING,
    SYSTEM_B,
    SYSTEM_C,
    groups_of,
    is_builders,
)
from autodb.nc.reading.compensation import RadiusOf
from autodb.nc.reading.controls import (
    FANUC_A,
    FANUC_B,
    FANUC_C,
    LINUXCNC,
    OF_FANUC,
    OKUMA,
    SINUMERIK,
    Control,
)
from autodb.nc.reading.corners import CornerRecord
from autodb.nc.reading.cycles import box_cycles, calls, drilling, grooving, roughing, threading
from autodb.nc.reading.cycles.pockets import POCKETS, mill_pocket
from autodb.nc.reading.cycles.stated import NOTHING_STATED, StatedOfProgram
from autodb.nc.reading.frames import (
    FRAMES,
    move_in_machine,
    names_axis,
    refuse_axial_shift,
    set_place,
    shift_frame,
    turn_plane,
)
from autodb.nc.reading.lines.blocks import ProgramBlock, Word
from autodb.nc.reading.lines.names import NAMES
from autodb.nc.reading.motions import carry_out_motion, word_not_read
from autodb.nc.reading.planes import TILTS, KeptMoves, tilt_by_word
from autodb.nc.reading.rests import rest_s
from autodb.nc.reading.rotary import turn_rotary
from autodb.nc.reading.runner import Runner
from autodb.nc.reading.spindles import ANOTHER_SPINDLE, starts_another, take_spindle
from autodb.nc.reading.state import (
    AXES,
    ProgramState,
    feed_value,
    word_value,
)
from autodb.nc.reading.targets import without

Values = Mapping[str, Word]
_LETTERS = frozenset("XYZUVWIJKRABCFSTDHNOPQLE@^") | frozenset({
    "CR", "LIMS", "TURN", "SF", ",R", ",C", ",A", "RND", "CHF", "CHR", "ANG", "FRC", "SPOS", "RPL",
    "S1", "M1", "S2", "T1", "DL", "FP", "AR",
})  # fmt: skip
_ONCE = frozenset({"G4", "G10", "G50", "G52", "G92", "G11", "G92.1", "G92.2", "G92.3", "G50.3"})
_ENDS = frozenset({"M2", "M30"})
_PLACE = frozenset("XYZIJKN")


class Interpreter:
    """Carries out blocks: ``state`` is what is in force, ``moves`` what the tool has done.

    ``stops``: lines of M0; ``rests``: line and seconds of every dwell.
    """

    def __init__(
        self,
        state: ProgramState,
        runner: Runner,
        stated: StatedOfProgram = NOTHING_STATED,
        radius_of: RadiusOf | None = None,
    ) -> None:
        self.state = state
        self.runner = runner
        self.stated = stated
        self.radius_of = radius_of
        self.kept = KeptMoves(state)
        self.moves = self.kept.all
        self.stops: list[int] = []
        self.rests: list[tuple[int, float]] = []
        self.modal_call: tuple[str, Word] | None = None
        self.in_contour = False
        self.record = CornerRecord(self.kept.keep, source=runner.instructions.source)
        self.groups = groups_of(state.control, lathe=state.lathe)
        self._group_of = {code: k for k, group in enumerate(self.groups) for code in group}
        self._cycles = self._cycles_of()

    def _cycles_of(self) -> dict[str, Callable[..., None]]:
        """Return what carries out each cycle of the control."""
        control, lathe = self.state.control, self.state.lathe
        drilled = dict.fromkeys(DRILLED - GROOVING, drilling.drill_holes)
        if control in (SINUMERIK, OKUMA):
            return {}
        taps = {"G33.1": drilling.rigid_tap} if control is LINUXCNC else {}
        if not lathe:
            return {**drilled, **taps, "G74": drilling.drill_holes}
        cycles: dict[str, Callable[..., None]] = {
            **dict.fromkeys(DRILLED - GROOVING - ROUGHING, drilling.drill_on_lathe),
            **dict.fromkeys(ROUGHING, roughing.fanuc_roughing),
            **dict.fromkeys(GROOVING, grooving.fanuc_grooves),
            "G76": threading.fanuc_threads,
            "G32": threading.thread_pass,
        }
        if control is LINUXCNC:
            own = {**taps, "G76": threading.linuxcnc_threads, "G73": drilling.drill_on_lathe}
            own |= {
                f"G{n}{part}": roughing.linuxcnc_roughing for n in (70, 71, 72) for part in _PARTS
            }
            return {n: c for n, c in cycles.items() if n in DRILLED and n != "G74"} | own
        return {**cycles, **dict.fromkeys(_boxes(control), box_cycles.box)}

    def step(self, block: ProgramBlock) -> None:
        """Carry out a block: its modes, values and motion, in the order of a control."""
        self.state.turning_rotary = False
        if self._is_place(block):
            places = {word.name: word for word in block.words}
            if len(places) == len(block.words):
                carry_out_motion(self.state, places, block, self.record)
                return
        codes, said = self._sorted(block)
        values: Values = said
        state = self.state
        if "G4" in codes:
            self.rests.append((block.line, rest_s(state, values, block)))
            return
        cycle = next((code for code in codes if code in self._cycles), None)
        self._change(codes, block, cycle)
        values = turn_rotary(state, codes, values)
        if state.side is not None:
            self._compensated(codes, values, block)
        if cycle is None and starts_another(state, codes, values):
            self.runner.ended = True
            raise block.refusal(values["P"].text, ANOTHER_SPINDLE)
        take_spindle(state, codes, values, block)
        self._tool(codes, values, block)
        later = state.lathe and cycle in ROUGHING and state.control is not LINUXCNC
        if "F" in values and "G10" not in codes and not later:
            state.feed = feed_value(values["F"], state.unit_mm, block)
        self._marks(codes, block)
        rest = without(values, "S", "D", "H", "LIMS", "N", "O", "S1", "M1", "E", "DL")
        rest = rest if cycle else without(rest, "T", "F", *(self._letters(codes, rest, block)))
        if self._once(codes, rest, block):
            return
        if cycle is not None or (state.cycle and names_axis(rest)):
            self._cycles[cycle or state.cycle or ""](self, cycle or state.cycle, values, block)
            return
        calls.call_cycles(self, codes, block)
        rest = without(rest, "L", "P") if not names_axis(rest) else rest
        carry_out_motion(state, rest, block, self.record)
        if self.modal_call is not None and names_axis(rest):
            calls.at_place(self, block)

    def _is_place(self, block: ProgramBlock) -> bool:
        """Return whether a block only states a place, with no cycle in force: most blocks do."""
        if self.modal_call is not None or self.state.cycle is not None:
            return False
        return all(word.name in _PLACE and word.number is not None for word in block.words)

    def run(self) -> list[UnusableInput]:
        """Carry out the program; return what was refused, at most one a block."""
        problems: list[UnusableInput] = []
        blocks = self.runner.blocks()
        while True:
            try:
                self.step(next(blocks))
            except StopIteration:
                self.record.finish()
                self.moves = self.kept.looked_at()
                return problems
            except UnusableInput as error:
                problems.append(error)

    def _sorted(self, block: ProgramBlock) -> tuple[dict[str, Word], dict[str, Word]]:
        """Return the words that name what to do, by code, and those with values, by letter."""
        codes: dict[str, Word] = {}
        values: dict[str, Word] = {}
        for word in block.words:
            code = self._code(word)
            if code is None:
                key, into = word.name, values
                if key not in _LETTERS or (word.number is None and key not in ("T", "D")):
                    raise word_not_read(word, block, self.state)
            else:
                key, into = code, codes
            if key == "T" and key in into and self._readies(block):
                continue
            if key in into and key != "N" and not key.startswith("M"):
                raise block.refusal(word.text, f"this is a second {key} in the block; use one")
            into[key] = word
        return codes, values

    def _readies(self, block: ProgramBlock) -> bool:
        """Return whether the second T of a block readies the next tool (T1 T2 M6, of Mazak)."""
        changes = any(word.code == "M6" for word in block.words)
        if changes and self.state.control in OF_FANUC:
            self.state.note("of two T beside M6 the first is changed in, the second only readied")
        return changes and self.state.control in OF_FANUC

    def _code(self, word: Word) -> str | None:
        """Return what a word does, by its name in G-code system A; None where it is a value."""
        code, control = word.code, self.state.control
        if self.state.lathe and control in (FANUC_B, FANUC_C):
            code = (SYSTEM_B if control is FANUC_B else SYSTEM_C).get(code, code)
            code = f"{code} " if code in BOXES and word.code not in BOXES else code
        if code in self._cycles or code in self._group_of:
            return code
        known = code in HARMLESS or code in OFFSETS or code in MACHINE or code in LENGTHS
        if code in _OF_MILLS and not self.state.lathe and control is not LINUXCNC:
            return code
        known = known or (code == "G5" and bool(control.system)) or self._of_builder(word)
        known = known or (code in OF_OKUMA and control is OKUMA)
        if known or code in _ONCE or (word.number is None and word.name in NAMES):
            return word.name if word.name in NAMES else code
        if control is SINUMERIK and code in ("G74", "G75"):
            return "G28"
        return None

    def _of_builder(self, word: Word) -> bool:
        """Return whether an M is one of the machine's builder, and note it."""
        if word.name != "M" or not is_builders(word.number or 0.0, self.state.control):
            return False
        self.state.note(f"{word.code} is the machine builder's word: taken to move no axis")
        return True

    def _change(self, codes: Mapping[str, Word], block: ProgramBlock, cycle: str | None) -> None:
        """Take the modal words of a block, one of each group.

        A feed or speed said under another unit or way of counting is not known any more. On the way
        to a machine's reference (G91 G28 Z0 G90) the last word of a group counts, as on Fanuc's
        controls.
        """
        state = self.state
        last = bool(codes.keys() & MACHINE) and state.control in OF_FANUC
        said: dict[int, str] = {}
        for code in codes:
            group = self._group_of.get(code)
            if group is None or code == cycle:
                continue
            if group in said and not last:
                raise block.refusal(
                    codes[code].text,
                    f"'{codes[said[group]].text}' stands in this block too; use one of them",
                )
            said[group] = code
        if any(code in self.groups[0] for code in said.values()) or "G80" in codes:
            state.cycle, state.taken = None, {}
        before, tilt = (state.unit_mm, state.feed_word, state.surface), state.tilt
        for group, code in said.items():
            for name, value in self.groups[group][code].items():
                setattr(state, name, value)
                state.feed_said |= name == "feed_word"
                state.diameter_said |= name == "diameter"
                state.unit_said |= name == "unit_mm"
        if state.unit_mm != before[0] or before[1] != state.feed_word:
            state.feed = None
        if state.tilt != tilt:
            state.forget()
        if state.surface != before[2] or (state.unit_mm != before[0] and before[2]):
            state.speed = None

    def _compensated(self, codes: Mapping[str, Word], values: Values, block: ProgramBlock) -> None:
        """Take a lathe's compensated path for the contour that it leaves; a mill's goes beside."""
        state = self.state
        if state.lathe:
            state.note("between G41 or G42 and G40 the programmed contour is what is left")
            return
        begins = next((codes[code] for code in _SIDES if code in codes), None)
        if begins is None:
            return
        if state.plane != "G17":
            raise block.refusal(begins.text, "a mill's radius is taken in G17; select it before")
        state.note(
            "between G41 or G42 and G40 the mill's centre goes beside the contour, by its radius "
            "or by offset_mm of its tool"
        )
        stated = "." in begins.written and "D" in values
        state.side_mm = 0.5 * word_value(values["D"]) * state.unit_mm if stated else None

    def _letters(self, codes: Mapping[str, Word], rest: Values, block: ProgramBlock) -> str:
        """Return the letters that the words of path modes take in a block."""
        if "G5" in codes and "P" not in rest:
            raise word_not_read(codes["G5"], block, self.state)
        return "".join(MODE_LETTERS.get(code, "") for code in codes)

    def _marks(self, codes: Mapping[str, Word], block: ProgramBlock) -> None:
        if "M0" in codes:
            self.stops.append(block.line)
        ends = codes.keys() & _ENDS or ("M17" in codes and self.runner.depth == 0)
        if ends and not self.in_contour:  # the end of a contour's subprogram is none of the program
            self.runner.ended = True
        if "M5" in codes:
            self.state.turning, self.state.stopped = False, block.line

    def _tool(self, codes: Mapping[str, Word], values: Values, block: ProgramBlock) -> None:
        """Take tool and offsets; others shift the program's coordinates by what it does not say."""
        state = self.state
        if "T" in values:
            state.called = values["T"].written
        changes = "M6" in codes or "M61" in codes
        at_once = state.lathe and state.control is not LINUXCNC
        by_hand = "T" in values and not (at_once or state.changes_tools)
        if by_hand:
            state.note("no M6 changes a tool: the one that T names is taken to cut from there on")
        tool = state.called if changes or at_once or by_hand else state.tool
        offset = next((code for code in codes if code in OFFSETS), state.offset)
        if state.control is SINUMERIK:
            refuse_axial_shift(codes, values, block)
        if state.control is OKUMA:  # its G56 is a tool's length
            chosen = "G15" in codes and "H" in values
            offset = f"G15 {values['H'].text}" if chosen else state.offset
        by_edge = "D" in values and at_once and state.control is SINUMERIK
        edge = values["D"].text if by_edge else state.edge
        if offset != state.offset and state.offset is not None:
            state.note(
                f"offsets {state.offset} and {offset}: both count from the zero of the same stock"
            )
        moved = (tool, offset, edge) != (state.tool, state.offset, state.edge)
        if moved and (at_once or offset != state.offset):
            state.forget()
            if state.lathe:
                state.place["y"] = 0.0
        state.tool, state.offset, state.edge = tool, offset, edge

    def _once(self, codes: Mapping[str, Word], values: Values, block: ProgramBlock) -> bool:
        """Carry out what holds for its block alone; return whether the block is done."""
        if codes.keys() & MACHINE:
            move_in_machine(self.state, codes, values, block)
            return True
        if "G10" in codes or "G11" in codes:
            self.state.note("offsets that G10 sets count as those of the setup")
            return True
        if codes.keys() & {"G92.1", "G92.2", "G92.3", "G50.3"}:
            self.state.shift = dict.fromkeys(AXES, 0.0)
            self.state.forget()
            self.state.place["y"] = 0.0 if self.state.lathe else None
            return True
        mills = next(iter(codes.keys() & _OF_MILLS), None)
        if mills is not None:
            if mills == "G68":
                turn_plane(self.state, values, block)
            elif mills in TILTS:
                tilt_by_word(self.state, mills, values, block)
            else:
                mill_pocket(self, mills, values, block)
            return True
        setting = next((code for code in ("G50", "G92", "G52") if code in codes), None)
        names = codes.keys() & FRAMES
        if setting is not None and not (setting == "G92" and "G92" in self._cycles):
            set_place(self.state, setting, values, block)
            return True
        if names:
            shift_frame(self.state, names, values, block)
        return bool(names)


_SIDES = ("G41", "G42", "G41.1", "G42.1")
_OF_MILLS = frozenset({"G68"}) | POCKETS | TILTS
"""Words that mills have, and that mean something else, or nothing, elsewhere."""
_PARTS = ("", ".1", ".2", ".3", ".4")


def _boxes(control: Control) -> frozenset[str]:
    """Return what a control's cycles of one pass are called: as in system A, or apart."""
    if control in (FANUC_B, FANUC_C):
        return frozenset(f"{code} " for code in BOXES)
    return BOXES if control is FANUC_A else frozenset()
