"""What is asked of the service in tests, and how its answers are read."""

import json
from typing import Any

from fastapi.testclient import TestClient

from autodb.web.app import make_app
from autodb.web.http.settings import Settings

API = "/api/v1"
CUT: dict[str, Any] = {
    "operation": "turn", "diameter_mm": 50.0, "depth_mm": 2.0, "feed_mm_rev": 0.25,
    "speed_m_min": 220.0,
}  # fmt: skip
MILLED = {"operation": "slot", "depth_mm": 2.0, "feed_mm_tooth": 0.05, "speed_m_min": 100.0}


def client_of(
    url: str,
    host: str = "127.0.0.1",
    headers: dict[str, str] | None = None,
    cookies: dict[str, str] | None = None,
    **more: Any,
) -> TestClient:
    made = make_app(Settings(url, host=host, **more))
    return TestClient(
        made, base_url="http://localhost", raise_server_exceptions=False, headers=headers,
        cookies=cookies,
    )  # fmt: skip


def detail(response: Any) -> str:
    body = response.json()
    assert list(body) == ["detail"]
    assert "\n" not in body["detail"]
    return str(body["detail"])


def batch(client: TestClient, pair: dict[str, str], lines: list[str]) -> list[dict[str, Any]]:
    got = client.post(f"{API}/machines/lathe-0/lookup/batch", params=pair, content="\n".join(lines))
    assert got.status_code == 200
    return [json.loads(line) for line in got.text.splitlines()]


def bearer(secret: str) -> dict[str, str]:
    return {"Authorization": f"Bearer {secret}"}
