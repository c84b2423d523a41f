"""The table of boosted trees on the learning curve's pairs, as `benchmarks.pair_peers` wrote it."""

from pathlib import Path

from autodb.proofs.runs.found import TextTable, percent, piped
from autodb.proofs.runs.pairs.curve_run import LEARNT
from benchmarks.pair_peers import ROWS

KEPT = Path(__file__).parent / "pair-peers.json"
PAGE = KEPT.parent.parent / "proofs" / "pairs.md"
BEGIN, END = "<!-- pair peers -->\n", "<!-- end of pair peers -->\n"


def filled(page: str) -> str:
    """Return ``page`` with the table between its two comments."""
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    return f"{before}{BEGIN}\n{piped(table())}\n{END}{after}"


def table() -> TextTable:
    """Return errors by way, component and number of cuts, with standard errors over pairs."""
    rows = tuple(
        (
            row.method, row.component,
            *(f"{percent(e)} ± {percent(s)}" if e is not None else "" for e, s in
              zip(row.error, row.se, strict=True)),
        )
        for row in ROWS.validate_json(KEPT.read_bytes())
    )  # fmt: skip
    return TextTable("", ("way", "component", *(f">{n} cuts" for n in LEARNT)), rows)
