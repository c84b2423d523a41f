"""Loops, branches and subprograms of Sinumerik as instructions."""

import re
from collections.abc import Callable

from autodb.errors import UnusableInput
from autodb.nc.reading.lines.blocks import WrittenLine, numbered_lines, of_line
from autodb.nc.reading.lines.expressions import Expression, expression, expression_at
from autodb.nc.reading.lines.instructions import (
    Call,
    Instructions,
    Jump,
    JumpToLabel,
    Repeat,
    Return,
    RunLine,
)
from autodb.nc.reading.lines.names import NAMES, REFUSED_NAMES
from autodb.nc.reading.lines.sinumerik_lines import arguments_at, sinumerik_worded

_SECTION = re.compile(r"%_N_(\w+?)_(?:MPF|SPF)|%_N_(\w+)|%(?:MPF|SPF)(\w*)")
_NUMBERED = re.compile(r"[N:](\d+)\s*(.*)$", re.DOTALL)
_LABEL = re.compile(r"([A-Z_]\w+)\s*:(?!=)\s*(.*)$", re.DOTALL)
_GOTO = re.compile(r"GOTO[FBCS]?\s+(\w+)$")
_JUMPS = re.compile(r"(GOTO[FBCS]?\s+\w+)(?:\s+IF\b\s*(.+GOTO.+))?$")
"""A jump behind its condition, and the next condition of the same block with its own."""
_CALLED = re.compile(r"(?:CALL\s+\"?)?(L\d+|[A-Z_]{2}\w*)\"?\s*(?:\((.*)\))?\s*(?:P=?\s*(\d+))?$")
_OUTSIDE = re.compile(
    r"EXTCALL\s*\(?\s*\"(?:[^\"]*[/\\:])?(?:_N_)?([^\"/\\:.]+?)(?:[._][SM]PF)?\"\s*\)?$"
)
"""A program outside of the control's memory, with or without its folder and ending."""
_DECLARED = re.compile(r"DEF\s+(REAL|INT|BOOL|CHAR|STRING(?:\[\d+\])?|AXIS|FRAME)\s+(.*)$")
_BETWEEN = re.compile(r",(?![^()\[\]]*[)\]])")
_UNREAD = re.compile(r"(CASE|REPEATB?\s+\w+|SWITCH|SYNACT|WHEN|EVERY|ID=|DO\s)")
_REPEAT = re.compile(r"REPEAT(B?)\s+(\w+)(?:\s+(?!P\s*=)(\w+))?(?:\s+P\s*=\s*(.+))?$")
_CASE = re.compile(r"CASE\b\s*(.+?)\s*\bOF\b\s*(.+)$")
_OF = re.compile(r"([+-]?\d+|DEFAULT)\s+(GOTO[FBCS]?\s+\w+)\s*")
_OF_CONTROL = re.compile(r"(?:CYCLE\d+|POCKET\d|SLOT\d|LONGHOLE)$")
"""Cycles of the control, beside those that are read."""
_PARAMETER = re.compile(r"(?:REAL|INT|BOOL)\s+([A-Z_]\w*)\s*(?:=\s*(.+))?$")


class _Flow:
    """Instructions that are being written, and what is open: jumps out of it and where it began."""

    def __init__(self, source: str) -> None:
        self.out = Instructions(source)
        self.open: list[tuple[str, int, list[Jump]]] = []
        self.unit: tuple[str, int] = ("", 0)

    def place(self) -> int:
        """Return where the next instruction will stand."""
        return len(self.out.steps)

    def begin_unit(self, name: str) -> None:
        """End the unit that is open, unless nothing stands in it, and begin another one."""
        before, start = self.unit
        if before or start < self.place():
            self.out.units.setdefault(before, (start, self.place()))
        self.unit = (name, self.place())

    def close(self, line: WrittenLine, kind: str) -> tuple[int, list[Jump]]:
        """Return where what ends here began, and what leaves it."""
        if not self.open or self.open[-1][0] != kind:
            raise line.refusal(line.text[:40], "what this ends is not open; open it before")
        _, start, jumps = self.open.pop()
        return start, jumps

    def condition(self, line: WrittenLine, text: str) -> Expression:
        """Return a condition; raises UnusableInput naming the line."""
        try:
            return expression(text, packed=False)
        except UnusableInput as error:
            raise line.refusal(text[:40], str(error)) from None


def sinumerik_instructions(text: str, *, source: str) -> Instructions:
    """Return the instructions of a program of Sinumerik, with what is not read of it."""
    flow = _Flow(source)
    for line in numbered_lines(text, source=source, brackets=False):
        section = _SECTION.match(line.text)
        if section is not None:
            flow.begin_unit(section[1] or section[2] or section[3] or "")
            continue
        try:
            _line(flow, line, line.text)
        except UnusableInput as error:
            flow.out.problems.append(of_line(error, line, line.text))
    name, start = flow.unit
    flow.out.units.setdefault(name, (start, flow.place()))
    flow.out.main = next(iter(flow.out.units))
    flow.out.problems += [
        jumps[0].line.refusal(kind, "this is never closed; close it")
        for kind, _, jumps in flow.open
        if jumps
    ]
    return flow.out


def _line(flow: _Flow, line: WrittenLine, text: str) -> None:
    numbered = _NUMBERED.match(text)
    if numbered is not None:
        flow.out.label(f"N{int(numbered[1])}")
        text = numbered[2].strip()
    label = _LABEL.match(text)
    if label is not None:
        flow.out.label(label[1])
        text = label[2].strip()
        if not text:  # a place of its own: what comes next is behind it
            flow.out.steps.append(RunLine(line))
    if not text or text.startswith(("%", "EXTERN")):
        return
    word = re.match(r"[A-Z]+", text)
    rest = text[word.end() :].strip() if word is not None else ""
    if word is not None and word[0] in _FLOW and not (word[0] == "REPEAT" and rest):
        _FLOW[word[0]](flow, line, rest)
    elif _GOTO.match(text):
        flow.out.steps.append(_goto(text, line))
    elif _REPEAT.match(text):
        _repeat(flow, line, text)
    elif _CASE.match(text):
        _case(flow, line, text)
    elif _UNREAD.match(text):
        raise line.refusal(text.split()[0][:40], "this is not read; write out the blocks")
    elif text.startswith("PROC"):
        _procedure(flow, line, rest)
    else:
        _plain(flow, line, text)


def _plain(flow: _Flow, line: WrittenLine, text: str) -> None:
    declared = _DECLARED.match(text)
    if declared is not None:
        if declared[1] in ("REAL", "INT", "BOOL") or "=" in declared[2]:
            begun = _begun(declared[2])
            flow.out.steps += [RunLine(sinumerik_worded(line, begun))] if begun else []
        return
    outside = _OUTSIDE.match(text)
    if outside is not None:
        flow.out.steps.append(Call(line, outside[1], by_name=True))
        return
    called = _CALLED.match(text)
    if called is not None and called[1] not in NAMES and "=" not in text:
        if called[1] in REFUSED_NAMES:
            raise line.refusal(called[1], REFUSED_NAMES[called[1]])
        if _OF_CONTROL.match(called[1]):
            raise line.refusal(
                called[1], "this cycle is not read; write out its moves as G0, G1, G2 and G3"
            )
        times = called[3]
        number = expression(times, packed=False) if times else None
        arguments = arguments_at(f"{called[2]})", 0)[0] if (called[2] or "").strip() else ()
        numbers = tuple(None if isinstance(one, str) else one for one in arguments)
        texts = any(isinstance(one, str) for one in arguments)
        flow.out.steps.append(
            Call(line, called[1], numbers, times=number, by_name=True, texts=texts)
        )
        return
    flow.out.steps.append(RunLine(sinumerik_worded(line, text)))


def _begun(names: str) -> str:
    """Return variables that are declared with what each begins with: 0 where nothing is said."""
    each = (one.strip() for one in _BETWEEN.split(names))
    plain = (one for one in each if one and ("=" in one or "[" not in one))
    return ",".join(one if "=" in one else f"{one}=0" for one in plain)


def _procedure(flow: _Flow, line: WrittenLine, rest: str) -> None:
    name = re.match(r"\w+", rest)
    if name is None:
        return
    given = re.match(r"\s*\((.*)\)", rest[name.end() :])
    named = []
    for one in given[1].split(",") if given is not None and given[1].strip() else ():
        found = _PARAMETER.match(one.strip())
        if found is None:
            raise line.refusal(one.strip()[:40], "use parameters that are numbers, without VAR")
        named.append((found[1], expression(found[2], packed=False) if found[2] else None))
    flow.out.parameters[name[0]] = tuple(named)
    if flow.unit[1] == flow.place():
        flow.out.units.setdefault(name[0], (flow.place(), flow.place()))
        flow.out.units.pop(name[0])
    flow.begin_unit(name[0])


def _goto(text: str, line: WrittenLine) -> JumpToLabel:
    found = _GOTO.match(text)
    assert found is not None  # asked before
    return JumpToLabel(line, _label(found[1]), back=text.startswith("GOTOB"))


def _label(name: str) -> str:
    """Return a label as it is kept, a number of a block without zeros that say nothing."""
    return f"N{int(name[1:])}" if re.fullmatch(r"N\d+", name) else name


def _repeat(flow: _Flow, line: WrittenLine, text: str) -> None:
    found = _REPEAT.match(text)
    assert found is not None  # asked before
    block, first, last, times = found.groups()
    number = expression(times, packed=False) if times else None
    flow.out.steps.append(
        Repeat(line, _label(first), _label(last) if last else None, bool(block), number)
    )


def _case(flow: _Flow, line: WrittenLine, text: str) -> None:
    """Write CASE (…) OF 1 GOTOF A 2 GOTOF B DEFAULT GOTOF C as one jump after the other."""
    found = _CASE.match(text)
    assert found is not None  # asked before
    branches = _OF.findall(found[2])
    if not branches or _OF.sub("", found[2]).strip():
        raise line.refusal(text[:40], "use CASE (…) OF 1 GOTOF A 2 GOTOF B DEFAULT GOTOF C")
    for number, goto in branches:
        jump = _goto(goto, line)
        if number != "DEFAULT":
            jump.when = flow.condition(line, f"({found[1]}) == {number}")
        flow.out.steps.append(jump)


def _if(flow: _Flow, line: WrittenLine, rest: str) -> None:
    try:
        condition, at = expression_at(rest, 0, packed=False)
    except UnusableInput as error:
        raise line.refusal(rest[:40], str(error)) from None
    goto = rest[at:].strip()
    if goto:
        jumps = _JUMPS.match(goto)
        if jumps is None:
            raise line.refusal(goto[:40], "this does not jump; write IF condition GOTOF label")
        jump = _goto(jumps[1], line)
        jump.when = condition
        flow.out.steps.append(jump)
        if jumps[2]:
            _if(flow, line, jumps[2])
        return
    over = Jump(line, when=condition, holds=False)
    flow.out.steps.append(over)
    flow.open.append(("IF", flow.place(), [over]))


def _else(flow: _Flow, line: WrittenLine, _rest: str) -> None:
    start, jumps = flow.close(line, "IF")
    out = Jump(line)
    flow.out.steps.append(out)
    jumps.pop().to = flow.place()
    flow.open.append(("IF", start, [out]))


def _end_if(flow: _Flow, line: WrittenLine, _rest: str) -> None:
    for jump in flow.close(line, "IF")[1]:
        jump.to = flow.place()


def _while(flow: _Flow, line: WrittenLine, rest: str) -> None:
    start = flow.place()
    over = Jump(line, when=flow.condition(line, rest), holds=False)
    flow.out.steps.append(over)
    flow.open.append(("WHILE", start, [over]))


def _for(flow: _Flow, line: WrittenLine, rest: str) -> None:
    setting, _, last = rest.partition(" TO ")
    name = setting.split("=")[0].strip()
    if not last or "=" not in setting:
        raise line.refusal(rest[:40], "this is no loop; write FOR R1=1 TO 10")
    flow.out.steps.append(RunLine(sinumerik_worded(line, setting)))
    start = flow.place()
    over = Jump(line, when=flow.condition(line, f"{name} <= ({last})"), holds=False)
    flow.out.steps.append(over)
    flow.open.append((f"FOR {name}", start, [over]))


def _end_for(flow: _Flow, line: WrittenLine, _rest: str) -> None:
    kind = flow.open[-1][0] if flow.open else ""
    start, jumps = flow.close(line, kind if kind.startswith("FOR ") else "FOR")
    name = kind.removeprefix("FOR ")
    flow.out.steps += [RunLine(sinumerik_worded(line, f"{name}={name}+1")), Jump(line, to=start)]
    jumps[0].to = flow.place()


def _loop(kind: str) -> Callable[[_Flow, WrittenLine, str], None]:
    def begins(flow: _Flow, _line: WrittenLine, _rest: str) -> None:
        flow.open.append((kind, flow.place(), []))

    return begins


def _ends(kind: str) -> Callable[[_Flow, WrittenLine, str], None]:
    def ends(flow: _Flow, line: WrittenLine, _rest: str) -> None:
        start, jumps = flow.close(line, kind)
        flow.out.steps.append(Jump(line, to=start))
        for jump in jumps:
            jump.to = flow.place()

    return ends


def _until(flow: _Flow, line: WrittenLine, rest: str) -> None:
    start, _ = flow.close(line, "REPEAT")
    flow.out.steps.append(Jump(line, to=start, when=flow.condition(line, rest), holds=False))


def _return(flow: _Flow, line: WrittenLine, _rest: str) -> None:
    flow.out.steps.append(Return(line))


_FLOW = {
    "IF": _if, "ELSE": _else, "ENDIF": _end_if, "WHILE": _while, "ENDWHILE": _ends("WHILE"),
    "FOR": _for, "ENDFOR": _end_for, "LOOP": _loop("LOOP"), "ENDLOOP": _ends("LOOP"),
    "REPEAT": _loop("REPEAT"), "UNTIL": _until, "RET": _return,
}  # fmt: skip
