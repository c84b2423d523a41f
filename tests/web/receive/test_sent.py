"""Recordings that are sent are kept and counted once, or refused in one line."""

import io
import pickle
import time
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from fastapi import HTTPException
from sqlalchemy import select

from autodb.agent.operate.access import Access, Role, add_token, noted
from autodb.agent.operate.receiving import Sent
from autodb.errors import UnusableInput
from autodb.proofs.runs.keeping.flips import read_rows
from autodb.store import Store, models
from autodb.web.client import Client
from autodb.web.http.settings import ReaderBounds, Settings
from autodb.web.receive import apart
from autodb.web.receive.imports import Imports
from autodb.web.receive.sent import safe
from tests.helpers.asked import API, detail
from tests.helpers.sending import SEND, WEEK, became_of, files_in, serving
from tests.helpers.serving import served


def test_a_recording_that_is_sent_is_kept_and_counts_once(
    url: str, store: Store, operates: dict[str, str], week: bytes, tmp_path: Path
) -> None:
    """Sent in part, then whole: known by its name again; then once more, with a path for a name."""
    lines = week.splitlines(keepends=True)
    with serving(url) as client:
        sent = [
            client.post(SEND, files={"recording": (name, data)}, headers=operates)
            for name, data in (
                (WEEK, b"".join(lines[:21])),
                (WEEK, week),
                (f"..\\..\\../../etc/{WEEK}", week),
            )
        ]
        part, whole, again = (became_of(client, one)["came_in"] for one in sent)
        counts = client.get("/metrics").text
    assert [part["cuts"], whole["cuts"], whole["again"]] == [20, 20, 20]
    assert (again["recording_id"], again["already_there"]) == (whole["recording_id"], True)
    assert 'autodb_imports_total{state="done"} 3.0' in counts
    assert "autodb_imports_running 0.0" in counts
    kept = files_in(tmp_path / "recordings")
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
    kept = sorted(path.suffix for path in files_in(tmp_path / "lathe-1"))
    assert kept == [".csv", ".parquet", ".toml"]


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
    ("a.csv", b"\x89PNG\x1a\x00\xff\n\x00", "", "a.csv: not text"),
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
     "w.csv: 10001 columns; send at most 10000"),
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
        key, (said, _language) = apart.received_line(last)
        assert (key, line in said) == (apart.REFUSED, True), said
        assert said.isprintable()
        assert str(tmp_path) not in said
    assert read_rows(tmp_path / "sent.sqlite3") == before
    assert not (tmp_path / "unpickled").exists()


@pytest.mark.parametrize(
    ("files", "line"),
    [
        ({"recording": ("a.png", b"\x89PNG")}, "a.png: unknown kind of file; use .csv, .txt"),
        ({"recording": ("a.pkl", b"\x80\x04.")}, "a.pkl: unknown kind of file"),
        ({"recording": ("a.npz", b"PK")}, "a.npz: unknown kind of file"),
        ({"recording": ("..", b"t")}, "recording: unknown kind of file"),
        ({"recording": ("a.csv", b"")}, "a.csv: the file is empty"),
        ({"side": ("a.toml", b"")}, "recording: missing; send it with -F recording=@FILE"),
        ({"recordin": ("a.csv", b"t")}, "no part 'recordin' (did you mean recording?)"),
        ([("recording", ("a.csv", b"t")), ("recording", ("b.csv", b"t"))], "recording: sent twice"),
    ],
)  # fmt: skip
def test_what_cannot_be_a_recording_is_refused_at_once(
    url: str, operates: dict[str, str], tmp_path: Path, files: Any, line: str
) -> None:
    with serving(url) as client:
        got = client.post(SEND, files=files, headers=operates)
    assert (got.status_code, line in detail(got)) == (422, True), got.text
    assert files_in(tmp_path / "recordings") == []


@pytest.mark.parametrize(
    ("kind", "body", "line"),
    [
        ("text/csv", b"t,x\n", "not a form with files"),
        ("multipart/form-data", b"", "not a form with files"),
        ("multipart/form-data; boundary=b", b"--c\r\n", "not a whole form"),
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
    with serving(url) as client:
        got = client.post(SEND, content=body, headers=operates | {"Content-Type": kind})
    assert (got.status_code, line in detail(got)) == (422, True), got.text


def test_who_may_send(url: str, store: Store, operates: dict[str, str], tmp_path: Path) -> None:
    reads = {"Authorization": f"Bearer {add_token(store, 'planner', 'read', days=1)}"}
    files = {"recording": ("a.csv", b"t,x.current\n")}
    with serving(url) as client:
        assert client.post(SEND, files=files).status_code == 401
        assert client.post(SEND, files=files, headers=reads).status_code == 403
        nobody = client.post(f"{API}/machines/x/recordings", files=files, headers=operates)
        assert (nobody.status_code, "no machine 'x'" in detail(nobody)) == (404, True)
        asked = client.get(f"{API}/imports/1")
        assert (asked.status_code, "no import 1" in detail(asked)) == (404, True)
    with serving(url, writes=False) as client:
        got = client.post(SEND, files=files, headers=operates)
        assert (got.status_code, "--write" in detail(got)) == (403, True)
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
