"""Inputs that cannot be used, and the line that each one gets.

`python -m tests.by_hand.bad_inputs docs/bad-inputs.md` makes every one of them, gives it to its
command and writes the page; a test compares the page with what the commands say.
"""

import contextlib
import io
import os
import sys
import tempfile
import textwrap
from collections.abc import Iterator
from pathlib import Path

from autodb.cli import run
from tests.helpers.bad_inputs import PARTS, Case

NOBODY = 65534
HEAD = """\
# Bad inputs

What each unusable input gets: one line on standard error (folded here), exit status 2, nothing
stored. Every line below was printed by the command beside it, on a file made for this page.

<!-- made by python -m tests.by_hand.bad_inputs docs/bad-inputs.md -->
"""


@contextlib.contextmanager
def folder_of(case: Case) -> Iterator[Path]:
    """Give a new working folder that holds the case's files."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o755)
        case.make(folder)
        os.chdir(folder)
        try:
            yield folder
        finally:
            os.chdir(before)


def answer(case: Case) -> tuple[int, str]:
    """Return exit status and standard error of a case's command."""
    with folder_of(case):
        if case.as_nobody and os.geteuid() == 0:
            return _in_child(case)
        return _run(case)


def _run(case: Case) -> tuple[int, str]:
    error = io.StringIO()
    with contextlib.redirect_stderr(error), contextlib.redirect_stdout(io.StringIO()):
        code = run(case.command.split()[1:])
    return code, error.getvalue()


def _in_child(case: Case) -> tuple[int, str]:
    """Run as the user nobody: the superuser has every permission."""
    _run(Case("", "autodb import nothing.csv", case.make))  # imports what the child may not read
    reads, writes = os.pipe()
    child = os.fork()
    if child == 0:
        os.setuid(NOBODY)
        code, text = _run(case)
        os.write(writes, text.encode())
        os._exit(code)
    os.close(writes)
    with os.fdopen(reads, encoding="utf-8") as pipe:
        text = pipe.read()
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), text


def page() -> str:
    """Return the page, made by running every case."""
    parts = [HEAD]
    for title, cases in PARTS:
        parts.append(f"\n## {title}\n")
        parts += [entry(case, answer(case)[1]) for case in cases]
    return "".join(parts)


def entry(case: Case, said: str) -> str:
    """Return a case's entry on the page: what is wrong, the command, the line that it gets."""
    line = textwrap.fill(said.strip(), 96, break_on_hyphens=False, break_long_words=False)
    return f"\n**{case.what}** · `{case.command}`\n\n```text\n{line}\n```\n"


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python -m tests.by_hand.bad_inputs PAGE")
    Path(sys.argv[1]).write_text(page(), encoding="utf-8")
