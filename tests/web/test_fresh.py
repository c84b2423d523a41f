"""An answer is of the database as it is now, whatever is kept of it meanwhile."""

from collections.abc import Callable
from pathlib import Path
from urllib.parse import urlencode

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import inspect, select

from autodb.agent.rows.machines import add_machine
from autodb.files.machine import LATHE
from autodb.store import Store, create_store, models, open_store
from autodb.store.watched import Watched
from autodb.web.lookup_cache import LookupCache
from tests.helpers.asked import API, CUT
from tests.helpers.servers import Server


def test_an_answer_is_fresh_as_soon_as_something_is_written(
    client: TestClient, store: Store
) -> None:
    path = f"{API}/machines"
    first = client.get(path)
    again = client.get(path, headers={"If-None-Match": first.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    add_machine(store, "new", LATHE)
    fresh = client.get(path, headers={"If-None-Match": first.headers["etag"]})
    assert fresh.status_code == 200
    assert "new" in [one["name"] for one in fresh.json()["machines"]]


@pytest.mark.parametrize(
    ("made", "status"),
    [
        (lambda tag: [tag], 304),
        (lambda tag: [f"W/{tag}"], 304),
        (lambda tag: [f'"a,b", W/"c" ,W/{tag}'], 304),
        (lambda tag: ['"other"', tag], 304),
        (lambda _: ["*"], 304),
        (lambda _: [" * "], 304),
        (lambda tag: [tag.strip('"')], 200),
        (lambda tag: [f'"{tag[1:-1]}-more"'], 200),
        (lambda _: ['"other", W/"another"'], 200),
        (lambda _: [""], 200),
    ],
)
def test_tags_are_compared_as_http_says(
    client: TestClient, pair: dict[str, str], made: Callable[[str], list[str]], status: int
) -> None:
    for path in (f"{API}/machines", f"{API}/machines/lathe-0/lookup?{urlencode(pair | CUT)}"):
        tag = client.get(path).headers["etag"]
        got = client.get(path, headers=[("If-None-Match", one) for one in made(tag)])
        assert (got.status_code, got.headers["etag"]) == (status, tag)
        assert (got.content == b"") == (status == 304)


def test_a_look_up_follows_what_is_learnt(
    client: TestClient, store: Store, pair: dict[str, str]
) -> None:
    asked = pair | CUT
    path = f"{API}/machines/lathe-0/lookup"

    def force_N() -> float:
        value = client.get(path, params=asked).json()["cut"]["force_y_N"]["value"]
        assert isinstance(value, float)
        return value

    before = force_N()
    assert force_N() == before
    number = _newer_version(store, client.get(path, params=asked).json()["behind"]["parameters"])
    assert force_N() > before
    with store.writing("lathe-0") as session:
        session.get_one(models.CuttingParameters, number).undone_at = "2026-01-01T00:00:00+00:00"
    assert force_N() == before
    with store.writing() as session:
        for tool in session.scalars(select(models.Tool)):
            tool.rake_deg = 20.0
    assert force_N() != before


def _newer_version(store: Store, number: int) -> int:
    """Add a version after one of a pair that is of another mean; return its number."""
    with store.writing("lathe-0") as session:
        row = session.get_one(models.CuttingParameters, number)
        columns = {c.key: getattr(row, c.key) for c in inspect(models.CuttingParameters).columns}
        columns |= {"mean": [row.mean[0] + 0.1, *row.mean[1:]], "version": row.version + 1}
        newer = models.CuttingParameters(**{k: v for k, v in columns.items() if k != "id"})
        session.add(newer)
        session.flush()
        return newer.id


def test_a_limit_that_changes_counts_at_once(
    client: TestClient, store: Store, pair: dict[str, str]
) -> None:
    path = f"{API}/machines/lathe-0/lookup"
    assert client.get(path, params=pair | CUT).json()["exceeds"] == []
    with store.writing("lathe-0") as session:
        for axis in session.scalars(select(models.Axis)):
            axis.limit_force_N = 1.0
    assert client.get(path, params=pair | CUT).json()["exceeds"] != []


def test_what_is_kept_of_a_pair_outlives_other_changes(
    url: str, store: Store, pair: dict[str, str]
) -> None:
    watched = Watched(store)
    lookup_cache = LookupCache(store, watched)
    first = lookup_cache.basis("lathe-0", **pair)
    writer = open_store(url)
    add_machine(writer, "another", LATHE)
    again = lookup_cache.basis("lathe-0", **pair)
    assert again.mark != first.mark
    assert again.basis is first.basis
    _newer_version(writer, first.basis.known.behind.parameters or 0)
    assert lookup_cache.basis("lathe-0", **pair).basis is not first.basis
    writer.close()
    watched.close()


def test_a_restored_backup_is_read(client: TestClient, url: str, tmp_path: Path) -> None:
    other = tmp_path / "other.sqlite3"
    create_store(f"sqlite:///{other}")
    store = open_store(f"sqlite:///{other}")
    add_machine(store, "restored", LATHE)
    store.close()
    assert client.get(f"{API}/machines").json()["machines"][0]["name"] == "a/b c"
    other.replace(url.removeprefix("sqlite:///"))
    assert client.get(f"{API}/machines").json()["machines"][0]["name"] == "restored"


def test_marks_differ_once_something_is_committed(url: str, store: Store) -> None:
    watched = Watched(open_store(url))
    first = watched.mark()
    assert watched.mark() == first
    with store.writing() as session:
        session.add(models.Material(name="new"))
        session.flush()
        assert watched.mark() == first
    assert watched.mark() != first
    watched.close()


def test_marks_of_a_server(server: Server) -> None:
    url = server.database()
    create_store(url)
    store = open_store(url)
    watched = Watched(store)
    first = watched.mark()
    assert watched.mark() == first
    with store.writing() as session:
        session.add(models.Material(name="new"))
    second = watched.mark()
    assert second != first
    server.stop()
    server.start()
    assert watched.mark()
    watched.close()
    store.close()
