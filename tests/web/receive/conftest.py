"""A database with a lathe that has learnt nothing, and who may send to it."""

from pathlib import Path

import pytest

from autodb.agent.operate.access import add_token
from autodb.agent.rows.machines import add_machine
from autodb.files.machine import LATHE
from autodb.store import Store, create_store, open_store
from tests.helpers.sending import WEEK


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Return a database with a lathe that has learnt nothing."""
    path = tmp_path_factory.mktemp("made") / "made.sqlite3"
    create_store(f"sqlite:///{path}")
    opened = open_store(f"sqlite:///{path}")
    add_machine(opened, "lathe-1", LATHE)
    opened.close()
    return path.read_bytes()


@pytest.fixture
def url(made: bytes, tmp_path: Path) -> str:
    """Return the URL of a copy of it."""
    path = tmp_path / "sent.sqlite3"
    path.write_bytes(made)
    return f"sqlite:///{path}"


@pytest.fixture
def operates(store: Store) -> dict[str, str]:
    """Return the headers of who may send recordings."""
    return {"Authorization": f"Bearer {add_token(store, 'shop', 'operate', days=1)}"}


@pytest.fixture
def week(sample_jobs: Path) -> bytes:
    """Return a table of forty cuts."""
    return (sample_jobs / "stepped_shaft" / "recordings" / WEEK).read_bytes()
