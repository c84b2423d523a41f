"""Sentences, looked up in the reader's language."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from autodb.wording.presentation import presentation

MOST_LISTED = 5
"""Stretches that are listed one by one."""


@dataclass(frozen=True)
class MadeOf:
    """What a text was made of: a sentence, or that for one and that for many, with its values.

    Without a sentence it is its values one after another, ``separator`` between them.
    """

    sentences: tuple[str, ...]
    values: Mapping[str, object] = field(default_factory=dict)
    count: int = 1
    separator: str = ", "


class Worded(str):
    """A text that knows the language it is in and what it was made of: it can be said again."""

    language: str
    said: MadeOf | None

    def __new__(cls, text: str, language: str, said: MadeOf | None = None) -> "Worded":
        """Return a text in a language."""
        made = super().__new__(cls, text)
        made.language = language
        made.said = said
        return made

    def __getnewargs__(self) -> tuple[str, str]:  # type: ignore[override]  # its copies know it too
        """Return what a copy is made of."""
        return str(self), self.language

    def __getstate__(self) -> None:
        """Leave out what the values of a sentence are: they may be anything."""

    def __deepcopy__(self, _memo: object) -> "Worded":
        """Return the text itself, which nothing changes."""
        return self


def language_of(text: object) -> str:
    """Return the language that a text is in; what does not say so is in English."""
    return str(getattr(text, "language", "en"))


def msgid(english: str) -> str:
    """Return a text as it is, which is said later: it is one that catalogues have."""
    return english


def stored_msgid(english: str) -> str:
    """Return a text as it is, which is stored in English and said again when it is shown."""
    return english


def phrase(english: str, **values: object) -> Worded:
    """Return a sentence in the reader's language, its ``{names}`` filled in.

    One that the catalogue has not, or with a part that is in another language, is said in English:
    it is in one language.
    """
    language = _language(values.values())
    try:
        text = _looked_up(language, english)
    except LookupError:
        text, language = english, "en"
    made = text.format(**values) if values else text
    return Worded(made, language, MadeOf((english,), values))


def phrase_many(one: str, many: str, count: int, **values: object) -> Worded:
    """Return the sentence for a count, which it has as ``{count}``, as ``say`` does."""
    language = _language(values.values())
    try:
        text = _looked_up(language, one, many, count)
    except LookupError:
        text, language = (one if count == 1 else many), "en"
    made = text.format(count=count, **values)
    return Worded(made, language, MadeOf((one, many), values, count))


def listed(some: Iterable[str], separator: str = ", ") -> Worded:
    """Return texts one after another, in English where one of them is."""
    every = list(some)
    parts = {f"part_{k}": one for k, one in enumerate(every)}
    said = MadeOf((), parts, separator=separator)
    return Worded(separator.join(every), _language(every), said)


def listed_stretches(
    stretches: Sequence[tuple[float, float]],
) -> list[tuple[float, float, int]]:
    """Return stretches to be listed, each with how many it stands for: of more than
    ``MOST_LISTED`` one, from where the first begins to where the last ends.
    """
    if len(stretches) <= MOST_LISTED:
        return [(low, high, 1) for low, high in stretches]
    return [(stretches[0][0], stretches[-1][1], len(stretches))]


def _looked_up(language: str, one: str, many: str = "", count: int = 1) -> str:
    """Return a sentence in a language; raises LookupError where its catalogue has it not."""
    if language == "en":
        return one if count == 1 else many
    from autodb.wording.catalogues import catalogue  # commands that say English need none

    found = catalogue(language)
    return found.ngettext(one, many, count) if many else found.gettext(one)


def _language(values: Iterable[Any]) -> str:
    """Return the reader's language, or English where a part is there in another."""
    ours = presentation().language
    known = (getattr(one, "language", ours) for one in values)
    return ours if all(one == ours for one in known) else "en"
