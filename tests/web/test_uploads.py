"""What is sent to the service: recordings and programs, read apart, within bounds."""

import io
import json
import os
import pickle
import signal
import socket
import subprocess
import sys
import time
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import anyio
import h5py
import httpx
import numpy as np
import pytest
from fastapi import HTTPException
from fastapi import Request as HttpRequest
from fastapi.testclient import TestClient
from scipy.io import savemat
from sqlalchemy import select

from autodb.agent.operate.access import Access, Role, add_token, noted
from autodb.agent.operate.receiving import Sent
from autodb.agent.rows.machines import add_machine
from autodb.errors import UnusableInput
from autodb.files.job import read_job
from autodb.files.machine import LATHE
from autodb.proofs.runs.keeping.flips import read_rows
from autodb.store import Store, create_store, models, open_store
from autodb.web.app import make_app
from autodb.web.client import Client
from autodb.web.http.settings import ReaderBounds, RequestLimits, Settings
from autodb.web.receive import apart, landing
from autodb.web.receive.accepted import ACCEPTED
from autodb.web.receive.imports import Imports
from autodb.web.receive.sent import receive_parts, safe
from tests.conftest import Cli
from tests.helpers.files import write
from tests.helpers.serving import served, wait_for

API = "/api/v1"
SEND = f"{API}/machines/lathe-1/recordings"
PREDICT = f"{API}/machines/lathe-1/predict/program"
WEEK = "shop-week-1.csv"


@pytest.fixture(scope="module")
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
def store(url: str) -> Iterator[Store]:
    """Return the copy, opened."""
    opened = open_store(url)
    yield opened
    opened.close()


@pytest.fixture
def operates(store: Store) -> dict[str, str]:
    """Return the headers of who may send recordings."""
    return {"Authorization": f"Bearer {add_token(store, 'shop', 'operate', days=1)}"}


@pytest.fixture
def week(sample_jobs: Path) -> bytes:
    """Return a table of forty cuts."""
    return (sample_jobs / "stepped_shaft" / "recordings" / WEEK).read_bytes()


@contextmanager
def _serving(url: str, *, writes: bool = True, **limits: Any) -> Iterator[TestClient]:
    app = make_app(Settings(url, writes=writes, limits=RequestLimits(**limits)))
    with TestClient(app, base_url="http://localhost", raise_server_exceptions=False) as client:
        yield client


def _detail(response: Any) -> str:
    body = response.json()
    assert list(body) == ["detail"]
    assert "\n" not in body["detail"]
    return str(body["detail"])


def _done(client: TestClient, sent: Any) -> dict[str, Any]:
    """Wait for an import, and return what became of it."""
    assert sent.status_code == 202, sent.text
    until = time.monotonic() + 60.0
    while time.monotonic() < until:
        said: dict[str, Any] = client.get(sent.headers["location"]).json()
        if said["state"] in ("done", "refused"):
            return said
        time.sleep(0.05)
    raise AssertionError("it was not read")


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())


# Recordings that come in


def test_a_recording_that_is_sent_is_kept_and_counts_once(
    url: str, store: Store, operates: dict[str, str], week: bytes, tmp_path: Path
) -> None:
    """Sent in part, then whole: known by its name again; then once more, with a path for a name."""
    lines = week.splitlines(keepends=True)
    with _serving(url) as client:
        sent = [
            client.post(SEND, files={"recording": (name, data)}, headers=operates)
            for name, data in (
                (WEEK, b"".join(lines[:21])),
                (WEEK, week),
                (f"..\\..\\../../etc/{WEEK}", week),
            )
        ]
        part, whole, again = (_done(client, one)["came_in"] for one in sent)
        counts = client.get("/metrics").text
    assert [part["cuts"], whole["cuts"], whole["again"]] == [20, 20, 20]
    assert (again["recording_id"], again["already_there"]) == (whole["recording_id"], True)
    assert 'autodb_imports_total{state="done"} 3.0' in counts
    assert "autodb_imports_running 0.0" in counts
    kept = _files(tmp_path / "recordings")
    with store.reading() as session:
        rows = session.scalars(
            select(models.StoredRecording).order_by(models.StoredRecording.id)
        ).all()
        assert sorted(row.path for row in rows) == sorted(map(str, kept))
        assert {row.delivered_as for row in rows} == {str(tmp_path / "recordings/lathe-1" / WEEK)}
        audit = [one for _, one in noted(session, most=9) if one.action == "recording imported"]
    month = time.strftime("%Y-%m", time.gmtime())
    assert {path.parent.parent for path in kept} == {tmp_path / "recordings" / "lathe-1" / month}
    assert [(one.who, one.row_id, dict(one.detail or {})["already_there"]) for one in audit] == [
        ("shop", 2, True), ("shop", 2, False), ("shop", 1, False)
    ]  # fmt: skip


def test_the_client_sends_a_recording_with_its_side_file(
    url: str, store: Store, sample_jobs: Path, tmp_path: Path
) -> None:
    token = add_token(store, "shop", "operate", days=1)
    folder = sample_jobs / "stepped_shaft" / "recordings"
    said: list[str] = []
    settings = Settings(url, writes=True, recordings=tmp_path)
    with served(settings) as at, Client(at, token=token) as client:
        came = client.import_recording("lathe-1", folder / WEEK, progress=said.append)
        raw = client.import_recording("lathe-1", folder / "standard-cut-raw.parquet")
        with pytest.raises(UnusableInput, match=r"air-moves\.toml: recording\.kind"):
            side = tmp_path / "side.toml"
            side.write_text("[recording]\nkind = 3\n")
            client.import_recording("lathe-1", folder / "air-moves.csv", side=side)
        with pytest.raises(UnusableInput, match="No such file"):
            client.import_recording("lathe-1", folder / "none.csv")
    assert (came.rows, came.cuts, came.already_there) == (40, 40, False)
    assert raw.cuts == 1
    assert {"waiting", "reading"} & set(said)
    kept = sorted(path.suffix for path in _files(tmp_path / "lathe-1"))
    assert kept == [".csv", ".parquet", ".toml"]


# Recordings that are refused


def _zip(path: Path) -> None:
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("a.csv", "t,x.current\n0,1\n")


def _elsewhere(path: Path) -> None:
    """Write an HDF5 file whose rows are those of a file of the computer that reads it."""
    with h5py.File(path, "w") as file:
        file["t"] = np.arange(8.0)
        external = [("/etc/passwd", 0, 64)]
        file.create_dataset("x.current", (8,), dtype="<f8", external=external)


class _Trap:
    """Something that makes a file when it is unpickled."""

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        return (Path("unpickled").touch, ())


WRONG: tuple[tuple[str, bytes | Callable[[Path], None], str, str], ...] = (
    ("a.csv", b"\x89PNG\x1a\x00\xff\n\x00", "", "a.csv: the header is not UTF-8 text"),
    ("zip.csv", _zip, "", "zip.csv: "),
    ("b.csv", b"t,x\n0,1\n1,2\n2,3\n", "", "b.csv: no channel beside its time or cut number"),
    ("c.csv", b"a,b\n1,2\n", "", "c.csv: neither a column 't'"),
    ("d.csv", b"t,x.current\n0,1\n1,a\n", "", "d.csv: "),
    ("e.csv", b"t,x.current\n0,1\n1,2\n2,3\n", "[recording\n", "e.toml: not a readable TOML"),
    (
        "f.csv", b"t,x.current\n0,1\n1,2\n2,3\n", '[recording]\nmachine = "mill-1"\n',
        "f.csv: its side file says machine 'mill-1', not 'lathe-1'",
    ),
    (
        "g.csv", b"t,x.current\n0,1\n1,2\n2,3\n", '[tool]\nfile = "/etc/passwd"\n',
        "g.toml: tool.file: only the recording and this file were sent",
    ),
    ("w.csv", b"cut," + b"c" * 9 + b",".join(b"%d" % k for k in range(10_000)) + b"\n", "",
     "w.csv: 10001 columns; at most 10000"),
    ("h.h5", _elsewhere, "", "h.h5: the rows of 'x.current' lie in another file"),
    ("i.mat", pickle.dumps(_Trap()), "", "i.mat: not a whole MAT file"),
)  # fmt: skip


def _put(folder: Path, name: str, made: bytes | Callable[[Path], None], side: str) -> Path:
    """Put a recording into a folder of its own, with its side file; return where."""
    path = folder / name.replace(".", "-") / name
    path.parent.mkdir()
    if isinstance(made, bytes):
        path.write_bytes(made)
    else:
        made(path)
    if side:
        path.with_suffix(".toml").write_text(side)
    return path


@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
def test_what_is_wrong_gets_one_line(url: str, tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.chdir(tmp_path)
    before = read_rows(tmp_path / "sent.sqlite3")
    for name, made, side, line in WRONG:
        path = _put(tmp_path, name, made, side)
        sent = Sent(path, "lathe-1", path, Access("shop", Role.OPERATE, None))
        says = io.BytesIO()
        apart.do_asked(apart.Request(url, ReaderBounds(), apart.Import(sent)), says)
        *_, last = says.getvalue().splitlines()
        key, said = apart.received_line(last)
        assert (key, line in said) == (apart.REFUSED, True), said
        assert said.isprintable()
        assert str(tmp_path) not in said
    assert read_rows(tmp_path / "sent.sqlite3") == before
    assert not (tmp_path / "unpickled").exists()


@pytest.mark.parametrize(
    ("files", "line"),
    [
        ({"recording": ("a.png", b"\x89PNG")}, "a.png: unknown kind of file; .csv, .parquet"),
        ({"recording": ("a.pkl", b"\x80\x04.")}, "a.pkl: unknown kind of file"),
        ({"recording": ("a.npz", b"PK")}, "a.npz: unknown kind of file"),
        ({"recording": ("..", b"t")}, "recording: unknown kind of file"),
        ({"recording": ("a.csv", b"")}, "a.csv: the file is empty"),
        ({"side": ("a.toml", b"")}, "recording: missing; -F recording=@FILE would work"),
        ({"recordin": ("a.csv", b"t")}, "no part 'recordin' (did you mean recording?)"),
        ([("recording", ("a.csv", b"t")), ("recording", ("b.csv", b"t"))], "recording: sent twice"),
    ],
)  # fmt: skip
def test_what_cannot_be_a_recording_is_refused_at_once(
    url: str, operates: dict[str, str], tmp_path: Path, files: Any, line: str
) -> None:
    with _serving(url) as client:
        got = client.post(SEND, files=files, headers=operates)
    assert (got.status_code, line in _detail(got)) == (422, True), got.text
    assert _files(tmp_path / "recordings") == []


@pytest.mark.parametrize(
    ("kind", "body", "line"),
    [
        ("text/csv", b"t,x\n", "no form with files"),
        ("multipart/form-data", b"", "no form with files"),
        ("multipart/form-data; boundary=b", b"--c\r\n", "no whole form"),
        (
            "multipart/form-data; boundary=b",
            b'--b\r\nContent-Disposition: form-data; name="recording"; filename="a.csv"\r\n\r\nt',
            "the body was cut off",
        ),
        ("multipart/form-data; boundary=" + "b" * 300, b"", "the body's boundary"),
    ],
)
def test_what_is_no_form_is_refused(
    url: str, operates: dict[str, str], kind: str, body: bytes, line: str
) -> None:
    with _serving(url) as client:
        got = client.post(SEND, content=body, headers=operates | {"Content-Type": kind})
    assert (got.status_code, line in _detail(got)) == (422, True), got.text


def test_who_may_send(url: str, store: Store, operates: dict[str, str], tmp_path: Path) -> None:
    reads = {"Authorization": f"Bearer {add_token(store, 'planner', 'read', days=1)}"}
    files = {"recording": ("a.csv", b"t,x.current\n")}
    with _serving(url) as client:
        assert client.post(SEND, files=files).status_code == 401
        assert client.post(SEND, files=files, headers=reads).status_code == 403
        nobody = client.post(f"{API}/machines/x/recordings", files=files, headers=operates)
        assert (nobody.status_code, "no machine 'x'" in _detail(nobody)) == (404, True)
        asked = client.get(f"{API}/imports/1")
        assert (asked.status_code, "no import 1" in _detail(asked)) == (404, True)
    with _serving(url, writes=False) as client:
        got = client.post(SEND, files=files, headers=operates)
        assert (got.status_code, "--write" in _detail(got)) == (403, True)
    assert not (tmp_path / "recordings").exists()


def test_a_database_on_a_server_needs_a_folder(tmp_path: Path) -> None:
    settings = Settings("postgresql://autodb@db/autodb", writes=True)
    nothing: Any = None
    imports = Imports(settings, nothing, nothing, nothing)
    refusal = pytest.raises(HTTPException, match="--recordings FOLDER")
    with refusal as refused, imports.place("lathe-1"):
        pass
    assert refused.value.status_code == 403
    said = Settings("postgresql://autodb@db/autodb", recordings=tmp_path)
    assert said.keeps_in == tmp_path


# Names


@pytest.mark.parametrize(
    ("called", "name"),
    [
        ("../../etc/passwd", "passwd"),
        ("C:\\recordings\\Fräsen 1.CSV", "Frasen-1.CSV"),
        ("..", "x"),
        (".csv", "csv"),
        ("a\x00b\nc.csv", "a-b-c.csv"),
        ("-rf.csv", "rf.csv"),
        ("$(reboot).csv", "reboot-.csv"),
        ("a" * 300 + ".parquet", "a" * 92 + ".parquet"),
        ("." + "b" * 300, "b" * 100),
        ("録音.csv", "csv"),
    ],
)
def test_a_name_becomes_one_that_is_no_path(called: str, name: str) -> None:
    assert safe(called, "x") == name
    assert safe(name, "x") == name


# Bounds


def test_what_takes_too_much_is_refused(
    url: str, operates: dict[str, str], tmp_path: Path, week: bytes
) -> None:
    """Unpacked, a file of a third of a megabyte asks for a third of a gigabyte."""
    before = read_rows(tmp_path / "sent.sqlite3")
    zeros = np.zeros((2 * 10**7, 1))
    savemat(tmp_path / "a.mat", {"t": zeros, "x.current": zeros}, do_compression=True)
    packed = (tmp_path / "a.mat").read_bytes()
    assert len(packed) < 2**20
    for bounds, name, data, line in (
        (ReaderBounds(memory_MiB=640), "a.mat", packed, "asks for more memory than there is"),
        (
            ReaderBounds(seconds=1),
            "b.csv",
            week,
            "reading it takes longer than the 1 s that it may take",
        ),
    ):
        with _serving(url, importing=bounds) as client:
            sent = client.post(SEND, files={"recording": (name, data)}, headers=operates)
            said = _done(client, sent)
        assert (said["state"], line in said["refused"]) == ("refused", True), said["refused"]
    assert _files(tmp_path / "recordings") == []
    assert read_rows(tmp_path / "sent.sqlite3") == before


def test_out_of_memory_is_said(url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def take_in(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(apart, "take_in", take_in)
    sent = Sent(tmp_path / "a.csv", "lathe-1", tmp_path, Access("shop", Role.OPERATE, None))
    says = io.BytesIO()
    apart.do_asked(apart.Request(url, ReaderBounds(memory_MiB=99), apart.Import(sent)), says)
    key, said = apart.received_line(says.getvalue())
    assert (key, "a.csv: reading it takes more than the 99 MiB" in said) == (apart.REFUSED, True)


def test_more_than_may_be_sent_is_refused(
    url: str, operates: dict[str, str], tmp_path: Path
) -> None:
    with _serving(url, recording_MiB=1) as client:
        for size_MiB, line in ((2, "recording: larger than 1 MiB"), (4, "larger than 3 MiB")):
            files = {"recording": ("a.csv", b"1" * (size_MiB * 2**20))}
            got = client.post(SEND, files=files, headers=operates)
            assert (got.status_code, line in _detail(got)) == (413, True), got.text
    assert _files(tmp_path / "recordings") == []


def test_who_sends_too_often_has_to_wait(url: str, operates: dict[str, str]) -> None:
    files = {"recording": ("a.png", b"x")}
    with _serving(url, a_minute=2) as client:
        sent = [client.post(SEND, files=files, headers=operates) for _ in range(3)]
        program = client.post(PREDICT, files={"program": ("a.nc", b"G0")})
    assert [one.status_code for one in sent] == [422, 422, 429]
    assert 0 < int(sent[-1].headers["retry-after"]) <= 61
    assert "2 files within a minute" in _detail(program)


def test_more_than_can_wait_is_refused(url: str, operates: dict[str, str]) -> None:
    files = {"recording": ("a.png", b"x")}
    with _serving(url, waiting=1) as client:
        imports = client.app.state.service.imports  # type: ignore[attr-defined]
        with imports.place("lathe-1") as place:
            got = client.post(SEND, files=files, headers=operates)
            assert (got.status_code, "1 recordings wait" in _detail(got)) == (503, True)
            assert int(got.headers["retry-after"]) > 0
            assert place.made.is_dir()
        assert client.post(SEND, files=files, headers=operates).status_code == 503


def test_what_is_long_on_its_way_is_given_up(tmp_path: Path) -> None:
    async def receive() -> dict[str, Any]:
        await anyio.sleep(5.0)
        return {}

    headers = [(b"content-type", b"multipart/form-data; boundary=b")]
    request = HttpRequest({"type": "http", "headers": headers}, receive)
    with pytest.raises(HTTPException, match=r"longer than 0\.05 s on its way") as refused:
        anyio.run(receive_parts, request, tmp_path, {"recording": 1}, 0.05)
    assert refused.value.status_code == 408


# Ends in the middle


@pytest.fixture
def large(tmp_path: Path) -> bytes:
    """Return a recording that takes seconds to be read."""
    t = np.arange(2_000_000) * 1e-3
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


def test_killed_in_the_middle_nothing_is_there(
    url: str, operates: dict[str, str], large: bytes, tmp_path: Path
) -> None:
    before = read_rows(tmp_path / "sent.sqlite3")
    files = {"recording": ("large.csv", large)}
    with _serving(url) as client:
        sent = client.post(SEND, files=files, headers=operates)
        os.kill(_reading(client, sent), signal.SIGKILL)
        said = _done(client, sent)
        assert "large.csv: reading it broke the process that read it (SIGKILL)" in said["refused"]
        assert _files(tmp_path / "recordings") == []
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
    with _serving(url) as client:
        sent = [
            client.post(SEND, files=files, headers=operates)
            for files in (
                {"recording": ("part.csv", week[: week.rindex(b"\n", 0, 1500) + 1])},
                {"recording": (WEEK, week), "side": ("s.toml", side)},
                {"recording": ("bad.csv", b"t,x.current\n0,1\n1,a\n")},
            )
        ]
    with _serving(url) as client:
        said = [_done(client, one) for one in sent]
        again = client.post(SEND, files={"recording": (WEEK, week)}, headers=operates)
        assert again.json()["number"] > max(one["number"] for one in said)
        assert _done(client, again)["came_in"]["already_there"]
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
    with _serving(url) as client:
        assert _done(client, sent)["state"] == "done"
    with store.reading() as session:
        (row,) = session.scalars(select(models.StoredRecording))
        assert [row.path] == [str(path) for path in _files(folder)]


def test_what_another_service_has_at_work_is_left_to_it(
    url: str, operates: dict[str, str], week: bytes
) -> None:
    with _serving(url) as first:
        sent = first.post(SEND, files={"recording": (WEEK, week)}, headers=operates)
        with _serving(url) as second:
            assert second.get(sent.headers["location"]).status_code == 404
        assert _done(first, sent)["state"] == "done"


@pytest.mark.parametrize(
    "text", ["{", json.dumps({"number": 1, "machine": "lathe-1", "file": "../a/b.csv",
                              "by": {"who": "a", "role": 2, "token_id": None}})]
)  # fmt: skip
def test_a_note_that_nothing_accepted_wrote_is_left(url: str, tmp_path: Path, text: str) -> None:
    folder = tmp_path / "recordings" / ACCEPTED
    folder.mkdir(parents=True)
    (tmp_path / "a").mkdir()
    (folder / "a.json").write_text(text)
    with _serving(url) as client:
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
    with _serving(url):
        pass
    assert [made.exists() for made in (old, known, fresh)] == [False, True, True]
    assert [path.name for path in (folder / landing.UNFINISHED).iterdir()] == [fresh.name]


# Programs


def test_a_program_is_predicted_as_the_command_does(
    cli: Cli, sample_jobs: Path, tmp_path: Path
) -> None:
    """Also where its file is called otherwise; and what is wrong with one is said with its line."""
    file = sample_jobs / "nc_profile" / "job.toml"
    cli("init")
    cli("machine", "add", "lathe-1")
    alone = json.loads(cli("predict", file, "--machine", "lathe-1", "--json").out)
    url = f"sqlite:///{Path('autodb.sqlite3').resolve()}"
    before = read_rows(Path("autodb.sqlite3"))
    job = read_job(file)
    assert job.program is not None
    with served(Settings(url)) as at, Client(at) as client:
        found = client.predict_program("lathe-1", job)
        (tmp_path / "broken.nc").write_text("G0 X10\nG77 Z3\n")
        program = job.program.model_copy(update={"file": str(tmp_path / "broken.nc")})
        with pytest.raises(UnusableInput, match=r"^broken\.nc: line 2: .*G77"):
            client.predict_program("lathe-1", job.model_copy(update={"program": program}))
    said = json.loads(json.dumps(found, default=_plain))
    for name in ("cuts", "behind", "notes", "exceeds"):
        assert said[name] == alone[name], name
    assert said["job"]["program"] == alone["job"]["program"] | {"file": "part.nc"}
    assert read_rows(Path("autodb.sqlite3")) == before


def _plain(value: Any) -> Any:
    return value.model_dump(mode="json") if hasattr(value, "model_dump") else vars(value)


@pytest.mark.parametrize(
    ("files", "line"),
    [
        ({"program": ("a.nc", b"G0")}, "job: missing; both as parts would work"),
        ({"job": (None, b"{"), "program": ("a.nc", b"G0")}, "job: no JSON"),
        ({"job": (None, b"[" * 9999), "program": ("a.nc", b"G0")}, "job: no JSON"),
        ({"job": (None, b"3"), "program": ("a.nc", b"G0")}, "job: "),
        ({"job": (None, b'{"name": 3}'), "program": ("a.nc", b"G0")}, "job: name: "),
        (
            {
                "job": (None, b'{"name": "a", "material": "b", "tool": "c", "program": {}}'),
                "program": ("a.nc", b"G0"),
            },
            "job: program: give either stock_diameter_mm",
        ),
        (
            {
                "job": (
                    None,
                    b'{"name": "a", "material": "b", "tool": "c", "cut": [{"depth_mm": 1, '
                    b'"diameter_mm": 9, "feed_mm_rev": 0.1, "speed_rpm": 100}]}',
                ),
                "program": ("a.nc", b"G0"),
            },
            "job: program: missing",
        ),
    ],
)
def test_a_job_that_cannot_be_is_refused(url: str, files: Any, line: str) -> None:
    with _serving(url) as client:
        got = client.post(PREDICT, files=files)
    assert (got.status_code, line in _detail(got)) == (422, True), got.text
