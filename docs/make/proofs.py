"""The pages of proofs, with tables as `autodb prove` wrote them into its folder.

A proof takes too long for a test: its summary is kept here, and the pages are made from it. A
section begins with its answer, a paragraph, which the first page has beside the limits it meets.
"""

import re
from dataclasses import dataclass
from pathlib import Path

from autodb.proofs.catalogue import proof
from autodb.proofs.runs.found import ProofResult, TextTable, markdown, piped

KEPT = Path(__file__).parent
FOLDER = KEPT.parent / "proofs"
INDEX = FOLDER / "index.md"
PAGES = tuple(
    FOLDER / f"{name}.md"
    for name in ("axes", "time", "lathes", "mills", "pairs", "explain", "real", "keeping")
)
BEGIN, END = "<!-- proof: {} -->\n", "<!-- end of proof -->\n"
PROOF = re.compile(BEGIN.format(r"([\w-]+)") + ".*?" + END, re.DOTALL)
ALL_BEGIN, ALL_END = "<!-- all proofs -->\n", "<!-- end of all proofs -->\n"


@dataclass(frozen=True)
class Section:
    """A part of a page under its own heading: the answer, what follows it, the proofs in it."""

    title: str
    answer: str
    rest: str
    proofs: tuple[str, ...]


def kept(name: str) -> ProofResult:
    """Return the summary of a proof that is kept beside this file."""
    return proof(name).read((KEPT / f"{name}.json").read_text("utf-8"))


def filled(page: str) -> str:
    """Return ``page`` with the table of each proof between its two comments."""
    return PROOF.sub(lambda found: _with_tables(found[1]), page)


def _with_tables(name: str) -> str:
    return f"{BEGIN.format(name)}\n{markdown(kept(name))}\n{END}"


def sections(page: str) -> list[Section]:
    """Return the parts of ``page`` under their headings, in order."""
    found = []
    for part in re.split(r"^## ", page, flags=re.MULTILINE)[1:]:
        title, answer, rest = part.split("\n\n", 2)
        found.append(Section(title, " ".join(answer.split()), rest, tuple(PROOF.findall(rest))))
    return found


def index_filled(index: str) -> str:
    """Return the first page with the table of all proofs between its two comments."""
    before, rest = index.split(ALL_BEGIN)
    _, after = rest.split(ALL_END)
    return f"{before}{ALL_BEGIN}\n{piped(overview())}\n{ALL_END}{after}"


def overview() -> TextTable:
    """Return what each proof answers, of how many runs, and which of its limits are met."""
    rows = tuple(
        (f"[{one.title}]({page.name}#{_anchor(one.title)})", *_counted(one), one.answer)
        for page in PAGES
        for one in sections(page.read_text("utf-8"))
    )
    return TextTable("", ("proof", ">runs", "limits met", "autodb", "answer"), rows)


def _anchor(title: str) -> str:
    return re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-")


def _counted(section: Section) -> tuple[str, str, str]:
    """Return runs, limits met and version of a section's proofs, as cells have them."""
    found = {name: kept(name) for name in section.proofs}
    runs = {str(one.seeds[1] - one.seeds[0] + 1): None for one in found.values()}
    met = (f"`{name}`: {_met(one)}" for name, one in found.items())
    versions = {one.origin.version: None for one in found.values()}
    return ", ".join(runs), ", ".join(met), ", ".join(versions)


def _met(one: ProofResult) -> str:
    cells = [cell for table in one.tables() for row in table.rows for cell in row]
    passed = cells.count("passed")
    return f"{passed} of {passed + cells.count('FAILED')}"
