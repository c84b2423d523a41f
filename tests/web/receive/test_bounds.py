"""How much may be sent, how often, and what reading it may take."""

import io
from pathlib import Path
from typing import Any

import anyio
import numpy as np
import pytest
from fastapi import HTTPException
from fastapi import Request as HttpRequest
from scipy.io import savemat

from autodb.agent.operate.access import Access, Role
from autodb.agent.operate.receiving import Sent
from autodb.proofs.runs.keeping.flips import read_rows
from autodb.web.http.settings import ReaderBounds
from autodb.web.receive import apart
from autodb.web.receive.sent import receive_parts
from tests.helpers.asked import detail
from tests.helpers.sending import PREDICT, SEND, became_of, files_in, serving


@pytest.mark.usefixtures("started")
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
        with serving(url, importing=bounds) as client:
            sent = client.post(SEND, files={"recording": (name, data)}, headers=operates)
            said = became_of(client, sent)
        assert (said["state"], line in said["refused"]) == ("refused", True), said["refused"]
    assert files_in(tmp_path / "recordings") == []
    assert read_rows(tmp_path / "sent.sqlite3") == before


def test_out_of_memory_is_said(url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def take_in(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(apart, "take_in_sent", take_in)
    sent = Sent(tmp_path / "a.csv", "lathe-1", tmp_path, Access("shop", Role.OPERATE, None))
    says = io.BytesIO()
    apart.do_asked(apart.Request(url, ReaderBounds(memory_MiB=99), apart.Import(sent)), says)
    key, said = apart.received_line(says.getvalue())
    assert (key, "a.csv: reading it takes more than the 99 MiB" in said[0]) == (apart.REFUSED, True)


def test_more_than_may_be_sent_is_refused(
    url: str, operates: dict[str, str], tmp_path: Path
) -> None:
    with serving(url, recording_MiB=1) as client:
        for size_MiB, line in ((2, "recording: larger than 1 MiB"), (4, "larger than 3 MiB")):
            files = {"recording": ("a.csv", b"1" * (size_MiB * 2**20))}
            got = client.post(SEND, files=files, headers=operates)
            assert (got.status_code, line in detail(got)) == (413, True), got.text
    assert files_in(tmp_path / "recordings") == []


def test_who_sends_too_often_has_to_wait(url: str, operates: dict[str, str]) -> None:
    files = {"recording": ("a.png", b"x")}
    with serving(url, a_minute=2) as client:
        sent = [client.post(SEND, files=files, headers=operates) for _ in range(3)]
        program = client.post(PREDICT, files={"program": ("a.nc", b"G0")})
    assert [one.status_code for one in sent] == [422, 422, 429]
    assert 0 < int(sent[-1].headers["retry-after"]) <= 61
    assert "2 files within a minute" in detail(program)


def test_more_than_can_wait_is_refused(url: str, operates: dict[str, str]) -> None:
    files = {"recording": ("a.png", b"x")}
    with serving(url, waiting=1) as client:
        imports = client.app.state.service.imports  # type: ignore[attr-defined]
        with imports.place("lathe-1") as place:
            got = client.post(SEND, files=files, headers=operates)
            assert (got.status_code, "1 recordings wait" in detail(got)) == (503, True)
            assert int(got.headers["retry-after"]) > 0
            assert place.made.is_dir()
        assert client.post(SEND, files=files, headers=operates).status_code == 503


def test_what_is_long_on_its_way_is_given_up(tmp_path: Path) -> None:
    async def receive() -> dict[str, Any]:
        await anyio.sleep(5.0)
        return {}

    headers = [(b"content-type", b"multipart/form-data; boundary=b")]
    request = HttpRequest({"type": "http", "headers": headers}, receive)
    with pytest.raises(HTTPException, match=r"sending it takes longer than 0\.05 s") as refused:
        anyio.run(receive_parts, request, tmp_path, {"recording": 1}, 0.05)
    assert refused.value.status_code == 408
