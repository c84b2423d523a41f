"""Many machines are refreshed at once, by a loop or by workers that nobody else reaches."""

import os
import signal
import socket
import ssl
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import select

from autodb.agent.fleet.tasks import MachineTask, RefreshedMachine
from autodb.store import create_store, models, open_store
from tests.conftest import Cli
from tests.helpers import shops
from tests.helpers.servers import Server
from tests.helpers.serving import self_signed
from tests.helpers.virtual_fleet import FIRST, FLEET, PAIRS, URL, added

PAGES = ("", "status", "info/main/workers.html", "metrics", "health", "json/counts.json")
"""Of Dask's dashboard, and of its members over HTTP."""


@pytest.mark.usefixtures("shop")
@pytest.mark.parametrize(
    ("given", "says"),
    [
        (["--scheduler", "tcp://127.0.0.1:1"], "--workers in place of --scheduler"),
        (["--scheduler", "tcp://127.0.0.1:1", "--workers", "2"], "use one of them"),
        (["--workers", "2", "--ca", "c.pem"], "give all three, with --scheduler"),
        (["--inboxes", "nowhere"], "nowhere: no such folder"),
        (["--machine", "lathe-9"], "no machine 'lathe-9'"),
        (["--standard", "nowhere.toml"], "nowhere.toml"),
    ],
)
def test_what_cannot_be_spread_is_one_line(cli: Cli, given: list[str], says: str) -> None:
    done = cli("fleet", "refresh", *given)
    assert done.code == 2
    assert says in done.err
    assert len(done.err.splitlines()) == 1


def test_a_scheduler_that_does_not_answer(
    cli: Cli, server: Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("autodb.agent.fleet.clusters.ANSWER_S", 0.5)
    url = server.database()
    create_store(url)
    cli("machine", "add", "lathe-1", "--db", url)
    made = self_signed(tmp_path)
    shown = ("--ca", made.chain, "--certificate", made.chain, "--key", made.key)
    for address, given, says in (
        ("tls://127.0.0.1:1", shown, "no Dask scheduler answers there"),
        ("tls://127.0.0.1:1", (), "--ca, --certificate and --key of the cluster"),
        ("tcp://127.0.0.1:1", shown, "tls://HOST:PORT with --ca"),
        ("tls://127.0.0.1:1", (*shown[:-1], made.chain), "give all three as PEM"),
    ):
        done = cli("fleet", "refresh", "--scheduler", address, *given, "--db", url)
        assert done.code == 2
        assert says in done.err
        assert len(done.err.splitlines()) == 1


def test_nobody_else_of_this_computer_reaches_the_workers() -> None:
    """All listen on loopback, over TLS, to who shows this session's certificate; none has pages."""
    psutil = pytest.importorskip("psutil", reason="no Dask here: the extra 'fleet' is missing")
    from distributed.security import Security

    from autodb.agent.fleet.clusters import workers_here

    with workers_here(1) as client:
        pids = {os.getpid(), *client.run(os.getpid).values(), *client.run(os.getppid).values()}
        ours = [one for pid in pids for one in psutil.Process(pid).net_connections()]
        listening = {one.laddr for one in ours if one.status == psutil.CONN_LISTEN}
        assert {at.ip for at in listening} == {"127.0.0.1"}
        known = client.scheduler_info()
        members = [known["address"], *known["workers"]]
        assert {member.partition("://")[0] for member in members} == {"tls"}
        theirs = Security.temporary().get_connection_args("client")
        shown = client.security.get_connection_args("client")
        spoken_to = set()
        for port in {at.port for at in listening}:
            pages = [_said(port, None, f"GET /{path} HTTP/1.0\r\n\r\n") for path in PAGES]
            if all(page.startswith(b"HTTP/1.1 404 ") for page in pages):
                continue
            assert set(pages) == {b""}
            assert _said(port, _unverified()) == b""
            assert _said(port, _unverified(theirs)) == b""
            assert _said(port, _unverified(shown))
            spoken_to.add(port)
        assert {int(one.rpartition(":")[2]) for one in members} <= spoken_to


def _unverified(given: dict[str, Any] | None = None) -> ssl.SSLContext:
    """Return a context that believes any server, and shows what it is given."""
    context: ssl.SSLContext = given["ssl_context"] if given else ssl.create_default_context()
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    return context


def _said(port: int, context: ssl.SSLContext | None, asked: str = "") -> bytes:
    """Return the first that is said at a port to who connects and asks, if anything is."""
    with socket.create_connection(("127.0.0.1", port), 10.0) as plain:
        try:
            with context.wrap_socket(plain) if context else plain as connection:
                connection.sendall(asked.encode())
                return connection.recv(20)
        except (ssl.SSLError, ConnectionError):
            return b""


def test_a_plain_loop_refreshes_all_and_one_s_fault_is_its_own(cli: Cli) -> None:
    create_store(URL)
    store = open_store(URL)
    for name in ("lathe-0", "lathe-1"):
        added(store, name, PAIRS[:1], cuts=2)
    store.close()
    (Path("in") / "lathe-0").mkdir(parents=True)
    (Path("in") / "lathe-0" / "broken.csv").write_text("cut,t\n1,2\n")
    (Path("in") / "lathe-1").write_text("a file in a folder's place")
    os.utime(Path("in") / "lathe-0" / "broken.csv", (0, 0))
    done = cli("fleet", "refresh", "--inboxes", "in")
    assert done.code == 0
    assert "lathe-0: broken.csv: refused" in done.out
    for name in ("lathe-0", "lathe-1"):
        assert f"{name}: {FLEET.materials[0]} / {FIRST}: version 1 from 2 cuts" in done.out


def test_workers_do_what_a_loop_does_and_a_lost_one_costs_only_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two worker processes, of which one is killed as soon as a machine is done."""
    pytest.importorskip("dask", reason="no Dask here: the extra 'fleet' is not installed")
    from autodb.agent.fleet.clusters import workers_here
    from autodb.agent.fleet.spreading import pinned, refresh_all

    url = f"sqlite:///{tmp_path / 'autodb.sqlite3'}"
    create_store(url)
    store = open_store(url)
    for name in shops.names(4):
        added(store, name, PAIRS[:1], cuts=3)
    machines = [MachineTask(url, name, None) for name in shops.names(4)]
    said: list[RefreshedMachine] = []
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2")
    with workers_here(2) as client:
        workers = client.run(os.getpid)
        assert len(workers) == 2
        assert max(client.run(_blas_threads).values()) == 2

        def tell(one: RefreshedMachine) -> None:
            if not said:
                os.kill(next(iter(workers.values())), signal.SIGKILL)
            said.append(one)

        refresh_all(client, machines, tell)
        assert client.submit(pinned, _blas_threads, pure=False).result() == 1
    assert sorted((one.machine, one.failed) for one in said) == [
        (name, None) for name in shops.names(4)
    ]
    with store.reading() as session:
        rows = session.scalars(select(models.CuttingParameters)).all()
        assert [(row.version, row.n_cuts) for row in rows] == [(1, 3)] * 4
        assert len(session.scalars(select(models.RefreshPass)).all()) == 4
    store.close()


def _blas_threads() -> int:
    from threadpoolctl import threadpool_info

    return max((one["num_threads"] for one in threadpool_info()), default=0)
