"""What went wrong, in words that say what to do."""

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from itertools import islice
from pathlib import Path

from autodb.wording import Worded, language_of, listed, msgid, phrase


class UnusableInput(Exception):  # noqa: N818 - the name says what it is to the reader of the message
    """Input that cannot be used: one line with file, column, row and the remedy (exit 2).

    ``line``: what it was raised with, which can be said again in another language than
    ``language``, the one that it is in. ``problems``: each of several, without the file.
    """

    def __init__(self, line: str, problems: Sequence[str] = ()) -> None:
        self.line = line
        self.language = language_of(line)
        self.problems = tuple(problems)
        super().__init__(printable(line))


def printable(line: str) -> str:
    """Return a line without what would break it."""
    return "".join(c if c.isprintable() else " " for c in line)


class NotThere(UnusableInput):
    """What was asked for by its name or number is not there."""


class SetAside(UnusableInput):
    """A recording of one cut from which nothing can be learned; others beside it go on."""


def together(where: object, problems: Sequence[str]) -> UnusableInput:
    """Return one line for all the problems of a file, so that none is found only in the next run.

    >>> print(together("a.csv", ["no time", "no channel"]))
    a.csv: 2 problems: (1) no time; (2) no channel
    """
    if len(problems) == 1:
        return UnusableInput(behind_name(where, problems[0]))
    numbered = (behind_name(f"({k})", said, " ") for k, said in enumerate(problems, start=1))
    said = phrase(
        "{where}: {count} problems: {problems}",
        where=where, count=len(problems), problems=listed(numbered, "; ")
    )  # fmt: skip
    return UnusableInput(said, problems)


def behind_name(where: object, said: str, separator: str = ": ") -> Worded:
    """Return what is said of a file, or of another place, behind its name."""
    return listed([str(where), said], separator)


MOST_LOOKED_AT = 2000
"""Names of a folder among which near ones are sought. Chosen: below 0.1 s."""
NEAR_FILE = 0.6
"""Likeness of a file's name from which it is proposed. Chosen: most of its letters, in order."""


def no_such_file(path: Path, remedy: str = "") -> UnusableInput:
    """Return the line for a file that is not there, with what would work.

    Near names of its kind in its folder, then of any; without one ``remedy``, which says how such
    a file is made; without that the files of its kind there, or that there are none.
    """
    folder = path.parent
    try:
        every = sorted(one.name for one in islice(folder.iterdir(), MOST_LOOKED_AT))
    except OSError:
        if str(folder) != "." and not folder.exists():
            what = phrase("there is no folder {folder}", folder=folder)
            return _not_there(path, what, remedy)
        every = []
    names = [name for name in every if not name.startswith(".")]
    kind = {Path(name).stem: name for name in names if Path(name).suffix == path.suffix != ""}
    close = [kind[stem] for stem in get_close_matches(path.stem, kind, n=3, cutoff=NEAR_FILE)]
    others = [name for name in names if name not in kind.values()]
    close = close or get_close_matches(path.name, others, n=3, cutoff=NEAR_FILE)
    if close:
        hint = phrase(" (did you mean {names}?)", names=", ".join(close))
    elif remedy or not path.suffix:
        return _not_there(path, remedy)
    elif not kind:
        return _not_there(path, phrase("its folder has no {suffix} file", suffix=path.suffix))
    else:
        hint = phrase(" (there are: {names})", names=first_names(kind.values()))
    return UnusableInput(phrase("{file}: no such file{hint}", file=path, hint=hint))


def _not_there(path: Path, *remedies: str) -> UnusableInput:
    said = phrase("{file}: no such file", file=path)
    return UnusableInput(listed([said, *filter(None, remedies)], "; "))


def near(name: str, known: Iterable[str]) -> str:
    """Return ``" (did you mean …?)"`` for the known names nearest to ``name``, or all if few.

    In English, for sentences that are there in English alone; ``near_words`` is for ``phrase``.

    >>> near("z.curent", ["z.current", "x.current"])
    ' (did you mean z.current, x.current?)'
    """
    hint, names = _near(name, known)
    return hint.format(names=names)


def near_words(name: str, known: Iterable[str]) -> Worded:
    """Return what ``near`` does in the reader's language, as a part of a ``phrase``."""
    hint, names = _near(name, known)
    return phrase(hint, names=names)


def _near(name: str, known: Iterable[str]) -> tuple[str, str]:
    """Return a hint as catalogues have it, and the names in it."""
    names = list(known)
    close = get_close_matches(name, names, n=3, cutoff=0.5)
    if close:
        return msgid(" (did you mean {names}?)"), ", ".join(close)
    return msgid(" (there are: {names})"), first_names(names)


def first_names(names: Iterable[str]) -> str:
    """Return the first dozen of some names."""
    every = list(names)
    return ", ".join([*every[:12], "…"] if len(every) > 12 else every)
