"""The page of the field: each job's rivals, what they and autodb get, and who wins by how much."""

import re
from collections.abc import Sequence
from pathlib import Path

from autodb.proofs.runs.found import TextTable, piped
from docs.make.field_rows import CONTESTS, Contest, Rival
from docs.make.kept import Kept, kept
from docs.make.standing import between, unbroken

PAGE = Path(__file__).parent.parent / "peers.md"
ANSWER = ("<!-- who wins -->\n", "<!-- end of who wins -->\n")
TABLES = ("<!-- field -->\n", "<!-- end of field -->\n")
HEADS = ("rival", "version", "set up", "figure", ">its", ">ours", "who wins")
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
SHARE = re.compile(r"of (\d+)$")
OURS, EVEN = "autodb", "even"
ALIKE = 1.005
"""Errors that differ by less than this factor are even: the page prints no more digits."""


def contests() -> list[Contest]:
    """Return all jobs with rivals."""
    return [contest() for contest in CONTESTS]


def filled(page: str) -> str:
    """Return the page with its first paragraph and its tables between their comments."""
    found = contests()
    return between(between(page, ANSWER, answer(found)), TABLES, tables(found))


def tables(found: Sequence[Contest]) -> str:
    """Return a heading, a sentence on the data, a table and its commands, job by job."""
    return "\n".join(map(_section, found))


def _section(one: Contest) -> str:
    of = dict.fromkeys(cell.of for rival in one.rivals for cell in (rival.theirs, rival.ours))
    commands = [f"    {_command(kept(name))}\n" for name in of]
    table = piped(TextTable("", HEADS, tuple(map(cells, one.rivals))))
    return f"## {one.job}\n\n{one.data}\n\n{table}\n{''.join(commands)}"


def _command(source: Kept) -> str:
    """Return a command and the product that it judged, where that is kept."""
    return f"{source.command}    # product {source.product}" if source.product else source.command


def cells(one: Rival) -> tuple[str, ...]:
    """Return the row of a rival."""
    winner, by = won(one)
    row = (
        one.name,
        one.version if isinstance(one.version, str) else one.version.text,
        one.setup,
        one.figure,
        one.theirs.text,
        one.ours.text,
        f"{OURS}, {by}" if winner == OURS else f"**{winner}**, {by}" if by else EVEN,
    )
    return tuple(map(unbroken, row))


def won(one: Rival) -> tuple[str, str]:
    """Return who wins, `autodb` or the rival's name, and by how much; no words where it is even."""
    theirs, ours = one.theirs.text, one.ours.text
    other, own = (float(NUMBER.findall(text)[0]) for text in (theirs, ours))
    if other == own or (not one.more and max(other, own) < ALIKE * min(other, own)):
        return EVEN, ""
    winner = OURS if (own > other) == one.more else one.name
    if not one.more:
        return winner, f"by a factor of {max(other, own) / min(other, own):.2f}"
    count = SHARE.search(ours)
    gap = abs(own - other)
    return winner, f"by {gap:g} of {count[1]}" if count else f"by {gap:.1f} points"


def answer(found: Sequence[Contest]) -> str:
    """Return in how many figures autodb is ahead, and each in which a rival is."""
    rows = [(one, *won(one)) for contest in found for one in contest.rivals]
    ahead = sum(winner == OURS for _, winner, _ in rows)
    behind = [(one, by) for one, winner, by in rows if winner not in (OURS, EVEN)]
    even = len(rows) - ahead - len(behind)
    lines = [
        f"autodb is ahead in {ahead} of {len(rows)} figures of {len(found)} jobs"
        f"{f', even in {even}' if even else ''}. A rival wins in {len(behind)}:",
        "",
        *(
            f"- {one.name}, {one.figure}: {one.theirs.text} for {one.ours.text}, {by}."
            for one, by in behind
        ),
    ]
    return "\n".join(lines) + "\n"
