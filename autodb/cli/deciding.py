"""`machine mismatches`, `confirm`, `reject`: a person's word on what explain found."""

from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import Database, opened, say, show, table, working

if TYPE_CHECKING:
    from autodb.agent.deciding import Decided
    from autodb.agent.identifying import KeptModel
    from autodb.store.models import Mismatch

Number = Annotated[int, typer.Argument(help="Number of the mismatch.", min=1, max=2**63 - 1)]
By = Annotated[str | None, typer.Option("--by", metavar="WHO", help="Who says so.")]
As = Annotated[
    str | None,
    typer.Option(
        "--as", metavar="TERM", help="Which of its alternatives it is [default: as named]."
    ),
]


def mismatches(
    name: Annotated[str, typer.Argument(help="Name of the machine.")],
    all_: Annotated[bool, typer.Option("--all", help="Also those decided on.")] = False,
    db: Database = None,
) -> None:
    """List the causes that explain found on a machine and nobody has decided on."""
    from autodb.agent.deciding import mismatches as find

    rows = table(
        f"Mismatches of {name}",
        ">number", "recording", "channel", "term", "or", "kind", ">sure %", "status", "statement",
    )  # fmt: skip
    with opened(db) as store, store.reading() as session:
        found = find(session, name, decided=all_)
        for row in found:
            rows.add_row(*_cells(row))
    if found:
        show(rows)
    else:
        kind = "mismatch" if all_ else "open mismatch"
        say(f"machine '{name}': no {kind}; 'autodb explain FILE --machine {name}' looks for them")


def _cells(row: "Mismatch") -> tuple[str, ...]:
    from pathlib import Path

    called = f" as {row.confirmed_term}" if row.confirmed_term not in (None, row.term) else ""
    who = f" by {row.decided_by}" if row.decided_by else ""
    return (
        str(row.id), Path(row.recording.path).name, row.channel, row.term,
        ", ".join(row.alternatives or ()), row.kind, f"{100 * row.confidence:.0f}",
        f"{row.status}{called}{who}", row.statement,
    )  # fmt: skip


def confirm(number: Number, as_: As = None, by: By = None, db: Database = None) -> None:
    """Confirm a cause: a term of the machine becomes part of its model, as the next version."""
    from autodb.agent.deciding import confirm as run

    with working(f"confirming mismatch {number}") as progress, opened(db) as store:
        done = run(store, number, term=as_, by=by, progress=progress)
    if done.already:
        say(f"mismatch {number}: already confirmed as {done.term}")
    elif done.kept is None:
        say(f"mismatch {number}: {done.term} confirmed; {_why_no_version(done)}")
    else:
        _show_version(done, done.kept)


def _why_no_version(done: "Decided") -> str:
    if done.term == "unknown" and done.alternatives:
        return f"no model changes; --as {' or --as '.join(done.alternatives)} would put it into one"
    return "it belongs to this recording, no model changes"


def _show_version(done: "Decided", kept: "KeptModel") -> None:
    """Print the version that holds the term now, its numbers, and what it does to the error."""
    from autodb.agent.deciding import of_term
    from autodb.cli.identifying import show_kept
    from autodb.sensing.axis_model import amplitudes, readable

    say(f"mismatch {done.number}: {done.term} confirmed")
    tables = [t for t in amplitudes(kept.model) if t.form == "table"]
    for t in [*readable(of_term(kept.model.fitted, done.term)), *of_term(tables, done.term)]:
        say(f"{t.key} {t.parameter} {t.value:.4g} ± {t.sd or 0.0:.2g} {t.unit}")
    for sentence in kept.model.not_excited:
        say(f"not excited, no number: {sentence}")
    for sentence in kept.model.doubts:
        say(f"doubtful: {sentence}")
    show_kept(kept, done.machine)
    errors = (100 * error for error in (done.error_before, done.error) if error is not None)
    say(f"relative error on {done.recording}: {' → '.join(f'{e:.2f}' for e in errors)} %")
    if done.stale:
        numbers = ", ".join(map(str, done.stale))
        again = f"'autodb explain FILE --machine {done.machine}' says what of it is left"
        say(f"still open, found before this version: {numbers}; {again}")


def reject(number: Number, by: By = None, db: Database = None) -> None:
    """Reject a cause: it was looked at, and does not hold on the machine."""
    from autodb.agent.deciding import reject as run

    with opened(db) as store:
        done = run(store, number, by=by)
    say(f"mismatch {number}: {'already rejected' if done.already else f'{done.term} rejected'}")
