"""One PostgreSQL server for many machines: the same rows as in a file, whoever writes when."""

import os
import random
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import event, inspect, select

from autodb.agent.ingest.importing import import_file
from autodb.agent.ingest.inbox import Inbox
from autodb.agent.operate.refreshing import refresh
from autodb.agent.rows.machines import add_machine
from autodb.agent.sense.calibrating import calibrate_machine
from autodb.errors import UnusableInput
from autodb.files.machine import LATHE
from autodb.proofs.runs.keeping.faults_run import CLOCKS, RECORDINGS
from autodb.store import Store, create_store, head, migrate, models, open_store, revisions
from autodb.store.engines import engine_of
from autodb.store.restoring import restore
from tests.conftest import Cli
from tests.helpers.campaigns import first
from tests.helpers.servers import Server, wait_for

pytestmark = pytest.mark.usefixtures("one_law")
FILES, CUTS, SEED = 2, 3, 12
JOB = RECORDINGS.parent / "job.toml"


@pytest.fixture
def url(server: Server) -> Iterator[str]:
    """Return a new, empty database on the server."""
    made = server.database()
    yield made
    engine_of(made).dispose()


def rows(url: str) -> dict[str, list[tuple[str, ...]]]:
    """Return every row of every table, but for the clock's time."""
    store = open_store(url)
    with store.reading() as session:
        found = {
            table.name: sorted(
                tuple(repr(row[c]) for c in table.columns if c.name not in CLOCKS)
                for row in session.execute(select(table)).mappings()
            )
            for table in models.Base.metadata.sorted_tables
        }
    store.close()
    return found


def test_migrations_make_on_a_server_what_the_models_say(url: str) -> None:
    assert create_store(url).now == head()
    assert not create_store(url).changed
    assert _beside_the_models(url) == []
    for revision in ["base", *revisions()][::-1]:
        migrate(url, revision)
    assert inspect(engine_of(url)).get_table_names() == ["alembic_version"]
    migrate(url, head())
    assert _beside_the_models(url) == []
    assert sum(map(len, rows(url).values())) == 0


def _beside_the_models(url: str) -> list[Any]:
    """Return what a database's tables are that the models do not say, and the other way round."""
    with engine_of(url).connect() as connection:
        seen = MigrationContext.configure(connection)
        return list(compare_metadata(seen, models.Base.metadata))


def _taken_up(cli: Cli, url: str) -> list[str]:
    """Run a machine's life on a database; return what the commands said of it."""
    cli("init", "--db", url)
    cli("machine", "add", "lathe-1", "--db", url)
    said = []
    for name in ("standard-cuts.csv", "air-moves.csv"):
        cli("import", RECORDINGS / name, "--machine", "lathe-1", "--db", url)
    for command in (
        ("calibrate", "--machine", "lathe-1"),
        ("refresh", "--machine", "lathe-1"),
        ("predict", "--machine", "lathe-1", JOB),
        ("lookup", "--machine", "lathe-1", "--material", "steel bar", "--tool", "carbide insert",
         "--operation", "turn", "--feed", "0.2", "--depth", "1.5", "--speed", "180",
         "--diameter", "60"),
        ("trace", "prediction", "1"),
        ("explain", RECORDINGS / "shop-week-2.csv", "--machine", "lathe-1", "--out", "out"),
        ("mismatch", "list", "lathe-1"),
    ):  # fmt: skip
        done = cli(*command, "--db", url)
        assert done.code == 0, (command, done.err)
        said.append(done.out)
    return said


def test_a_machine_on_a_server_is_what_it_is_in_a_file_and_moves_between_them(
    cli: Cli, url: str, server: Server
) -> None:
    file = "sqlite:///file.sqlite3"
    in_file = _taken_up(cli, file)
    assert _taken_up(cli, url) == in_file
    found = rows(url)
    assert len(found["cutting_parameters"]) == 1
    assert cli("doctor", "--db", url).code == 0

    # A backup of the server is a file; a file, or an export, moves to a server
    assert cli("backup", "copy.sqlite3", "--db", url).code == 0
    assert rows("sqlite:///copy.sqlite3") == found
    assert cli("export", "tables", "--db", url).code == 0
    for source in ("copy.sqlite3", "tables"):
        other = server.database()
        done = cli("restore", source, "--db", other)
        assert (done.code, done.err) == (0, "")
        assert rows(other) == found
        engine_of(other).dispose()

    # Held rows are replaced only when asked, and new rows are numbered behind the restored
    refused = cli("restore", "copy.sqlite3", "--db", url)
    assert refused.code == 2
    assert "or --replace" in refused.err
    assert cli("restore", "copy.sqlite3", "--replace", "--db", url).code == 0
    assert cli("machine", "add", "lathe-2", "--db", url).code == 0
    assert len(rows(url)["machine"]) == 2


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("postgresql://autodb@127.0.0.1:1/shop", "Connection refused"),
        ("postgresql://autodb:secret@127.0.0.1:1/shop", "autodb:***@127.0.0.1:1/shop"),
        ("postgresql://autodb@127.0.0.1", "names no database"),
        ("mysql://autodb@127.0.0.1/shop", "only SQLite and PostgreSQL are supported"),
        ("postgresql://autodb@127.0.0.1:port/shop", "is no database URL"),
    ],
)
def test_a_database_that_cannot_be_used_is_one_line(cli: Cli, text: str, says: str) -> None:
    for command in (("init",), ("machine", "list"), ("backup", "copy.sqlite3")):
        done = cli(*command, "--db", text)
        assert done.code == 2
        assert says in done.err
        assert "secret" not in done.err
        assert len(done.err.splitlines()) == 1


def test_a_database_that_is_not_there_or_not_ours(cli: Cli, server: Server, url: str) -> None:
    assert "does not exist" in cli("init", "--db", server.url("nowhere")).err
    assert "make one with 'autodb init'" in cli("machine", "list", "--db", url).err
    import psycopg

    with psycopg.connect(url) as connection:
        connection.execute("CREATE TABLE theirs (id int)")
    done = cli("init", "--db", url)
    assert "holds another program's tables; use a new database" in done.err


def test_schedule_never_prints_a_password(cli: Cli, url: str) -> None:
    create_store(url)
    cli("machine", "add", "lathe-1", "--db", url)
    Path("in").mkdir()
    ask = ("schedule", "--machine", "lathe-1", "--inbox", "in", "--cron", "--db")
    assert url in cli(*ask, url).out
    with_password = url.replace("autodb@", "autodb:secret@")
    done = cli(*ask, with_password)
    assert (done.code, done.out) == (2, "")
    assert "put it into ~/.pgpass" in done.err
    engine_of(with_password).dispose()


def _shop(folder: Path, writers: int) -> list[str]:
    """Make an inbox for each of some machines; return the machines' names.

    Of each machine's cuts none is another's; their materials and tools are.
    """
    week = pd.read_csv(RECORDINGS / "shop-week-1.csv").drop(columns=["cut"])
    names = [f"lathe-{number}" for number in range(writers)]
    for number, name in enumerate(names):
        (folder / name).mkdir()
        for k in range(FILES):
            some = week.iloc[CUTS * k : CUTS * (k + 1)].copy()
            some.insert(0, "cut", range(CUTS * k, CUTS * (k + 1)))
            some["material"], some["tool"] = f"steel {number % 3}", "insert"
            some["cutting.depth"] += 0.01 * number
            some.to_csv(folder / name / f"{k}.csv", index=False)
    return names


def _calibrated(file: Path, writers: int) -> None:
    """Make the database of some calibrated machines."""
    url = f"sqlite:///{file}"
    create_store(url)
    store = open_store(url)
    standard = pd.read_csv(RECORDINGS / "standard-cuts.csv").drop(columns="tool")
    for number in range(writers):
        path = file.with_name(f"standard-{number}.csv")
        standard.assign(t=standard["t"] + number).to_csv(path, index=False)
        add_machine(store, f"lathe-{number}", LATHE)
        import_file(store, path, machine=f"lathe-{number}")
        calibrate_machine(store, f"lathe-{number}")
        refresh(store, f"lathe-{number}")
    store.close()


def _take(url: str, folder: Path, name: str) -> None:
    """Import what is in a machine's inbox and refresh it, as its agent does."""
    store = open_store(url)
    try:
        refresh(store, name, inbox=Inbox(folder / name, settled_s=0.0))
    finally:
        store.close()


def _forked(work: Callable[[], None]) -> int:
    """Do work in a forked process; return its id."""
    child = os.fork()
    if child:
        return child
    failed = 1
    try:
        work()
        failed = 0
    finally:
        os._exit(failed)


def _by_content(url: str) -> dict[str, Any]:
    """Return what machines, cuts and pairs are, without the ids that whoever was first has."""
    store = open_store(url)
    with store.reading() as session:
        found = {
            "catalogue": [
                sorted(session.scalars(select(table.name)))
                for table in (models.Machine, models.Material, models.Tool)
            ],
            "pairs": sorted(
                (row.material.name, row.tool.name) for row in session.scalars(select(models.Pair))
            ),
            "forces": sorted(
                (f.cut.recording.sha256, f.cut.number, f.component, f.value_N, f.sd_N)
                for f in session.scalars(select(models.SensedForce))
                if f.value_N
            ),
            "beliefs": sorted(
                (p.machine_id, p.pair.material.name, p.version, p.n_cuts, *p.mean)
                for p in session.scalars(select(models.CuttingParameters))
            ),
            "cuts": sorted(
                (c.recording.machine_id, c.recording.sha256, c.number, repr(c.conditions),
                 c.pair.material.name, c.pair.tool.name)
                for c in session.scalars(select(models.Cut)) if c.pair
            ),
            "files": sorted(
                (f.machine_id, Path(f.path).name, f.sha256, f.status)
                for f in session.scalars(select(models.InboxFile))
            ),
        }  # fmt: skip
    store.close()
    return found


@pytest.mark.parametrize("writers", first(1, [3, 8]))
def test_writers_that_are_killed_end_as_one_after_the_other(
    server: Server, tmp_path: Path, writers: int
) -> None:
    urls = {way: server.database() for way in ("serial", "at once")}
    _calibrated(tmp_path / "calibrated.sqlite3", writers)
    for way, made in urls.items():
        restore(made, tmp_path / "calibrated.sqlite3")
        (tmp_path / way).mkdir()
        _shop(tmp_path / way, writers)
    start = time.perf_counter()
    for number in range(writers):
        _take(urls["serial"], tmp_path / "serial", f"lathe-{number}")
    took_s = time.perf_counter() - start
    all_take_s = took_s / min(writers, os.cpu_count() or 1)

    # Each writer is killed twice, and begun again; then let end
    rng, url, folder = random.Random(SEED), urls["at once"], tmp_path / "at once"
    engine_of(url).dispose()
    killed = 0
    for last in (False, False, True):
        children = [
            _forked(lambda n=number: _take(url, folder, f"lathe-{n}"))  # type: ignore[misc]
            for number in range(writers)
        ]
        at_s = sorted(rng.uniform(0.0, 0.75 * all_take_s) for _ in children)
        begun = time.perf_counter()
        for child, then_s in () if last else zip(children, at_s, strict=True):
            time.sleep(max(0.0, begun + then_s - time.perf_counter()))
            os.kill(child, signal.SIGKILL)
        ended = [os.waitpid(child, 0)[1] for child in children]
        killed += sum(os.WIFSIGNALED(status) for status in ended)
        assert not last or ended == [0] * writers
    assert killed >= writers // 2  # the others had ended before
    found = _by_content(url)
    assert len(found["beliefs"]) == writers
    assert found == _by_content(urls["serial"])
    for one in urls.values():
        engine_of(one).dispose()


def test_writers_of_one_machine_wait_and_those_of_another_do_not(url: str) -> None:
    create_store(url)
    store = open_store(url)
    for name in ("lathe-1", "lathe-2"):
        add_machine(store, name, LATHE)
    reads, writes = os.pipe()

    def other(machine: str | None, letter: bytes) -> int:
        def work() -> None:
            own = open_store(url)
            with own.writing(machine) as session:
                session.scalars(select(models.Machine)).all()
                os.write(writes, letter)
            own.close()

        return _forked(work)

    with store.writing("lathe-1") as session:
        session.scalars(select(models.Machine)).all()
        free = other("lathe-2", b"2")
        assert os.read(reads, 1) == b"2"
        same, every = other("lathe-1", b"1"), other(None, b"*")
        time.sleep(0.3)
        os.write(writes, b"0")  # neither has come so far
        assert os.read(reads, 1) == b"0"
    assert {os.read(reads, 1), os.read(reads, 1)} == {b"1", b"*"}
    assert [os.waitpid(child, 0)[1] for child in (free, same, every)] == [0, 0, 0]
    store.close()


def test_a_server_that_restarts_in_the_middle_loses_nothing(server: Server, tmp_path: Path) -> None:
    urls = {}
    for way in ("undisturbed", "restarted"):
        urls[way] = server.database()
        create_store(urls[way])
        (tmp_path / way).mkdir()
        _shop(tmp_path / way, 1)
        store = open_store(urls[way])
        add_machine(store, "lathe-0", LATHE)
        store.close()
    _take(urls["undisturbed"], tmp_path / "undisturbed", "lathe-0")
    engine_of(urls["restarted"]).dispose()
    reads, writes = os.pipe()

    def work() -> None:
        event.listen(engine_of(urls["restarted"]), "commit", lambda _: os.write(writes, b"c"))
        _take(urls["restarted"], tmp_path / "restarted", "lathe-0")

    child = _forked(work)
    os.read(reads, 1)
    server.stop()
    server.start()
    assert os.waitpid(child, 0)[1] == 0
    assert _by_content(urls["restarted"]) == _by_content(urls["undisturbed"])
    for one in urls.values():
        engine_of(one).dispose()


def test_a_server_that_stays_away_is_one_line(
    server: Server, url: str, cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    create_store(url)
    cli("machine", "add", "lathe-1", "--db", url)
    monkeypatch.setattr("autodb.store.engines.BACK_S", 0.0)
    Path("in").mkdir()

    def gone(*_: object) -> list[str]:
        server.stop()
        return []

    with monkeypatch.context() as patched:
        patched.setattr(Inbox, "take_in", gone)
        done = cli("refresh", "--machine", "lathe-1", "--inbox", "in", "--db", url)
    server.start()
    assert done.code == 2
    assert "try again when the server answers" in done.err
    wait_for(lambda: cli("machine", "list", "--db", url).code == 0)


def test_a_reader_sees_one_state_and_writes_nothing(url: str) -> None:
    create_store(url)
    store: Store = open_store(url)
    with store.reading() as session:
        assert session.scalars(select(models.Machine)).all() == []
        add_machine(store, "lathe-1", LATHE)
        assert session.scalars(select(models.Machine)).all() == []
    store.close()


def test_without_the_extra_it_says_which(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "psycopg", None)
    with pytest.raises(UnusableInput, match=r"run pip install 'autodb\[postgres\]'"):
        open_store("postgresql://autodb@127.0.0.1:1/without-the-extra")
