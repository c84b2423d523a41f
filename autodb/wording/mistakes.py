"""What is wrong with a value that a model refuses, in the words of those who wrote it."""

from collections.abc import Callable, Mapping
from typing import Any

from autodb.wording.amounts import localized
from autodb.wording.sentences import Worded, phrase

Context = Mapping[str, Any]
WHOLE_BELOW = 1e9
"""Whole numbers below are written without an exponent."""
LONGEST = 40
"""Characters of a value that are shown."""


def mistake_words(mistake: Mapping[str, Any]) -> Worded:
    """Return what is wrong, of one of the errors that pydantic lists, as a sentence without its
    subject: `must be a number, not 'a'`.

    What a model of ours says itself, and what is rarer than the kinds here, stays as it is.
    """
    kind, context = str(mistake["type"]), mistake.get("ctx", {})
    if kind == "missing":
        return phrase("is missing")
    if kind == "string_too_short":
        return phrase("is empty")
    for ending, must in KINDS.items():
        if kind.startswith(ending):
            return phrase("{must}, not {value}", must=must(context), value=_shown(mistake["input"]))
    raised = context.get("error")
    if isinstance(raised, ValueError) and raised.args:
        return _as_worded(raised.args[0])
    return Worded(mistake["msg"].removeprefix("Value error, "), "en")


def _as_worded(said: object) -> Worded:
    return said if isinstance(said, Worded) else Worded(str(said), "en")


def _shown(value: object) -> str:
    if isinstance(value, str):
        text = f"'{value}'"
    elif isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, int | float):
        text = _number(value)
    else:
        return phrase("this")
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 1]}…"


def _alternatives(context: Context) -> str:
    return str(context["expected"]).replace(" or ", ", ")


def _amount(context: Context, name: str) -> str:
    return _number(context[name])


def _number(value: float) -> str:
    whole = isinstance(value, float) and value.is_integer() and abs(value) < WHOLE_BELOW
    return localized(f"{value:.0f}" if whole else f"{value:g}")


KINDS: Mapping[str, Callable[[Context], Worded]] = {
    "float_": lambda _: phrase("must be a number"),
    "finite_number": lambda _: phrase("must be a finite number"),
    "int_": lambda _: phrase("must be a whole number"),
    "string_type": lambda _: phrase("must be a text"),
    "bool_": lambda _: phrase("must be true or false"),
    "list_type": lambda _: phrase("must be a list"),
    "tuple_type": lambda _: phrase("must be a list"),
    "dict_type": lambda _: phrase("must be a table of keys"),
    "model_": lambda _: phrase("must be a table of keys"),
    "literal_error": lambda c: phrase("must be one of {values}", values=_alternatives(c)),
    "enum": lambda c: phrase("must be one of {values}", values=_alternatives(c)),
    "greater_than_equal": lambda c: phrase("must be at least {least}", least=_amount(c, "ge")),
    "greater_than": lambda c: phrase("must be greater than {least}", least=_amount(c, "gt")),
    "less_than_equal": lambda c: phrase("must be at most {most}", most=_amount(c, "le")),
    "less_than": lambda c: phrase("must be less than {most}", most=_amount(c, "lt")),
}
"""By how pydantic's kinds of mistakes begin, the longer before what they begin with."""
