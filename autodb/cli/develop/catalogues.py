"""Brings the catalogues of sentences up to date: `python -m autodb.cli.develop.catalogues`.

What is said is collected from code and templates, and from the vocabulary, whose words are data. In
each `autodb/wording/*.po` a new sentence has no translation until somebody writes it; one that is
said no more is gone.
"""

from collections.abc import Iterator
from io import SEEK_END, BytesIO
from pathlib import Path

from babel.messages.catalog import Catalog
from babel.messages.extract import extract_from_file
from babel.messages.pofile import read_po, write_po

import autodb
from autodb.cutting.shear import PARAMETERS
from autodb.explain.waves.answers import APART
from autodb.files.job_cut import OPERATIONS
from autodb.terms.vocabulary import TAKEN, WITHOUT_TERM, all_terms
from autodb.wording.catalogues import LANGUAGES, STORED
from autodb.wording.kept import SENTENCE_ENDS

PACKAGE = Path(autodb.__file__).parent
VOCABULARY = "autodb/terms/vocabulary.py"
WAVES = "autodb/explain/waves/answers.py"
KEPT = {"stored_msgid": None}
IN_CODE = {"phrase": None, "msgid": None, "phrase_many": (1, 2), **KEPT}
IN_TEMPLATES = {"_": None, "_n": (1, 2)}
METHODS = (("*.py", "python", IN_CODE), ("*.j2", "jinja2", IN_TEMPLATES))
OURS = "from autodb.wording"
WIDTH = 100
HEADER = """\
# What is said, brought up to date by python -m autodb.cli.develop.catalogues
msgid ""
msgstr ""
"Language: {language}\\n"
"Plural-Forms: {plurals}\\n"
"MIME-Version: 1.0\\n"
"Content-Type: text/plain; charset=utf-8\\n"
"Content-Transfer-Encoding: 8bit\\n"

"""


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
            for _, message, _, _ in extract_from_file(method, path, keywords=KEPT):
                found.add(message, auto_comments=[STORED])
    for message, place in _vocabulary():
        found.add(message, locations=[(place, 1)])
    for term in all_terms():
        every = SENTENCE_ENDS.split(term.distinguished_by or "")
        for said in filter(None, (term.check, *every)):
            found.add(said, locations=[(VOCABULARY, 1)], auto_comments=[STORED])  # kept as it is
    for effect in WITHOUT_TERM:
        found.add(effect.check, locations=[(VOCABULARY, 1)], auto_comments=[STORED])
    for said in APART.values():
        found.add(said, locations=[(WAVES, 1)], auto_comments=[STORED])
    return found


def _vocabulary() -> Iterator[tuple[str, str]]:
    """Give what is said of operations and effects, which are data, and where they are listed."""
    for operation in OPERATIONS:
        yield operation, "autodb/files/job_cut.py"
    for effect in (*all_terms(), *WITHOUT_TERM):
        if effect.title:
            yield effect.title, VOCABULARY
            yield effect.name.replace("_", " "), VOCABULARY
    for term in all_terms():
        yield term.statement, VOCABULARY
        for parameter in term.parameters:
            plain = parameter.name.rstrip("0123456789").rstrip("_").replace("_", " ")
            yield plain, VOCABULARY
    for number in PARAMETERS:
        yield number.meaning, "autodb/cutting/shear.py"
    for name in sorted(TAKEN):
        yield name.replace("_", " "), VOCABULARY


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
            catalogue_path(language).write_bytes(updated(language))


def updated(language: str) -> bytes:
    """Return the catalogue of a language as it is with what is said now."""
    known = read_catalogue(language)
    known.update(said_messages(), no_fuzzy_matching=True)
    known.obsolete.clear()
    for message in known:
        message.flags.clear()  # a per cent sign is none of a format here
    head = HEADER.format(language=language, plurals=known.plural_forms)
    made = BytesIO(head.encode())
    made.seek(0, SEEK_END)
    write_po(made, known, width=WIDTH, omit_header=True, include_lineno=False, sort_by_file=True)
    return made.getvalue()


if __name__ == "__main__":
    update()
