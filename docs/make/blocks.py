"""Pages whose blocks are run: the page is the source of every command, the commands of its output.

A comment before a fenced block says what it is:

    <!-- run: autodb … -->      run the command, which must exit 0; the block becomes its output
    <!-- refused: autodb … -->  the same for a command that must exit 2
    <!-- write: NAME -->        write the block to the file NAME
    <!-- python -->             run the block
    <!-- show: NAME N -->       the block becomes the first N lines of a file

Everything happens in the order of the page, in one working folder.
"""

import contextlib
import io
import os
import re
import shlex
import textwrap
from collections.abc import Iterator
from pathlib import Path

from autodb.cli import run

COLUMNS = "200"
"""Width of the terminal that commands print to: no table wraps in it."""
FOLD = 92
"""Characters after which a sentence of the output is folded on the page; tables are not."""
TABLE = re.compile(r"\S {3,}\S|[─│]")
BLOCK = re.compile(
    r"<!-- (?P<kind>run|refused|write|python|show)(?:: (?P<what>[^\n]+?))? -->\n"
    r"(?P<fence>```\w*\n)(?P<body>.*?)```\n",
    re.DOTALL,
)
EXIT = {"run": 0, "refused": 2}


class WrongExit(Exception):  # noqa: N818 - says what happened
    """A command on a page did not end as the page says."""


def played(page: str, folder: Path) -> str:
    """Return the text of a page with the output of its commands, run in ``folder``.

    Raises WrongExit when a command ends otherwise than the page says.
    """
    with contextlib.chdir(folder), _plain_terminal():
        return BLOCK.sub(_play, page)


def _play(match: re.Match[str]) -> str:
    kind, what, body = match["kind"], match["what"], match["body"]
    if kind == "write":
        Path(what).write_text(body, encoding="utf-8")
    elif kind == "python":
        exec(compile(body, "<page>", "exec"), {"__name__": "__page__"})
    elif kind == "show":
        name, lines = what.split()
        shown = Path(name).read_text(encoding="utf-8").splitlines(keepends=True)
        body = "".join(shown[: int(lines)])
    else:
        body = f"$ {what}\n{printed(what, code=EXIT[kind])}"
    comment = match[0][: match.start("body") - match.start()]
    return f"{comment}{body}```\n"


def printed(command: str, *, code: int) -> str:
    """Return what ``autodb …`` prints, without the blanks that fill its lines, sentences folded.

    Raises WrongExit when it does not exit with ``code``.
    """
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
        ended = run(shlex.split(command)[1:])
    if ended != code:
        raise WrongExit(f"{command}: exit {ended}, the page says {code}: {out.getvalue()}")
    return "".join(f"{_folded(line.rstrip())}\n" for line in out.getvalue().splitlines())


def _folded(line: str) -> str:
    if len(line) <= FOLD or TABLE.search(line):
        return line
    indent = " " * (len(line) - len(line.lstrip()) + 4)
    return textwrap.fill(
        line, FOLD, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )


@contextlib.contextmanager
def _plain_terminal() -> Iterator[None]:
    """Fix the width and the database of every command; put back what was there."""
    before = dict(os.environ)
    os.environ["COLUMNS"] = COLUMNS
    os.environ.pop("AUTODB_DB", None)
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(before)
