"""Who may ask: tokens, their roles and ends, guesses, and requests that were passed on."""

from pathlib import Path
from typing import Any

import httpx
import pytest
from fastapi.testclient import TestClient

from autodb.agent.operate.access import add_token, revoke_token
from autodb.store import Store, models
from autodb.web.http.settings import Settings
from autodb.web.service import PASSED_ON
from tests.helpers.asked import API, CUT, bearer, client_of, detail
from tests.helpers.serving import served


def test_another_address_needs_a_token_for_all_but_health(url: str, store: Store) -> None:
    secret = add_token(store, "planner", "read", days=None)
    with client_of(url, host="192.0.2.1") as client:
        assert client.get("/healthz").json() == {"status": "ok"}
        for path in (f"{API}/machines", "/metrics"):
            got = client.get(path)
            assert got.status_code == 401
            assert got.headers["www-authenticate"] == "Bearer"
            assert client.get(path, headers=bearer(secret)).status_code == 200
        assert client.get(f"{API}/machines", headers=bearer(secret + "x")).status_code == 401
        assert client.get(f"{API}/machines", headers={"Authorization": secret}).status_code == 401


def test_only_hashes_of_tokens_are_kept(url: str, store: Store) -> None:
    secret = add_token(store, "planner", "read", days=1)
    store.close()
    assert secret.encode() not in Path(url.removeprefix("sqlite:///")).read_bytes()


def test_roles_allow_what_they_say(url: str, store: Store, pair: dict[str, str]) -> None:
    reads, operates, admin = (add_token(store, r, r, days=1) for r in ("read", "operate", "admin"))
    job = {"name": "j", **pair, "cut": [CUT]}
    path = f"{API}/machines/lathe-0/predictions"
    with client_of(url, writes=True) as client:
        assert client.post(path, json=job).status_code == 401
        refused = client.post(path, json=job, headers=bearer(reads))
        assert (refused.status_code, detail(refused)) == (403, "'read' may read, not operate")
        made = client.post(path, json=job, headers=bearer(operates))
        assert made.status_code == 201
        assert client.get(made.headers["location"]).status_code == 200
        assert client.get(f"{API}/audit", headers=bearer(operates)).status_code == 403
        log = client.get(f"{API}/audit", headers=bearer(admin)).json()
        assert [one["entry"]["action"] for one in log] == [
            "prediction kept", *["token added"] * 3
        ]  # fmt: skip
        assert (log[0]["entry"]["who"], log[0]["entry"]["row_id"]) == ("operate", 1)
    with client_of(url) as client:
        refused = client.post(path, json=job, headers=bearer(operates))
        assert refused.status_code == 403
        assert "read-only" in detail(refused)


def test_a_token_that_is_revoked_or_expired_is_refused(
    url: str, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("autodb.web.service.HELD_S", 0.0)
    secret, old = (add_token(store, name, "read", days=1) for name in ("a", "b"))
    with store.writing() as session:
        row = session.query(models.AccessToken).filter_by(name="b").one()
        row.expires_at = "2026-01-01T00:00:00+00:00"
    with client_of(url, host="192.0.2.1") as client:
        assert client.get(f"{API}/machines", headers=bearer(old)).status_code == 401
        assert client.get(f"{API}/machines", headers=bearer(secret)).status_code == 200
        assert revoke_token(store, "a")
        assert client.get(f"{API}/machines", headers=bearer(secret)).status_code == 401
    assert not revoke_token(store, "a")


def test_who_guesses_tokens_has_to_wait(url: str, store: Store) -> None:
    secret = add_token(store, "planner", "read", days=1)
    with client_of(url, host="192.0.2.1") as client:
        for k in range(20):
            assert client.get(f"{API}/machines", headers=bearer(f"guess {k}")).status_code == 401
        got = client.get(f"{API}/machines", headers=bearer("one more"))
        assert got.status_code == 429
        assert 0 < int(got.headers["retry-after"]) <= 60
        as_long = client.get(f"{API}/machines", headers=bearer(secret[:-1] + "~"))
        assert as_long.status_code == 429
        assert client.get(f"{API}/machines", headers=bearer(secret)).status_code == 200
        assert client.post("/sign-in", data={"token": "no"}).status_code == 429
        signed_in = client.post("/sign-in", data={"token": secret}, follow_redirects=False)
        assert signed_in.status_code == 303


@pytest.mark.parametrize(
    "more", [{"names": ("shop.example",)}, {"proxies": ("127.0.0.1",)}], ids=["name", "proxy"]
)
def test_behind_a_proxy_all_but_health_needs_a_token(
    url: str, store: Store, more: dict[str, Any]
) -> None:
    secret = add_token(store, "planner", "read", days=1)
    with client_of(url, **more) as client:
        assert client.get("/healthz").status_code == 200
        for path in (
            f"{API}/machines",
            f"{API}/openapi.json",
            "/metrics",
            "/",
            "/machines/lathe-0",
        ):
            assert client.get(path).status_code == 401, path
            assert client.get(path, headers=bearer(secret)).status_code == 200, path


@pytest.mark.parametrize("name", PASSED_ON)
def test_what_was_passed_on_is_not_of_this_computer(client: TestClient, name: str) -> None:
    assert client.get(f"{API}/machines").status_code == 200
    assert client.get(f"{API}/machines", headers={name: "127.0.0.1"}).status_code == 401


@pytest.mark.parametrize(
    ("proxies", "seen"),
    [((), {"127.0.0.1"}), (("192.0.2.0/24",), {"127.0.0.1"}), (("127.0.0.0/8",), {"192.0.2.7"})],
)
def test_who_asks_is_believed_from_named_proxies_alone(
    url: str, store: Store, proxies: tuple[str, ...], seen: set[str], caplog: Any
) -> None:
    secret = add_token(store, "planner", "read", days=1)
    said = {"X-Forwarded-For": "192.0.2.7", "X-Forwarded-Proto": "https"}
    with served(Settings(url, proxies=proxies)) as at, caplog.at_level("INFO", "autodb.web"):
        httpx.get(f"{at}{API}/machines", headers=bearer(secret) | said).raise_for_status()
        cookie = httpx.post(f"{at}/sign-in", data={"token": secret}, headers=said).headers
    assert {one.client for one in caplog.records if one.message == "answered"} == seen
    assert ("Secure" in cookie["set-cookie"]) == (seen == {"192.0.2.7"})
