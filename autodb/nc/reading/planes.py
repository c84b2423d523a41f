"""Planes that a mill tilts and that stand while it cuts: the one that a job names by its line.

A plane is known by what the program says of it, not worked out: coordinates in it are its own, and
a job states the block as it is seen there. Calls that say the same tilt the same plane.
"""

from collections.abc import Mapping

from autodb.nc.reading.lines.blocks import ProgramBlock, Word
from autodb.nc.reading.rotary import stands_as_stated
from autodb.nc.reading.state import ProgramState, Tilt, word_value
from autodb.nc.reading.travels import PackedMoves, ProgramMove

TILTS = frozenset({"G68.2", "G53.1", "G53.6"})
"""Fanuc's words of a tilted plane: G68.2 says it, the others turn the machine's axes to it."""
_LETTERS = "XYZIJKPQR"
_BY_POINTS = (2.0, 3.0)
"""P of a G68.2 that says a plane by points or vectors, in several blocks."""
_TILTED = (
    "this tilts the plane; state the number of this line as plane in the job to look at what is "
    "cut in it, with block_mm as the block is seen there, or plane = 0 at what is cut upright"
)
_SWIVELS = (
    "this swivels or shifts the plane; only X, Y and Z of one position are read: give what is cut "
    "in each as a program of its own"
)


class KeptMoves:
    """The moves that a job looks at: at its angles of rotary axes, and in its plane."""

    def __init__(self, state: ProgramState) -> None:
        self.state = state
        self.all = PackedMoves()
        self.tilted: dict[Tilt, PackedMoves] = {}
        plain = state.angles is None and state.looks_at is None
        self.keep = self.all.append if plain else self._keep_as_stated

    def _keep_as_stated(self, move: ProgramMove) -> None:
        """Keep a move where the rotary axes stand as the job states, by its plane."""
        state = self.state
        if not stands_as_stated(state):
            state.note(
                "what is cut at other angles of the rotary axes, or while they turn, is left out"
            )
        elif not state.tilt:
            self.all.append(move)
        else:
            self.tilted.setdefault(state.tilt, PackedMoves()).append(move)

    def looked_at(self) -> PackedMoves:
        """Return the moves in the plane that the job names, those of no tilt where it names none.

        What is cut in others is left out, with a note.
        """
        state = self.state
        if not state.looks_at:
            found, others = self.all, bool(self.tilted)
        else:
            tilt = state.tilted_in.get(state.looks_at, ())
            found = self.tilted.pop(tilt, PackedMoves())
            others = bool(self.tilted) or len(self.all) > 0
        if others:
            state.note(
                f"what is cut in other planes than that of line {state.looks_at} is left out"
                if state.looks_at
                else "what is cut in planes that are tilted is left out"
            )
        return found


def why_nothing(state: ProgramState) -> str:
    """Return why nothing of a program is looked at, and what would be."""
    if state.looks_at and state.looks_at not in state.tilted_in:
        if not state.tilted_in:
            return "no line of this program tilts the plane; leave plane out of the job"
        lines = ", ".join(str(line) for line in list(state.tilted_in)[:9])
        return f"line {state.looks_at} tilts no plane; state plane as one of the lines {lines}"
    if state.looks_at is not None:
        return "nothing is cut in this plane; state another"
    if state.angles is not None:
        return "nothing is cut at these angles; state others"
    return "no cutting move; use a program with G1, G2 or G3"


def swivel(
    state: ProgramState, numbers: tuple[float | None, ...], name: str, block: ProgramBlock
) -> None:
    """Tilt the plane by CYCLE800(_FR, _TC, _ST, _MODE, _X0 … _Z0, _A, _B, _C, _X1 … _Z1, …).

    It begins anew, or adds to the plane before where the last digit of _ST is 1.
    """
    if state.lathe and any(numbers[4:13]):
        raise block.refusal(name, _SWIVELS)
    adds = len(numbers) > 2 and int(numbers[2] or 0.0) % 10 == 1
    said = numbers[3:13] if any(numbers[4:13]) else ()
    _tilt(state, tuple(one or 0.0 for one in said), name, block, adds=adds)


def tilt_by_word(
    state: ProgramState, code: str, values: Mapping[str, Word], block: ProgramBlock
) -> None:
    """Tilt the plane by G68.2; G53.1 turns the axes to it, so that places are not known."""
    if code != "G68.2":
        state.forget()
        return
    said = tuple(word_value(values[n]) if n in values else 0.0 for n in _LETTERS)
    by_points = "P" in values and word_value(values["P"]) in _BY_POINTS
    _tilt(state, said if any(said) else (), code, block, adds=by_points)


def _tilt(
    state: ProgramState, said: tuple[float, ...], name: str, block: ProgramBlock, *, adds: bool
) -> None:
    """Let a plane be in force; refused where it is tilted and the job names none."""
    tilt = (*(state.tilt if adds else ()), *((said,) if said else ()))
    if tilt and state.looks_at is None:
        raise block.refusal(name, _TILTED)
    if tilt:
        state.tilted_in.setdefault(block.line, tilt)
    if tilt != state.tilt:
        state.forget()
    state.tilt = tilt
