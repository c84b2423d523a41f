"""`mismatch`: what explain found on a machine, listed, shown, and a person's word on it."""

from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import (
    Database,
    Json,
    MachineAlone,
    MachineName,
    named_machine,
    opened_machine,
    opened_store,
    say,
    say_json,
    show,
    table,
    working,
)
from autodb.files.channels import unit_of
from autodb.wording import listed_stretches

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.table import Table

    from autodb.agent.operate.deciding import Decided
    from autodb.agent.sense.identifying import KeptModel
    from autodb.store.models import Mismatch

mismatch = typer.Typer(
    help="Causes that explain found on a machine: list, show, confirm, reject, reopen.",
    no_args_is_help=True,
)

Number = Annotated[int, typer.Argument(help="Number of the mismatch.", min=1, max=2**63 - 1)]
By = Annotated[str | None, typer.Option("--by", metavar="WHO", help="Who says so.")]
Why = Annotated[
    str | None, typer.Option("--why", metavar="TEXT", help="Why; kept with the decision.")
]
Lot = Annotated[
    str | None,
    typer.Option(
        "--lot",
        metavar="NAME",
        help="Lot of material that a hard spot is of [default: as cuts say].",
    ),
]
As = Annotated[
    str | None,
    typer.Option(
        "--as", metavar="TERM", help="Which of its alternatives it is [default: as named]."
    ),
]


@mismatch.command("list")
def list_mismatches_command(
    alone: MachineAlone = None,
    machine: MachineName = None,
    all_: Annotated[bool, typer.Option("--all", help="Also those decided on.")] = False,
    json: Json = False,
    db: Database = None,
) -> None:
    """List the causes that explain found on a machine and nobody has decided on."""
    from autodb.agent.operate.deciding import mismatches

    asked = named_machine(machine, alone)
    with opened_machine(db, asked) as (store, name), store.reading() as session:
        found = mismatches(session, name, decided=all_)
        if json:
            from autodb.agent.answer.overview import mismatch_said

            say_json({"mismatches": [mismatch_said(session, row) for row in found]})
            return
        listed = [_cells(row) for row in found]
    rows = table(
        f"Mismatches of {name}",
        ">number", "recording", "channel", "term", "or", "kind", ">sure %", "status", "statement",
    )  # fmt: skip
    for cells in listed:
        rows.add_row(*cells)
    if listed:
        show(rows)
    else:
        kind = "mismatch" if all_ else "open mismatch"
        say(f"machine '{name}': no {kind}; 'autodb explain FILE --machine {name}' looks for them")


def _cells(row: "Mismatch") -> tuple[str, ...]:
    from autodb.agent.rows.mismatches import found_words

    return (
        str(row.id), found_words(row) or _name(row.recording.path), row.channel, row.term,
        ", ".join(row.alternatives or ()), row.kind, f"{100 * row.confidence:.0f}",
        _status(row), row.statement,
    )  # fmt: skip


@mismatch.command("show")
def show_mismatch_command(number: Number, json: Json = False, db: Database = None) -> None:
    """Show all that is kept of a mismatch: its numbers, where it sits, what else it may be."""
    from autodb.agent.operate.deciding import mismatch as find

    with opened_store(db) as store, store.reading() as session:
        row = find(session, number)
        if json:
            from autodb.agent.answer.overview import mismatch_said

            say_json(mismatch_said(session, row))
            return
        several = "s" if len(row.recordings) > 1 else ""
        numbers = ", ".join(str(one.id) for one in row.recordings)
        names = ", ".join(_name(one.path) for one in row.recordings)
        say(f"mismatch {row.id}: {row.channel} of recording{several} {numbers}: {names}")
        for what, text in _details(row):
            say(f"{what}: {text}")
        rows = _numbers(row)
    if rows.row_count:
        show(rows)


def _name(path: str) -> str:
    from pathlib import Path

    return Path(path).name


def _details(row: "Mismatch") -> "Iterator[tuple[str, str]]":
    """Return what is kept of a mismatch, a line each: what it is and its text."""
    from autodb.agent.rows.mismatches import decision_words, found_words
    from autodb.terms.homes import kept_words
    from autodb.terms.vocabulary import effect_called

    if found := found_words(row):
        yield "found in", found
    yield "term", f"{row.term} ({row.kind}, {100 * row.confidence:.0f} % sure)"
    yield "statement", row.statement
    yield "where", "; ".join(_places(row)) or f"all along the recording{'s' if row.further else ''}"
    if row.variables:
        yield "depends on", ", ".join(row.variables)
    if row.alternatives:
        yield "or", ", ".join(row.alternatives)
        yield "to tell them apart", row.to_tell_apart or "no simple move or cut separates them"
    yield "status", _status(row) + (f" on {row.decided_at}" if row.decided_at else "")
    for decision in row.decisions:
        yield "decision", decision_words(decision)
    if row.lot is not None:
        yield "lot", row.lot
    yield from (("made", text) for text in _made(row))
    yield "once confirmed", kept_words(row.confirmed_term or row.term, row.channel)
    one = effect_called(row.confirmed_term or row.term)
    yield "advice", f"{one.check} ({one.check_source})"


def _made(row: "Mismatch") -> "Iterator[str]":
    """Return the versions that hold a mismatch; those that were taken back say so."""
    for model in row.models:
        yield f"{model.channel} version {model.version} (model {model.id}){_back(model.undone_at)}"
    for one in row.calibrations:
        back = _back(one.undone_at)
        yield f"calibration of {one.axis} version {one.version} (calibration {one.id}){back}"
    for held in row.parameters_of_pairs:
        pair = f"{held.pair.material.name} / {held.pair.tool.name}"
        back = _back(held.undone_at)
        yield f"{pair} version {held.version} (parameters {held.id}){back}"


def _back(undone_at: str | None) -> str:
    return "" if undone_at is None else f", taken back on {undone_at}"


def _places(row: "Mismatch") -> "Iterator[str]":
    """Return the stretches and regimes in which a mismatch sits."""
    what, unit = ("cuts", "") if row.recording.kind == "cuts" else ("from", " s")
    if row.further:
        what = "of all cuts in the order of time"
    for low, high, count in listed_stretches(row.intervals or ()):
        some = "" if count == 1 else f"{count} stretches "
        yield f"{some}{what} {low:g} to {high:g}{unit}"
    for one in row.regime or ():
        unit = f" {known}" if (known := unit_of(one["signal"])) else ""
        holds = f"{100 * one['share']:.0f} % of it"
        if one.get("rows") is not None:
            holds = (
                f"{100 * one['share']:.0f} % of the squared error in {100 * one['rows']:.0f} % of "
                "the rows"
            )
        yield f"{one['signal']} {one['low']:.4g} to {one['high']:.4g}{unit}, {holds}"


def _numbers(row: "Mismatch") -> "Table":
    rows = table("Its numbers", "parameter", ">value", ">95 % from", ">to", "unit")
    for name, value in row.parameters.items():
        numbers = (f"{value[key]:.4g}" for key in ("value", "low", "high"))
        rows.add_row(name, *numbers, value["unit"])
    return rows


def _status(row: "Mismatch") -> str:
    called = f" as {row.confirmed_term}" if row.confirmed_term not in (None, row.term) else ""
    who = f" by {row.decided_by}" if row.decided_by else ""
    return f"{row.status}{called}{who}"


@mismatch.command("confirm")
def confirm_command(
    number: Number,
    as_: As = None,
    lot: Lot = None,
    by: By = None,
    why: Why = None,
    db: Database = None,
) -> None:
    """Confirm a cause: it becomes part of what the machine knows, as the next version.

    A term of the machine enters its model, one of cutting the work-tool pair's parameters, run-out
    the tool, a gain the calibration. `mismatch show` says where its term is kept. What belongs to
    its recording is noted, and no prediction changes.
    """
    from autodb.agent.operate.deciding import confirm

    with working(f"confirming mismatch {number}") as progress, opened_store(db) as store:
        done = confirm(store, number, term=as_, lot=lot, by=by, why=why, progress=progress)
    if done.already:
        say(f"mismatch {number}: already confirmed as {done.term}")
    elif done.kept is not None:
        _show_version(done, done.kept)
    elif done.changed:
        say(f"mismatch {number}: {done.term} confirmed")
        for changed in done.changed:
            say(changed)
    else:
        say(f"mismatch {number}: {done.term} confirmed; {_why_no_version(done)}")
        for note in done.notes:
            say(note)


def _why_no_version(done: "Decided") -> str:
    if done.term == "unknown" and done.alternatives:
        return (
            f"no model changes; use --as {' or --as '.join(done.alternatives)} to put it into one"
        )
    if done.of_cuts and done.home == "lot":
        return (
            "it is noted, no prediction changes: fewer than five of its cuts are outliers, or its "
            "cuts are of no lot; 'autodb mismatch reopen' and --lot NAME name theirs"
        )
    if done.of_cuts and done.home == "pair":
        return "it is noted, no prediction changes: fewer than five of its cuts state what it needs"
    if done.of_cuts and done.home == "tool":
        return "it is noted, no prediction changes: its recording names no tool"
    if done.of_cuts and done.home == "calibration":
        return (
            "it is noted, no prediction changes: it states no factor, or no calibration senses it"
        )
    return "it belongs to this recording: it is noted, no prediction changes"


def _show_version(done: "Decided", kept: "KeptModel") -> None:
    """Print the version that holds the term now, its numbers, and what it does to the error."""
    from autodb.agent.operate.fitting_confirmed import of_term
    from autodb.cli.understand.identifying import show_kept
    from autodb.sensing.drives.fit.axis_model import amplitudes, readable

    say(f"mismatch {done.number}: {done.term} confirmed")
    tables = [t for t in amplitudes(kept.model) if t.form == "table"]
    for t in [*readable(of_term(kept.model.fitted, done.term)), *of_term(tables, done.term)]:
        say(f"{t.key} {t.parameter} {t.value:.4g} ± {t.sd or 0.0:.2g} {t.unit}")
    for sentence in kept.model.not_excited:
        say(f"not excited, not estimated: {sentence}")
    for sentence in kept.model.doubts:
        say(f"doubtful: {sentence}")
    show_kept(kept, done.machine)
    errors = (100 * error for error in (done.error_before, done.error) if error is not None)
    say(f"relative error on {done.recording}: {' → '.join(f'{e:.2f}' for e in errors)} %")
    if done.stale:
        numbers = ", ".join(map(str, done.stale))
        again = f"'autodb explain FILE --machine {done.machine}' shows the residual"
        say(f"still open, found before this version: {numbers}; {again}")


@mismatch.command("reject")
def reject_command(number: Number, by: By = None, why: Why = None, db: Database = None) -> None:
    """Reject a cause that does not hold on the machine; take back what confirming it changed."""
    from autodb.agent.operate.deciding import reject

    with opened_store(db) as store:
        done = reject(store, number, by=by, why=why)
    _say_back(done, "already rejected" if done.already else f"{done.term} rejected")


@mismatch.command("reopen")
def reopen_command(number: Number, by: By = None, why: Why = None, db: Database = None) -> None:
    """Take back a decision, and what it changed: the next prediction is as it was before."""
    from autodb.agent.operate.deciding import reopen

    with opened_store(db) as store:
        done = reopen(store, number, by=by, why=why)
    _say_back(done, "already open" if done.already else f"{done.term} is open again")


def _say_back(done: "Decided", said: str) -> None:
    say(f"mismatch {done.number}: {said}")
    for one in done.back:
        say(one)
