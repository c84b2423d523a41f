"""Changes of tools' edges through the service: who may record them, and what is answered."""

import pytest
from fastapi.testclient import TestClient

from autodb.agent.operate.access import add_token, noted
from autodb.errors import NotThere, UnusableInput
from autodb.store import Store
from autodb.web.client import Client
from autodb.web.http.settings import Settings
from tests.helpers.asked import API, bearer, client_of, detail
from tests.helpers.serving import served

EDGES = f"{API}/machines/lathe-0/edges"
EARLY = "2026-01-01T07:30:00+00:00"


def test_a_change_is_kept_with_who_recorded_it(
    url: str, store: Store, pair: dict[str, str]
) -> None:
    reads, operates = (bearer(add_token(store, r, r, days=1)) for r in ("read", "operate"))
    with client_of(url, writes=True) as client:
        there = client.get(EDGES, headers=reads).json()
        assert (there["edges"], pair["tool"] in there["tools"]) == ([], True)
        given = {"tool": pair["tool"], "at": EARLY, "why": "chipped"}
        assert client.post(EDGES, json=given).status_code == 401
        assert client.post(EDGES, json=given, headers=reads).status_code == 403
        done = client.post(EDGES, json=given, headers=operates).json()
        assert (done["number"], done["at"], done["already"]) == (1, EARLY, False)
        assert done["cuts"] > 0
        assert client.post(EDGES, json=given, headers=operates).json()["already"]
        (one,) = client.get(EDGES, headers=reads).json()["edges"]
        assert (one["by"], one["why"], one["cuts"]) == ("operate", "chipped", done["cuts"])
        of_maria = {"tool": pair["tool"], "by": "Maria"}
        assert client.post(EDGES, json=of_maria, headers=operates).json()["cuts"] == 0
        (one,) = client.get(EDGES, headers=reads).json()["edges"]
        assert (one["number"], one["by"]) == (2, "Maria")
        undo = f"{API}/edges/2/undo"
        assert client.post(undo, headers=reads).status_code == 403
        assert not client.post(undo, headers=operates).json()["already"]
        assert client.post(undo, headers=operates).json()["already"]
        every = client.get(EDGES, params={"every": "true"}, headers=reads).json()["edges"]
        assert [(one["number"], one["undone_at"] is None) for one in every] == [
            (1, True), (2, False)
        ]  # fmt: skip
    with store.reading() as session:
        said = [(one.who, one.action, one.row_id) for _, one in noted(session, most=3)]
    assert said == [
        ("operate", "edge change undone", 2), ("operate", "edge changed", 2),
        ("operate", "edge changed", 1),
    ]  # fmt: skip


def test_what_is_wrong_is_refused(url: str, store: Store, pair: dict[str, str]) -> None:
    operates = bearer(add_token(store, "o", "operate", days=1))
    with client_of(url, writes=True) as client:

        def refused(path: str, **given: object) -> tuple[int, str]:
            got = client.post(path, json=given, headers=operates)
            return got.status_code, detail(got)

        code, said = refused(EDGES, tool="nothing like it")
        assert (code, pair["tool"] in said) == (422, True)
        assert refused(EDGES, tool=pair["tool"], at="soon")[0] == 422
        assert "still to come" in refused(EDGES, tool=pair["tool"], at="2999-01-01")[1]
        assert refused(f"{API}/machines/none/edges", tool=pair["tool"])[0] == 404
        assert refused(f"{API}/edges/9/undo")[0] == 404
        assert client.get(EDGES, headers=operates).json()["edges"] == []
    with client_of(url) as read_only:
        got = read_only.post(EDGES, json={"tool": pair["tool"]}, headers=operates)
        assert got.status_code == 403


def test_the_client_records_lists_and_undoes(url: str, store: Store, pair: dict[str, str]) -> None:
    token = add_token(store, "operator", "operate", days=1)
    with served(Settings(url, writes=True)) as at, Client(at, token=token) as asked:
        done = asked.change_edge("lathe-0", pair["tool"], at=EARLY, by="Maria", why="worn")
        found = asked.edges("lathe-0").edges
        assert [(one.number, one.by, one.cuts) for one in found] == [
            (done.number, "Maria", done.cuts)
        ]
        assert asked.undo_edge_change(done.number).cuts == done.cuts
        assert asked.edges("lathe-0").edges == []
        assert len(asked.edges("lathe-0", every=True).edges) == 1
        with pytest.raises(NotThere):
            asked.undo_edge_change(9)
        with pytest.raises(UnusableInput):
            asked.change_edge("lathe-0", "none")


def test_without_writes_edges_are_read(client: TestClient) -> None:
    assert client.get(EDGES).json()["machine"] == "lathe-0"
    assert client.get(f"{API}/machines/a%2Fb%20c/edges").json()["tools"] == []
