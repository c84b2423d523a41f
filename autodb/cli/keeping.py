"""`doctor`, `backup`, `restore`, `export`: a database that lasts."""

from pathlib import Path
from typing import Annotated

import typer

from autodb.cli._common import Database, opened, say, show, table, working

CHECK_FAILED = 1
EXAMPLES = 3
Replace = Annotated[bool, typer.Option("--replace", help="Replace what is there.")]


def doctor(db: Database = None) -> None:
    """Check the database and the recordings it came from; exit 1 when a check fails."""
    from autodb.agent.doctor import OF_THE_CONTENT, examine
    from autodb.store import database_url

    with working("checking") as progress:
        findings = examine(database_url(db), progress=progress)
    rows = table("Checks", "check", ">found", "must be", "")
    for finding in findings:
        out = finding.outcome
        verdict = "passed" if out.passed else "FAILED"
        rows.add_row(finding.check.name, out.statistic, f"{out.operator} {out.threshold}", verdict)
    done = {finding.check.name for finding in findings}
    for check in OF_THE_CONTENT:
        if check.name not in done:
            rows.add_row(check.name, "", "", "not checked: the file comes first")
    show(rows)
    failed = [finding for finding in findings if not finding.outcome.passed]
    for finding in failed:
        found = finding.outcome.found
        for line in found[:EXAMPLES]:
            say(f"{finding.check.name}: {line}")
        more = f" ({len(found) - EXAMPLES} more)" if len(found) > EXAMPLES else ""
        say(f"{finding.check.name}{more}: {finding.check.what_to_do}")
    if failed:
        raise typer.Exit(CHECK_FAILED)


def backup(
    file: Annotated[Path, typer.Argument(help="File to write the copy to.")],
    replace: Replace = False,
    db: Database = None,
) -> None:
    """Copy the database into one file, also while others write to it; the copy is checked."""
    from autodb.store import database_url
    from autodb.store.copies import backup as run

    with working(f"copying to {file.name}") as progress:
        done = run(database_url(db), file, replace=replace, progress=progress)
    say(f"{file}: {done.total} rows of {len(done.rows)} tables, schema {done.schema}")


def restore(
    source: Annotated[Path, typer.Argument(help="A backup file, or the folder of an export.")],
    replace: Replace = False,
    db: Database = None,
) -> None:
    """Put a backup, or an export, in the database's place, at this version's schema."""
    from autodb.store import database_url, head
    from autodb.store.restoring import restore as run

    url = database_url(db)
    with working(f"restoring {source.name}") as progress:
        done = run(url, source, replace=replace, progress=progress)
    upgraded = "" if done.schema == head() else f", upgraded to {head()}"
    say(f"{url}: {done.total} rows of {len(done.rows)} tables, schema {done.schema}{upgraded}")


def export(
    folder: Annotated[Path, typer.Argument(help="New folder for the tables.")],
    machine: Annotated[
        str | None, typer.Option("--machine", help="Only what belongs to this machine.")
    ] = None,
    db: Database = None,
) -> None:
    """Write every table as Parquet, with a manifest; 'autodb restore' takes the folder back."""
    from autodb.store.exports import export as run

    with opened(db) as store, working(f"exporting to {folder.name}") as progress:
        done = run(store, folder, machine=machine, progress=progress)
    total = sum(entry.rows for entry in done.tables.values())
    say(f"{folder}: {total} rows of {len(done.tables)} tables, schema {done.schema_revision}")
