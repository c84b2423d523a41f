"""Entries of the answer: an effect with its name, and one that may be any of several names."""

from collections.abc import Collection
from typing import Literal

from autodb.explain.answer import Cause, Value
from autodb.explain.cutting.rivals import Standing
from autodb.explain.suspects import UNKNOWN, Choice

LIKELY = 0.6
"""A name less likely than this is not given: it is `unknown`, with the names that it could be."""
LEAST = 0.3
"""The same for a name beside others that are known to look like it: three such share one table."""


def is_undecided(sure: Standing) -> bool:
    """Say whether several names are about as likely."""
    return bool(sure.near) and (sure.like < LIKELY or sure.confidence < LEAST)


def named(
    choice: Choice,
    sure: Standing,
    statement: str,
    values: dict[str, Value],
    *,
    includes: Collection[str],
    apart: str | None,
) -> Cause:
    """Return the entry of a named effect; ``values`` hold its ``size``, what it adds at its peak.

    ``statement``: what it is in shop words; ``apart``: what would tell it from its alternatives.
    """
    term, size = choice.suspect.term, values["size"]
    kind: Literal["missing", "mistuned"] = "mistuned" if term in includes else "missing"
    left_out = {
        "mistuned": "The simulation has it with another size",
        "missing": "The simulation leaves it out",
    }
    return Cause(
        term=term,
        kind=kind,
        confidence=sure.confidence,
        statement=(
            f"{statement} {left_out[kind]}: up to {size.value:.3g} N "
            f"({size.low:.3g} to {size.high:.3g})."
        ),
        parameters=values,
        alternatives=sure.near,
        variables=choice.suspect.variables,
        to_tell_apart=apart,
    )


def undecided(
    choice: Choice, sure: Standing, size: Value, *, where: str, apart: str | None
) -> Cause:
    """Return an entry without a name; ``where``: what does not tell which it is, in the plural."""
    names = (choice.suspect.term, *sure.near)
    words = ", ".join(name.replace("_", " ") for name in names)
    return Cause(
        term=UNKNOWN,
        kind="missing",
        confidence=1.0 - sure.confidence,
        statement=(
            f"Something of up to {size.value:.3g} N is missing that may be any of: {words}. "
            f"{where} do not tell which."
        ),
        parameters={"size": size},
        alternatives=names,
        variables=choice.suspect.variables,
        to_tell_apart=apart,
    )
