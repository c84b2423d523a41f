"""Contours that are called apart from what cuts them (CYCLE62), and turned by CYCLE952.

Names and order of CYCLE952's 34 arguments: Siemens, SINUMERIK 840D sl, NC Programming, 06/2019,
section 3.25.1.44, as public lists of them give it. What the digits of _VARI, _GMODE, _DMODE and
_AMODE mean is not told there: a job states what a call does. Depths and allowances are those of a
radius: the operating manual (Turning, 06/2019, 10.3) marks diameters, and these are none.
"""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from autodb.nc.reading.cycles.contours import Array, chain
from autodb.nc.reading.cycles.cycle_moves import CLEAR_MM, Carrying
from autodb.nc.reading.cycles.roughing import (
    AXES_OF,
    INDEX_OF,
    Passes,
    contour_as_cut,
    contour_of,
    rough_and_finish,
)
from autodb.nc.reading.cycles.stated import StatedTurning
from autodb.nc.reading.lines.blocks import ProgramBlock, Word
from autodb.nc.reading.runner import NO_SUBPROGRAM
from autodb.nc.reading.state import CalledContour

_NAMES = (
    "_PRG", "_CON", "_CONR", "_VARI", "_F", "_FR", "_RP", "_D", "_DX", "_DZ", "_UX", "_UZ", "_U",
    "_U1", "_BL", "_XD", "_ZD", "_XA", "_ZA", "_XB", "_ZB", "_XDA", "_XDB", "_N", "_DP", "_DI",
    "_SC", "_DN", "_GMODE", "_DMODE", "_AMODE", "_PK", "_DCH", "_FS",
)  # fmt: skip
_WRITE_OUT = "write out its moves as G0, G1, G2 and G3"
_MOST_CONTOURS = 2
"""Contours that CYCLE952 takes: that of the blank, and the finished one behind it."""


def call_contour(m: Carrying, word: Word, block: ProgramBlock) -> None:
    """Keep the contour that CYCLE62(KNAME, TYPE, LAB1, LAB2) calls.

    Types: 0 a subprogram, 1 a name (labels E_LAB_A_… and E_LAB_E_… of the program that runs),
    2 two labels of it, 3 two labels of a subprogram.
    """
    name, kind, first, last = [*word.arguments, *([None] * 4)][:4]
    texts = [one if isinstance(one, str) and one else None for one in (name, first, last)]
    unit, begin, end = texts
    given = (unit is not None, begin is not None and end is not None)
    needs = _NEEDED.get(float(kind) if isinstance(kind, float) else 0.0)
    if needs is None or given != needs:
        raise block.refusal(
            "CYCLE62",
            'this calls no contour; use ("NAME",0) for a subprogram, ("NAME",1) for a contour\'s '
            'name, (,2,"FIRST","LAST") for labels, ("NAME",3,"FIRST","LAST") for those of a '
            "subprogram",
        )
    if kind == 1.0:
        called = CalledContour(None, f"E_LAB_A_{unit}", f"E_LAB_E_{unit}")
    else:
        called = CalledContour(unit, begin, end)
    m.state.contours = (*m.state.contours, called)
    if called.unit is not None and not m.runner.has(called.unit):
        raise block.refusal(called.unit, NO_SUBPROGRAM)


_NEEDED = {0.0: (True, False), 1.0: (True, False), 2.0: (False, True), 3.0: (True, True)}
"""Whether each type of CYCLE62 has a name, and labels."""


class _Call(NamedTuple):
    """A call of CYCLE952: its texts and numbers by name, lengths and feeds in mm."""

    texts: Mapping[str, str]
    numbers: Mapping[str, float]
    unit_mm: float

    def mm(self, name: str) -> float:
        """Return a length, or a feed, 0 where it is left out."""
        return self.numbers.get(name, 0.0) * self.unit_mm


def cycle952(m: Carrying, word: Word, block: ProgramBlock) -> None:
    """Turn the contour that was called last, in passes along or across, once along it, or both."""
    contours, m.state.contours = m.state.contours, ()
    if not 1 <= len(contours) <= _MOST_CONTOURS:
        raise block.refusal(
            "CYCLE952", "the contour is missing; call it by CYCLE62, behind that of the blank"
        )
    call = _said(word, m.state.unit_mm, block)
    how = m.stated.turning_of(block.line)
    kind = m.stated.kind_of(m.state.tool)
    _refuse_other_ways(call, kind, block)
    if how is None:
        raise block.refusal(
            "CYCLE952",
            f"no public text says what _VARI {call.numbers.get('_VARI', 0.0):.0f} does; state cut "
            f"and passes in [program.cycle952.{block.line}] of the job",
        )
    _refuse_unread(call, how, kind, block)
    _turn(m, block, call, how, contours[-1], inside=kind == "boring")


def _said(word: Word, unit_mm: float, block: ProgramBlock) -> _Call:
    """Return a call's arguments by their names."""
    if len(word.arguments) > len(_NAMES):
        raise block.refusal("CYCLE952", f"this has more than {len(_NAMES)} arguments; use as many")
    named = dict(zip(_NAMES, word.arguments, strict=False))
    texts = {name: one for name, one in named.items() if isinstance(one, str) and one}
    return _Call(texts, {n: one for n, one in named.items() if isinstance(one, float)}, unit_mm)


def _refuse_other_ways(call: _Call, kind: str, block: ProgramBlock) -> None:
    """Raise UnusableInput for what is told without digits: residual stock, grooves, two tools."""
    if "_CON" in call.texts:
        why = f"residual stock of {call.texts['_CON']}, a blank that the control alone has"
    elif kind not in ("outside", "boring"):
        why = f"a tool of kind '{kind}' removes no stock along a contour here"
    elif call.numbers.get("_N", 0.0) > 1 or call.mm("_DP"):
        why = "several grooves (_N, _DP) are not read"
    elif any(call.mm(name) for name in ("_XA", "_ZA", "_XB", "_ZB")):
        why = "limits of the machined area (_XA to _ZB) are not read"
    elif call.mm("_DCH"):
        why = "cutting by two channels (_DCH) is not read"
    else:
        return
    raise block.refusal("CYCLE952", f"{why}; {_WRITE_OUT}")


def _refuse_unread(call: _Call, how: StatedTurning, kind: str, block: ProgramBlock) -> None:
    """Raise UnusableInput for what is missing of a call, or stands in the way of reading it."""
    if how.across and kind == "boring":
        raise block.refusal("CYCLE952", f"facing inside a bore is not read; {_WRITE_OUT}")
    if how.roughs and call.mm("_D") <= 0:
        raise block.refusal("CYCLE952", "the depth of a pass is missing; state _D")
    if how.finishes and call.mm("_U1"):
        raise block.refusal(
            "CYCLE952", f"an allowance for a second finishing cut (_U1) is not read; {_WRITE_OUT}"
        )
    allowed = [call.mm(name) for name in ("_UX", "_UZ", "_U")]
    if how.roughs and any(allowed) and how.by_axes is None:
        raise block.refusal(
            "CYCLE952",
            "no public text says which of _UX, _UZ and _U count; state allowance in "
            f"[program.cycle952.{block.line}] of the job",
        )


def _turn(
    m: Carrying,
    block: ProgramBlock,
    call: _Call,
    how: StatedTurning,
    contour: CalledContour,
    *,
    inside: bool,
) -> None:
    """Cut a contour; passes begin where the stock does that the job states."""
    along, across = AXES_OF["G72" if how.across else "G71"]
    moves = contour_of(m, _blocks(m, contour, block), block)
    places = contour_as_cut(chain(moves, along=INDEX_OF[along], across=INDEX_OF[across]))
    side = -1.0 if inside else 1.0
    over = (call.mm("_UZ"), side * call.mm("_UX")) if how.by_axes else (0.0, 0.0)
    clear = call.mm("_SC") or CLEAR_MM
    first, edge = _reach(m, places, across=how.across, inside=inside)
    at = (first + clear, edge + side * clear)
    passes = Passes(
        along, across, call.mm("_D"), CLEAR_MM, over[::-1] if how.across else over,
        0.0 if how.by_axes else call.mm("_U"), (at[0], edge),
    )  # fmt: skip
    finishing = call.mm("_FS") if how.roughs else call.mm("_F")
    feeds = (call.mm("_F") if how.roughs else None, finishing if how.finishes else None)
    m.state.note(
        "CYCLE952 cuts as the job states, in passes from the job's stock on, whatever blank it says"
    )
    rough_and_finish(m, block, places, passes, at=at, feeds=feeds)


def _reach(m: Carrying, places: Array, *, across: bool, inside: bool) -> tuple[float, float]:
    """Return where passes begin along the cut, and the level above the first one, mm."""
    first, edges = float(places[:, 0].max()), places[:, 1]
    edge, stock = float(edges.min() if inside else edges.max()), m.stated.stock
    if stock is None:
        return first, edge
    if across:
        return max(first, stock.outer_mm), max(edge, stock.face_mm)
    level = min(edge, stock.bore_mm) if inside else max(edge, stock.outer_mm)
    return max(first, stock.face_mm), level


def _blocks(m: Carrying, called: CalledContour, block: ProgramBlock) -> Iterable[ProgramBlock]:
    """Return the blocks of a contour that was called."""
    if called.first is not None and called.last is not None:
        return m.runner.contour(called.first, called.last, block, unit=called.unit)
    assert called.unit is not None  # call_contour() refused
    return m.runner.called(called.unit, block)
