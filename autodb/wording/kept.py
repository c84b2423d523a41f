"""Sentences that were stored in English, said again for the reader.

What is stored is the sentence itself, so that programs and older databases have the same. It is
recognised by its fixed words, which the catalogue marks, and said again with what stood between
them: numbers with the reader's marks, amounts in the shop's units. What is not recognised stays in
English and says so. One that was not stored yet knows what it was made of.
"""

import re
from dataclasses import dataclass
from functools import cache
from string import Formatter

from autodb.wording.amounts import day, localized, shop_amount
from autodb.wording.presentation import ENGLISH, presentation
from autodb.wording.sentences import Worded, language_of, listed, phrase, phrase_many

SENTENCES = (
    "why", "verdict", "said", "what", "group", "found", "kind", "where", "conditions", "move",
    "noise",
)  # fmt: skip
"""Places of a stored sentence that hold stored sentences; what stands in others is a number, an
amount or a name. Of an amount that another shares its unit with, ``size_low`` and ``size_high``
are the ends of ``size``, and ``size_now`` another."""
CAUSES, VALUES, TERM, OR = "causes", "values", "term", " or "
"""Places of titles of causes, one after another (``causes_other`` of more), of quoted values, any
of which holds, and of an effect by its name."""
QUOTED = r"'[^',;]*'(?: or '[^',;]*')*"
SEPARATOR = "; "
_AMOUNT = re.compile(r"([-+−]?\d+(?:\.\d+)?(?:e[-+]\d+)?)(?: (\S{1,8}))?")


_DAY = re.compile(r"\d{4}-\d\d-\d\d(?: \d\d:\d\d)?")
SENTENCE_ENDS = re.compile(r"(?<=\.) (?=[A-Z])")
"""Between sentences that stand one after the other."""


@dataclass(frozen=True)
class StoredSentence:
    """A sentence as code has it, and the shape by which a stored one is recognised."""

    english: str
    shape: re.Pattern[str]

    def values(self, text: str) -> dict[str, str] | None:
        """Return what stands in the places of a text; None: it is another sentence."""
        found = self.shape.fullmatch(text)
        return None if found is None else found.groupdict()


def stored_sentence(english: str) -> StoredSentence:
    """Return the shape of a sentence with ``{names}``.

    >>> stored_sentence("{k} of {n} cuts").values("3 of 7 cuts")
    {'k': '3', 'n': '7'}
    """
    shape, known = "", set[str]()
    for fixed, name, _, _ in Formatter().parse(english):
        shape += re.escape(fixed)
        if name is not None:
            shape += f"(?P={name})" if name in known else f"(?P<{name}>{_shape(name)})"
            known.add(name)
    return StoredSentence(english, re.compile(shape, re.DOTALL))


def _shape(name: str) -> str:
    """Return what may stand in a place: several sentences only where they are expected."""
    return QUOTED if name == VALUES else ".+?" if name in SENTENCES else "(?:(?!; ).)+?"


@cache
def stored_sentences() -> tuple[StoredSentence, ...]:
    """Return the sentences that may be stored, those with the most fixed words first."""
    from autodb.wording.catalogues import LANGUAGES, STORED, written_catalogue

    language = next(one for one in LANGUAGES if one != "en")  # each catalogue has all of them
    marked = (one for one in written_catalogue(language) if STORED in one.auto_comments)
    found = [stored_sentence(str(one.id)) for one in marked]
    return tuple(sorted(found, key=lambda one: -len(re.sub(r"\{\w+\}", "", one.english))))


def said_again(text: str) -> Worded:
    """Return a stored sentence, or several, in the reader's language and units; in English where
    one is not known.
    """
    if presentation() == ENGLISH:
        return Worded(text, "en")
    made = _made_again(text) or _whole(text)
    if made is None and SEPARATOR in text:
        parts = text.split(SEPARATOR)
        every = [amount_again(one) if _AMOUNT.fullmatch(one) else _whole(one) for one in parts]
        if all(every):
            return listed([one for one in every if one], SEPARATOR)
    return Worded(text, "en") if made is None else made


def _made_again(text: str) -> Worded | None:
    """Return a text that knows what it was made of for the reader; None: it does not."""
    said = text.said if isinstance(text, Worded) else None
    if said is None:
        return None
    values = {name: _part_again(one) for name, one in said.values.items()}
    if not said.sentences:
        between = said_again(said.separator)
        if language_of(between) == "en":  # marks alone, which every language has
            between = Worded(said.separator, presentation().language)
        made = listed((one for one in values.values() if isinstance(one, str)), between)
    elif len(said.sentences) == 1:
        made = phrase(said.sentences[0], **values)
    else:
        one, many = said.sentences
        made = phrase_many(one, many, said.count, **values)
    return made if language_of(made) == presentation().language else None


def _part_again(part: object) -> object:
    """Return what was filled in for the reader: a text again, an amount with the shop's unit."""
    if isinstance(part, Worded):
        return said_again(part)
    line = getattr(part, "line", None)  # of a refusal
    if isinstance(line, Worded):
        return said_again(line)
    if isinstance(part, str):
        return day(part) if _DAY.fullmatch(part) else amount_again(part)
    return part


def _whole(text: str) -> Worded | None:
    """Return one stored sentence for the reader; None: it is not known."""
    for one in stored_sentences():
        values = one.values(text)
        if values is None:
            continue
        said = {name: _value(name, values) for name in values}
        made = phrase(one.english, **said)
        if language_of(made) == presentation().language:
            return made
    return None


def _value(name: str, values: dict[str, str]) -> str:
    """Return what stands in a place, for the reader."""
    text, whole = values[name], re.sub("_(low|high|now)$", "", name)
    if whole != name and whole in values:
        _, _, unit = values[whole].partition(" ")
        return amount_again(f"{text} {unit}").rpartition(" ")[0] if unit else amount_again(text)
    if _AMOUNT.fullmatch(text):
        return amount_again(text)
    if name == TERM:
        word = phrase(text.replace("_", " "))
        return word if language_of(word) == presentation().language else text
    if name == VALUES:
        return listed(text.split(OR), phrase(" or "))
    if name.startswith(CAUSES):
        return listed(phrase(one) for one in text.split(", "))
    again = said_again(text)
    known = language_of(again) == presentation().language and again != text
    return again if known or name in SENTENCES else text


def amount_again(text: str) -> str:
    """Return a stored number, or a number and its unit, for the reader; other text as it is.

    >>> amount_again("19.8 N"), amount_again("Ø56")
    ('19.8 N', 'Ø56')
    """
    found = _AMOUNT.fullmatch(text)
    if found is None:
        return text
    number, unit = found.groups()
    if unit is None:
        return localized(number)
    factor, name = shop_amount(1.0, unit)
    if factor != 1.0:
        digits = max(len(re.sub(r"e.*|\D", "", number).lstrip("0")), 1)
        number = f"{factor * float(number.replace('−', '-')):.{digits}g}"
        number = f"{float(number):g}" if "e" in number else number
    return f"{localized(number)} {name}"
