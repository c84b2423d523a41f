"""A program run: its lines in the order in which a control meets them, with their numbers.

Loops, branches, subprograms and macros are followed, variables set and read. What a cycle needs of
other lines (a contour between two N numbers, or a subprogram) is run apart.
"""

from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import dataclass, replace

from autodb.nc.reading.lines.blocks import ProgramBlock, Word, WrittenLine
from autodb.nc.reading.lines.expressions import Expression, Key, Number, Values
from autodb.nc.reading.lines.instructions import (
    Call,
    Count,
    Instruction,
    Instructions,
    Jump,
    JumpToLabel,
    Repeat,
    Return,
    RunLine,
)

MOST_BLOCKS = 2_000_000
"""Blocks that a program may run: more is a loop that does not end. Chosen: 20 times the longest
program that is to be read."""
MOST_AGAIN = 50_000
"""How often one loop may go back. Chosen: a turn in steps of a hundredth of a degree is 36 000."""
DEEPEST = 60
"""How deep calls may be nested. Chosen: controls allow 4 to 16, a recursion of examples 20."""
NO_SUBPROGRAM = (
    "there is no subprogram of this name; put it into this file, or name it in the job's left_out "
    "if it cuts nothing"
)
_MACRO = dict(zip("ABCIJKDEFHMQRSTUVWXYZ", (
    1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 13, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26,
), strict=True))  # fmt: skip
"""Local variables that the letters of a G65 set (Fanuc's first way)."""


@dataclass
class _Loop:
    """A jump that went back: how often, and what was known the last time, at which depth."""

    times: int = 0
    known: tuple[dict[Key, float], dict[Key, float], dict[Key, Number]] | None = None
    depth: int = 0


Library = Callable[[str], Instructions | None]
"""What finds a subprogram that is not in the file, by its name."""


class Runner:
    """Runs instructions; ``values`` may be read and set from outside between two blocks."""

    def __init__(
        self, instructions: Instructions, *, values: Values, block_skip: bool, library: Library
    ) -> None:
        self.instructions = instructions
        self.values = values
        self.block_skip = block_skip
        self.library = library
        self.ran = 0
        self.depth = 0
        self.ended = False
        self._skip_to: int | None = None
        self._here = -1
        self._loops: dict[int, _Loop] = {}
        self._unit = instructions.units[instructions.main]

    def blocks(self) -> Iterator[ProgramBlock]:
        """Yield the blocks of the main program and of what it calls."""
        yield from self._unit_blocks(self.instructions.main)

    def contour(
        self, first: str, last: str, at: ProgramBlock, *, unit: str | None = None
    ) -> Iterator[ProgramBlock]:
        """Yield the blocks from one label to another, both included, of a unit, or that which
        runs."""
        before, here = self._unit, self._here
        if unit is not None:
            self._find(unit, at)
            self._unit = self.instructions.units[unit]
        begin, end = self._contour_places(first, last, at)
        yield from self._run((begin, end + 1))
        self._unit, self._here = before, here

    def skip_contour(self, last: str, *, first: str | None = None) -> None:
        """Go on behind a label, where it lies ahead, and ``first``, if one is given, comes next."""
        begin = self._here + 1 if first is None else self.instructions.place_of(first, self._unit)
        place = self.instructions.place_of(last, self._unit)
        if place is not None and place > self._here and begin == self._here + 1:
            self._skip_to = place + 1

    def called(self, unit: str, at: ProgramBlock) -> Iterator[ProgramBlock]:
        """Yield the blocks of a subprogram."""
        self._find(unit, at)
        here = self._here
        yield from self._unit_blocks(unit)
        self._here = here

    def has(self, unit: str) -> bool:
        """Return whether there is a subprogram of a name, in the file or beside it."""
        if unit not in self.instructions.units:
            found = self.library(unit)
            if found is not None:
                self._add(found, unit)
        return unit in self.instructions.units

    def _find(self, unit: str, at: ProgramBlock | WrittenLine) -> None:
        if not self.has(unit):
            raise at.refusal(unit, NO_SUBPROGRAM)

    def _add(self, found: Instructions, unit: str) -> None:
        """Take the instructions of another file behind those that are there."""
        by = len(self.instructions.steps)
        for step in found.steps:
            if isinstance(step, Jump):
                step.to += by
        self.instructions.steps += found.steps
        for name, (first, end) in found.units.items():
            self.instructions.units.setdefault(name or unit, (first + by, end + by))
        self.instructions.parameters |= {
            name or unit: named for name, named in found.parameters.items()
        }
        for name, places in found.labels.items():
            self.instructions.labels.setdefault(name, []).extend(at + by for at in places)
        self.instructions.problems += found.problems

    def _contour_places(self, first: str, last: str, at: ProgramBlock) -> tuple[int, int]:
        places = [self.instructions.place_of(name, self._unit) for name in (first, last)]
        for name, place in zip((first, last), places, strict=True):
            if place is None:
                raise at.refusal(
                    name,
                    "there is no block of this number or label; give the contour's first and last "
                    "block",
                )
        begin, end = places
        assert begin is not None and end is not None
        if end < begin:
            raise at.refusal(last, f"this block stands before {first}; give first and last")
        return begin, end

    def _unit_blocks(self, unit: str) -> Iterator[ProgramBlock]:
        before, self._unit = self._unit, self.instructions.units[unit]
        self._forget_loops(*self._unit)
        yield from self._run(self._unit)
        self._unit = before

    def _run(self, span: tuple[int, int]) -> Iterator[ProgramBlock]:
        at, end = span
        steps = self.instructions.steps
        while at < end and not self.ended:
            step = steps[at]
            self._here = at
            self.ran += 1
            if self.ran > MOST_BLOCKS:
                raise step.line.refusal(
                    step.line.text[:40],
                    f"more than {MOST_BLOCKS} blocks have run; use a loop that ends",
                )
            if isinstance(step, Return):
                self._return(step)
                return
            if isinstance(step, RunLine):
                returned, where = yield from self._line(step.line)
                if returned:
                    return
                at = at + 1 if where is None else where
            elif isinstance(step, Call | Repeat):
                yield from self._call(step) if isinstance(step, Call) else self._repeat(step, at)
                at += 1
            else:
                to = self._next(step, at)
                if to <= at:
                    self._goes_back(step, at, to)
                at = to

    def _goes_back(self, step: Instruction, at: int, to: int) -> None:
        """Raise UnusableInput for a loop that never ends: nothing that it asks for changes.

        One that has gone back more often than any that is to be read is taken for one.
        """
        values = self.values
        known = dict(values.own), dict(values.shared), dict(values.heard)
        loop = self._loops.setdefault(at, _Loop())
        loop.times += 1
        if loop.known == known and loop.depth == self.depth:
            raise step.line.refusal(
                step.line.text[:40],
                "this loop never ends: no variable changes from one time to the next; change what "
                "its condition asks for, or leave the loop out",
            )
        if loop.times > MOST_AGAIN:
            raise step.line.refusal(
                step.line.text[:40],
                f"this loop has gone back {MOST_AGAIN} times; use one that ends",
            )
        loop.known, loop.depth = known, self.depth
        self._forget_loops(to, at)

    def _forget_loops(self, begin: int, end: int) -> None:
        """Let loops within a span begin anew: what is around them goes through it once more."""
        for place in [one for one in self._loops if begin <= one < end]:
            del self._loops[place]

    def _next(self, step: Instruction, at: int) -> int:
        """Return where to go on after a jump or a counter."""
        if isinstance(step, Jump):
            holds = step.when is None or bool(self._of(step.line, step.when)) == step.holds
            open_ended = len(self.instructions.steps)  # nothing closes it, which is refused
            return (step.to if step.to >= 0 else open_ended) if holds else at + 1
        if isinstance(step, Count):
            left = self.values.own.get(step.counter, 0.0) - 1.0
            to = left if step.to is None else self._of(step.line, step.to) or 0.0
            self.values.own[step.counter] = float(round(to))
            return at + 1
        assert isinstance(step, JumpToLabel)
        if step.when is not None and not self._of(step.line, step.when):
            return at + 1
        label = step.label
        if callable(label):
            label = f"N{self._of(step.line, label) or 0:.0f}"
        place = self.instructions.place_of(label, self._unit, after=at, back=step.back)
        if place is None:
            raise step.line.refusal(label, "there is no block of this label; use one that is there")
        return place

    def _of(self, line: WrittenLine, value: Expression) -> Number:
        try:
            return value(self.values)
        except (ValueError, OverflowError) as error:
            raise line.refusal(line.text[:40], str(error)) from None

    def _line(self, line: WrittenLine) -> Generator[ProgramBlock, None, tuple[bool, int | None]]:
        """RunLine a line: yield its block and set its variables.

        Returns whether it goes back to what called it, and where to go on: None is the next line.
        """
        if line.optional and self.block_skip:
            return False, None
        if line.kept is not None and self.block_skip:
            line = replace(line, words=line.words[: line.kept])
        block = line.block(self.values)
        codes = {word.code: word for word in block.words}
        words = {word.name: word for word in block.words}
        if "M98" in codes or "M97" in codes or "G65" in codes:
            yield from self._subprogram(block, codes, words)
        elif block.words:
            yield block
        for key, value in line.settings:
            self._set(line, key, value)
        if "M99" in codes:
            return self._back(block, words)
        where, self._skip_to = self._skip_to, None
        return False, where

    def _back(self, block: ProgramBlock, words: Mapping[str, Word]) -> tuple[bool, int | None]:
        """Return from a subprogram; at the end of a main program M99 begins it anew: it ends."""
        if "P" not in words:
            self.ended = self.depth == 0
            return True, None
        label = f"N{words['P'].number or 0:.0f}"
        place = self.instructions.place_of(label, self._unit)
        if place is None or self.depth > 0:
            raise block.refusal(words["P"].text, "this goes on elsewhere; use M99 alone")
        return False, place

    def _set(self, line: WrittenLine, key: Expression | Key, value: Expression) -> None:
        number = self._of(line, value)
        where = self._of(line, key) if callable(key) else key
        place: Key = int(where or 0) if isinstance(where, float) else where or 0
        if number is None:
            self.values.own.pop(place, None)
            self.values.shared.pop(place, None)
        else:
            self.values.put(place, number)

    def _subprogram(
        self, block: ProgramBlock, codes: Mapping[str, Word], words: Mapping[str, Word]
    ) -> Iterator[ProgramBlock]:
        """RunLine what M98, M97 or G65 calls."""
        if "P" not in words and ("G65" in codes or "Q" not in words):
            raise block.refusal(block.words[0].text, "this calls nothing; state the number P")
        times = words["L"].number if "L" in words else None
        again = 1.0 if times is None else times
        if "P" not in words:  # M98 Q calls a block of the same program
            for _ in range(round(again)):
                yield from self._local(f"N{words['Q'].number or 0:.0f}", block)
            return
        number = words["P"].number or 0.0
        own: dict[Key, float] = {}
        if "G65" in codes:
            own = {_MACRO[n]: w.number for n, w in words.items() if n in _MACRO and w.number}
        if "M98" in codes and times is None and number > 9999 and not self.has(f"{number:.0f}"):
            again, number = divmod(number, 10000)
        moves = tuple(word for word in block.words if word.name not in ("M", "P", "L"))
        if moves and "G65" not in codes:
            yield ProgramBlock(block.source, block.line, moves, block.optional)
        for _ in range(round(again)):
            if "M97" in codes:
                yield from self._local(f"N{number:.0f}", block)
            else:
                yield from self._deeper(f"{number:.0f}", own if "G65" in codes else None, block)

    def _local(self, label: str, block: ProgramBlock) -> Iterator[ProgramBlock]:
        place = self.instructions.place_of(label, self._unit)
        if place is None:
            raise block.refusal(label, "there is no block of this number; call one that is")
        self._go_deeper(block)
        yield from self._run((place, len(self.instructions.steps)))
        self.depth -= 1

    def _deeper(
        self, unit: str, own: dict[Key, float] | None, at: ProgramBlock | WrittenLine
    ) -> Iterator[ProgramBlock]:
        """RunLine a unit, with variables of its own where some are given."""
        self._find(unit, at)
        self._go_deeper(at)
        outer = self.values
        if own is not None:
            self.values = outer.inner(own)
        yield from self._unit_blocks(unit)
        if own is not None:
            outer.shared.update(self.values.shared)
            self.values = outer
        self.depth -= 1

    def _go_deeper(self, at: ProgramBlock | WrittenLine) -> None:
        self.depth += 1
        if self.depth > DEEPEST:
            raise at.refusal(
                "", f"calls are nested deeper than {DEEPEST}; call no program from itself"
            )

    def _call(self, step: Call) -> Iterator[ProgramBlock]:
        own = self._parameters(step)
        times = 1.0 if step.times is None else self._of(step.line, step.times) or 0.0
        for _ in range(round(times)):
            yield from self._deeper(step.unit, dict(own), step.line)

    def _parameters(self, step: Call) -> dict[Key, float]:
        """Return the variables that a call gives: by number, or by the names that the unit has."""
        given = [None if one is None else self._of(step.line, one) for one in step.arguments]
        own: dict[Key, float] = dict.fromkeys(range(1, 31), 0.0)
        if not step.by_name:
            return own | {k: one or 0.0 for k, one in enumerate(given, start=1)}
        self._find(step.unit, step.line)
        if step.texts:
            raise step.line.refusal(
                step.unit, "a text as an argument is not read; write out its blocks"
            )
        named = self.instructions.parameters.get(step.unit, ())
        if len(given) > len(named):
            raise step.line.refusal(
                step.unit, f"this takes {len(named)} arguments, and {len(given)} are given"
            )
        for k, (name, else_it_is) in enumerate(named):
            value = given[k] if k < len(given) else None
            if value is None and else_it_is is not None:
                value = self._of(step.line, else_it_is)
            own[name] = value or 0.0
        return own

    def _repeat(self, step: Repeat, here: int) -> Iterator[ProgramBlock]:
        """RunLine the blocks from a label on once more, some times: up to another, or to here."""
        names = [step.first] if step.last is None else [step.first, step.last]
        places = [self.instructions.place_of(name, self._unit) for name in names]
        for name, place in zip(names, places, strict=True):
            if place is None:
                raise step.line.refusal(name, "there is no block of this label; use one that is")
        begin, end = places[0], places[-1]
        assert begin is not None and end is not None
        span = (begin, here if step.last is None and not step.block else end + 1)
        times = 1.0 if step.times is None else self._of(step.line, step.times) or 0.0
        for _ in range(round(times)):
            self._go_deeper(step.line)
            self._forget_loops(*span)
            yield from self._run(span)
            self.depth -= 1

    def _return(self, step: Return) -> None:
        if step.value is not None:
            self.values.shared["_value"] = self._of(step.line, step.value) or 0.0
