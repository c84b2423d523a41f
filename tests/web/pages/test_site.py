"""The pages without a browser: who may, what is escaped, what is refused, and what they say."""

import re
from html import unescape
from pathlib import Path
from urllib.parse import quote, urlencode

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import select

from autodb.agent.answer.looking_up import PairReader
from autodb.agent.operate.access import add_token
from autodb.agent.operate.deciding import mismatches
from autodb.store import Store, models
from autodb.web.http.static import FILES, at
from autodb.web.routes.asked import as_cut
from tests.helpers.asked import client_of
from tests.helpers.site import STRANGE

MACHINE = "/machines/lathe-1"
CUT = {"operation": "turn", "diameter_mm": "56", "depth_mm": "2.5", "feed_mm_rev": "0.3",
       "speed_m_min": "220"}  # fmt: skip


def _said(html: str) -> list[str]:
    """Return what a page says aloud."""
    found = re.findall(r'class="said[^"]*"[^>]*>(.*?)</p>', html, re.DOTALL)
    return [unescape(re.sub(r"<[^>]+>", "", one)) for one in found]


def _text(html: str) -> str:
    """Return what is read of a page, in one line."""
    shown = re.sub(r"<(script|style|title).*?</\1>", " ", html, flags=re.DOTALL)
    return " ".join(unescape(re.sub(r"<[^>]+>", " ", shown)).replace("\u00a0", " ").split())


def _sign_in(client: TestClient, token: str, then: str = "/") -> str:
    """Sign in; return the number that the session's forms bring."""
    got = client.post("/sign-in", data={"token": token, "then": then}, follow_redirects=False)
    assert (got.status_code, got.headers["location"]) == (303, then)
    found = re.search(r'data-csrf="([^"]+)"', client.get("/").text)
    assert found is not None
    return found[1]


def _open_mismatch(store: Store) -> int:
    with store.reading() as session:
        return mismatches(session, "lathe-1", decided=False)[0].id


# What pages say


def test_every_page_answers_and_loads_scripts_of_its_own_alone(
    client: TestClient, store: Store, pair: dict[str, str]
) -> None:
    pages = [
        "/", "/sign-in", MACHINE, f"{MACHINE}/moved", f"{MACHINE}/pairs", f"{MACHINE}/plan",
        f"{MACHINE}/pair?{urlencode(pair)}", f"{MACHINE}/plan?{urlencode(pair | CUT)}",
        f"{MACHINE}/mismatches", f"{MACHINE}/mismatches?decided=true", f"{MACHINE}/import",
        f"{MACHINE}/scores", f"{MACHINE}/recordings", f"{MACHINE}/recordings/2",
        f"{MACHINE}/recordings/4", f"{MACHINE}/health",
        f"{MACHINE}/drives/z.current", f"/mismatches/{_open_mismatch(store)}",
        f"{MACHINE}/stability",
    ]  # fmt: skip
    for path in pages:
        got = client.get(path)
        assert got.status_code == 200, path
        policy = got.headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "script-src 'self';" in policy
        assert "unsafe-eval" not in policy
        scripts = re.findall(r"<script([^>]*)>", got.text)
        assert all('src="/static/' in one or 'type="application/json"' in one for one in scripts)
        assert not re.findall(r"https?://(?!www\.w3\.org)", got.text), path
        assert len(re.findall("<h1[ >]", got.text)) == 1


def test_the_planner_says_what_the_library_says(
    client: TestClient, store: Store, pair: dict[str, str]
) -> None:
    with store.reading() as session:
        alone = PairReader(session, "lathe-1").look_up(**pair, cut=as_cut(CUT))
    text = _text(client.get(f"{MACHINE}/plan?{urlencode(pair | CUT)}").text)
    rounded = float(f"{alone.cut.force_y_N.value:.3g}")
    assert f"{rounded:.0f} N" in text
    for one in alone.exceeds:
        assert one.statement in text
    assert alone.exceeds
    assert "What to cut next" not in text
    text = _text(client.get(f"{MACHINE}/plan?{urlencode(pair | CUT | {'next': 'true'})}").text)
    assert "What to cut next" in text
    assert "Then, on average" in text


def test_several_cuts_keep_what_each_states(client: TestClient, pair: dict[str, str]) -> None:
    every = [*(CUT | {"name": "rough"}).items(), *(CUT | {"name": "", "depth_mm": "1"}).items()]
    html = client.get(f"{MACHINE}/plan?{urlencode([*pair.items(), *every])}").text
    assert html.split("data-program")[0].count("<fieldset>") == 3
    assert "rough" in html
    assert "cut 2" in _text(html)


def test_a_cut_that_cannot_be_is_said_and_what_was_typed_stays(
    client: TestClient, pair: dict[str, str]
) -> None:
    html = client.get(f"{MACHINE}/plan?{urlencode(pair | CUT | {'depth_mm': 'deep'})}").text
    assert _said(html) == ["cut 1: depth_mm: 'deep' is not a number; send a number such as 2.5"]
    assert 'value="deep"' in html
    lacking = {key: value for key, value in CUT.items() if key != "diameter_mm"}
    html = client.get(f"{MACHINE}/plan?{urlencode(pair | lacking)}").text
    assert "needs diameter_mm" in _said(html)[0]


def test_numbers_are_typed_with_a_comma_in_every_field(
    client: TestClient, pair: dict[str, str]
) -> None:
    typed = CUT | {"depth_mm": "2,5", "feed_mm_rev": "0,3"}
    for path in ("plan", "pair"):
        points, commas = (
            _text(client.get(f"{MACHINE}/{path}?{urlencode(pair | one)}").text)
            for one in (CUT, typed)
        )
        assert points == commas
    for text in ("1,234", "1.234,5"):
        asked = urlencode(pair | CUT | {"depth_mm": text})
        assert f"depth_mm: '{text}'" in _said(client.get(f"{MACHINE}/plan?{asked}").text)[0]
    largest = CUT | {"largest": "feed", "share": "80,0", "sure": "95,5"}
    page = client.get(f"{MACHINE}/pair?{urlencode(pair | largest)}").text
    assert "with 95.5 % probability" in _text(page)
    assert 'type="number"' not in page
    far = client.get(f"{MACHINE}/pair?{urlencode(pair | largest | {'share': '120'})}").text
    assert "Share: 120 % is not from 1 to 100" in _said(far)[0]


def test_limits_are_drawn_into_the_maps(client: TestClient, pair: dict[str, str]) -> None:
    html = client.get(f"{MACHINE}/pair?{urlencode(pair | CUT)}").text
    assert "50 % chance to exceed the limit" in html
    assert "limit 900 N" in html


def test_the_planner_says_how_every_limit_stands(client: TestClient, pair: dict[str, str]) -> None:
    """A limit that nobody entered is said, and none is green by silence; figures beside them."""
    light = CUT | {"depth_mm": "0.2", "feed_mm_rev": "0.1", "length_mm": "100"}
    text = _text(client.get(f"{MACHINE}/plan?{urlencode(pair | light)}").text)
    assert "Limits within: x force 600 N, z force 900 N, spindle torque 30 N·m" in text
    assert "Limits not entered: z feed, spindle power, spindle speed" in text
    assert re.search(r"Energy of all cuts: [\d.]+ \(", text)
    heavy = _text(client.get(f"{MACHINE}/plan?{urlencode(pair | CUT)}").text)
    assert re.search(r"Limits exceeded: .*spindle torque 30 N·m \(", heavy)


def test_a_pair_s_page_answers_with_the_largest_feed(
    client: TestClient, pair: dict[str, str]
) -> None:
    asked = pair | CUT | {"largest": "feed", "share": "80", "sure": "95"}
    html = client.get(f"{MACHINE}/pair?{urlencode(asked)}").text
    (said,) = [one for one in _said(html) if "Largest feed" in one]
    found = re.search(r"with 95 % probability: (0\.\d+) mm/rev; what ends it is", said)
    assert found is not None
    got = client.get(
        f"/api/v1{MACHINE}/largest", params=pair | CUT | {"what": "feed", "share": 80}
    ).json()
    assert got["value"] == float(found[1])
    assert f'value="{float(found[1]):g}"' in html
    refused = client.get(f"{MACHINE}/pair?{urlencode(pair | CUT | {'largest': 'feet'})}").text
    assert "nothing to look for" in _said(refused)[0]


def test_machines_are_found_by_a_part_of_their_name(client: TestClient) -> None:
    assert "lathe-1" in _text(client.get("/?like=LATHE").text)
    assert STRANGE not in _text(client.get("/?like=LATHE").text)
    assert "No machine" in _said(client.get("/?like=none%25").text)[0]


# What could break a page


def test_a_mismatch_of_several_recordings_names_all_of_them(
    client: TestClient, store: Store
) -> None:
    number = _open_mismatch(store)
    with store.writing() as session:
        row = session.get_one(models.Mismatch, number)
        other = session.scalars(
            select(models.StoredRecording).where(models.StoredRecording.id != row.recording_id)
        ).first()
        assert other is not None
        row.further = [other]
        row.found_in = {"cuts": 24, "excluded": 7, "edges": ["B1", "B2"]}
        names = [f"{Path(one.path).name} (number {one.id})" for one in row.recordings]
        ids = [one.id for one in row.recordings]
    words = "24 cuts of 2 recordings, 7 excluded, edges B1, B2"
    page = _text(client.get(f"/mismatches/{number}").text)
    assert f"Found in {words} Recordings {', '.join(names)}" in page
    assert f"In {words}." in _text(client.get(f"{MACHINE}/mismatches").text)
    said = client.get(f"/api/v1/mismatches/{number}").json()
    assert (said["recordings"], said["found_in"]) == (ids, words)


def test_names_are_escaped_everywhere(client: TestClient) -> None:
    path = f"/machines/{quote(STRANGE, safe='')}"
    for page in ("/", path, f"{path}/plan", f"{path}/pairs", f"{path}/moved", f"{path}/mismatches",
                 f"{path}/pair?{urlencode({'material': STRANGE, 'tool': STRANGE})}"):  # fmt: skip
        html = client.get(page).text
        assert "<script>alert" not in html, page
        assert "&lt;script&gt;" in html, page
    assert client.get(path).status_code == 200


def test_what_is_not_there_is_a_page_that_says_so(client: TestClient) -> None:
    for path, words in (
        ("/machines/lath-1", "lathe-1"),
        ("/mismatches/999", "there is no mismatch 999"),
        (f"{MACHINE}/drives/x.current", "no model of 'x.current'"),
        ("/none", "Not Found"),
    ):
        got = client.get(path)
        assert (got.status_code, got.headers["content-type"][:9]) == (404, "text/html")
        assert words in _said(got.text)[0]
    assert client.get("/mismatches/nothing").status_code == 422
    many = urlencode([("operation", "turn")] * 51)
    assert "51 cuts" in _said(client.get(f"{MACHINE}/plan?{many}").text)[0]


# Files


def test_files_are_kept_for_ever_by_their_digest_and_packed(client: TestClient) -> None:
    for name in FILES:
        got = client.get(at(name))
        assert got.status_code == 200
        assert "immutable" in got.headers["cache-control"]
        assert got.headers["content-encoding"] == "gzip"
        plain = client.get(at(name), headers={"Accept-Encoding": "identity"})
        assert plain.content == got.content
        assert "immutable" not in client.get(f"/static/{name}?v=other").headers["cache-control"]
    assert client.get("/static/..%2Fapp.py").status_code == 404


# Who may


def test_elsewhere_every_page_asks_for_a_token(url: str, store: Store) -> None:
    secret = add_token(store, "planner", "read", days=1)
    with client_of(url, host="192.0.2.1") as client:
        got = client.get(f"{MACHINE}/plan")
        assert (got.status_code, "Token" in got.text) == (401, True)
        assert f'value="{MACHINE}/plan"' in got.text
        assert client.post("/sign-in", data={"token": secret + "x"}).status_code == 401
        _sign_in(client, secret, f"{MACHINE}/plan")
        assert client.get(f"{MACHINE}/plan").status_code == 200
        assert client.get("/api/v1/machines").status_code == 200
        assert "planner (read)" in _text(client.get("/").text)


def test_a_session_is_a_cookie_that_scripts_and_other_sites_do_not_get(
    url: str, store: Store
) -> None:
    secret = add_token(store, "planner", "read", days=1)
    for tls in (False, True):
        with client_of(url, tls=tls) as client:
            got = client.post("/sign-in", data={"token": secret}, follow_redirects=False)
            cookie = got.headers["set-cookie"]
            assert "HttpOnly" in cookie
            assert "SameSite=strict" in cookie
            assert ("Secure" in cookie) == tls
            assert secret not in cookie


def test_signing_in_goes_on_nowhere_else(url: str, store: Store) -> None:
    secret = add_token(store, "planner", "read", days=1)
    with client_of(url) as client:
        for then in ("https://evil.example", "//evil.example", "/\\evil.example", ""):
            got = client.post(
                "/sign-in", data={"token": secret, "then": then}, follow_redirects=False
            )
            assert got.headers["location"] == "/"


def test_a_decision_needs_the_role_and_the_sessions_number(url: str, store: Store) -> None:
    reads, operates = (add_token(store, role, role, days=1) for role in ("read", "operate"))
    path = f"/mismatches/{_open_mismatch(store)}"
    word = {"word": "reject"}
    with client_of(url, writes=True) as client:
        assert "could decide" in _text(client.get(path).text)
        assert client.post(path, data=word).status_code == 401
        csrf = _sign_in(client, reads)
        assert client.post(path, data=word | {"csrf": csrf}).status_code == 403
        csrf = _sign_in(client, operates)
        assert client.post(path, data=word).status_code == 403
        assert client.post(path, data=word | {"csrf": csrf + "x"}).status_code == 403
        assert client.post(path, data={"word": "perhaps", "csrf": csrf}).status_code == 422
        other = {"Sec-Fetch-Site": "cross-site"}
        assert client.post(path, data=word | {"csrf": csrf}, headers=other).status_code == 403
        got = client.post(path, data=word | {"csrf": csrf})
        assert "Rejected by operate" in _text(got.text)
        again = client.post(path, data={"word": "confirm", "csrf": csrf})
        assert (again.status_code, "take that back first" in _said(again.text)[0]) == (422, True)
        shown = client.get(path).text
        assert "Once confirmed it is kept in" in _text(shown)
        assert "Take the decision back" in shown
        back = {"word": "reopen", "csrf": csrf, "why": "it was another machine"}
        assert "Confirm" in client.post(path, data=back).text
        assert ": it was another machine" in _text(client.get(path).text)
        assert client.post(path, data=word | {"csrf": csrf}).status_code == 200
    with client_of(url) as client:
        csrf = _sign_in(client, operates)
        assert client.post(path, data=word | {"csrf": csrf}).status_code == 403


def test_the_api_takes_a_session_with_its_number_alone(url: str, store: Store) -> None:
    operates = add_token(store, "operate", "operate", days=1)
    path = f"/api/v1/mismatches/{_open_mismatch(store)}/reject"
    with client_of(url, writes=True) as client:
        csrf = _sign_in(client, operates)
        assert client.post(path).status_code == 403
        assert client.post(path, headers={"X-CSRF-Token": csrf}).status_code == 200


def test_signing_out_and_revoking_end_a_session(
    url: str, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("autodb.web.service.HELD_S", 0.0)
    secret = add_token(store, "planner", "read", days=1)
    with client_of(url, host="192.0.2.1") as client:
        csrf = _sign_in(client, secret)
        client.post("/sign-out", data={"csrf": "other"})
        assert client.get("/").status_code == 200
        client.post("/sign-out", data={"csrf": csrf})
        assert client.get("/").status_code == 401
        _sign_in(client, secret)
        monkeypatch.setattr("autodb.web.http.sessions.time.monotonic", lambda: 1e12)
        assert client.get("/").status_code == 401
