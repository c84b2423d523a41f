"""The pages in German: every sentence is looked up, what is not says so, and what is stored is not.

Sentences are put between marks where they are looked up. What then stands outside of marks is data:
names of machines, files and channels, numbers and units.
"""

import re
import sqlite3
from contextlib import closing
from urllib.parse import quote, urlencode

import pytest
from fastapi.testclient import TestClient

from autodb.agent.operate.access import add_token
from autodb.agent.operate.deciding import mismatches
from autodb.store import Store
from autodb.wording import catalogues
from tests.conftest import Cli
from tests.helpers.asked import client_of
from tests.helpers.marked_words import CLOSE, OPEN, Marked, left, left_of_page
from tests.helpers.site import STRANGE

MACHINE = "/machines/lathe-1"
CUT = {"operation": "turn", "diameter_mm": "56", "depth_mm": "2.5", "feed_mm_rev": "0.3",
       "speed_m_min": "220", "name": "Schruppen", "length_mm": "100"}  # fmt: skip
GERMAN = {"Accept-Language": "de-DE,de;q=0.9"}


@pytest.fixture
def marked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have every sentence marked that is looked up for who reads German."""
    monkeypatch.setattr(catalogues, "catalogue", lambda _language: Marked())


MODE = "axis=x&frequency_Hz=603&damping_ratio=0.039&stiffness_N_m=5590"


def _mismatch(store: Store) -> int:
    with store.reading() as session:
        return mismatches(session, "lathe-1", decided=False)[0].id


def _pages(store: Store, pair: dict[str, str]) -> list[str]:
    """Return every page, with those of refusals."""
    cut = urlencode(pair | CUT)
    number = _mismatch(store)
    return [
        "/", "/?like=lath-1", "/?after=z", "/?like=a&after=z", "/sign-in", "/none", MACHINE,
        "/machines/lath-1", f"{MACHINE}/moved", f"{MACHINE}/pairs", f"{MACHINE}/plan",
        f"{MACHINE}/pair?{cut}&largest=feed",
        f"{MACHINE}/pair?{cut}&largest=feed&share=120",
        f"{MACHINE}/plan?{cut}&next=true", f"{MACHINE}/plan?{cut}&depth_mm=3&operation=turn",
        f"{MACHINE}/plan?{urlencode(pair | CUT | {'depth_mm': 'deep'})}",
        f"{MACHINE}/plan?{urlencode(pair | CUT | {'depth_mm': '1,234'})}",
        f"{MACHINE}/plan?{urlencode(pair | CUT | {'diameter_mm': ''})}",
        f"{MACHINE}/plan?{urlencode(pair | CUT | {'speed_rpm': '900'})}",
        f"{MACHINE}/plan?{urlencode([('operation', 'turn')] * 51)}",
        f"{MACHINE}/plan?{urlencode({'material': 'brass', 'tool': 'HSS'} | CUT)}",
        f"{MACHINE}/stability", f"{MACHINE}/stability?{cut}&{MODE}",
        f"{MACHINE}/stability?{cut}&{MODE}&axis=y&damping_ratio=9", f"{MACHINE}/stability?{MODE}",
        f"{MACHINE}/mismatches", f"{MACHINE}/mismatches?decided=true", f"{MACHINE}/import",
        f"{MACHINE}/scores", f"{MACHINE}/recordings", f"{MACHINE}/recordings/2",
        f"{MACHINE}/recordings/4", f"{MACHINE}/recordings/99", f"{MACHINE}/health",
        f"{MACHINE}/health/axes", f"{MACHINE}/drives/z.current", f"{MACHINE}/drives/x.current",
        f"/mismatches/{number}", "/mismatches/999",
        f"/machines/{quote(STRANGE, safe='')}", f"/machines/{quote(STRANGE, safe='')}/pairs",
        f"/machines/{quote(STRANGE, safe='')}/recordings",
        f"/machines/{quote(STRANGE, safe='')}/moved",
    ]  # fmt: skip


@pytest.mark.usefixtures("marked")
def test_every_sentence_of_every_page_is_looked_up(
    url: str, store: Store, pair: dict[str, str]
) -> None:
    with client_of(url, headers=GERMAN) as client:
        pages = {page: client.get(page) for page in _pages(store, pair)}
    assert all(got.status_code < 500 for got in pages.values())
    left = {page: found for page, got in pages.items() if (found := left_of_page(got.text))}
    assert left == {}
    for page, got in pages.items():
        if got.text.startswith("<!doctype"):
            assert 'name="language" value="en" lang="en"' in got.text, page
            assert 'name="units" value="inch"' in got.text, page


@pytest.mark.usefixtures("marked")
def test_decisions_are_said_in_german_and_stored_in_english(url: str, store: Store) -> None:
    secret = add_token(store, "operator", "operate", days=1)
    mismatch, recording = f"/mismatches/{_mismatch(store)}", f"{MACHINE}/recordings/4"
    with client_of(url, writes=True, headers=GERMAN) as client:
        assert left_of_page(client.post("/sign-in", data={"token": "wrong"}).text) == []
        client.post("/sign-in", data={"token": secret})
        csrf = re.search(r'data-csrf="([^"]+)"', client.get("/").text)
        assert csrf is not None
        sent = {"csrf": csrf[1], "why": "HSS"}
        pages = [
            client.get(mismatch),
            client.get(f"{MACHINE}/import"),
            *(client.post(mismatch, data=sent | {"word": one}) for one in ("reject", "confirm")),
            client.get(f"{MACHINE}/mismatches?decided=true"),
            client.post(mismatch, data=sent | {"word": "reopen"}),
            client.post(mismatch, data=sent | {"word": "confirm"}),
            client.get(recording),
            client.post(recording, data=sent | {"word": "withdraw"}),
            client.post(recording, data=sent | {"word": "withdraw", "sure": "yes"}),
            client.get(f"{MACHINE}/recordings"),
            client.post(recording, data=sent | {"word": "take-again"}),
        ]
    assert [got.status_code for got in pages] == [*[200] * 3, 422, *[200] * 4, 422, *[200] * 3]
    left = {str(got.url): found for got in pages if (found := left_of_page(got.text))}
    assert left == {}
    with closing(sqlite3.connect(url.removeprefix("sqlite:///"))) as database:
        dump = "\n".join(database.iterdump())
    assert OPEN not in dump
    assert CLOSE not in dump


@pytest.mark.usefixtures("marked")
def test_commands_say_mismatches_and_sensors_in_german(
    url: str, store: Store, cli: Cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "1000")  # no sentence in several lines
    at = ("--db", url, "--language", "de", "--units", "inch")
    said = [
        cli("mismatch", "list", "--machine", "lathe-1", "--all", *at),
        cli("mismatch", "show", _mismatch(store), *at),
        cli("sensors", "--machine", "lathe-1", *at),
    ]
    assert [one.code for one in said] == [0, 0, 0]
    lines = [line for one in said for line in one.out.splitlines()]
    assert len(lines) > 20
    paper = re.compile(r"\([^()]*\)$|\bforce\.|\bspindle\b")
    assert left(paper.sub(" ", line) for line in left(lines)) == []


@pytest.mark.usefixtures("marked")
def test_programs_get_english_whatever_they_send(url: str, pair: dict[str, str]) -> None:
    cookies = {"autodb_language": "de", "autodb_units": "inch"}
    asked = pair | {key: value for key, value in CUT.items() if key != "name"}
    with client_of(url) as plain, client_of(url, headers=GERMAN, cookies=cookies) as german:
        for path, query in (
            (f"/api/v1{MACHINE}/lookup", asked),
            (f"/api/v1{MACHINE}/lookup", asked | {"depth_mm": "deep"}),
            (f"/api/v1{MACHINE}/health", {}),
            (f"/api/v1{MACHINE}/recordings/2", {}),
        ):
            ours, theirs = (one.get(path, params=query) for one in (plain, german))
            assert theirs.text == ours.text
            assert OPEN not in ours.text
        shown = german.get(f"/api/v1{MACHINE}/lookup", params=asked | {"depth_mm": "deep"},
                           headers={"X-Shown-In": "de"})  # fmt: skip
        assert shown.headers["content-language"] == "de"


def test_a_page_is_in_the_language_of_its_browser_and_then_of_its_reader(
    client: TestClient,
) -> None:
    def shown(**headers: str) -> tuple[str, str]:
        got = client.get("/", headers=headers)
        found = re.search(r'<html lang="(\w+)">', got.text)
        assert found is not None
        assert got.headers["content-language"] == found[1]
        assert "Accept-Language" in got.headers["vary"]
        return found[1], "Maschinen" if "Maschinen" in got.text else "Machines"

    assert shown() == ("en", "Machines")
    german = {"accept-language": "de-AT,en;q=0.7"}
    assert shown(**german) == ("de", "Maschinen")
    kept = client.post("/shown", data={"language": "en", "then": f"{MACHINE}/plan?a=b"},
                       headers=german, follow_redirects=False)  # fmt: skip
    assert (kept.status_code, kept.headers["location"]) == (303, f"{MACHINE}/plan?a=b")
    assert "HttpOnly" in kept.headers["set-cookie"]
    assert shown(**german) == ("en", "Machines")
    client.post("/shown", data={"language": "de"})
    assert shown() == ("de", "Maschinen")
    wrong = {"language": "xx", "units": "ells", "then": "//evil.example"}
    other = client.post("/shown", data=wrong, follow_redirects=False)
    assert other.headers["location"] == "/"
    assert "set-cookie" not in other.headers


def test_words_of_the_trade_and_marks_of_the_language(
    client: TestClient, pair: dict[str, str]
) -> None:
    html = client.get(f"{MACHINE}/plan?{urlencode(pair | CUT)}", headers=GERMAN).text
    text = re.sub(r"<[^>]+>", " ", html)
    for word in (
        "Schnittkraft Fc", "Vorschubkraft Ff", "Passivkraft Fp", "Schnitttiefe",
                 "Vorschub", "Schnittgeschwindigkeit", "Spezifische Schnittkraft",
                 "Drehmoment der Spindel", "Schnittleistung", "Werkstoff", "Längsdrehen",
    ):  # fmt: skip
        assert word in text, word
    assert re.search(r"\d,\d+ bis \d+,\d+\s*N·m", text)
    assert "mm/U" in text
    assert (
        'value="0,3"' in client.get(f"{MACHINE}/pair?{urlencode(pair | CUT)}", headers=GERMAN).text
    )
