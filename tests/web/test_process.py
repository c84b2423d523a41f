"""The service as a process: its client, TLS, how it stops, and its commands."""

import json
import os
import signal
import socket
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest

from autodb.agent.answer.looking_up import PairReader
from autodb.agent.operate.access import noted
from autodb.cli import run
from autodb.errors import NotThere, UnusableInput
from autodb.files.job import Job
from autodb.files.job_cut import JobCut
from autodb.store import Store, open_store
from autodb.web.client import Client, Unanswered
from autodb.web.http.settings import Settings
from tests.conftest import Cli
from tests.helpers.asked import API, CUT, MILLED
from tests.helpers.serving import listening, self_signed, served, wait_for


def test_the_client_says_what_the_library_says(
    url: str, store: Store, pair: dict[str, str]
) -> None:
    cuts = [JobCut.model_validate(CUT | {"depth_mm": depth}) for depth in (1.0, 2.0)]
    job = Job(name="j", material=pair["material"], tool=pair["tool"], cut=tuple(cuts))
    with store.reading() as session:
        pair_reader = PairReader(session, "lathe-0")
        alone = [pair_reader.look_up(**pair, cut=cut) for cut in cuts]
        known = pair_reader.pairs()
    with served(Settings(url)) as at, Client(at) as client:
        assert [one.name for one in client.machines()] == ["a/b c", "lathe-0"]
        assert client.machine("a/b c").recordings == 0
        assert client.pairs("lathe-0") == known
        assert [client.look_up("lathe-0", **pair, cut=cut) for cut in cuts * 2] == alone * 2
        rows = list(client.look_up_many("lathe-0", **pair, cuts=cuts))
        assert [row.row for row in rows] == [1, 2]
        assert client.predict("lathe-0", job).job == job
        assert client.trace("recording", 1).text.startswith("recording 1")
        assert client.senses("lathe-0").not_sensed
        assert (client.calibrations("lathe-0"), client.mismatches("lathe-0")) == ([], [])
        with pytest.raises(NotThere, match="did you mean lathe-0"):
            client.machine("lathe")
        (refused,) = client.look_up_many("lathe-0", "unknown", "mill", [_slot()])
        assert "state diameter_mm in a tool file" in (refused.problem or "")
        with pytest.raises(UnusableInput, match="state diameter_mm in a tool file"):
            client.look_up("lathe-0", "unknown", "mill", _slot())
        with pytest.raises(Unanswered, match=r"a token is needed|read-only"):
            client.keep_prediction("lathe-0", job)
    with pytest.raises(Unanswered, match="no answer"), Client(at) as client:
        client.machine("lathe-0")


def _slot() -> JobCut:
    return JobCut.model_validate(MILLED)


def test_over_tls(url: str, tmp_path: Path) -> None:
    certificate = self_signed(tmp_path)
    with served(Settings(url), certificate) as at:
        with Client(at, ca=certificate.chain) as client:
            assert client.machine("lathe-0").name == "lathe-0"
        with pytest.raises(Unanswered, match="CERTIFICATE_VERIFY_FAILED"), Client(at) as client:
            client.machine("lathe-0")


@contextmanager
def _forked(url: str, log: Path) -> Iterator[tuple[int, str]]:
    """Have the command answer in a child that has no terminal; give its process and address."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    child = os.fork()
    if child == 0:
        code = 99
        try:
            signal.signal(signal.SIGINT, signal.default_int_handler)
            with log.open("w", buffering=1) as sys.stdout:
                sys.stderr = sys.stdout
                code = run(["serve", "--port", str(port), "--db", url])
        finally:
            os._exit(code)
    at = f"http://127.0.0.1:{port}"
    wait_for(at)
    yield child, at


def _said(log: Path, at: str) -> list[dict[str, Any]]:
    """Return what a service logged between its first line and its last."""
    first, *logged, last = log.read_text().splitlines()
    assert first == f"{at} (and {at}/api/v1): read-only; Ctrl-C stops it"
    assert last == "autodb: stopped"
    return [json.loads(line) for line in logged]


def test_stopped_it_answers_what_is_on_its_way(
    url: str, pair: dict[str, str], tmp_path: Path
) -> None:
    lines = (json.dumps(CUT) + "\n") * 3000
    got: list[str] = []
    with _forked(url, tmp_path / "log") as (child, at):
        path = f"{at}{API}/machines/lathe-0/lookup/batch"
        with httpx.stream("POST", path, params=pair, content=lines, timeout=60.0) as response:
            for line in response.iter_lines():
                if not got:
                    os.kill(child, signal.SIGTERM)
                got.append(line)
        assert os.waitpid(child, 0)[1] == 0
    assert json.loads(got[-1]) == {"answered": 3000, "refused": 0}
    said = _said(tmp_path / "log", at)
    answered = [one for one in said if one.get("route", "").endswith("/batch")]
    assert [one["status"] for one in answered] == [200]


def test_interrupted_twice_it_stops_without_alarm(
    url: str, pair: dict[str, str], tmp_path: Path
) -> None:
    lines = (json.dumps(CUT) + "\n") * 100_000  # more than the buffers of a socket hold
    with _forked(url, tmp_path / "log") as (child, at):
        path = f"{at}{API}/machines/lathe-0/lookup/batch"
        with (
            httpx.Client() as quiet,
            httpx.stream("POST", path, params=pair, content=lines, timeout=60.0) as response,
        ):
            quiet.get(f"{at}/healthz")  # a connection that is kept
            answered = response.iter_lines()
            next(answered)
            for _ in range(2):
                os.kill(child, signal.SIGINT)
                time.sleep(0.2)
            assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 130
    said = _said(tmp_path / "log", at)
    assert [one["message"] for one in said if one["level"] != "info"] == [
        "1 answers on their way were cut off"
    ]


def test_tokens_by_command(cli: Cli) -> None:
    cli("init")
    assert "no token" in cli("token", "list").out
    secret = cli("token", "add", "planner", "--role", "operate", "--days", 30).out.strip()
    assert secret.startswith("autodb_")
    again = cli("token", "add", "planner")
    assert (again.code, "use another" in again.err) == (2, True)
    assert "valid" in cli("token", "list").out
    (listed,) = json.loads(cli("token", "list", "--json").out)
    assert (listed["state"], listed["role"]) == ("valid", "operate")
    assert "revoked" in cli("token", "revoke", "planner").out
    assert "already" in cli("token", "revoke", "planner").out
    assert cli("token", "revoke", "plan").code == 2
    assert cli("token", "add", "x", "--role", "root").code == 2
    store = open_store("sqlite:///autodb.sqlite3")
    with store.reading() as session:
        said = [(one.who, one.action) for _, one in noted(session, most=9)]
    store.close()
    assert said == [("command line", "token revoked"), ("command line", "token added")]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--host", "0.0.0.0"), "autodb token add NAME --role read"),
        (("--write",), "autodb token add NAME --role operate"),
        (("--certificate", "c.pem"), "give both"),
        (("--certificate", "c.pem", "--key", "k.pem"), "give both as PEM"),
        (("--host", "203.0.113.9", "--port", "9"), "autodb token add"),
        (("--name", "shop.example"), "autodb token add NAME --role read"),
        (("--proxy", "127.0.0.1"), "autodb token add NAME --role read"),
        (("--proxy", "shop"), "write one such as 127.0.0.1 or 192.0.2.0/24"),
    ],
)
def test_a_service_that_nobody_could_use_does_not_begin(
    cli: Cli, options: tuple[str, ...], said: str
) -> None:
    cli("init")
    done = cli("serve", *options)
    assert (done.code, done.err.count("\n")) == (2, 1)
    assert said in done.err


def test_a_port_that_is_taken_is_said(cli: Cli) -> None:
    cli("init")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        done = cli("serve", "--port", taken.getsockname()[1])
    assert done.code == 2
    assert "use another --port or --host" in done.err


def test_no_connection_is_open_once_answers_are_cut_off(url: str, pair: dict[str, str]) -> None:
    """An answer that nobody reads: what is not closed would hold up the end of the process."""
    lines = (json.dumps(CUT) + "\n") * 100_000  # more than the buffers of a socket hold
    server, thread, at = listening(Settings(url))
    path = f"{at}{API}/machines/lathe-0/lookup/batch"
    with httpx.stream("POST", path, params=pair, content=lines, timeout=60.0) as response:
        answered = response.iter_lines()
        next(answered)
        time.sleep(0.3)
        server.should_exit = server.force_exit = True
        thread.join(30.0)
    assert not thread.is_alive()
    assert not server.server_state.connections
