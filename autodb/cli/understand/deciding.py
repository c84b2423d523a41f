"""`mismatch`: what explain found on a machine, listed, shown, and a person's word on it."""

from pathlib import Path
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
from autodb.cli._reader import headed, in_english, shown_again
from autodb.cli.understand.mismatch_shown import (
    kept_of_mismatch,
    mismatch_statement,
    numbers_table,
    status_words,
)
from autodb.wording import (
    listed,
    localized,
    msgid,
    phrase,
    shop_amount,
)

if TYPE_CHECKING:
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

NONE_OPEN = msgid(
    "machine '{machine}': no open mismatch; 'autodb explain FILE --machine {machine}' looks for "
    "them"
)
NONE_AT_ALL = msgid(
    "machine '{machine}': no mismatch; 'autodb explain FILE --machine {machine}' looks for them"
)


NOT_LEARNT = {
    "lot": msgid(
        "it is noted, no prediction changes: fewer than five of its cuts are outliers, or its cuts "
        "are of no lot; 'autodb mismatch reopen' and --lot NAME name theirs"
    ),
    "pair": msgid(
        "it is noted, no prediction changes: fewer than five of its cuts state what it needs"
    ),
    "tool": msgid("it is noted, no prediction changes: its recording names no tool"),
    "calibration": msgid(
        "it is noted, no prediction changes: it states no factor, or no calibration senses it"
    ),
}
"""Why a cause that was found in forces changed nothing, by where it would be kept."""


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
    with (
        in_english(json),
        opened_machine(db, asked) as (store, name),
        store.reading() as session,
    ):
        found = mismatches(session, name, decided=all_)
        if json:
            from autodb.agent.answer.overview import mismatch_said

            say_json({"mismatches": [mismatch_said(session, row) for row in found]})
            return
        every = [_cells(row) for row in found]
    rows = table(
        phrase("Mismatches of {machine}", machine=name),
        *(headed(phrase("number")), phrase("recording"), phrase("channel"), phrase("term")),
        *(phrase("or"), phrase("kind"), headed(phrase("sure"), "%"), phrase("status")),
        phrase("statement"),
    )
    for cells in every:
        rows.add_row(*cells)
    if every:
        show(rows)
    else:
        say(phrase(NONE_AT_ALL if all_ else NONE_OPEN, machine=name))


def _cells(row: "Mismatch") -> tuple[str, ...]:
    from autodb.agent.rows.mismatches import found_words

    return (
        str(row.id), found_words(row) or Path(row.recording.path).name, row.channel, row.term,
        ", ".join(row.alternatives or ()), phrase(row.kind), f"{100 * row.confidence:.0f}",
        status_words(row), mismatch_statement(row),
    )  # fmt: skip


@mismatch.command("show")
def show_mismatch_command(number: Number, json: Json = False, db: Database = None) -> None:
    """Show all that is kept of a mismatch: its numbers, where it sits, what else it may be."""
    from autodb.agent.operate.deciding import mismatch as find

    with in_english(json), opened_store(db) as store, store.reading() as session:
        row = find(session, number)
        if json:
            from autodb.agent.answer.overview import mismatch_said

            say_json(mismatch_said(session, row))
            return
        numbers = ", ".join(str(one.id) for one in row.recordings)
        names = ", ".join(Path(one.path).name for one in row.recordings)
        of = phrase("recording") if len(row.recordings) == 1 else phrase("recordings")
        said = phrase(
            "mismatch {number}: {channel} of {recording} {numbers}: {files}",
            number=row.id, channel=row.channel, recording=of, numbers=numbers, files=names,
        )  # fmt: skip
        say(said)
        for what, text in kept_of_mismatch(row):
            say(phrase(what, what=text))
        rows = numbers_table(row)
    if rows.row_count:
        show(rows)


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

    with (
        in_english(),  # what is found is kept
        working(f"confirming mismatch {number}") as progress,
        opened_store(db) as store,
    ):
        done = confirm(store, number, term=as_, lot=lot, by=by, why=why, progress=progress)
    called = {"number": number, "term": done.term}
    if done.already:
        say(phrase("mismatch {number}: already confirmed as {term}", **called))
    elif done.kept is not None:
        _show_version(done, done.kept)
    elif done.changed:
        say(phrase("mismatch {number}: {term} confirmed", **called))
        for changed in done.changed:
            say(shown_again(changed))
    else:
        said = phrase("mismatch {number}: {term} confirmed", **called)
        say(listed([said, _why_no_version(done)], "; "))
        for note in done.notes:
            say(shown_again(note))


def _why_no_version(done: "Decided") -> str:
    if done.term == "unknown" and done.alternatives:
        either = listed((f"--as {one}" for one in done.alternatives), phrase(" or "))
        return phrase("no model changes; use {options} to put it into one", options=either)
    if not done.of_cuts or done.home not in NOT_LEARNT:
        return phrase("it belongs to this recording: it is noted, no prediction changes")
    return phrase(NOT_LEARNT[done.home])


def _show_version(done: "Decided", kept: "KeptModel") -> None:
    """Print the version that holds the term now, its numbers, and what it does to the error."""
    from autodb.agent.operate.fitting_confirmed import of_term
    from autodb.cli.understand.identified import say_not_excited, show_kept
    from autodb.sensing.drives.fit.axis_model import amplitudes, readable

    say(phrase("mismatch {number}: {term} confirmed", number=done.number, term=done.term))
    tables = [t for t in amplitudes(kept.model) if t.form == "table"]
    for t in [*readable(of_term(kept.model.fitted, done.term)), *of_term(tables, done.term)]:
        scale, unit = shop_amount(1.0, t.unit)
        number = localized(f"{scale * t.value:.4g} ± {scale * (t.sd or 0.0):.2g}")
        say(f"{t.key} {t.parameter} {number} {unit}")
    for sentence in kept.model.not_excited:
        say_not_excited(sentence)
    for sentence in kept.model.doubts:
        say(phrase("doubtful: {what}", what=shown_again(sentence)))
    show_kept(kept, done.machine)
    errors = (100 * error for error in (done.error_before, done.error) if error is not None)
    numbers = " → ".join(localized(f"{e:.2f}") for e in errors)
    said = phrase("relative error on {file}: {numbers} %", file=done.recording, numbers=numbers)
    say(said)
    if done.stale:
        said = phrase(
            "still open, found before this version: {numbers}; 'autodb explain FILE --machine "
            "{machine}' shows the residual",
            numbers=", ".join(map(str, done.stale)), machine=done.machine
        )  # fmt: skip
        say(said)


@mismatch.command("reject")
def reject_command(number: Number, by: By = None, why: Why = None, db: Database = None) -> None:
    """Reject a cause that does not hold on the machine; take back what confirming it changed."""
    from autodb.agent.operate.deciding import reject

    with in_english(), opened_store(db) as store:
        done = reject(store, number, by=by, why=why)
    already = msgid("mismatch {number}: already rejected")
    _say_back(done, already if done.already else msgid("mismatch {number}: {term} rejected"))


@mismatch.command("reopen")
def reopen_command(number: Number, by: By = None, why: Why = None, db: Database = None) -> None:
    """Take back a decision, and what it changed: the next prediction is as it was before."""
    from autodb.agent.operate.deciding import reopen

    with in_english(), opened_store(db) as store:
        done = reopen(store, number, by=by, why=why)
    already = msgid("mismatch {number}: already open")
    _say_back(done, already if done.already else msgid("mismatch {number}: {term} is open again"))


def _say_back(done: "Decided", sentence: str) -> None:
    say(phrase(sentence, number=done.number, term=done.term))
    for one in done.back:
        say(shown_again(one))
