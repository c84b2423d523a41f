"""Catalogues of sentences by language (GNU gettext's .po files), and which of them a reader wants.

They are read as they are: a .po of some hundred sentences takes some 20 ms, once a process.
"""

from functools import cache
from gettext import GNUTranslations, NullTranslations
from importlib.resources import files
from io import BytesIO
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from babel.messages.catalog import Catalog

LANGUAGES = {"en": "English", "de": "Deutsch"}
"""Languages by their codes, each as it calls itself; English is that of the sentences in code."""
STORED = "stored"
"""What a catalogue notes of a sentence that the database keeps."""


class _NotThere(NullTranslations):
    """What a catalogue falls back to: it says that a sentence is not in it."""

    def gettext(self, message: str) -> str:
        """Raise LookupError."""
        raise LookupError(message)

    def ngettext(self, msgid1: str, msgid2: str, n: int) -> str:  # noqa: ARG002 - gettext's names
        """Raise LookupError."""
        raise LookupError(msgid1)


@cache
def catalogue(language: str) -> NullTranslations:
    """Return the sentences of a language; it raises LookupError for one that it has not."""
    from babel.messages.mofile import write_mo

    compiled = BytesIO()
    write_mo(compiled, written_catalogue(language))
    compiled.seek(0)
    found = GNUTranslations(compiled)
    found.add_fallback(_NotThere())
    return found


@cache
def written_catalogue(language: str) -> "Catalog":
    """Return the sentences of a language as its file has them, with what is noted of each."""
    from babel.messages.pofile import read_po

    with files("autodb.wording").joinpath(f"{language}.po").open("rb") as source:
        return read_po(source, locale=language)


def preferred_language(accepted: str) -> str:
    """Return the language of ours that an Accept-Language header likes best; English by default.

    >>> preferred_language("fr, de-AT;q=0.8, en;q=0.3"), preferred_language("en;q=0, *")
    ('de', 'en')
    """
    liked: dict[str, float] = {}
    for one in accepted.split(","):
        tag, _, weight = one.partition(";")
        code = tag.strip().lower().split("-")[0]
        if code in LANGUAGES:
            liked[code] = max(liked.get(code, 0.0), _weight(weight))
    best = max(liked, key=lambda code: liked[code], default="en")
    return best if liked.get(best) else "en"


def _weight(parameter: str) -> float:
    """Return the weight that a language's parameter states; 1 where it states none."""
    name, _, value = parameter.partition("=")
    if name.strip() != "q":
        return 1.0
    try:
        return float(value)
    except ValueError:
        return 0.0
