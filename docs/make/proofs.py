"""The tables of the proofs, as `autodb prove` wrote them into its folder.

A proof takes too long for a test: its summary is kept here, and the page is made from it.
"""

from pathlib import Path

from autodb.proofs.catalogue import proof
from autodb.proofs.runs.found import ProofResult, markdown

KEPT = Path(__file__).parent
BEGIN, END = "<!-- proof: {} -->\n", "<!-- end of proof -->\n"


def kept(name: str) -> ProofResult:
    """Return the summary of a proof that is kept beside this file."""
    return proof(name).read((KEPT / f"{name}.json").read_text("utf-8"))


def filled(page: str, names: list[str]) -> str:
    """Return ``page`` with the table of each proof between its two comments."""
    for name in names:
        before, rest = page.split(BEGIN.format(name))
        _, after = rest.split(END, maxsplit=1)
        page = f"{before}{BEGIN.format(name)}\n{markdown(kept(name))}\n{END}{after}"
    return page
