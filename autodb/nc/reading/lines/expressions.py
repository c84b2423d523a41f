"""Expressions of programs: numbers, variables, operators and functions, in the words of controls.

Fanuc and LinuxCNC write ``[#1 + SIN[30]]``, Sinumerik ``(R1 + SIN(30))``; angles count degrees. An
expression is read once and worked out each time its block runs. A variable that nobody has set is
vacant (None): it counts as 0 in sums, and ``EQ #0`` tells it from 0.
"""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from autodb.errors import UnusableInput

Number = float | None
Key = int | str
"""What a variable is called: #5 by its number, the others by name, R5 as ``R5``."""


class Variables(Protocol):
    """Where the values of variables are."""

    def value(self, key: Key) -> Number:
        """Return a variable's value, None where nobody has set it."""


Expression = Callable[[Variables], Number]

LOCAL = range(1, 34)
"""Numbers of variables that each call of a macro has of its own."""


def nothing_known(_key: Key) -> Number:
    """Return that a control knows no variable of its own."""
    return None


def begins_with_line(name: str) -> bool:
    """Return whether a named variable is of all programs: its name begins with _."""
    return name[:1] == "_"


@dataclass
class Values:
    """Variables: those of a call of its own, those of all, and those that the control has."""

    own: dict[Key, float] = field(default_factory=dict)
    shared: dict[Key, float] = field(default_factory=dict)
    of_control: Callable[[Key], Number] = nothing_known
    of_all: Callable[[str], bool] = begins_with_line
    heard: dict[Key, Number] = field(default_factory=dict)
    """What the control has answered last, of all that it was asked for."""

    def value(self, key: Key) -> Number:
        """Return a variable's value, None where nobody has set it."""
        if key in self.own:
            return self.own[key]
        found = self.shared.get(key)
        if found is not None:
            return found
        self.heard[key] = answer = self.of_control(key)
        return answer

    def put(self, key: Key, value: float) -> None:
        """Set a variable: numbers above the locals are of all programs, and names that are."""
        if isinstance(key, int):
            shared = key not in LOCAL
        else:
            shared = key not in self.own and (self.of_all(key) or key in self.shared)
        (self.shared if shared else self.own)[key] = value

    def inner(self, own: dict[Key, float]) -> "Values":
        """Return the variables as a unit that is called has them."""
        return Values(own, self.shared, self.of_control, self.of_all, self.heard)


_NUMBER = r"\d+\.?\d*(?:EX[+-]?\d+)?|\.\d+"
_SIGNS = r"\*\*|==|<>|<=|>=|[-+*/<>,\[\]()]"
_SPACED = re.compile(
    rf"\s*(?:(?:{_NUMBER})|#<[^<>]*>|#|[$A-Z_][A-Z0-9_]*|{_SIGNS})",
)
_PACKED = re.compile(
    rf"(?:{_NUMBER})|#<[^<>]*>|#|MOD|AND|X?OR|EQ|NE|G[TE]|L[TE]|A?SIN|A?COS|A?TAN|ABS|SQRT"
    rf"|ROUND|FIX|FUP|LN|EXP|EXISTS|{_SIGNS}"
)
"""Tokens of controls with names, between blanks, and of those without names nor blanks."""


def _zero(value: Number) -> float:
    return 0.0 if value is None else value


def _divide(a: float, b: float) -> float:
    if b == 0.0:
        raise ValueError("a division by 0; use another divisor")
    return a / b


def _modulo(a: float, b: float) -> float:
    if b == 0.0:
        raise ValueError("MOD by 0; use another divisor")
    return a % b


_ARITHMETIC: dict[str, tuple[int, Callable[[float, float], float]]] = {
    "**": (7, lambda a, b: a**b),
    "*": (6, lambda a, b: a * b),
    "/": (6, _divide),
    "DIV": (6, lambda a, b: math.trunc(_divide(a, b))),
    "MOD": (6, _modulo),
    "+": (5, lambda a, b: a + b),
    "-": (5, lambda a, b: a - b),
    "GT": (4, lambda a, b: float(a > b)),
    "GE": (4, lambda a, b: float(a >= b)),
    "LT": (4, lambda a, b: float(a < b)),
    "LE": (4, lambda a, b: float(a <= b)),
    "AND": (3, lambda a, b: float(bool(a) and bool(b))),
    "OR": (2, lambda a, b: float(bool(a) or bool(b))),
    "XOR": (2, lambda a, b: float(bool(a) != bool(b))),
}
"""Operators that take two numbers: how strongly they bind, and what they give."""
_SAME = {"EQ": True, "==": True, "NE": False, "<>": False}
_SPELT = {">": "GT", ">=": "GE", "<": "LT", "<=": "LE"}


def _root(a: float) -> float:
    if a < 0:
        raise ValueError(f"the root of {a:g}; use a number of at least 0")
    return math.sqrt(a)


def _arc(function: Callable[[float], float]) -> Callable[[float], float]:
    def of(a: float) -> float:
        if abs(a) > 1.0 + 1e-9:
            raise ValueError(f"the arc of {a:g}; use a number from -1 to 1")
        return math.degrees(function(max(-1.0, min(a, 1.0))))

    return of


_FUNCTIONS: dict[str, Callable[[float], float]] = {
    "SIN": lambda a: math.sin(math.radians(a)),
    "COS": lambda a: math.cos(math.radians(a)),
    "TAN": lambda a: math.tan(math.radians(a)),
    "ASIN": _arc(math.asin),
    "ACOS": _arc(math.acos),
    "SQRT": _root,
    "SQR": _root,
    "POT": lambda a: a * a,
    "ABS": abs,
    "ROUND": lambda a: float(math.floor(a + 0.5)),
    "FIX": lambda a: float(math.floor(a)),
    "FUP": lambda a: float(math.ceil(a)),
    "TRUNC": lambda a: float(math.trunc(a)),
    "EXP": math.exp,
    "LN": math.log,
    "NOT": lambda a: float(not a),
}
"""Functions of one number. ATAN is apart: it takes one, or two as ATAN[a]/[b] or ATAN2(a, b)."""


class _Parser:
    """An expression that is being read: the text, and how far."""

    def __init__(self, text: str, at: int, *, packed: bool) -> None:
        self.text, self.at = text, at
        self.pattern = _PACKED if packed else _SPACED

    def next(self) -> str:
        """Return the next token, "" at the end or before what is none."""
        found = self.pattern.match(self.text, self.at)
        return "" if found is None else found[0].strip()

    def take(self) -> str:
        """Return the next token and go past it."""
        found = self.pattern.match(self.text, self.at)
        if found is None:
            rest = self.text[self.at :].strip()
            raise ValueError(
                f"'{rest[:20] or 'its end'}' is no value; write a number or a variable"
            )
        self.at = found.end()
        return found[0].strip()

    def expect(self, *some: str) -> None:
        """Go past one of some tokens."""
        if self.next() not in some:
            raise ValueError(f"'{some[0]}' is missing; close every bracket")
        self.take()

    def binary(self, least: int) -> Expression:
        """Read values and the operators between them that bind so strongly at least."""
        left = self.unary()
        while True:
            token = _SPELT.get(self.next(), self.next())
            if token in _SAME and least <= 4:
                self.take()
                left = _same(left, self.binary(5), _SAME[token])
                continue
            if token not in _ARITHMETIC or _ARITHMETIC[token][0] < least:
                return left
            self.take()
            binds, of = _ARITHMETIC[token]
            left = _both(left, self.binary(binds + 1), of)

    def unary(self) -> Expression:
        """Read a value with its sign."""
        if self.next() in ("-", "+"):
            minus = self.take() == "-"
            inner = self.unary()
            return (lambda env: -_zero(inner(env))) if minus else inner
        return self.primary()

    def primary(self) -> Expression:
        """Read a number, a variable, a function or what stands in brackets."""
        token = self.take()
        if token in ("[", "("):
            inner = self.binary(0)
            self.expect("]", ")")
            return inner
        if token == "#":
            return _indexed(self.unary())
        if token[:2] == "#<":
            return _variable(token[2:-1].lower().replace(" ", ""))
        if token and (token[0].isdigit() or token[0] == "."):
            number = float(token.replace("EX", "E"))
            return _constant(number)
        if token and (token[0].isalpha() or token[0] in "$_"):
            return self.word(token)
        raise ValueError(f"'{token or 'its end'}' is no value; write a number or a variable")

    def word(self, name: str) -> Expression:
        """Read what follows a name: of a function its argument."""
        if name in ("ATAN", "ATAN2", "ACOT"):
            return self.arc_tangent()
        if name == "EXISTS":
            self.expect("[", "(")
            inner = self.primary()
            self.expect("]", ")")
            return lambda env: float(inner(env) is not None)
        if name in _FUNCTIONS:
            of, inner = _FUNCTIONS[name], self.primary()
            return lambda env: of(_zero(inner(env)))
        if self.next() in ("[", "(") and name != "R":
            raise ValueError(f"the function '{name}' is not read; write out what it gives")
        if name == "R":
            inner = self.primary()
            return lambda env: env.value(f"R{_zero(inner(env)):.0f}")
        return _variable(name)

    def arc_tangent(self) -> Expression:
        """Read the two sides of an arc tangent, or its one argument."""
        self.expect("[", "(")
        above = self.binary(0)
        below: Expression | None = None
        if self.next() == ",":
            self.take()
            below = self.binary(0)
        self.expect("]", ")")
        if below is None and self.next() == "/":
            self.take()
            below = self.primary()
        right = below or _constant(1.0)
        return lambda env: math.degrees(math.atan2(_zero(above(env)), _zero(right(env))))


def _constant(number: float) -> Expression:
    def of(_variables: Variables) -> Number:
        return number

    return of


def _variable(key: Key) -> Expression:
    return lambda env: env.value(key)


def _indexed(inner: Expression) -> Expression:
    return lambda env: env.value(int(_zero(inner(env))))


def _both(a: Expression, b: Expression, of: Callable[[float, float], float]) -> Expression:
    return lambda env: of(_zero(a(env)), _zero(b(env)))


def _same(a: Expression, b: Expression, wanted: bool) -> Expression:
    def of(env: Variables) -> float:
        left, right = a(env), b(env)
        if left is None or right is None:
            return float((left is right) == wanted)
        return float((abs(left - right) < 1e-9) == wanted)

    return of


def expression_at(text: str, at: int, *, packed: bool) -> tuple[Expression, int]:
    """Return the longest expression that begins at a place of a text, and where it ends.

    The text is in capitals; ``packed``: without names and blanks.

    Raises UnusableInput, without file and line.
    """
    return _read(text, at, packed=packed, whole=True)


def value_at(text: str, at: int, *, packed: bool) -> tuple[Expression, int]:
    """Return the single value that begins at a place: a number, variable, function or bracket.

    Raises UnusableInput, without file and line.
    """
    return _read(text, at, packed=packed, whole=False)


def expression(text: str, *, packed: bool) -> Expression:
    """Return what is one expression from end to end.

    Raises UnusableInput, without file and line.
    """
    found, end = expression_at(text, 0, packed=packed)
    if text[end:].strip():
        raise UnusableInput(
            f"'{text[end:].strip()[:20]}' follows a value; write an operator between"
        )
    return found


def _read(text: str, at: int, *, packed: bool, whole: bool) -> tuple[Expression, int]:
    parser = _Parser(text, at, packed=packed)
    try:
        found = parser.binary(0) if whole else parser.unary()
    except (ValueError, RecursionError) as error:
        raise UnusableInput(str(error)) from None
    return found, parser.at
