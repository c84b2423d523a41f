"""`doctor`, `backup`, `restore`, `export`: a database that lasts."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import (
    Database,
    Json,
    opened_store,
    say,
    say_json,
    show,
    table,
    working,
)
from autodb.cli._reader import headed, in_english, shown_again
from autodb.wording import localized, phrase

if TYPE_CHECKING:
    from autodb.agent.operate.doctor import Finding
    from autodb.store.copies import Copied

CHECK_FAILED = 1
EXAMPLES = 3
Replace = Annotated[bool, typer.Option("--replace", help="Replace what is there.")]


def doctor(
    backups: Annotated[
        Path | None,
        typer.Option(
            "--backups",
            metavar="FOLDER",
            help="Restore its newest backup in a temporary place, and check that.",
        ),
    ] = None,
    json: Json = False,
    db: Database = None,
) -> None:
    """Check the database and the recordings it came from; exit 1 when a check fails."""
    from autodb.agent.operate.doctor import OF_ITS_VALUES, OF_ROWS, OF_THE_CONTENT, examine
    from autodb.store import database_url, on_server

    url = database_url(db)
    with in_english(json), working("checking") as progress:
        findings = examine(url, backups=backups, progress=progress)
    if json:
        say_json([{"check": one.check.name, **asdict(one.outcome)} for one in findings])
        _fail_where_one_did(findings)
        return
    heads = (phrase("check"), headed(phrase("found")), phrase("must be"), "")
    rows = table(phrase("Checks"), *heads)
    for finding in findings:
        out = finding.outcome
        verdict = phrase("passed") if out.passed else phrase("FAILED")
        found, must = phrase(out.statistic), f"{out.operator} {phrase(out.threshold)}"
        rows.add_row(phrase(finding.check.name), found, must, verdict)
    done = {finding.check.name for finding in findings}
    why_not = phrase("not checked: the file comes first")
    if on_server(url):
        why_not = phrase("not checked: the schema comes first")
        if OF_ROWS[0].name in done:
            why_not = phrase("not checked: they lie on the machines' computers")
    for check in (*OF_ITS_VALUES, *OF_THE_CONTENT):
        if check.name not in done:
            rows.add_row(phrase(check.name), "", "", why_not)
    show(rows)
    _say_what_was_found(findings)
    _fail_where_one_did(findings)


def _fail_where_one_did(findings: "list[Finding]") -> None:
    if not all(finding.outcome.passed for finding in findings):
        raise typer.Exit(CHECK_FAILED)


def _say_what_was_found(findings: "list[Finding]") -> None:
    """Print what passed checks found, and of failed ones some examples and what to do."""
    for finding in findings:
        found, check = finding.outcome.found, finding.check
        name = phrase(check.name)
        for line in found[:EXAMPLES]:
            say(phrase("{check}: {what}", check=name, what=line))
        if not finding.outcome.passed:
            more = len(found) - EXAMPLES
            if more > 0:
                name = phrase("{check} ({count} more)", check=name, count=more)
            say(phrase("{check}: {what}", check=name, what=check.remedy_words))


def backup_command(
    file: Annotated[
        Path, typer.Argument(help="File to write the copy to; with --keep or --every, a folder.")
    ],
    replace: Replace = False,
    keep: Annotated[
        int | None,
        typer.Option(
            "--keep", metavar="N", min=1, help="A dated one in the folder, of which N stay."
        ),
    ] = None,
    every: Annotated[
        str | None,
        typer.Option(
            "--every",
            metavar="PERIOD",
            help="A dated one in the folder where the newest is as old: hour, day or week.",
        ),
    ] = None,
    json: Json = False,
    db: Database = None,
) -> None:
    """Copy the database into one SQLite file, also while others write to it, and check it."""
    from autodb.errors import UnusableInput
    from autodb.store import database_url
    from autodb.store.backups import backup

    if keep is not None or every is not None:
        if replace:
            raise UnusableInput(phrase("--replace goes with a file; dated backups replace none"))
        _rotate(database_url(db), file, keep, every, json=json)
        return
    with working(f"copying to {file.name}") as progress:
        done = backup(database_url(db), file, replace=replace, progress=progress)
    if json:
        say_json({"file": file, **asdict(done)})
        return
    say(phrase("{file}: {rows}", file=file, rows=_rows(done)))


def _rows(copied: "Copied") -> str:
    """Return how much was copied."""
    return phrase(
        "{total} rows of {count} tables, schema {schema}",
        total=copied.total,
        count=len(copied.rows),
        schema=copied.schema,
    )


def _rotate(url: str, folder: Path, keep: int | None, every: str | None, *, json: bool) -> None:
    """Make a dated backup in a folder where one is due, and say what there is."""
    from datetime import UTC, datetime

    from autodb.errors import UnusableInput
    from autodb.store.rotation import Every, age_words, rotate

    if every is not None and every not in list(Every):
        raise UnusableInput(
            phrase("--every {every}: use {names}", every=every, names=", ".join(Every))
        )
    apart, now = None if every is None else Every(every), datetime.now(UTC)
    with working(f"copying to {folder.name}") as progress:
        done = rotate(url, folder, keep=keep, every=apart, now=now, progress=progress)
    if json:
        say_json(asdict(done))
        return
    there = phrase("{count} there", count=len(done.there))
    called = {"folder": folder, "there": there}
    if done.copied is None:
        age = age_words(now - done.there[-1].at)
        said = phrase("{folder}: {there}, the newest {age} old: none is due", age=age, **called)
    else:
        said = phrase("{folder}: a new one, {rows}; {there}", rows=_rows(done.copied), **called)
    say(said)
    for path in done.removed:
        say(phrase("{path}: removed", path=path))


def restore_command(
    source: Annotated[Path, typer.Argument(help="File of a backup, or folder of an export.")],
    replace: Replace = False,
    db: Database = None,
) -> None:
    """Replace the database by a backup or an export, at this version's schema."""
    from autodb.store import database_url, head, shown_url
    from autodb.store.restoring import restore

    url = database_url(db)
    with working(f"restoring {source.name}") as progress:
        done = restore(url, source, replace=replace, progress=progress)
    said = phrase("{file}: {rows}", file=shown_url(url), rows=_rows(done))
    if done.schema != head():
        said = phrase("{said}, upgraded to {schema}", said=said, schema=head())
    say(said)
    _say_unread(url)


def _say_unread(url: str) -> None:
    """Say which recordings on the disk a database that was put back does not know."""
    from autodb.agent.ingest.kept import every_unread

    with opened_store(url) as store, store.reading() as session:
        for machine, some in every_unread(session).items():
            say(
                phrase(
                    "{machine}: {count} recordings that its inbox keeps are not in it; 'autodb "
                    "refresh --machine {machine} --inbox INBOX' imports them",
                    machine=machine,
                    count=len(some),
                )
            )


def export_command(
    folder: Annotated[Path | None, typer.Argument(help="New folder for the tables.")] = None,
    machine: Annotated[
        str | None, typer.Option("--machine", help="Only what belongs to this machine.")
    ] = None,
    cards: Annotated[
        Path | None,
        typer.Option(
            "--cards",
            metavar="FILE",
            help="Write the machine's materials as Kienzle cards (CSV) instead.",
        ),
    ] = None,
    coefficients: Annotated[
        Path | None,
        typer.Option(
            "--coefficients",
            metavar="FILE",
            help="Write its fitted coefficients (JSON), tools by ISO 13399 codes, instead.",
        ),
    ] = None,
    material: Annotated[
        str | None, typer.Option("--material", help="Only what is of this material.")
    ] = None,
    tool: Annotated[
        str | None, typer.Option("--tool", help="Only what is of pairs with this tool.")
    ] = None,
    db: Database = None,
) -> None:
    """Write every table as Parquet, with a manifest; 'autodb restore' takes the folder back."""
    from autodb.errors import UnusableInput

    if [folder, cards, coefficients].count(None) != 2:
        raise UnusableInput(
            phrase(
                "give one of a folder for the tables, --cards FILE.csv, --coefficients FILE.json"
            )
        )
    if cards is not None:
        _export_cards(cards, machine, material, tool, db)
    elif coefficients is not None:
        _export_coefficients(coefficients, machine, material, tool, db)
    elif material is not None or tool is not None:
        raise UnusableInput(phrase("--material and --tool go with --cards and --coefficients"))
    else:
        _export_tables(Path(str(folder)), machine, db)


def _export_tables(folder: Path, machine: str | None, db: str | None) -> None:
    from autodb.store.exports import export

    with opened_store(db) as store, working(f"exporting to {folder.name}") as progress:
        done = export(store, folder, machine=machine, progress=progress)
    total = sum(entry.rows for entry in done.tables.values())
    say(
        phrase(
            "{folder}: {total} rows of {count} tables, schema {schema}",
            folder=folder,
            total=total,
            count=len(done.tables),
            schema=done.schema_revision,
        )
    )


def _export_coefficients(
    path: Path, machine: str | None, material: str | None, tool: str | None, db: str | None
) -> None:
    from autodb.agent.answer.coefficients import machine_coefficients
    from autodb.errors import UnusableInput
    from autodb.files.targets import check_target, write_text

    check_target(path, suffix=".json", option="--coefficients")
    if machine is None:
        raise UnusableInput(
            phrase("--coefficients needs --machine NAME: they are what a machine has learnt")
        )
    with opened_store(db) as store, store.reading() as session:
        made = machine_coefficients(session, machine, material, tool)
    write_text(path, made.model_dump_json(indent=1, exclude_none=True) + "\n")
    say(phrase("{path}: {count} pairs", path=path, count=len(made.pairs)))
    for pair in made.pairs:
        said = phrase(
            "{pair}: version {version} from {cuts} cuts",
            pair=f"{pair.material} / {pair.tool.name}",
            version=pair.version,
            cuts=pair.learnt_from.cuts,
        )
        say(said)


def _export_cards(
    path: Path, machine: str | None, material: str | None, tool: str | None, db: str | None
) -> None:
    from autodb.agent.answer.made_cards import made_cards
    from autodb.errors import UnusableInput
    from autodb.files.targets import check_target, write_text
    from autodb.pairs.cards import cards_as_csv

    check_target(path, suffix=".csv", option="--cards")
    if machine is None:
        raise UnusableInput(
            phrase("--cards needs --machine NAME: cards are of what a machine has learnt")
        )
    with opened_store(db) as store, store.reading() as session:
        made = made_cards(session, machine, material, tool)
    write_text(path, cards_as_csv(made.cards))
    rows = table(
        phrase("Cards in {path}", path=path),
        *(phrase("material"), ">k_c1.1 N/mm²", ">m_c", phrase("source")),
    )
    for card in made.cards:
        k, bounds = card.k_c11, card.m_c_bounds
        m_c = localized(f"{card.m_c:.3f}")
        if bounds is not None:
            low, high = (localized(f"{end:.3f}") for end in bounds)
            m_c = phrase("{value} ({low} to {high})", value=m_c, low=low, high=high)
        size = phrase(
            "{value} ({low} to {high})",
            value=f"{k.value:.0f}",
            low=f"{k.lower:.0f}",
            high=f"{k.upper:.0f}",
        )
        rows.add_row(card.material, size, m_c, card.source)
    show(rows)
    for line in made.left_out:
        say(phrase("excluded: {what}", what=shown_again(line)))
