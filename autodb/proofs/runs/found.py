"""What every proof finds: whether it passed, where it came from, tables for terminal and page."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, Self

from pydantic import TypeAdapter

from autodb.proofs.runs.run_file import Origin


@dataclass(frozen=True)
class TextTable:
    """A table of text; heads that begin with > stand over right-aligned columns."""

    title: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


class ProofResult(Protocol):
    """The score of a proof."""

    @property
    def origin(self) -> Origin:
        """What its runs came from."""

    @property
    def seeds(self) -> tuple[int, int]:
        """First and last seed."""

    @property
    def passed(self) -> bool:
        """Say whether everything is within its limits."""

    def tables(self) -> Sequence[TextTable]:
        """Return all that was found."""

    def to_json(self) -> str:
        """Return it as JSON."""


class KeptAsJson:
    """A dataclass that a proof's folder keeps as JSON."""

    def to_json(self) -> str:
        """Return it as JSON, as ``from_json`` reads it."""
        return TypeAdapter(type(self)).dump_json(self, indent=1).decode() + "\n"

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Return what was written; raises pydantic's ValidationError on any other text."""
        return TypeAdapter(cls).validate_json(text)


Check = tuple[str, str, str, bool]
"""What is checked, what it is, what it must be, and whether it is."""


class CheckedScore(KeptAsJson):
    """The score of a proof that passes where all of its checks do."""

    def checks(self) -> list[Check]:
        """Return all that must be."""
        raise NotImplementedError

    @property
    def passed(self) -> bool:
        """Say whether everything is within its limits."""
        return all(passed for *_, passed in self.checks())

    def limits(self, title: str) -> TextTable:
        """Return the table of the checks."""
        rows = tuple((*cells, passed_words(passed)) for *cells, passed in self.checks())
        return TextTable(title, ("", ">found", ">must be", ""), rows)


def passed_words(passed: bool) -> str:
    """Return what a cell says of a check."""
    return "passed" if passed else "FAILED"


def origin_line(found: ProofResult) -> str:
    """Return where a score came from, in one line."""
    first, last = found.seeds
    origin = found.origin
    return (
        f"{origin.proof}: {last - first + 1} runs, seeds {first} to {last}, "
        f"autodb {origin.version}, generator {origin.generator}, product {origin.product}"
    )


def markdown(found: ProofResult) -> str:
    """Return the line of origin and the tables as a page has them; one alone needs no title."""
    tables = found.tables()
    titles = [f"**{table.title}**\n\n" if len(tables) > 1 else "" for table in tables]
    whole = [f"{title}{piped(table)}" for title, table in zip(titles, tables, strict=True)]
    return "\n".join([f"{origin_line(found)}\n", *whole])


def piped(table: TextTable) -> str:
    """Return a table as a page has it."""
    heads = [name.removeprefix(">") for name in table.heads]
    rules = ["---:" if name.startswith(">") else "---" for name in table.heads]
    return "".join(f"| {' | '.join(row)} |\n" for row in (heads, rules, *table.rows))


def percent(share: float | None) -> str:
    """Return a share as a cell has it; nothing for none."""
    return "" if share is None else f"{100.0 * share:.1f} %"


def ratio(value: float | None) -> str:
    """Return a ratio as a cell has it; nothing for none."""
    return "" if value is None else f"{value:.2f}"
