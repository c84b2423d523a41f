"""The published examples of Sugeno systems, as `benchmarks.anfis` kept their errors."""

from pathlib import Path

from autodb.proofs.runs.found import piped
from docs.make.kept import sugeno_errors, sugeno_table
from docs.make.standing import between

PAGE = Path(__file__).parent.parent / "anfis.md"
COMMENTS = ("<!-- sugeno -->\n", "<!-- end of sugeno -->\n")


def filled(page: str) -> str:
    """Return the page with the errors between its two comments."""
    found = sugeno_errors()
    three = (
        f"Three inputs, 8 rules: {found.three_train:.4f} % of the training rows, "
        f"{found.three_check:.3f} % of the check rows (mean relative error); published are 0.043 "
        "and 1.066 %.\n"
    )
    return between(page, COMMENTS, f"Mackey-Glass, 16 rules:\n\n{piped(sugeno_table())}\n{three}")
