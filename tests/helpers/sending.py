"""Recordings and programs that are sent to the service in tests."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from fastapi.testclient import TestClient

from autodb.web.app import make_app
from autodb.web.http.settings import RequestLimits, Settings
from tests.helpers.asked import API

SEND = f"{API}/machines/lathe-1/recordings"
PREDICT = f"{API}/machines/lathe-1/predict/program"
WEEK = "shop-week-1.csv"


@contextmanager
def serving(url: str, *, writes: bool = True, **limits: Any) -> Iterator[TestClient]:
    app = make_app(Settings(url, writes=writes, limits=RequestLimits(**limits)))
    with TestClient(app, base_url="http://localhost", raise_server_exceptions=False) as client:
        yield client


def became_of(client: TestClient, sent: Any) -> dict[str, Any]:
    """Wait for an import, and return what became of it."""
    assert sent.status_code == 202, sent.text
    until = time.monotonic() + 60.0
    while time.monotonic() < until:
        said: dict[str, Any] = client.get(sent.headers["location"]).json()
        if said["state"] in ("done", "refused"):
            return said
        time.sleep(0.05)
    raise AssertionError("it was not read")


def files_in(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())
