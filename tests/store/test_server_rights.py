"""The roles of docs/how-to/server-rights.md: each may do what it runs, and nothing else."""

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from sqlalchemy import select

from autodb.store import create_store, head, migrate, models, open_store
from autodb.store.engines import engine_of
from tests.conftest import ROOT, Cli
from tests.helpers.servers import Server

pytestmark = pytest.mark.usefixtures("one_law")

PAGE = ROOT / "docs" / "how-to" / "server-rights.md"
ROLES = ("autodb_owner", "autodb_writer", "autodb_reader")
MACHINE = ("--machine", "lathe-1")


def _as(server: Server, role: str) -> str:
    return f"postgresql://{role}@127.0.0.1:{server.port}/autodb"


def _do(url: str, *statements: str) -> None:
    import psycopg

    with psycopg.connect(url, autocommit=True) as connection:
        for statement in statements:
            connection.execute(statement.encode())


@pytest.fixture
def rights(server: Server) -> Iterator[Callable[[str], str]]:
    """Make the database and roles by the statements of the page; return the URL of each role."""
    once, inside, after = (
        [one for one in block.split(";") if one.strip()]
        for block in re.findall(r"```sql\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    )
    _do(server.url("postgres"), *once)
    _do(server.url("autodb"), *inside)
    owner = _as(server, "autodb_owner")
    migrate(owner, "0008")
    assert create_store(owner).was == "0008"
    _do(owner, *after)
    yield lambda role: _as(server, role)
    for role in ROLES:
        engine_of(_as(server, role)).dispose()
    _do(server.url("postgres"), "DROP DATABASE autodb WITH (FORCE)",
        *(f"DROP ROLE {role}" for role in ROLES))  # fmt: skip


def test_the_roles_of_the_page_do_what_they_are_for_and_nothing_else(
    rights: Callable[[str], str], cli: Cli, refused: Callable[..., str], sample_jobs: Path
) -> None:
    import psycopg

    job = sample_jobs / "stepped_shaft"
    owner, writer, reader = (rights(role) for role in ROLES)
    for command in (
        ("machine", "add", "lathe-1", "--file", job / "machine.toml"),
        ("import", *sorted((job / "recordings").glob("s*-*s*.csv")), *MACHINE),
        ("calibrate", *MACHINE),
        ("refresh", *MACHINE),
        ("predict", job / "job.toml", *MACHINE),
        ("doctor",),
        ("init",),
    ):
        done = cli(*command, "--db", writer)
        assert done.code == 0, (command, done.err)
    assert "lathe-1" in cli("machine", "list", "--db", reader).out
    assert cli("export", "out", "--db", reader).code == 0
    said = refused("machine", "add", "other", "--db", reader)
    assert "permission denied for table machine; use a database role that may do that" in said

    for url, statements in (
        (
            writer,
            (
                "DROP TABLE cut",
                "ALTER TABLE cut ADD COLUMN more text",
                "TRUNCATE cut",
                "CREATE TABLE more (a int)",
                "CREATE TEMPORARY TABLE more (a int)",
                "CREATE FUNCTION more() RETURNS int LANGUAGE sql AS 'SELECT 1'",
                "CREATE TRIGGER more BEFORE INSERT ON cut EXECUTE FUNCTION "
                "suppress_redundant_updates_trigger()",
                "UPDATE alembic_version SET version_num = '0001'",
                "INSERT INTO access_token (name, sha256, role, created_at) "
                "VALUES ('x', 'y', 'admin', 'z')",
                "DELETE FROM audit_entry",
            ),
        ),
        (reader, ("DELETE FROM cut", "DROP TABLE cut", "SELECT nextval('cut_id_seq')")),
    ):
        for statement in statements:
            with pytest.raises(psycopg.errors.InsufficientPrivilege):
                _do(url, statement)

    migrate(owner, "0008")
    said = refused("init", "--db", writer)
    assert "must be owner of table" in said
    assert "use a database role that may do that" in said
    assert cli("init", "--db", owner).out.strip().endswith(f"from schema 0008 to {head()}")
    store = open_store(writer)
    with store.reading() as session:
        assert session.scalars(select(models.Prediction)).all()
    store.close()
