"""The published examples of Sugeno systems, as `benchmarks.anfis` kept their errors."""

from pathlib import Path

from autodb.proofs.runs.found import TextTable, piped
from docs.make.kept import sugeno_errors, sugeno_table
from docs.make.standing import between

PAGE = Path(__file__).parent.parent / "anfis.md"
COMMENTS = ("<!-- sugeno -->\n", "<!-- end of sugeno -->\n")


def filled(page: str) -> str:
    """Return the page with the errors between its two comments."""
    found = sugeno_errors()
    three = TextTable(
        "Three inputs, 8 rules",
        ("learner", ">train, %", ">check, %"),
        tuple((row.name, f"{row.train:.4f}", f"{row.check:.3f}") for row in found.three),
    )
    said = (
        f"Mackey-Glass, 16 rules:\n\n{piped(sugeno_table())}\n"
        "Three inputs, 8 rules, mean relative error (published: 0.043 and 1.066 %):\n\n"
    )
    return between(page, COMMENTS, said + piped(three))
