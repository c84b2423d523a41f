"""What went wrong, in words that say what to do."""

from collections.abc import Iterable, Sequence
from difflib import get_close_matches

from autodb.wording import language_of, phrase


class UnusableInput(Exception):  # noqa: N818 - the name says what it is to the reader of the message
    """Input that cannot be used: one line with file, column, row and the remedy (exit 2).

    ``language``: the one that it is said in. ``problems``: each of several, without the file.
    """

    def __init__(self, line: str, problems: Sequence[str] = ()) -> None:
        self.language = language_of(line)
        self.problems = tuple(problems)
        super().__init__("".join(c if c.isprintable() else " " for c in line))


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
        return UnusableInput(f"{where}: {problems[0]}")
    listed = "; ".join(f"({number}) {said}" for number, said in enumerate(problems, start=1))
    return UnusableInput(f"{where}: {len(problems)} problems: {listed}", problems)


def near(name: str, known: Iterable[str]) -> str:
    """Return ``" (did you mean …?)"`` for the known names nearest to ``name``, or all if few.

    >>> near("z.curent", ["z.current", "x.current"])
    ' (did you mean z.current, x.current?)'
    """
    names = list(known)
    close = get_close_matches(name, names, n=3, cutoff=0.5)
    if close:
        return phrase(" (did you mean {names}?)", names=", ".join(close))
    more = ", …" if len(names) > 12 else ""
    return phrase(" (there are: {names})", names=f"{', '.join(names[:12])}{more}")
