"""The tables of known methods, from the lines that `python -m benchmarks.peers.run` wrote."""

from pathlib import Path

from benchmarks.peers.run import kept
from benchmarks.peers.table import markdown

KEPT = Path(__file__).parent / "peers.jsonl"
PAGE = KEPT.parent.parent / "peers.md"
BEGIN, END = "<!-- peers -->\n", "<!-- end of peers -->\n"


def filled(page: str) -> str:
    """Return ``page`` with the tables between its two comments."""
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    return f"{before}{BEGIN}\n{markdown(kept(KEPT))}\n{END}{after}"
