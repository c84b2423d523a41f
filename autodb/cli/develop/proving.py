"""`prove`: does what is said of virtual machines hold against their truth?"""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import progress_bar, say, show, table

if TYPE_CHECKING:
    from autodb.proofs.runs.found import ProofResult

CHECK_FAILED = 1

Name = Annotated[str | None, typer.Argument(help="Which proof; without it they are listed.")]
Runs = Annotated[
    int | None,
    typer.Option("--runs", min=1, help="Cases to draw, seeds 1 to this [default: of the proof]."),
]
Workers = Annotated[
    int | None,
    typer.Option("--workers", min=2, help="Processes that share the runs [default: this one]."),
]
Out = Annotated[
    Path | None,
    typer.Option("--out", help="Folder for the runs, which go on there [default: ./NAME-proof]."),
]


def prove(name: Name = None, runs: Runs = None, out: Out = None, workers: Workers = None) -> None:
    """Prove on virtual machines that autodb's answers hold; exit 1 when a check fails."""
    from autodb.errors import UnusableInput
    from autodb.proofs.carrying_out import begin_runs, carry_out
    from autodb.proofs.catalogue import proof
    from autodb.proofs.runs.found import origin_line

    if name is None:
        if (runs, out, workers) != (None, None, None):
            raise UnusableInput("--runs, --out and --workers go with the name of a proof")
        _list()
        return
    asked = proof(name)
    wanted = asked.runs if runs is None else runs
    begun = begin_runs(asked, out or Path(f"{name}-proof"))
    if begun.note:
        say(begun.note)
    there = sum(seed <= wanted for seed in begun.finished)
    if there:
        say(f"{begun.path}: {there} of {wanted} runs are already there")
    with progress_bar(f"proving {name}", wanted) as progress:
        found = carry_out(begun, wanted, progress=progress, workers=workers or 1)
    _show(found)
    say(f"{origin_line(found)}: {begun.path.with_suffix('.json')}")
    if not found.passed:
        raise typer.Exit(CHECK_FAILED)


def _list() -> None:
    from autodb.proofs.catalogue import PROOFS

    rows = table("Proofs", "name", ">runs", "what it proves")
    for one in PROOFS:
        rows.add_row(one.name, str(one.runs), one.what)
    show(rows)


def _show(found: "ProofResult") -> None:
    for one in found.tables():
        rows = table(one.title, *one.heads)
        for row in one.rows:
            rows.add_row(*row)
        show(rows)
