"""Brings the catalogues of sentences up to date: `python -m autodb.cli.develop.catalogues`.

What is said is collected from code and templates, and from the vocabulary, whose words are data. In
each `autodb/wording/*.po` a new sentence has no translation until somebody writes it; one that is
said no more is gone.
"""

from collections.abc import Iterator
from pathlib import Path

from babel.messages.catalog import Catalog
from babel.messages.extract import extract_from_file
from babel.messages.pofile import read_po, write_po

import autodb
from autodb.files.job import OPERATIONS
from autodb.terms.vocabulary import TAKEN, WITHOUT_TERM, all_terms
from autodb.wording.catalogues import LANGUAGES

PACKAGE = Path(autodb.__file__).parent
IN_CODE = {"say": None, "msgid": None, "say_many": (1, 2)}
IN_TEMPLATES = {"_": None, "_n": (1, 2)}
METHODS = (("*.py", "python", IN_CODE), ("*.j2", "jinja2", IN_TEMPLATES))
OURS = "from autodb.wording"
WIDTH = 100


def said_messages() -> Catalog:
    """Return every sentence that is looked up, with where it is said."""
    found = Catalog(project="autodb", charset="utf-8", fuzzy=False)
    for pattern, method, keywords in METHODS:
        for path in sorted(PACKAGE.rglob(pattern)):
            if method == "python" and OURS not in path.read_text(encoding="utf-8"):
                continue  # what is called ``say`` there is not ours
            place = path.relative_to(PACKAGE.parent).as_posix()
            for _, message, _, _ in extract_from_file(method, path, keywords=keywords):
                found.add(message, locations=[(place, 1)])
    for message, place in _vocabulary():
        found.add(message, locations=[(place, 1)])
    return found


def _vocabulary() -> Iterator[tuple[str, str]]:
    """Give what is said of operations and effects, which are data, and where they are listed."""
    for operation in OPERATIONS:
        yield operation, "autodb/files/job.py"
    for effect in (*all_terms(), *WITHOUT_TERM):
        if effect.title:
            yield effect.title, "autodb/terms/vocabulary.py"
    for term in all_terms():
        yield term.statement, "autodb/terms/vocabulary.py"
        for parameter in term.parameters:
            plain = parameter.name.rstrip("0123456789").rstrip("_").replace("_", " ")
            yield plain, "autodb/terms/vocabulary.py"
    for name in sorted(TAKEN):
        yield name.replace("_", " "), "autodb/terms/vocabulary.py"


def catalogue_path(language: str) -> Path:
    """Return where the sentences of a language are."""
    return PACKAGE / "wording" / f"{language}.po"


def read_catalogue(language: str) -> Catalog:
    """Return the sentences of a language as they are written."""
    with catalogue_path(language).open("rb") as source:
        return read_po(source, locale=language)


def update() -> None:
    """Write each catalogue anew, with what is said now."""
    for language in LANGUAGES:
        if language != "en":
            known = read_catalogue(language)
            known.update(said_messages(), no_fuzzy_matching=True)
            known.obsolete.clear()
            with catalogue_path(language).open("wb") as place:
                write_po(place, known, width=WIDTH, include_lineno=False, sort_by_file=True)


if __name__ == "__main__":
    update()
