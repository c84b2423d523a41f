"""Exports: a folder with one Parquet file a table and a manifest that knows their checksums.

Columns are typed; JSON columns are JSON text as it is stored. ``load_export`` puts the same rows
back.
"""

import json
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
from pydantic import BaseModel, ConfigDict, ValidationError
from sqlalchemy import (
    JSON,
    Boolean,
    Column,
    ColumnElement,
    Connection,
    Float,
    Integer,
    String,
    Table,
    or_,
    select,
)

import autodb
from autodb.errors import UnusableInput, near_words
from autodb.files.checksums import checksum
from autodb.files.targets import Progress, hidden, needs_folder, replace_by
from autodb.store import Store, head, migrate, models, revisions
from autodb.store.copies import Copied, connect
from autodb.store.moving import ROWS_A_STEP, as_stored, in_steps
from autodb.wording import phrase

FORMAT = 1
MANIFEST = "manifest.json"
NOT_OF_ONE_MACHINE = ("access_token", "audit_entry")
"""Tables that the export of one machine leaves out: who may use the whole database."""


class TableEntry(BaseModel):
    """One table of an export; its file is ``NAME.parquet``."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    rows: int
    sha256: str


class Manifest(BaseModel):
    """What an export holds. ``machine``: the only machine in it, or all."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    format: int
    autodb: str
    schema_revision: str
    machine: str | None
    tables: dict[str, TableEntry]


def export(
    store: Store, folder: Path, *, machine: str | None = None, progress: Progress | None = None
) -> Manifest:
    """Write every table, or what belongs to one machine, into a new folder.

    Raises UnusableInput when the folder holds anything, or there is no such machine.
    """
    needs_folder(folder)
    with hidden(folder, progress) as partial:
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise UnusableInput(
                phrase("{folder}: is there already; use a new folder", folder=folder)
            )
        partial.mkdir()
        with store.reading() as session:
            owner = None if machine is None else _machine_id(session.connection(), machine)
            tables = _write_tables(session.connection(), partial, owner, progress)
        manifest = Manifest(
            format=FORMAT,
            autodb=autodb.__version__,
            schema_revision=head(),
            machine=machine,
            tables=tables,
        )
        text = json.dumps(manifest.model_dump(), indent=1) + "\n"
        (partial / MANIFEST).write_text(text, encoding="utf-8")
        replace_by(partial, folder)
    return manifest


def _machine_id(connection: Connection, name: str) -> int:
    table = models.Machine.__table__
    found = connection.execute(select(table.c.name, table.c.id)).all()
    ids = {str(row[0]): int(row[1]) for row in found}
    if name not in ids:
        raise UnusableInput(
            phrase("no machine '{name}'{hint}", name=name, hint=near_words(name, ids))
        )
    return ids[name]


def _write_tables(
    connection: Connection, folder: Path, owner: int | None, progress: Progress | None
) -> dict[str, TableEntry]:
    entries = {}
    for table in models.Base.metadata.sorted_tables:
        if owner is not None and table.name in NOT_OF_ONE_MACHINE:
            continue
        if progress:
            progress(f"table {table.name}")
        path = folder / f"{table.name}.parquet"
        rows = _write(connection, table, path, owner)
        entries[table.name] = TableEntry(rows=rows, sha256=checksum(path))
    return entries


def _write(connection: Connection, table: Table, path: Path, owner: int | None) -> int:
    query = as_stored(table)
    kept = None if owner is None else _kept(table, owner)
    if kept is not None:
        query = query.where(kept)
    schema = pa.schema([(c.name, _arrow(c)) for c in table.columns])
    n = 0
    with pq.ParquetWriter(path, schema, compression="zstd") as writer:
        for rows in in_steps(connection, query):
            values = [[row[i] for row in rows] for i in range(len(schema))]
            writer.write_batch(pa.record_batch(values, schema=schema))
            n += len(rows)
    return n


def _arrow(column: Column[Any]) -> pa.DataType:
    for kind, arrow in (
        (Boolean, pa.bool_()),
        (Integer, pa.int64()),
        (Float, pa.float64()),
        (JSON, pa.string()),
        (String, pa.string()),
    ):
        if isinstance(column.type, kind):
            return arrow
    raise TypeError(f"{column}: no Parquet type for {column.type}")


def _kept(table: Table, owner: int) -> ColumnElement[bool] | None:
    """Return which rows the export of one machine holds; None for all.

    Of work-tool pairs, which belong to no machine, those that a row of this machine points to.
    """
    pair = models.Pair.__table__
    if table is not pair:
        return _of_machine(table, owner)
    used = [
        table.c.id.in_(select(column).where(mine))
        for other in models.Base.metadata.sorted_tables
        for column in other.columns
        if column.references(pair.c.id) and (mine := _of_machine(other, owner)) is not None
    ]
    return or_(*used)


def _of_machine(table: Table, owner: int) -> ColumnElement[bool] | None:
    """Return which rows of a table lead to no other machine; None where no row leads to one.

    Tools, materials and what else belongs to no machine lead to none.
    """
    if table.name == models.Machine.__tablename__:
        return table.c.id == owner
    kept: ColumnElement[bool] | None = None
    for column in table.columns:
        for key in column.foreign_keys:
            parent = key.column.table
            of_parent = None if parent is table else _of_machine(parent, owner)
            if of_parent is not None:
                inside = or_(column.is_(None), column.in_(select(parent.c.id).where(of_parent)))
                kept = inside if kept is None else kept & inside
    return kept


def load_export(folder: Path, target: Path, *, progress: Progress | None = None) -> Copied:
    """Make a new database file at ``target`` from an export, at the export's own schema.

    Raises UnusableInput naming the file that is missing, altered or not what the schema holds.
    """
    manifest = read_manifest(folder)
    url = f"sqlite:///{target}"
    migrate(url, manifest.schema_revision)
    with closing(connect(target)) as connection:
        connection.execute("BEGIN")
        for name in manifest.tables:
            if progress:
                progress(f"table {name}")
            path = folder / f"{name}.parquet"
            try:
                filled = _fill(connection, name, path)
            except (sqlite3.Error, pa.ArrowException) as error:
                reason = str(error).splitlines()[0]
                raise UnusableInput(
                    phrase(
                        "{path}: no rows of table '{name}' ({reason})",
                        path=path,
                        name=name,
                        reason=reason,
                    )
                ) from None
            if filled != manifest.tables[name].rows:
                raise UnusableInput(
                    phrase(
                        "{path}: {filled} rows, {manifest} says {rows}",
                        path=path,
                        filled=filled,
                        manifest=MANIFEST,
                        rows=manifest.tables[name].rows,
                    )
                )
        lost = connection.execute("PRAGMA foreign_key_check").fetchall()
        if lost:
            raise UnusableInput(
                phrase(
                    "{folder}: rows of '{table}' point to no row", folder=folder, table=lost[0][0]
                )
            )
        connection.execute("COMMIT")
    rows = {name: entry.rows for name, entry in manifest.tables.items()}
    return Copied(rows, manifest.schema_revision)


def read_manifest(folder: Path) -> Manifest:
    """Read an export's manifest and check every file against it.

    Raises UnusableInput naming the file that is missing or altered.
    """
    path = folder / MANIFEST
    try:
        manifest = Manifest.model_validate_json(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise UnusableInput(
            phrase("{path}: not there; use a folder that 'autodb export' wrote", path=path)
        ) from None
    except (UnicodeDecodeError, ValidationError) as error:
        first = str(error).splitlines()[0]
        raise UnusableInput(
            phrase("{path}: not a manifest of an export ({first})", path=path, first=first)
        ) from None
    if manifest.format != FORMAT or manifest.schema_revision not in revisions():
        raise UnusableInput(
            phrase(
                "{path}: format {format} with schema {schema} is not known to this "
                "version, which knows format {known} and schemas up to {head}",
                path=path,
                format=manifest.format,
                schema=manifest.schema_revision,
                known=FORMAT,
                head=head(),
            )
        )
    if manifest.schema_revision == head():
        left_out = () if manifest.machine is None else NOT_OF_ONE_MACHINE
        needed = {table.name for table in models.Base.metadata.sorted_tables} - set(left_out)
        if set(manifest.tables) != needed:
            odd = sorted(needed ^ set(manifest.tables))
            raise UnusableInput(
                phrase(
                    "{path}: table '{table}' is missing, or none of the schema's",
                    path=path,
                    table=odd[0],
                )
            )
    for name, entry in manifest.tables.items():
        file = folder / f"{name}.parquet"
        if not file.is_file():
            raise UnusableInput(
                phrase("{file}: not there, but {manifest} lists it", file=file, manifest=MANIFEST)
            )
        if checksum(file) != entry.sha256:
            raise UnusableInput(
                phrase("{file}: altered since the export (its checksum differs)", file=file)
            )
    return manifest


def _fill(connection: sqlite3.Connection, name: str, path: Path) -> int:
    """Put the rows of a table's file into the database; return how many."""
    columns = [row[1] for row in connection.execute("SELECT * FROM pragma_table_info(?)", (name,))]
    parquet = pq.ParquetFile(path)
    if not columns or sorted(parquet.schema_arrow.names) != sorted(columns):
        raise UnusableInput(
            phrase(
                "{path}: not the columns of table '{name}' in the manifest's schema",
                path=path,
                name=name,
            )
        )
    listed = ", ".join(f'"{column}"' for column in columns)
    places = ", ".join("?" for _ in columns)
    for batch in parquet.iter_batches(ROWS_A_STEP, columns=columns):
        values = [batch.column(column).to_pylist() for column in columns]
        connection.executemany(
            f'INSERT INTO "{name}" ({listed}) VALUES ({places})', zip(*values, strict=True)
        )
    return int(parquet.metadata.num_rows)
