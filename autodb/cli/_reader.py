"""For whom a command answers: `--language` and `--units`, or AUTODB_LANGUAGE and AUTODB_UNITS.

What is stored, and what programs read, stays in English and in SI units.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from copy import copy
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any

import typer

from autodb.wording import (
    ENGLISH,
    language_of,
    localized,
    phrase,
    presentation,
    presented,
    shop_amount,
)
from autodb.wording.presentation import present_for

if TYPE_CHECKING:
    from autodb.forward.prediction import Interval

LANGUAGE, UNITS = "AUTODB_LANGUAGE", "AUTODB_UNITS"
Language = Annotated[
    str | None,
    typer.Option(
        "--language",
        metavar="CODE",
        envvar=LANGUAGE,
        show_envvar=False,
        help=f"Language of the answer: en or de [default: {LANGUAGE} or en]",
    ),
]
Units = Annotated[
    str | None,
    typer.Option(
        "--units",
        metavar="SYSTEM",
        envvar=UNITS,
        show_envvar=False,
        help=f"Units of the answer: si or inch [default: {UNITS} or si]",
    ),
]


def for_its_reader(command: Any) -> None:
    """Give a command the options of its reader, and have it answer in what they say."""
    own, answer = {one.name for one in command.params}, command.callback
    command.params += [copy(one) for one in _options() if one.name not in own]

    def answered(*, language: str | None, units: str | None, **given: object) -> Any:
        _answer_in(language, units)
        return answer(**given)

    command.callback = answered


@cache
def _options() -> list[Any]:
    """Return the options of a reader, built once; each command has copies."""
    from typer.main import get_command

    alone = typer.Typer(add_completion=False)
    alone.command()(_answer_in)
    made: Any = get_command(alone)
    return list(made.params)


def _answer_in(language: Language = None, units: Units = None) -> None:
    """Answer in a language and in units; raises UnusableInput for those that there are not."""
    if language is None and units is None:
        return
    from autodb.errors import UnusableInput, near_words
    from autodb.files.units import SI, SYSTEMS, presentation_of
    from autodb.wording.catalogues import LANGUAGES

    for option, given, known in (
        ("--language", language, LANGUAGES), ("--units", units, SYSTEMS)
    ):  # fmt: skip
        if given is not None and given not in known:
            raise UnusableInput(
                phrase(
                    "{option} '{given}': there is none{hint}",
                    option=option,
                    given=given,
                    hint=near_words(given, known),
                )
            )
    present_for(presentation_of(language or "en", units or SI))


@contextmanager
def in_english(when: bool = True) -> Iterator[None]:
    """Work in English and SI units: what is stored, and what programs read."""
    if not when:
        yield
        return
    with presented(ENGLISH):
        yield


def for_reader(tell: Callable[[str], None]) -> Callable[[str], None]:
    """Return what tells a line as its reader has it, also where the work is done in English."""
    shown = presentation()

    def told(line: str) -> None:
        with presented(shown):
            tell(shown_again(line))

    return told


def shown_again(text: str) -> str:
    """Return what was stored in English as its reader has it; what is not known stays as it is."""
    if presentation() == ENGLISH or language_of(text) != "en":
        return text
    from autodb.wording.kept import said_again  # who says English needs none

    return said_again(text)


def headed(what: str, unit: str = "") -> str:
    """Return the head of a column of numbers, with their unit as the reader has it."""
    return ">" + f"{what} {shop_amount(1.0, unit)[1]}".strip()


def table_number(value: float, unit: str, digits: int | None = None) -> str:
    """Return a number of a table for the reader, in what ``headed`` says.

    ``digits``: after the mark of a number in our units; without them one, from 100 on none.
    """
    return _number(value, unit, _digits(value, unit, digits))


def interval(one: "Interval", unit: str, digits: int | None = None) -> str:
    """Return 'value (low to high)' for the reader, its digits as ``table_number`` has them."""
    shown = _digits(one.value, unit, digits)
    value, low, high = (_number(end, unit, shown) for end in (one.value, one.low, one.high))
    return phrase("{value} ({low} to {high})", value=value, low=low, high=high)


def _number(value: float, unit: str, digits: int) -> str:
    return localized(f"{shop_amount(value, unit)[0]:.{digits}f}")


def _digits(value: float, unit: str, digits: int | None) -> int:
    """Return how many digits stand after the mark: of a shop's units so many that three count."""
    factor, _ = shop_amount(1.0, unit)
    if factor == 1.0 and digits is not None:
        return digits
    least = (100.0,) if factor == 1.0 else (100.0, 10.0, 1.0)
    return next((k for k, one in enumerate(least) if factor * abs(value) >= one), len(least))
