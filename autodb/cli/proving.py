"""`prove`: do the intervals hold the truth of virtual machines as often as stated?"""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import counting, say, show, table

if TYPE_CHECKING:
    from autodb.prove.summary import Summary

CHECK_FAILED = 1
RUNS = 2000

Name = Annotated[str | None, typer.Argument(help="Which proof; without it they are listed.")]
Runs = Annotated[
    int | None,
    typer.Option("--runs", min=1, help=f"Machines to draw, seeds 1 to this [default: {RUNS}]."),
]
Out = Annotated[
    Path | None,
    typer.Option("--out", help="Folder for the runs, which go on there [default: ./NAME-proof]."),
]


def prove(name: Name = None, runs: Runs = None, out: Out = None) -> None:
    """Prove on virtual machines that 95 % intervals hold the truth; exit 1 when a check fails."""
    from autodb.errors import UnusableInput
    from autodb.prove.proofs import begin, carry_out, proof

    if name is None:
        if runs is not None or out is not None:
            raise UnusableInput("--runs and --out go with the name of a proof")
        _list()
        return
    wanted = RUNS if runs is None else runs
    begun = begin(proof(name), out or Path(f"{name}-proof"))
    if begun.note:
        say(begun.note)
    there = sum(seed <= wanted for seed in begun.finished)
    if there:
        say(f"{begun.path}: {there} of {wanted} runs are already there")
    with counting(f"proving {name}", wanted) as progress:
        found = carry_out(begun, wanted, progress=progress)
    _show(found)
    say(f"{found.line}: {begun.path.with_suffix('.json')}")
    if not found.passed:
        raise typer.Exit(CHECK_FAILED)


def _list() -> None:
    from autodb.prove.proofs import PROOFS

    rows = table("Proofs", "name", "what it proves")
    for one in PROOFS:
        rows.add_row(one.name, one.what)
    show(rows)


def _show(found: "Summary") -> None:
    from autodb.prove.summary import COLUMNS, cells

    rows = table("Intervals against the truth", *COLUMNS)
    for row in found.rows:
        rows.add_row(*cells(row))
    show(rows)
