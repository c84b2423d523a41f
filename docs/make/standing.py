"""The page *Where it stands*: a table a job, and above them what works and what does not."""

import re
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

from autodb.proofs.runs.found import TextTable, piped
from docs.make.kept import kept
from docs.make.standing_rows import JOBS, Figure

PAGE = Path(__file__).parent.parent / "where-it-stands.md"
ANSWER = ("<!-- what works -->\n", "<!-- end of what works -->\n")
TABLES = ("<!-- figures -->\n", "<!-- end of figures -->\n")
UNIT = re.compile(r"(?<=\d) (?=%|N\b)")
"""A space before a unit, which no line is broken at."""
MISSING = "none run", "none"
"""What stands in place of a rival and of an oracle."""
HEADS = ("what", ">figure", ">limit", "", "best rival, same data", ">oracle", "printed by; product")


def figures() -> list[Figure]:
    """Return all figures of the page, job by job."""
    return [figure for job in JOBS for figure in job()]


def filled(page: str) -> str:
    """Return the page with its first paragraph and its tables between their comments."""
    found = figures()
    return between(between(page, ANSWER, answer(found)), TABLES, tables(found))


def between(page: str, comments: tuple[str, str], text: str) -> str:
    """Return a page with a text between two comments."""
    begin, end = comments
    before, rest = page.split(begin)
    _, after = rest.split(end)
    return f"{before}{begin}\n{text}\n{end}{after}"


def tables(found: Sequence[Figure]) -> str:
    """Return a heading and a table a job."""
    return "\n".join(
        f"## {job}\n\n{piped(TextTable('', HEADS, tuple(cells(one) for one in rows)))}"
        for job, rows in groupby(found, lambda one: one.job)
    )


def cells(one: Figure) -> tuple[str, ...]:
    """Return the row of a figure."""
    source = kept(one.value.of)
    behind = [] if one.interval is None else [one.interval.text]
    found = (
        one.what,
        f"{one.said}<br>{', '.join([*behind, f'n = {one.cases_or_runs}'])}",
        one.must_be,
        one.verdict,
        MISSING[0] if one.rival is None else f"{one.rival[0]}: {one.rival[1].text}",
        MISSING[1] if one.oracle is None else one.oracle.text,
        f"`{source.short}`<br>{source.product}",
    )
    return tuple(map(unbroken, found))


def unbroken(text: str) -> str:
    """Return a text whose numbers keep their units in one line."""
    return UNIT.sub("\N{NO-BREAK SPACE}", text)


def answer(found: Sequence[Figure]) -> str:
    """Return what works and what does not, counted."""
    met = sum(not one.missed for one in found)
    lines = [
        f"**What works**: {met} of {len(found)} limits are met. {_counts(found)}",
        "",
        f"**What does not**: {len(found) - met} limits are missed.",
        "",
        *(f"- {one.what}: {one.said}; asked: {one.must_be}." for one in found if one.missed),
    ]
    return "\n".join(lines) + "\n"


def _counts(found: Sequence[Figure]) -> str:
    parts = []
    for job, group in groupby(found, lambda one: one.job):
        rows = list(group)
        parts.append(f"{job.split(':')[0]}: {sum(not one.missed for one in rows)} of {len(rows)}.")
    return " ".join(parts)
