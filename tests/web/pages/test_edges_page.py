"""The edges of a machine's tools on its page: a button, and another that takes it back."""

import re

from autodb.agent.operate.access import add_token
from autodb.agent.operate.changed_edges import edges_of_machine
from autodb.store import Store
from tests.helpers.asked import client_of
from tests.web.pages.test_site import MACHINE, _sign_in, _text

EDGES = f"{MACHINE}/edges"


def test_an_operator_says_that_an_edge_was_changed_and_takes_it_back(
    url: str, store: Store, pair: dict[str, str]
) -> None:
    token = add_token(store, "operator", "operate", days=1)
    with client_of(url, writes=True) as client:
        csrf = _sign_in(client, token)
        assert "not recorded" in _text(client.get(MACHINE).text)
        form = {"tool": pair["tool"], "by": "Maria <b>", "why": "chipped", "csrf": csrf}
        given = form | {"at": "2026-01-01T07:30"}
        got = client.post(EDGES, data=given, follow_redirects=False)
        assert (got.status_code, got.headers["location"]) == (303, f"{MACHINE}#edges")
        page = client.get(MACHINE).text
        assert "Maria &lt;b&gt; (chipped)" in page
        assert re.search(r"2026-01-01 \d\d:30", _text(page))
        assert client.get(EDGES, follow_redirects=False).headers["location"] == f"{MACHINE}#edges"

        for wrong in ({"tool": "none"}, {"at": "2999-01-01T00:00"}):
            got = client.post(EDGES, data=form | wrong)
            assert got.status_code == 422
            assert 'role="alert"' in got.text
        assert client.post(EDGES, data=form | {"csrf": "guessed"}).status_code == 403

        got = client.post(f"{EDGES}/1/undo", data={"csrf": csrf}, follow_redirects=False)
        assert got.status_code == 303
        assert client.post(f"{EDGES}/9/undo", data={"csrf": csrf}).status_code == 404
        assert "not recorded" in _text(client.get(MACHINE).text)
    with store.reading() as session:
        assert edges_of_machine(session, "lathe-1").edges == []


def test_who_reads_sees_no_button(url: str, store: Store) -> None:
    token = add_token(store, "reader", "read", days=1)
    with client_of(url, writes=True) as client:
        csrf = _sign_in(client, token)
        assert "<button>Edge changed" not in client.get(MACHINE).text
        assert client.post(EDGES, data={"tool": "x", "csrf": csrf}).status_code == 403
    with client_of(url) as client:
        assert "Edges" in _text(client.get(MACHINE).text)
        assert "<button>Edge changed" not in client.get(MACHINE).text
