"""A service that is stopped or killed while it reads: what was accepted is imported, once."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from fastapi.testclient import TestClient
from sqlalchemy import select

from autodb.agent.operate.access import noted
from autodb.proofs.runs.keeping.flips import read_rows
from autodb.store import Store, models
from autodb.web.receive import landing
from autodb.web.receive.accepted import ACCEPTED
from tests.helpers.asked import API
from tests.helpers.files import write
from tests.helpers.sending import SEND, WEEK, became_of, files_in, serving
from tests.helpers.serving import wait_for


@pytest.fixture
def large(tmp_path: Path) -> bytes:
    """Return a recording that takes seconds to be read."""
    t = np.arange(1_000_000) * 1e-3
    columns = {"t": t, "x.current": np.sin(t), "y.current": np.cos(t)}
    return write(tmp_path / "large.csv", columns).read_bytes()


def _reading(client: TestClient, sent: Any) -> int:
    """Wait until a recording is read; return the process that does."""
    children = client.app.state.service.children  # type: ignore[attr-defined]
    while "rows" not in (said := client.get(sent.headers["location"]).json())["progress"]:
        assert said["state"] in ("waiting", "reading"), said
        time.sleep(0.01)
    (pid,) = children._running
    return int(pid)


@pytest.mark.usefixtures("started")
def test_killed_in_the_middle_nothing_is_there(
    url: str, operates: dict[str, str], large: bytes, tmp_path: Path
) -> None:
    before = read_rows(tmp_path / "sent.sqlite3")
    files = {"recording": ("large.csv", large)}
    with serving(url) as client:
        sent = client.post(SEND, files=files, headers=operates)
        os.kill(_reading(client, sent), signal.SIGKILL)
        said = became_of(client, sent)
        assert "large.csv: reading it broke the process that read it (SIGKILL)" in said["refused"]
        assert files_in(tmp_path / "recordings") == []
        assert read_rows(tmp_path / "sent.sqlite3") == before

        # Stopped in the middle, the service ends it, and leaves what waits to the next one
        two = [client.post(SEND, files=files, headers=operates) for _ in range(2)]
        pid = _reading(client, two[0])
        imports = client.app.state.service.imports  # type: ignore[attr-defined]
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    for one in two:
        assert imports.said(one.json()["number"]).state == "waiting"
    assert read_rows(tmp_path / "sent.sqlite3") == before


def test_what_was_accepted_is_imported_after_a_stop(
    url: str, store: Store, operates: dict[str, str], week: bytes, tmp_path: Path
) -> None:
    """In its order, under its number, by whom it was sent; numbers go on."""
    side = b'[recording]\nmachine = "lathe-1"\n'
    with serving(url) as client:
        sent = [
            client.post(SEND, files=files, headers=operates)
            for files in (
                {"recording": ("part.csv", week[: week.rindex(b"\n", 0, 1500) + 1])},
                {"recording": (WEEK, week), "side": ("s.toml", side)},
                {"recording": ("bad.csv", b"t,x.current\n0,1\n1,a\n")},
            )
        ]
    with serving(url) as client:
        said = [became_of(client, one) for one in sent]
        again = client.post(SEND, files={"recording": (WEEK, week)}, headers=operates)
        assert again.json()["number"] > max(one["number"] for one in said)
        assert became_of(client, again)["came_in"]["already_there"]
        assert "autodb_imports_running 0.0" in client.get("/metrics").text
    assert [one["state"] for one in said] == ["done", "done", "refused"]
    with store.reading() as session:
        notes = [one for _, one in noted(session, most=9) if one.row_kind == "recording"]
    audit = [(one.who, one.row_id) for one in notes]
    assert audit == [("shop", 2), ("shop", 2), ("shop", 1)]
    assert list((tmp_path / "recordings" / ACCEPTED).iterdir()) == []
    assert list((tmp_path / "recordings" / landing.UNFINISHED).iterdir()) == []


def test_what_was_accepted_is_imported_after_a_kill(
    url: str, store: Store, operates: dict[str, str], week: bytes, tmp_path: Path
) -> None:
    """Killed as soon as it has said 202; its note is older than what is taken away."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [sys.executable, "-m", "autodb", "serve", "--write", "--port", str(port), "--db", url]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        at = f"http://127.0.0.1:{port}"
        wait_for(at)
        sent = httpx.post(f"{at}{SEND}", files={"recording": (WEEK, week)}, headers=operates)
        process.kill()
    assert sent.status_code == 202
    folder = tmp_path / "recordings"
    (note,) = (folder / landing.UNFINISHED).iterdir()
    os.utime(note, (0.0, 0.0))
    with serving(url) as client:
        assert became_of(client, sent)["state"] == "done"
    with store.reading() as session:
        (row,) = session.scalars(select(models.StoredRecording))
        assert [row.path] == [str(path) for path in files_in(folder)]


def test_what_another_service_has_at_work_is_left_to_it(
    url: str, operates: dict[str, str], week: bytes
) -> None:
    with serving(url) as first:
        sent = first.post(SEND, files={"recording": (WEEK, week)}, headers=operates)
        with serving(url) as second:
            assert second.get(sent.headers["location"]).status_code == 404
        assert became_of(first, sent)["state"] == "done"


@pytest.mark.parametrize(
    "text", ["{", json.dumps({"number": 1, "machine": "lathe-1", "file": "../a/b.csv",
                              "by": {"who": "a", "role": 2, "token_id": None}})]
)  # fmt: skip
def test_a_note_that_nothing_accepted_wrote_is_left(url: str, tmp_path: Path, text: str) -> None:
    folder = tmp_path / "recordings" / ACCEPTED
    folder.mkdir(parents=True)
    (tmp_path / "a").mkdir()
    (folder / "a.json").write_text(text)
    with serving(url) as client:
        assert client.get(f"{API}/imports/1").status_code == 404
    assert (tmp_path / "a").is_dir()
    assert (folder / "a.json").read_text() == text


def test_what_a_killed_service_left_is_decided_a_day_later(
    url: str, store: Store, tmp_path: Path
) -> None:
    folder = tmp_path / "recordings"
    old, known, fresh = (landing.place(folder, "lathe-1") for _ in range(3))
    for made in (old, known, fresh):
        (made / "a.csv").write_bytes(b"t")
    with store.writing() as session:
        machine = session.scalars(select(models.Machine)).one()
        row = models.StoredRecording(
            machine_id=machine.id, sha256="0", path=str(known / "a.csv"), kind="cuts", rows=1,
            units={}, side={},
        )  # fmt: skip
        session.add(row)
    for made in (old, known):
        os.utime(folder / landing.UNFINISHED / made.name, (0.0, 0.0))
    with serving(url):
        pass
    assert [made.exists() for made in (old, known, fresh)] == [False, True, True]
    assert [path.name for path in (folder / landing.UNFINISHED).iterdir()] == [fresh.name]
