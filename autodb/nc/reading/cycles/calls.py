"""Cycles of Sinumerik, called by name with arguments, once or at every place (MCALL)."""

from collections.abc import Callable, Mapping
from math import cos, radians, sin

from autodb.nc.reading.cycles import drilling, recessing, roughing, stock_removal, threading
from autodb.nc.reading.cycles.cycle_moves import Carrying, rapid_to
from autodb.nc.reading.cycles.sinumerik_pockets import POCKETS, mill_sinumerik_pocket
from autodb.nc.reading.cycles.sinumerik_slots import SLOTS, mill_sinumerik_slots
from autodb.nc.reading.lines.blocks import ProgramBlock, Word
from autodb.nc.reading.lines.names import CALLS
from autodb.nc.reading.planes import swivel

_DRILLS = frozenset({"CYCLE840"} | {f"CYCLE8{n}" for n in range(1, 10)})
_REMEDY = "this cycle is not read; write out its moves as G0, G1, G2 and G3"
Numbers = tuple[float | None, ...]
_MILLED = {
    **dict.fromkeys(POCKETS, mill_sinumerik_pocket),
    **dict.fromkeys(SLOTS, mill_sinumerik_slots),
}


def call_cycles(m: Carrying, codes: Mapping[str, Word], block: ProgramBlock) -> None:
    """Carry out the cycles that a block calls; after its place, where one is in force."""
    names = [name for name in codes if name in CALLS]
    if "MCALL" in names:
        names.remove("MCALL")
        m.state.cycle = None
        if names and names[0] in _PATTERNS:
            raise block.refusal(
                "MCALL", f"{names[0]} is a row of places, no cycle; call a cycle, then {names[0]}"
            )
        if names:
            m.modal_call = (names[0], codes[names[0]])
            return
        m.modal_call = None
    for name in names:
        _carry_out(m, name, codes[name], block)


def at_place(m: Carrying, block: ProgramBlock) -> None:
    """Carry out the cycle that is in force at every place."""
    if m.modal_call is not None:
        name, word = m.modal_call
        _carry_out(m, name, word, block)


def _carry_out(m: Carrying, name: str, word: Word, block: ProgramBlock) -> None:
    numbers = tuple(one if isinstance(one, float) else None for one in word.arguments)
    texts = [one for one in word.arguments if isinstance(one, str)]
    if name in _DRILLS:
        drilling.sinumerik(m, name, numbers, block)
    elif name == "CYCLE93":
        recessing.cycle93(m, block, numbers)
    elif name == "CYCLE97":
        threading.cycle97(m, block, numbers)
    elif name == "CYCLE95" and texts:
        roughing.cycle95(m, block, texts[0], numbers[1:])
    elif name == "CYCLE62":
        stock_removal.call_contour(m, word, block)
    elif name == "CYCLE952":
        stock_removal.cycle952(m, word, block)
    elif name in _MILLED:
        _MILLED[name](m, name, numbers, block)
    elif name == "CYCLE800":
        swivel(m.state, numbers, name, block)
    elif name in _PATTERNS:
        for x, y in _PATTERNS[name](numbers, name, block):
            rapid_to(m, block, x=x + m.state.shift["x"], y=y + m.state.shift["y"])
            at_place(m, block)
    else:
        raise block.refusal(name, _REMEDY)


def _row(numbers: Numbers, name: str, block: ProgramBlock) -> list[tuple[float, float]]:
    """Return the holes of HOLES1(SPCA, SPCO, STA1, FDIS, DBH, NUM)."""
    x, y, turn, first, apart, count = _six(numbers, name, block)
    along = (cos(radians(turn)), sin(radians(turn)))
    ways = [first + apart * k for k in range(int(count))]
    return [(x + way * along[0], y + way * along[1]) for way in ways]


def _ring(numbers: Numbers, name: str, block: ProgramBlock) -> list[tuple[float, float]]:
    """Return the holes of HOLES2(CPA, CPO, RAD, STA1, INDA, NUM)."""
    x, y, radius, first, step, count = _six(numbers, name, block)
    step = step or 360.0 / max(count, 1.0)
    angles = [radians(first + step * k) for k in range(int(count))]
    return [(x + radius * cos(a), y + radius * sin(a)) for a in angles]


def _grid(numbers: Numbers, name: str, block: ProgramBlock) -> list[tuple[float, float]]:
    """Return the holes of CYCLE801(SPCA, SPCO, STA, DIS1, DIS2, NUM1, NUM2), of a frame if VARI."""
    x, y, turn, apart, between, columns = _six(numbers, name, block)
    more = [one or 0.0 for one in numbers[6:8]] + [0.0, 0.0]
    rows, frame = int(more[0]), bool(more[1])
    c, s = cos(radians(turn)), sin(radians(turn))
    return [
        (x + c * apart * k - s * between * n, y + s * apart * k + c * between * n)
        for n in range(rows)
        for k in range(int(columns))
        if not frame or n in (0, rows - 1) or k in (0, int(columns) - 1)
    ]


def _six(numbers: Numbers, name: str, block: ProgramBlock) -> tuple[float, ...]:
    if len(numbers) < 6:
        raise block.refusal(name, "six numbers are needed; state place, angle, distances and count")
    return tuple(one or 0.0 for one in numbers[:6])


_PATTERNS: dict[str, Callable[[Numbers, str, ProgramBlock], list[tuple[float, float]]]] = {
    "HOLES1": _row,
    "HOLES2": _ring,
    "CYCLE801": _grid,
}
