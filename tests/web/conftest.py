"""A database that has learnt, and clients of the service on it."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from fastapi.testclient import TestClient
from playwright.sync_api import Browser, Page, sync_playwright

from autodb.agent.answer.looking_up import PairReader
from autodb.agent.operate.access import add_token
from autodb.agent.operate.refreshing import refresh
from autodb.agent.rows.machines import add_machine
from autodb.files.machine import LATHE
from autodb.proofs.machines.lathe import fleets
from autodb.store import Store, create_store, open_store
from autodb.web.http.settings import Settings
from autodb.web.receive import children
from tests.helpers import shops
from tests.helpers.asked import client_of
from tests.helpers.browsing import CHROMIUM, Site, Watched
from tests.helpers.forked_readers import ForkedReaders
from tests.helpers.serving import served
from tests.helpers.site import filled


@pytest.fixture(scope="session")
def readers() -> Iterator[ForkedReaders]:
    """Return what forks processes that read what was sent."""
    made = ForkedReaders()
    yield made
    made.end()


@pytest.fixture(autouse=True)
def _forked(
    request: pytest.FixtureRequest, readers: ForkedReaders, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Have services fork them, but where a test asks how they are started (``started``)."""
    if "started" not in request.fixturenames:
        monkeypatch.setattr(children, "subprocess", readers)


@pytest.fixture
def started() -> None:
    """Have each process that reads started anew, as a service does."""


@pytest.fixture(scope="session")
def learnt(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a database whose machine 'lathe-0' has learnt two pairs, and one more has nothing."""
    path = tmp_path_factory.mktemp("served") / "made.sqlite3"
    url = f"sqlite:///{path}"
    create_store(url)
    store = open_store(url)
    rng = np.random.default_rng(3)
    fleet = fleets.draw_fleet(rng, materials=2, tools=1)
    keys = [(material, fleet.tools[0]) for material in fleet.materials]
    shops.add(store, "lathe-0", fleets.on_machine(rng, fleet, keys), cuts=8, rng=rng)
    add_machine(store, "a/b c", LATHE)
    refresh(store, "lathe-0")
    store.close()
    return path


@pytest.fixture(scope="session")
def sampled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a database whose machine learnt from the sample's cuts, with mismatches that wait."""
    path = tmp_path_factory.mktemp("site") / "made.sqlite3"
    filled(path)
    return path


@pytest.fixture
def url(learnt: Path, tmp_path: Path) -> str:
    """Return the URL of a copy of it."""
    path = tmp_path / "served.sqlite3"
    path.write_bytes(learnt.read_bytes())
    return f"sqlite:///{path}"


@pytest.fixture
def store(url: str) -> Iterator[Store]:
    """Return the copy, opened."""
    opened = open_store(url)
    yield opened
    opened.close()


@pytest.fixture
def client(url: str) -> Iterator[TestClient]:
    """Return a client of the service on loopback, read-only."""
    with client_of(url) as made:
        yield made


@pytest.fixture
def pair(store: Store) -> dict[str, str]:
    """Return a pair that was learnt, as a query names it."""
    with store.reading() as session:
        one = PairReader(session, "lathe-0").pairs()[0]
    return {"material": one.material, "tool": one.tool}


@pytest.fixture(scope="module")
def site(sampled: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    """Return a service of a machine that has learnt a pair."""
    path = tmp_path_factory.mktemp("browsed") / "made.sqlite3"
    path.write_bytes(sampled.read_bytes())
    url = f"sqlite:///{path}"
    store = open_store(url)
    token = add_token(store, "operator", "operate", days=1)
    with store.reading() as session:
        one = PairReader(session, "lathe-1").pairs()[0]
    with served(Settings(url, writes=True)) as at:
        yield Site(at, store, token, {"material": one.material, "tool": one.tool})
    store.close()


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """Return a browser without a screen."""
    with sync_playwright() as playwright:
        made = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield made
        made.close()


@pytest.fixture
def watched(site: Site) -> Watched:
    """Return what watches the pages."""
    return Watched(site.at)


@pytest.fixture
def page(browser: Browser, site: Site, watched: Watched) -> Iterator[Page]:
    """Return a page of a browser that nobody has used; it must have done nothing wrong."""
    context = browser.new_context(base_url=site.at, reduced_motion="reduce")
    context.set_default_timeout(15_000)
    watched.watch(context)
    made = context.new_page()
    yield made
    context.close()
    assert watched.wrong == []
