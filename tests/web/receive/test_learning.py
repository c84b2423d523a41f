"""A machine learns from its page: how far it is, what was learnt, and what an end leaves."""

import os
import re
import signal
import sys
import time
from html import unescape
from pathlib import Path

import httpx2
import numpy as np
import pytest
from fastapi.testclient import TestClient
from sqlalchemy import func, select

from autodb.agent.operate.access import add_token, noted
from autodb.proofs.machines.lathe import fleets
from autodb.store import Store, create_store, models, open_store
from autodb.web.receive import children
from tests.helpers import shops
from tests.helpers.asked import client_of

MACHINE = "/machines/lathe-0"
LEARNING = f"{MACHINE}/learning"
SAYS_AND_WAITS = (
    "import sys, time; sys.stdin.readline();"
    'print(\'{"progress": "updating steel / P10: 3 of 7"}\', flush=True); time.sleep(60)'
)


@pytest.fixture(scope="module")
def unlearnt(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Return a database whose machine has cuts of two pairs that nobody has learnt from."""
    path = tmp_path_factory.mktemp("unlearnt") / "made.sqlite3"
    create_store(f"sqlite:///{path}")
    store = open_store(f"sqlite:///{path}")
    rng = np.random.default_rng(5)
    fleet = fleets.draw_fleet(rng, materials=2, tools=1)
    keys = [(material, fleet.tools[0]) for material in fleet.materials]
    shops.add(store, "lathe-0", fleets.on_machine(rng, fleet, keys), cuts=8, rng=rng)
    store.close()
    return path.read_bytes()


@pytest.fixture
def url(unlearnt: bytes, tmp_path: Path) -> str:
    """Return the URL of a copy of it."""
    path = tmp_path / "unlearnt.sqlite3"
    path.write_bytes(unlearnt)
    return f"sqlite:///{path}"


def _kept(store: Store) -> tuple[int, int, int]:
    """Return how many forces were sensed, versions made and passes kept."""
    with store.reading() as session:
        rows = models.SensedForce, models.CuttingParameters, models.RefreshPass
        one, two, three = (session.scalar(select(func.count()).select_from(row)) for row in rows)
    return one or 0, two or 0, three or 0


def _begin(client: TestClient, headers: dict[str, str]) -> httpx2.Response:
    return client.post(LEARNING, headers=headers, follow_redirects=False)


def _text(got: httpx2.Response) -> str:
    shown = re.sub(r"<(script|style|title).*?</\1>", " ", got.text, flags=re.DOTALL)
    return " ".join(unescape(re.sub(r"<[^>]+>", " ", shown)).split())


def _ended(client: TestClient) -> str:
    """Wait until the machine learns no more; return what its page says of it."""
    until = time.monotonic() + 60.0
    while "data-running" in (got := client.get(f"{LEARNING}/piece")).text:
        assert time.monotonic() < until, got.text
        time.sleep(0.05)
    return _text(got)


def test_a_machine_learns_and_its_page_says_what(
    url: str, store: Store, operates: dict[str, str]
) -> None:
    with client_of(url, writes=True) as client:
        assert "data-running" not in client.get(MACHINE, headers=operates).text
        began = _begin(client, operates)
        assert (began.status_code, began.headers["location"]) == (303, f"{MACHINE}#learn")
        said = _ended(client)
        assert re.search(r"Learnt in \d+ s: \d+ forces", said), said
        with store.reading() as session:
            pairs = session.scalars(select(models.CuttingParameters)).all()
            names = {f"{one.pair.material.name} / {one.pair.tool.name}" for one in pairs}
        assert len(names) == 2
        assert all(name in said for name in names)
        assert said in _text(client.get(MACHINE))  # a reload has it too
        _begin(client, operates)
        assert "Nothing is new" in _ended(client)
    with store.reading() as session:
        (first, second), *_ = [
            [one for _, one in noted(session, most=9) if one.action == "learning started"]
        ]
    assert first.who == second.who == "shop"


def test_while_one_runs_no_second_begins_and_pages_say_how_far_it_is(
    url: str, store: Store, operates: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(children, "COMMAND", (sys.executable, "-c", SAYS_AND_WAITS))
    before = _kept(store)
    with client_of(url, writes=True) as client:
        _begin(client, operates)
        while "3 of 7" not in _text(client.get(f"{LEARNING}/piece")):
            time.sleep(0.01)
        page = client.get(MACHINE)
        assert "lathe-0 is learning, pair 3 of 7: updating steel / P10: 3 of 7" in _text(page)
        assert '<progress aria-label="How far it is" max="7" value="2">' in page.text
        assert '<noscript><meta http-equiv="refresh"' in page.text
        assert (
            client.get(LEARNING, follow_redirects=False).headers["location"] == f"{MACHINE}#learn"
        )
        german = client.get(MACHINE, headers={"Accept-Language": "de"})
        assert "lathe-0 lernt, Paarung 3 von 7: steel / P10 wird gelernt: 3 von 7" in _text(german)
        again = _begin(client, operates)
        assert again.status_code == 409
        assert "lathe-0 is learning already; wait until it is done" in _text(again)
        learnings = client.app.state.service.learnings  # type: ignore[attr-defined]
        begun = time.monotonic()
    assert time.monotonic() - begun < 10.0  # Ctrl-C ends the process
    assert "the service ended meanwhile" in str(learnings.said("lathe-0").refused)
    assert _kept(store) == before


def test_killed_in_the_middle_nothing_half_is_there_and_it_learns_again(
    url: str, store: Store, operates: dict[str, str]
) -> None:
    before = _kept(store)
    with client_of(url, writes=True) as client:
        service = client.app.state.service  # type: ignore[attr-defined]
        _begin(client, operates)
        while not service.learnings.said("lathe-0").step:
            time.sleep(0.002)
        (pid,) = service.children._running
        assert os.getpriority(os.PRIO_PROCESS, pid) > os.getpriority(os.PRIO_PROCESS, 0)
        os.kill(pid, signal.SIGKILL)
        assert "lathe-0: learning broke off (SIGKILL)" in _ended(client)
        assert _kept(store) == before
        _begin(client, operates)
        assert "Learnt in" in _ended(client)
    assert all(now > was for now, was in zip(_kept(store), before, strict=True))


def test_who_may_only_read_learns_nothing(url: str, store: Store) -> None:
    reads = {"Authorization": f"Bearer {add_token(store, 'guest', 'read', days=1)}"}
    with client_of(url, writes=True) as client:
        assert _begin(client, reads).status_code == 403
        assert _begin(client, {}).status_code == 401
        assert "Learn now" in _text(client.get(MACHINE))
    with client_of(url) as client:
        assert _begin(client, {}).status_code == 403
        assert "autodb refresh --machine lathe-0" in _text(client.get(MACHINE))
