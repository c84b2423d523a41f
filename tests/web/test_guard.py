"""What stands before every route: headers, host names, sizes, counts, a database that is gone."""

from collections.abc import Iterator
from pathlib import Path

from fastapi.testclient import TestClient

from autodb.web.http.guard import HEADERS
from tests.helpers.asked import API, CUT, client_of, detail


def test_every_answer_has_the_headers_of_safety(client: TestClient) -> None:
    for path in ("/healthz", f"{API}/machines", f"{API}/none", "/static/site.css"):
        got = client.get(path)
        assert HEADERS.items() <= dict(got.headers).items() | {
            (name, got.headers.get(name)) for name in HEADERS
        }
        assert len(got.headers["x-request-id"]) == 12
        assert "server" not in got.headers


def test_a_name_that_leads_here_from_elsewhere_is_refused(client: TestClient) -> None:
    for host in ("evil.example", "evil.example:8321", "localhost.evil.example"):
        got = client.get(f"{API}/machines", headers={"Host": host})
        assert got.status_code == 400, host
    for host in ("localhost", "127.0.0.1:8321", "[::1]:8321", "LOCALHOST:1"):
        assert client.get(f"{API}/machines", headers={"Host": host}).status_code == 200, host


def test_more_than_is_taken_is_refused(client: TestClient) -> None:
    path = f"{API}/machines/lathe-0/predict"
    large = b" " * (2**20 + 1)
    assert client.post(path, content=large).status_code == 413

    def parts() -> Iterator[bytes]:
        for _ in range(20):
            yield b" " * 100_000

    got = client.post(path, content=parts())
    assert got.status_code == 413
    assert "1 MiB" in detail(got)


def test_counts_say_what_was_asked(client: TestClient, pair: dict[str, str]) -> None:
    client.get(f"{API}/machines/lathe-0/lookup", params=pair | CUT)
    client.get(f"{API}/machines/nobody")
    text = client.get("/metrics").text
    route = 'route="/machines/{machine:path}/lookup"'
    assert f'autodb_requests_total{{method="GET",{route},status="200"}} 1.0' in text
    assert 'status="404"} 1.0' in text
    assert "autodb_cuts_looked_up_total 1.0" in text
    assert f"autodb_request_seconds_count{{{route}}} 1.0" in text


def test_a_database_that_is_gone_is_503(url: str, tmp_path: Path) -> None:
    with client_of(url) as client:
        Path(url.removeprefix("sqlite:///")).rename(tmp_path / "away")
        got = client.get(f"{API}/machines")
        assert got.status_code == 503
        assert "No such file" in detail(got)
