"""Is the database sound, and are the recordings that it came from still what they were?

Each check is a function that returns (statistic, operator, threshold, passed) and what it found.
"""

import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

from sqlalchemy import JSON, ColumnElement, Text, cast, exists, select, text
from sqlalchemy.exc import DatabaseError
from sqlalchemy.orm import InstrumentedAttribute, Session

from autodb.agent.ingest.importing import files_of
from autodb.agent.ingest.kept import every_unread
from autodb.agent.operate.access import first_broken
from autodb.agent.rows.posteriors import pair_name
from autodb.errors import UnusableInput, behind_name
from autodb.files.checksums import checksum
from autodb.files.excuses import system_words
from autodb.store import (
    Store,
    head,
    models,
    on_server,
    open_store,
    pointing_nowhere,
    revisions,
    rowsums,
)
from autodb.store.rotation import age_words, drill
from autodb.store.schemas import schema_faults
from autodb.terms.vocabulary import of_the_machine
from autodb.wording import msgid, phrase

Progress = Callable[[str], None]


@dataclass(frozen=True)
class CheckOutcome:
    """What a check measured, what it must be, and the rows or files that stand out."""

    statistic: str
    operator: str
    threshold: str
    passed: bool
    found: tuple[str, ...] = ()


@dataclass(frozen=True)
class SoundnessCheck:
    """One check: its name, its function, and what to do when it fails, with a ``folder``."""

    name: str
    run: Callable[[Session, Progress], CheckOutcome]
    what_to_do: str
    folder: str = ""

    @property
    def remedy_words(self) -> str:
        """What to do, for the reader."""
        return phrase(self.what_to_do, folder=self.folder)


@dataclass(frozen=True)
class Finding:
    """A check with its outcome."""

    check: SoundnessCheck
    outcome: CheckOutcome


def examine(url: str, *, backups: Path | None = None, progress: Progress) -> list[Finding]:
    """Run the checks on a database; of its content only where file and values are sound.

    ``backups``: the folder whose newest one is tried too, whatever the database is like.

    A server sees to its pages and keys itself, and the recordings lie on the machines' computers:
    of its database the others are checked. Raises UnusableInput when there is no database of ours.
    """
    store = open_store(url, any_schema=True)
    file = (OF_THE_FILE, OF_ITS_VALUES, OF_THE_CONTENT)
    findings: list[Finding] = []
    try:
        for checks in (OF_A_SCHEMA, OF_ROWS) if on_server(url) else file:
            if all(finding.outcome.passed for finding in findings):
                findings += _run(store, checks, progress)
        if backups is not None:
            again = msgid("make a new one with 'autodb backup {folder} --keep 7'")
            drilled = SoundnessCheck(
                msgid("restore of the newest backup"), partial(restores, backups), again,
                str(backups),
            )  # fmt: skip
            findings += _run(store, (drilled,), progress)
    finally:
        store.close()
    return findings


def restores(folder: Path, _session: Session, progress: Progress) -> CheckOutcome:
    """Restore the newest backup of a folder in a temporary place, as a restore would, and say how
    old it is."""
    must = msgid("restored")
    try:
        tried = drill(folder, now=datetime.now(UTC), progress=progress)
    except UnusableInput as error:
        return CheckOutcome(msgid("not restored"), "=", must, False, (error.line,))
    line = phrase(
        "{folder}: {count} rows of one that is {age} old",
        folder=folder, count=tried.restored.total, age=age_words(tried.age)
    )  # fmt: skip
    return CheckOutcome(must, "=", must, True, (line,))


def _run(store: Store, checks: Iterable[SoundnessCheck], progress: Progress) -> list[Finding]:
    findings = []
    with store.reading() as session:
        for check in checks:
            progress(check.name)
            findings.append(Finding(check, _outcome(check, session, progress)))
    return findings


def _outcome(check: SoundnessCheck, session: Session, progress: Progress) -> CheckOutcome:
    """Return what a check finds; a file that cannot even be read so far has failed it."""
    try:
        return check.run(session, progress)
    except DatabaseError as error:
        return CheckOutcome(msgid("unreadable"), "=", "0", False, (str(error.orig),))
    except rowsums.UNREADABLE as error:
        return CheckOutcome(msgid("unreadable"), "=", "0", False, (str(error),))


def _none_of(found: Iterable[str]) -> CheckOutcome:
    """Return the outcome of a check that must find nothing."""
    rows = tuple(found)
    return CheckOutcome(str(len(rows)), "=", "0", not rows, rows)


def schema(session: Session, _progress: Progress) -> CheckOutcome:
    """Compare the schema with the one that this version works with."""
    have = str(session.execute(text("SELECT version_num FROM alembic_version")).scalar())
    return CheckOutcome(have, "=", head(), have == head())


def integrity(session: Session, _progress: Progress) -> CheckOutcome:
    """Let SQLite check its pages, indices and constraints."""
    rows = session.execute(text("PRAGMA integrity_check")).scalars()
    return _none_of(str(row) for row in rows if row != "ok")


def look_for_references(session: Session, _progress: Progress) -> CheckOutcome:
    """Look for rows that point to a row which is not there, such as cuts without recording."""
    return _none_of(pointing_nowhere(session.connection()))


def of_the_schema(session: Session, _progress: Progress) -> CheckOutcome:
    """Look for tables, indices, triggers and views that the schema has not, lacks or has otherwise.

    A trigger or view of somebody else's runs with the rights of who writes to the database.
    """
    revision = str(session.execute(text("SELECT version_num FROM alembic_version")).scalar())
    if revision not in revisions():
        return _none_of(
            [phrase("schema {revision} is not known to this version", revision=revision)]
        )
    return _none_of(schema_faults(rowsums.driver_of(session.connection()), revision))


def values(session: Session, _progress: Progress) -> CheckOutcome:
    """Look for groups of rows that are not what was written, by their checksums."""
    return _none_of(rowsums.altered(rowsums.driver_of(session.connection())))


def readable_json(session: Session, progress: Progress) -> CheckOutcome:
    """Look for JSON columns whose text is no JSON."""
    found = []
    for table in models.Base.metadata.sorted_tables:
        for column in table.columns:
            if isinstance(column.type, JSON):
                progress(f"{table.name}.{column.name}")
                query = select(table.c.id, cast(column, Text))
                for row_id, value in session.execute(query):
                    if not _is_json(value):
                        found.append(f"{table.name} {row_id}: {column.name}")
    return _none_of(found)


def _is_json(value: str | None) -> bool:
    try:
        json.loads(value or "null")
    except ValueError:
        return False
    return True


def sources(session: Session, _progress: Progress) -> CheckOutcome:
    """Look for derived rows that came from nothing."""
    force, parameters = models.SensedForce, models.CuttingParameters
    without: tuple[tuple[str, InstrumentedAttribute[int], ColumnElement[bool]], ...] = (
        ("calibration", models.CalibrationVersion.id, ~models.CalibrationVersion.recordings.any()),
        ("channel_model", models.ChannelModel.id, ~models.ChannelModel.recordings.any()),
        (
            "sensed_force",
            force.id,
            force.value_N.is_not(None)
            & force.calibration_id.is_(None)
            & force.estimator_id.is_(None)
            & force.errors.is_(None),
        ),
        ("cutting_parameters", parameters.id, ~parameters.forces.any()),
        (
            "prediction",
            models.Prediction.id,
            ~models.Prediction.parameters.any() & models.Prediction.started_from.is_(None),
        ),
        ("fleet_prior", models.FleetPrior.id, ~models.FleetPrior.parameters.any()),
    )
    return _none_of(
        f"{name} {row_id}"
        for name, column, lacks in without
        for row_id in session.scalars(select(column).where(lacks))
    )


def look_for_confirmed(session: Session, _progress: Progress) -> CheckOutcome:
    """Look for confirmed causes without a term, or whose term is the machine's and in no model."""
    mismatch = models.Mismatch
    lacks = mismatch.confirmed_term.is_(None) | (
        mismatch.confirmed_term.in_(of_the_machine()) & ~mismatch.models.any()
    )
    rows = session.scalars(select(mismatch).where(mismatch.status == "confirmed", lacks))
    return _none_of(
        phrase("mismatch {number}: {what}", number=row.id, what=f"{row.channel}: {row.term}")
        for row in rows
    )


def look_for_pairs(session: Session, _progress: Progress) -> CheckOutcome:
    """Look for work-tool pairs that no cut was made with."""
    cut = exists().where(models.Cut.pair_id == models.Pair.id)
    rows = session.scalars(select(models.Pair).where(~cut))
    return _none_of(
        phrase("pair {number}: {name}", number=row.id, name=pair_name(row)) for row in rows
    )


def chained(session: Session, _progress: Progress) -> CheckOutcome:
    """Look for the first entry of the audit log that does not follow from those before it."""
    broken = first_broken(session)
    return _none_of(
        []
        if broken is None
        else [phrase("audit_entry {number}: it, or the one before", number=broken)]
    )


def present(session: Session, _progress: Progress) -> CheckOutcome:
    """Look for recordings of which neither the original nor our copy is on the disk.

    Those that were dropped by a machine's [retention] are not to be there.
    """
    kept = select(models.StoredRecording).where(models.StoredRecording.dropped_at.is_(None))
    rows = session.scalars(kept.order_by(models.StoredRecording.id))
    return _none_of(
        phrase("recording {number}: {file}", number=r.id, file=r.path)
        for r in rows
        if not files_of(r)
    )


def unaltered(session: Session, progress: Progress) -> CheckOutcome:
    """Look for recordings whose file has another checksum than at import, or cannot be read."""
    rows = session.scalars(select(models.StoredRecording).order_by(models.StoredRecording.id)).all()
    found = []
    for number, row in enumerate(rows, start=1):
        for path, sha256 in files_of(row).items():
            progress(f"recording {number} of {len(rows)}: {path.name}")
            try:
                same = checksum(path) == sha256
            except OSError as error:
                found.append(
                    behind_name(
                        phrase("recording {number}: {file}", number=row.id, file=path),
                        system_words(error),
                    )
                )
                continue
            if not same:
                found.append(phrase("recording {number}: {file}", number=row.id, file=path))
    return _none_of(found)


def imported(session: Session, _progress: Progress) -> CheckOutcome:
    """Look for recordings that an inbox keeps and the database has not, or only their beginning."""
    return _none_of(
        phrase(UNREAD if one.grown is None else GROWN, machine=machine, file=one.path)
        for machine, some in every_unread(session).items()
        for one in some
    )


RESTORE = msgid("'autodb restore BACKUP --replace'")
UNREAD = msgid("{machine}: {file}")
GROWN = msgid("{machine}: {file}: has grown since it was imported")
OF_A_SCHEMA = (
    SoundnessCheck(
        msgid("schema"), schema, msgid("'autodb init' brings it to this version's schema")
    ),
)
OF_THE_FILE = (
    *OF_A_SCHEMA,
    SoundnessCheck(msgid("integrity of the file"), integrity, RESTORE),
    SoundnessCheck(
        msgid("rows that point to no row"),
        look_for_references,
        RESTORE,
    ),
    SoundnessCheck(
        msgid("what is no part of the schema"),
        of_the_schema,
        RESTORE,
    ),
)
OF_ITS_VALUES = (SoundnessCheck(msgid("values that nobody wrote"), values, RESTORE),)
OF_ROWS = (
    SoundnessCheck(msgid("unreadable JSON"), readable_json, RESTORE),
    SoundnessCheck(msgid("derived rows without a source"), sources, RESTORE),
    SoundnessCheck(
        msgid("confirmed causes in no model"),
        look_for_confirmed,
        RESTORE,
    ),
    SoundnessCheck(
        msgid("pairs nobody cut"), look_for_pairs, msgid("import their cuts; they do no harm")
    ),
    SoundnessCheck(
        msgid("audit log altered"),
        chained,
        msgid("compare it with a backup's: who wrote to the database?"),
    ),
)
OF_THE_CONTENT = (
    *OF_ROWS,
    SoundnessCheck(
        msgid("recordings not on the disk"), present, msgid("put the file back under its path")
    ),
    SoundnessCheck(
        msgid("recordings altered on the disk"),
        unaltered,
        msgid("put back the file that was imported"),
    ),
    SoundnessCheck(
        msgid("kept recordings not imported"),
        imported,
        msgid("'autodb refresh --inbox INBOX' imports them"),
    ),
)
