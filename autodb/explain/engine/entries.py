"""Entries of the answer: an effect with its name, and one that may be any of several names."""

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Literal

from autodb.explain.answer import Cause, IntervalValue
from autodb.explain.engine.candidates import UNKNOWN, Choice
from autodb.explain.engine.confidence import LIKELIER_THAN_NOT, Mistuned
from autodb.explain.engine.search import MARGIN, alike_terms
from autodb.explain.engine.standing import Standing
from autodb.terms.vocabulary import effect_called
from autodb.wording import significant, stored_msgid

HAS_WITH = stored_msgid(
    "The simulation has {term} with {parameter} {size}; the recording says {size_now} ({size_low} "
    "to {size_high})."
)
OFF_BY = stored_msgid(
    "The simulation's {term} is off by a factor: the recording says {value} times it ({low} to "
    "{high})."
)

LIKELY = 0.6
"""A name less likely than this is not given: it is `unknown`, with the names that it could be."""
LEAST = 0.3
"""The same for a name beside others that are known to look like it: three such share one table."""

OTHER_SIZE = stored_msgid(
    "The simulation has it with another size: up to {size} ({size_low} to {size_high})."
)
LEFT_OUT = stored_msgid("The simulation leaves it out: up to {size} ({size_low} to {size_high}).")
ANY_OF = stored_msgid(
    "The simulation leaves out up to {size}. It may be any of: {causes}. {where} do not tell which."
)


def size_words(size: IntervalValue) -> dict[str, str]:
    """Return a size and its ends, as sentences have them."""
    return {
        "size": f"{significant(size.value)} {size.unit}",
        "size_low": significant(size.low),
        "size_high": significant(size.high),
    }


def is_undecided(choice: Choice, sure: Standing) -> bool:
    """Say whether several names are about as likely."""
    like = sure.of(alike_terms(choice.candidate.term))
    return bool(sure.near) and (like < LIKELY or sure.confidence < LEAST)


def named_entry(
    choice: Choice,
    sure: Standing,
    statement: str,
    values: dict[str, IntervalValue],
    *,
    includes: Collection[str],
    apart: str | None,
) -> Cause:
    """Return the entry of a named effect; ``values`` hold its ``size``, what it adds at its peak.

    ``statement``: what it is in shop words; ``apart``: what would tell it from its alternatives.
    """
    term, size = choice.candidate.term, values["size"]
    kind: Literal["missing", "mistuned"] = "mistuned" if term in includes else "missing"
    left_out = {
        "mistuned": OTHER_SIZE,
        "missing": LEFT_OUT,
    }
    return Cause(
        term=term,
        kind=kind,
        confidence=sure.confidence,
        statement=f"{statement} " + left_out[kind].format(**size_words(size)),
        parameters=values,
        alternatives=sure.near,
        variables=choice.candidate.variables,
        to_tell_apart=apart,
    )


def retuned_words(term: str, now: IntervalValue, *, of: tuple[str, float] | None) -> str:
    """Return what an own term is and should be: a parameter, its name and value ``of`` the
    simulation; None: the factor by which all of it is off.
    """
    value, low, high = (f"{one:.4g}" for one in (now.value, now.low, now.high))
    if of is None:
        return OFF_BY.format(term=term, value=value, low=low, high=high)
    parameter, had = of
    size = f"{had:.4g}" if now.unit == "1" else f"{had:.4g} {now.unit}"
    return HAS_WITH.format(
        term=term, parameter=parameter, size=size, size_now=value, size_low=low, size_high=high
    )


def told_entries(entries: Sequence[Cause]) -> list[Cause]:
    """Return the entries without other sizes of what the simulation is said to have, found as
    effects, that are no likelier than not: as of own terms, these are not said.

    Where nothing else is said they stay, so that a mismatch is not passed over.
    """
    told = [
        entry
        for entry in entries
        if entry.kind == "missing" or entry.confidence > LIKELIER_THAN_NOT
    ]
    return told or list(entries)


def own_term_entries(
    off: Mapping[str, Mistuned],
    causes: Mapping[str, Cause],
    *,
    beside: Collection[Cause],
    jointly: Callable[[Collection[str]], Mistuned],
) -> list[Cause]:
    """Return what is said of own terms: the entries of those that are mistuned, ``causes``.

    Where nothing is told, of these or ``beside`` them, one entry without a name for all that
    something else may stand in for: what is off then is not passed over. Where that is likelier it
    is asked for the evidence of an effect beside that of the own term's change. ``jointly``: how
    several are judged as one, which may be clear where it is not which of them is off.
    """
    entries = [cause for name, cause in causes.items() if off[name].told]
    sizes = {n: cause.parameters["size"] for n, cause in causes.items() if off[n].either}
    if not sizes or entries or beside:
        return entries
    names = sorted(sizes, key=lambda name: -sizes[name].value)
    if len(names) > 1:
        joint = jointly(names)
        if joint.told:
            return [_one_of(joint, names, sizes[names[0]])]
    first = off[names[0]]
    clear = first.standing.is_likeliest or first.worth > MARGIN
    return [_either(first, names, sizes[names[0]])] if clear else []


def _one_of(joint: Mistuned, names: Sequence[str], size: IntervalValue) -> Cause:
    """Return the entry of own terms of which one or more are off, and nothing tells which."""
    return Cause(
        term=UNKNOWN,
        kind="mistuned",
        confidence=joint.standing.confidence,
        statement=(
            f"{_or(names).capitalize()} has another size than in the simulation, by up to "
            f"{significant(size.value)} {size.unit}. This recording does not tell which."
        ),
        parameters={"size": size},
        alternatives=tuple(names),
    )


def _either(sure: Mistuned, names: Sequence[str], size: IntervalValue) -> Cause:
    """Return the entry of own terms that may be off, or something in their place.

    An own term that is likelier than each other account is called by its name, however unsure all
    of them together make it.
    """
    others = tuple(dict.fromkeys((*names, *sure.standing.near)))
    over = f" over {' and '.join(sure.variables)}" if sure.variables else ""
    own = sure.standing.is_likeliest
    called = names[0] if own and len(names) == 1 else UNKNOWN
    return Cause(
        term=called,
        kind="mistuned" if own else "missing",
        confidence=sure.standing.confidence if own else 1.0 - sure.standing.confidence,
        statement=(
            f"The simulation is off by up to {significant(size.value)} {size.unit}. Either "
            f"{_or(names)} "
            f"has another size, or the simulation leaves out something{over}. This recording "
            "does not tell which."
        ),
        parameters={"size": size},
        alternatives=tuple(other for other in others if other != called),
        variables=sure.variables,
    )


def _or(names: Sequence[str]) -> str:
    return " or ".join(name.replace("_", " ") for name in names)


def undecided_entry(
    choice: Choice, sure: Standing, size: IntervalValue, *, where: str, apart: str | None
) -> Cause:
    """Return an entry without a name; ``where``: what does not tell which it is, in the plural."""
    names = (choice.candidate.term, *sure.near)
    words = ", ".join(effect_called(name).title for name in names)
    return Cause(
        term=UNKNOWN,
        kind="missing",
        confidence=1.0 - sure.confidence,
        statement=ANY_OF.format(
            size=f"{significant(size.value)} {size.unit}", causes=words, where=where
        ),
        parameters={"size": size},
        alternatives=names,
        variables=choice.candidate.variables,
        to_tell_apart=apart,
    )
