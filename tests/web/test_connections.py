"""Connections that say nothing, go on without end, or send much at once."""

import json
import socket
from contextlib import ExitStack, suppress
from urllib.parse import urlencode

import httpx
import pytest

from autodb.web.http import turns
from autodb.web.http.settings import Settings
from tests.helpers.asked import API, CUT
from tests.helpers.serving import served


def test_connections_that_say_nothing_keep_nobody_out(
    url: str, pair: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Silent ones and begun ones are ended; idle ones between requests and slow bodies are not."""
    monkeypatch.setattr("autodb.web.server.AT_ONCE", 6)
    monkeypatch.setattr("autodb.web.http.connections.HEAD_S", 1.0)
    line = json.dumps(CUT).encode()
    asked = f"POST {API}/machines/lathe-0/lookup/batch?{urlencode(pair)} HTTP/1.1\r\n"
    head = f"{asked}Host: localhost\r\nContent-Length: {len(line)}\r\n\r\n".encode()
    with served(Settings(url)) as at, httpx.Client(base_url=at) as client, ExitStack() as opened:
        slow, *held = (opened.enter_context(socket.socket()) for _ in range(5))
        where = ("127.0.0.1", httpx.URL(at).port or 0)
        slow.connect(where)
        slow.sendall(head)
        assert client.get("/healthz").status_code == 200
        for one in held:
            one.settimeout(10.0)
            one.connect(where)
        held[0].sendall(b"GET /healthz HTTP/1.1\r\nHost:")
        statuses = (client.get("/healthz").status_code for _ in range(200))
        assert 503 in statuses, "once all are accepted"
        assert [one.recv(12) for one in held] == [b"HTTP/1.1 408", b"", b"", b""]
        assert client.get("/healthz").status_code == 200
        slow.sendall(line)
        assert slow.recv(12) == b"HTTP/1.1 200"


HEALTH = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n"
CHUNKED = HEALTH + b"Transfer-Encoding: chunked\r\n\r\n"


@pytest.mark.parametrize(
    ("parts", "status"),
    [
        ([HEALTH + b"A: " + b"a" * 15_000, b"\r\n\r\n"], b"200"),
        ([HEALTH, *(b"A%d: a\r\n" % k for k in range(98)), b"\r\n"], b"200"),
        ([CHUNKED, *[b"1\r\na\r\n" * 20_000], b"0\r\n\r\n"], b"200"),
        ([HEALTH + b"A: ", *[b"a" * 65_536] * 1000], b"431"),
        ([HEALTH + b"A: " + b"a" * 16_384 + b"\r\n\r\n"], b"431"),
        ([HEALTH, b"A: a\r\n" * 99 + b"\r\n"], b"431"),
        ([b"GET /" + b"a" * 1_000_000], b"431"),
        ([b"\r\n" * 1_000_000], b"431"),
        ([b"no request\r\n\r\n"], b"400"),
    ],
    ids=["long", "many", "chunks", "endless", "too long", "too many", "path", "blank", "none"],
)
def test_a_head_that_goes_on_is_refused(url: str, parts: list[bytes], status: bytes) -> None:
    with served(Settings(url)) as at, socket.socket() as one:
        one.settimeout(20.0)
        one.connect(("127.0.0.1", httpx.URL(at).port or 0))
        with suppress(ConnectionError):  # it is ended before all is sent
            for part in parts:
                one.sendall(part)
        said = one.recv(4096)
        head, _, body = said.partition(b"\r\n\r\n")
        assert head.startswith(b"HTTP/1.1 " + status)
        assert b"x-content-type-options: nosniff" in head.lower()
        assert (status == b"200") or list(json.loads(body)) == ["detail"]
        with suppress(ConnectionError):
            assert one.recv(4096) == b""


def test_trailers_that_go_on_end_the_connection(url: str) -> None:
    with served(Settings(url)) as at, socket.socket() as one:
        one.settimeout(20.0)
        one.connect(("127.0.0.1", httpx.URL(at).port or 0))
        one.sendall(CHUNKED + b"1\r\na\r\n0\r\nT: ")
        with pytest.raises(ConnectionError):
            for _ in range(1000):
                one.sendall(b"t" * 65_536)


def test_blank_lines_between_requests_keep_no_connection(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("autodb.web.http.connections.HEAD_S", 0.5)
    with served(Settings(url)) as at, socket.socket() as one:
        one.settimeout(20.0)
        one.connect(("127.0.0.1", httpx.URL(at).port or 0))
        one.sendall(HEALTH.replace(b"close", b"keep-alive") + b"\r\n")
        assert one.recv(4096).startswith(b"HTTP/1.1 200")
        one.sendall(b"\r\n")
        assert one.recv(1) == b""


def test_a_body_that_goes_on_after_its_answer_is_not_waited_for(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("autodb.web.http.connections.HEAD_S", 0.5)
    with served(Settings(url)) as at, socket.socket() as one:
        one.settimeout(20.0)
        one.connect(("127.0.0.1", httpx.URL(at).port or 0))
        one.sendall(HEALTH.replace(b"close", b"keep-alive") + b"Content-Length: 1000\r\n\r\na")
        assert one.recv(4096).startswith(b"HTTP/1.1 200")
        one.sendall(b"a")
        assert one.recv(1) == b""


def test_requests_that_are_sent_at_once_wait_unread(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A thousand at once, each answered, and no more of them parsed than a piece has."""
    waiting: list[int] = []

    def count(connection: turns.InTurns, piece: bytes) -> None:
        parse(connection, piece)
        waiting.append(len(connection.pipeline))

    parse = turns.InTurns.take
    monkeypatch.setattr(turns.InTurns, "take", count)
    asked = b"GET /no HTTP/1.1\r\nHost: localhost\r\n\r\n"
    with served(Settings(url)) as at, socket.socket() as one:
        one.settimeout(20.0)
        one.connect(("127.0.0.1", httpx.URL(at).port or 0))
        one.sendall(asked * 1000 + HEALTH + b"\r\n")
        said = b"".join(iter(lambda: one.recv(65_536), b""))
    assert said.count(b"HTTP/1.1 404") == 1000
    assert said.count(b"HTTP/1.1 200") == 1
    carried = len(asked) - 1  # at most what the piece before ended with
    assert 0 < max(waiting) <= (turns.PIECE_BYTES + carried) // len(asked)


def test_who_sends_what_is_long_to_parse_gives_others_their_turn(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a body in chunks of one byte no more than a piece is parsed until another is answered."""
    monkeypatch.setattr(turns, "TURN_S", 0.0)
    monkeypatch.setattr(turns, "REST_S", 3600.0)
    with served(Settings(url)) as at, socket.socket() as one, httpx.Client(base_url=at) as other:
        one.settimeout(0.2)
        one.connect(("127.0.0.1", httpx.URL(at).port or 0))
        one.sendall(HEALTH.replace(b"close", b"keep-alive") + b"Transfer-Encoding: chunked\r\n\r\n")
        with pytest.raises(TimeoutError):  # it is read no more
            for _ in range(1000):
                one.sendall(b"1\r\na\r\n" * 20_000)
        assert other.get("/healthz").status_code == 200
