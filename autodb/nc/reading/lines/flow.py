"""Loops, branches, subprograms and macros of Fanuc, Haas and LinuxCNC as instructions."""

import re
from collections.abc import Callable

from autodb.errors import UnusableInput
from autodb.nc.reading.lines.blocks import WrittenLine, numbered_lines, of_line, worded
from autodb.nc.reading.lines.expressions import Expression, expression, expression_at
from autodb.nc.reading.lines.foreign import okuma_plain
from autodb.nc.reading.lines.instructions import (
    Call,
    Count,
    Instructions,
    Jump,
    JumpToLabel,
    Return,
    RunLine,
)

_NUMBERED = re.compile(r"(?:N(\d+)|N(?=[A-Z]|$))?(.*)$", re.DOTALL)
_O_WORD = re.compile(
    r"O(<[^>]*>|\d+)(SUB|ENDSUB|CALL|RETURN|IF|ELSEIF|ELSE|ENDIF|WHILE|ENDWHILE|DO|REPEAT"
    r"|ENDREPEAT|BREAK|CONTINUE)(.*)$"
)
_PROGRAM = re.compile(r"[O:](\d+)(?!\d)(.*)$")
_NAMED = re.compile(r"O[A-Z]\w*|<[\w.+-]+>")
"""A program's name in place of its number (Fanuc's 30i; posts of Okuma)."""
_GOTO = re.compile(r"GOTO(.+)$")
_WHILE = re.compile(r"(?:WH(?:ILE)?(\[.*\]))?DO(\d)$")
_END = re.compile(r"END(\d)$")
_ENDED = re.compile(r"M0*(?:2|30|99)(?!\d)")
"""What ends a program or a subprogram: an O number behind it begins the next."""
_OVER = re.compile(r"M0*(?:2|30)(?!\d)")
"""What ends a program of LinuxCNC: lines behind it that no subprogram has are never run."""
_PRINTS = re.compile(r"[BD]PRNT\[|POPEN|PCLOS")
"""Macro words that print to a port."""


class _Reader:
    """Instructions that are being written, and the structures that are still open.

    ``ended``: the line before ends a program or a subprogram; ``over``: the main program has ended.
    """

    def __init__(self, source: str) -> None:
        self.out = Instructions(source)
        self.open: dict[str, list[Jump]] = {}
        self.starts: dict[str, int] = {}
        self.unit: tuple[str, int] = ("", 0)
        self.programs: list[str] = []
        self.ended = False
        self.over = False

    def within(self) -> bool:
        """Return whether a subprogram, a branch or a loop is open."""
        return any(self.open.values())

    def place(self) -> int:
        """Return where the next instruction will stand."""
        return len(self.out.steps)

    def begin_program(self, name: str) -> None:
        """End what stands before a subprogram of LinuxCNC's M98; the first is the main program."""
        before, start = self.unit
        self.out.units.setdefault(before, (start, self.place()))
        self.programs.append(before)
        self.unit = (name, self.place())

    def close_unit(self, name: str) -> None:
        """End the unit that is open and begin another one."""
        before, start = self.unit
        if before:
            self.out.units.setdefault(before, (start, self.place()))
            start = self.place()
        self.unit = (name, start)


def fanuc_instructions(text: str, *, source: str) -> Instructions:
    """Return the instructions of a program of Fanuc or Haas, with what is not read of it."""
    reader = _Reader(source)
    return _instructions(reader, text, _fanuc_line)


def linuxcnc_instructions(text: str, *, source: str) -> Instructions:
    """Return the instructions of a program of LinuxCNC, with what is not read of it."""
    reader = _Reader(source)
    return _instructions(reader, text, _linuxcnc_line)


def okuma_instructions(text: str, *, source: str) -> Instructions:
    """Return the instructions of a program of Okuma's OSP; its own language is refused at once."""
    plain, refused = okuma_plain(text, source=source)
    out = fanuc_instructions(plain, source=source)
    out.problems += [] if refused is None else [refused]
    return out


def _instructions(
    reader: _Reader, text: str, read: Callable[[_Reader, WrittenLine, str], None]
) -> Instructions:
    for line in numbered_lines(text, source=reader.out.source, brackets=True):
        plain = re.sub(r"\s", "", line.text)
        if plain.startswith("%"):
            continue
        plain = plain.rstrip("%")
        found = _NUMBERED.match(plain)
        assert found is not None  # every text matches
        if found[1]:
            reader.out.label(f"N{int(found[1])}")
        try:
            read(reader, line, found[2])
        except UnusableInput as error:
            reader.out.problems.append(of_line(error, line, plain))
    out, (name, start) = reader.out, reader.unit
    out.units.setdefault(name, (start, reader.place()))
    out.main = next((one for one in out.units if one in reader.programs), name)
    for jumps in reader.open.values():
        for jump in jumps:
            if jump.to < 0:
                out.problems.append(jump.line.refusal(jump.line.text[:40], "this is never closed"))
    return out


def _condition(line: WrittenLine, text: str) -> Expression:
    try:
        return expression(text, packed=True)
    except UnusableInput as error:
        raise line.refusal(text[:40], str(error)) from None


def _fanuc_line(reader: _Reader, line: WrittenLine, plain: str) -> None:
    steps = reader.out.steps
    program = _PROGRAM.match(plain)
    if program is not None and (plain[0] == "O" or not program[2]):
        reader.close_unit(f"{int(program[1])}")
        reader.programs.append(reader.unit[0])
        plain = program[2]
    named = not steps and _NAMED.fullmatch(plain) is not None
    if named or plain in ("", ":") or _PRINTS.match(plain):
        return
    if plain.startswith("IF"):
        _fanuc_if(reader, line, plain)
        return
    goto, loop, end = _GOTO.match(plain), _WHILE.match(plain), _END.match(plain)
    if goto is not None:
        steps.append(_to_label(line, goto[1]))
    elif loop is not None:
        reader.starts[loop[2]] = reader.place()
        condition = _condition(line, loop[1]) if loop[1] else None
        jump = Jump(line, when=condition, holds=False)
        reader.open.setdefault(loop[2], []).append(jump)
        if condition is not None:
            steps.append(jump)
    elif end is not None:
        if not reader.open.get(end[1]):
            raise line.refusal(plain, "no DO of this number is open; write WHILE [ … ] DO before")
        steps.append(Jump(line, to=reader.starts[end[1]]))
        reader.open[end[1]].pop().to = reader.place()
    else:
        steps.append(RunLine(worded(line, plain)))


def _fanuc_if(reader: _Reader, line: WrittenLine, plain: str) -> None:
    try:
        condition, at = expression_at(plain, 2, packed=True)
    except UnusableInput as error:
        raise line.refusal(plain[:40], str(error)) from None
    rest = plain[at:]
    goto = _GOTO.match(rest)
    if goto is not None:
        jump = _to_label(line, goto[1])
        jump.when = condition
        reader.out.steps.append(jump)
        return
    over = Jump(line, when=condition, holds=False)
    reader.out.steps += [over, RunLine(worded(line, rest.removeprefix("THEN")))]
    over.to = reader.place()


def _to_label(line: WrittenLine, text: str) -> JumpToLabel:
    if text.isdigit():
        return JumpToLabel(line, f"N{int(text)}")
    return JumpToLabel(line, _condition(line, text))


def _linuxcnc_line(reader: _Reader, line: WrittenLine, plain: str) -> None:
    found = _O_WORD.match(plain)
    ended, reader.ended = reader.ended, _ENDED.search(plain) is not None
    if found is None:
        program = re.fullmatch(r"O(\d+)", plain)
        if program is not None and (ended or reader.over):
            reader.begin_program(f"{int(program[1])}")
            reader.over = False
        elif not reader.over or reader.within():
            reader.out.steps.append(RunLine(worded(line, plain)))
            reader.over |= _OVER.search(plain) is not None and not reader.within()
        return
    name = found[1].strip("<>").lower()
    name = f"{int(name)}" if name.isdigit() else name
    _O_WORDS[found[2]](reader, line, name, found[3])


def _sub(reader: _Reader, line: WrittenLine, name: str, _rest: str) -> None:
    over = Jump(line)
    reader.out.steps.append(over)
    reader.open.setdefault(f"sub {name}", []).append(over)
    reader.starts[f"sub {name}"] = reader.place()


def _end_sub(reader: _Reader, line: WrittenLine, name: str, rest: str) -> None:
    jump = _opened(reader, line, f"sub {name}")
    reader.out.steps.append(Return(line, _condition(line, rest) if rest else None))
    reader.out.units[name] = (reader.starts[f"sub {name}"], reader.place())
    jump.to = reader.place()


def _opened(reader: _Reader, line: WrittenLine, key: str) -> Jump:
    if not reader.open.get(key):
        raise line.refusal(line.text[:40], "what this ends is not open; open it before")
    return reader.open[key].pop()


def _call(reader: _Reader, line: WrittenLine, name: str, rest: str) -> None:
    arguments = []
    while rest:
        value, at = expression_at(rest, 0, packed=True)
        arguments.append(value)
        rest = rest[at:]
    reader.out.steps.append(Call(line, name, tuple(arguments)))


def _return(reader: _Reader, line: WrittenLine, _name: str, rest: str) -> None:
    reader.out.steps.append(Return(line, _condition(line, rest) if rest else None))


def _if(reader: _Reader, line: WrittenLine, name: str, rest: str) -> None:
    jump = Jump(line, when=_condition(line, rest), holds=False)
    reader.out.steps.append(jump)
    reader.open.setdefault(f"if {name}", []).append(jump)
    reader.open.setdefault(f"end {name}", [])


def _else_if(reader: _Reader, line: WrittenLine, name: str, rest: str) -> None:
    _else(reader, line, name, rest)
    _if(reader, line, name, rest)


def _else(reader: _Reader, line: WrittenLine, name: str, _rest: str) -> None:
    before = _opened(reader, line, f"if {name}")
    out = Jump(line)
    reader.out.steps.append(out)
    reader.open[f"end {name}"].append(out)
    before.to = reader.place()


def _end_if(reader: _Reader, _line: WrittenLine, name: str, _rest: str) -> None:
    if reader.open.get(f"if {name}"):
        reader.open[f"if {name}"].pop().to = reader.place()
    for jump in reader.open.pop(f"end {name}", []):
        jump.to = reader.place()


def _while(reader: _Reader, line: WrittenLine, name: str, rest: str) -> None:
    if f"do {name}" in reader.starts:  # closes DO … WHILE
        start = reader.starts.pop(f"do {name}")
        again = reader.place()
        reader.out.steps.append(Jump(line, to=start, when=_condition(line, rest)))
        _leave(reader, name, again)
        return
    reader.starts[f"loop {name}"] = reader.place()
    jump = Jump(line, when=_condition(line, rest), holds=False)
    reader.out.steps.append(jump)
    reader.open.setdefault(f"loop {name}", []).append(jump)


def _do(reader: _Reader, _line: WrittenLine, name: str, _rest: str) -> None:
    reader.starts[f"do {name}"] = reader.place()


def _repeat(reader: _Reader, line: WrittenLine, name: str, rest: str) -> None:
    counter = f"repeat {name}"
    reader.out.steps.append(Count(line, counter, _condition(line, rest)))
    reader.starts[f"loop {name}"] = reader.place()
    jump = Jump(line, when=lambda env: float((env.value(counter) or 0.0) >= 1.0), holds=False)
    reader.out.steps += [jump, Count(line, counter, None)]
    reader.open.setdefault(f"loop {name}", []).append(jump)


def _end_loop(reader: _Reader, line: WrittenLine, name: str, _rest: str) -> None:
    _opened(reader, line, f"loop {name}").to = reader.place() + 1
    start = reader.starts[f"loop {name}"]
    reader.out.steps.append(Jump(line, to=start))
    _leave(reader, name, start)


def _leave(reader: _Reader, name: str, again: int) -> None:
    """Let what leaves a loop go behind it, and what goes on to where it is decided."""
    for jump in reader.open.pop(f"break {name}", []):
        jump.to = reader.place()
    for jump in reader.open.pop(f"continue {name}", []):
        jump.to = again


def _skips(kind: str) -> Callable[[_Reader, WrittenLine, str, str], None]:
    def skips(reader: _Reader, line: WrittenLine, name: str, _rest: str) -> None:
        jump = Jump(line)
        reader.out.steps.append(jump)
        reader.open.setdefault(f"{kind} {name}", []).append(jump)

    return skips


_O_WORDS = {
    "SUB": _sub, "ENDSUB": _end_sub, "CALL": _call, "RETURN": _return, "IF": _if,
    "ELSEIF": _else_if, "ELSE": _else, "ENDIF": _end_if, "WHILE": _while,
    "ENDWHILE": _end_loop, "DO": _do, "REPEAT": _repeat, "ENDREPEAT": _end_loop,
    "BREAK": _skips("break"), "CONTINUE": _skips("continue"),
}  # fmt: skip
