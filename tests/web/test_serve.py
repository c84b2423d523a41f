"""The service: look-ups, what is read by name, tokens, and what stands before every route."""

import json
import os
import signal
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from dataclasses import asdict
from itertools import product
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import httpx
import numpy as np
import pytest
from fastapi.testclient import TestClient
from numpy.testing import assert_allclose
from pydantic import TypeAdapter
from sqlalchemy import inspect, select

from autodb.agent.answer.looking_up import Shelf
from autodb.agent.answer.lookup_cache import Shelves
from autodb.agent.answer.predicting import JobAnswer
from autodb.agent.answer.prediction_basis import LookedUp
from autodb.agent.operate.access import add_token, noted, revoke_token
from autodb.agent.operate.refreshing import refresh
from autodb.agent.rows.machines import add_machine
from autodb.cli import run
from autodb.errors import NotThere, UnusableInput
from autodb.files.channels import largest_of
from autodb.files.job import LEAST, Job, JobCut
from autodb.files.machine import LATHE
from autodb.proofs.machines.lathe import fleets
from autodb.store import Store, create_store, models, open_store
from autodb.store.watched import Watched
from autodb.web.app import make_app
from autodb.web.client import Client, Unanswered
from autodb.web.http import turns
from autodb.web.http.guard import HEADERS
from autodb.web.http.settings import Settings
from autodb.web.service import PASSED_ON
from tests.conftest import Cli
from tests.helpers import shops
from tests.helpers.servers import Server
from tests.helpers.serving import self_signed, served, wait_for

API = "/api/v1"
CUT: dict[str, Any] = {
    "operation": "turn", "diameter_mm": 50.0, "depth_mm": 2.0, "feed_mm_rev": 0.25,
    "speed_m_min": 220.0,
}  # fmt: skip
MILLED = {"operation": "slot", "depth_mm": 2.0, "feed_mm_tooth": 0.05, "speed_m_min": 100.0}
SIX_DIGITS = 1e-6


@pytest.fixture(scope="module")
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


def _client(url: str, host: str = "127.0.0.1", **more: Any) -> TestClient:
    made = make_app(Settings(url, host=host, **more))
    return TestClient(made, base_url="http://localhost", raise_server_exceptions=False)


@pytest.fixture
def client(url: str) -> Iterator[TestClient]:
    """Return a client of the service on loopback, read-only."""
    with _client(url) as made:
        yield made


@pytest.fixture
def pair(store: Store) -> dict[str, str]:
    """Return a pair that was learnt, as a query names it."""
    with store.reading() as session:
        one = Shelf(session, "lathe-0").pairs()[0]
    return {"material": one.material, "tool": one.tool}


def _detail(response: Any) -> str:
    body = response.json()
    assert list(body) == ["detail"]
    assert "\n" not in body["detail"]
    return str(body["detail"])


# Look-ups


def test_a_look_up_is_what_the_library_says(
    client: TestClient, store: Store, pair: dict[str, str]
) -> None:
    got = client.get(f"{API}/machines/lathe-0/lookup", params=pair | CUT)
    assert got.status_code == 200
    with store.reading() as session:
        found = Shelf(session, "lathe-0").look_up(**pair, cut=JobCut.model_validate(CUT))
    assert TypeAdapter(LookedUp).validate_json(got.content) == found


def test_a_pair_never_cut_is_answered_and_said(client: TestClient) -> None:
    asked = {"material": "unheard of", "tool": "any"} | CUT
    got = client.get(f"{API}/machines/a%2Fb%20c/lookup", params=asked)
    assert got.status_code == 200
    assert "has not learnt unheard of / any" in got.json()["notes"][0]


@pytest.mark.parametrize(
    ("change", "status", "said"),
    [
        ({"depth_mm": "deep"}, 422, "depth_mm: 'deep' is no number"),
        ({"depth_mm": "-1"}, 422, "depth_mm: Input should be greater than 0"),
        ({"depth_mm": "nan"}, 422, "depth_mm"),
        ({"dept_mm": "1"}, 422, "did you mean depth_mm"),
        ({"operation": "grind"}, 422, "operation"),
        ({"speed_rpm": "100"}, 422, "either speed_rpm or speed_m_min"),
        ({"material": ""}, 422, "material: missing"),
    ],
)
def test_a_cut_that_cannot_be_is_refused_in_one_line(
    client: TestClient, pair: dict[str, str], change: dict[str, str], status: int, said: str
) -> None:
    got = client.get(f"{API}/machines/lathe-0/lookup", params=pair | CUT | change)
    assert got.status_code == status
    assert said in _detail(got)


BEYOND = [
    ({"depth_mm": 1e308}, "depth_mm: Input should be less than or equal to 1000"),
    ({"feed_mm_rev": 1e5}, "feed_mm_rev: Input should be less than or equal to 1000"),
    ({"speed_m_min": 1e7}, "speed_m_min: Input should be less than or equal to 100000"),
    ({"diameter_mm": 1e308}, "diameter_mm: Input should be less than or equal to 100000"),
    ({"cutting_time_s": 1e300}, "cutting_time_s: Input should be less than or equal to 100000000"),
    ({"depth_mm": 1e-308}, "depth_mm: 1e-308 is below any machine; at least 1e-06 would work"),
]


@pytest.mark.parametrize(("change", "said"), BEYOND)
def test_what_no_machine_does_is_refused_in_the_same_words_everywhere(
    url: str, store: Store, pair: dict[str, str], change: dict[str, float], said: str
) -> None:
    """By a look-up, a batch, a job that is kept or not, and on the planner's page."""
    cut, at = CUT | change, f"{API}/machines/lathe-0"
    operates = _bearer(add_token(store, "shop", "operate", days=1))
    job = {"name": "j", **pair, "cut": [CUT, cut]}
    with _client(url, writes=True) as client:
        assert _detail(client.get(f"{at}/lookup", params=pair | cut)) == said
        row, end = _batch(client, pair, [json.dumps(cut)])
        assert (row["problem"], end) == (said, {"answered": 0, "refused": 1})
        for path in ("predict", "predictions"):
            got = client.post(f"{at}/{path}", json=job, headers=operates)
            assert (got.status_code, _detail(got)) == (422, f"cut.1.{said}")
        page = client.get("/machines/lathe-0/plan", params=pair | cut)
        assert f"cut 1: {said}" in page.text


def test_the_furthest_that_is_taken_is_answered(client: TestClient, pair: dict[str, str]) -> None:
    ends = {
        "diameter_mm": (LEAST, largest_of("work.diameter")),
        "depth_mm": (LEAST, largest_of("cutting.depth")),
        "feed_mm_rev": (LEAST, largest_of("cutting.feed")),
        "speed_m_min": (LEAST, largest_of("cutting.speed")),
    }
    for stated in product(*ends.values()):
        cut = CUT | dict(zip(ends, stated, strict=True))
        got = client.get(f"{API}/machines/lathe-0/lookup", params=pair | cut)
        assert got.status_code == 200, cut


def test_what_is_not_there_is_404(client: TestClient) -> None:
    for path, said in (
        ("machines/lathe", "did you mean lathe-0"),
        ("machines/nobody/lookup?material=a&tool=b&diameter_mm=5&depth_mm=1&feed_mm_rev=0.1"
         "&speed_rpm=100", "no machine 'nobody'"),
        ("trace/parameters/99", "there is no parameters 99"),
        ("trace/nonsense/1", "nothing called 'nonsense'"),
        ("mismatches/7", "no mismatch 7"),
        ("tools/none", "no tool 'none'"),
        ("nothing", "openapi.json lists what would work"),
    ):  # fmt: skip
        got = client.get(f"{API}/{path}")
        assert got.status_code == 404, path
        assert said in _detail(got)


def test_a_job_is_predicted_and_nothing_kept(
    client: TestClient, store: Store, pair: dict[str, str]
) -> None:
    job = {"name": "j", **pair, "cut": [CUT, CUT | {"depth_mm": 1.0}]}
    got = client.post(f"{API}/machines/lathe-0/predict", json=job)
    assert got.status_code == 200
    answer = TypeAdapter(JobAnswer).validate_json(got.content)
    assert len(answer.cuts) == 2
    assert answer.cuts[0].force_y_N.value > answer.cuts[1].force_y_N.value
    with store.reading() as session:
        assert session.query(models.Prediction).count() == 0


def test_a_job_that_names_a_file_is_refused(client: TestClient, pair: dict[str, str]) -> None:
    program = {"file": "/etc/passwd", "stock_diameter_mm": 50.0}
    job = {"name": "j", **pair, "program": program}
    got = client.post(f"{API}/machines/lathe-0/predict", json=job)
    assert got.status_code == 422
    assert "a job with cuts would work" in _detail(got)
    assert "root:" not in got.text


# Batches


def _batch(client: TestClient, pair: dict[str, str], lines: list[str]) -> list[dict[str, Any]]:
    got = client.post(f"{API}/machines/lathe-0/lookup/batch", params=pair, content="\n".join(lines))
    assert got.status_code == 200
    return [json.loads(line) for line in got.text.splitlines()]


def test_a_batch_answers_each_line_as_a_look_up_does(
    client: TestClient, store: Store, pair: dict[str, str]
) -> None:
    cuts = [CUT | {"depth_mm": 0.5 + 0.01 * k} for k in range(600)]
    *rows, end = _batch(client, pair, [json.dumps(cut) for cut in cuts])
    assert end == {"answered": 600, "refused": 0}
    assert [row["row"] for row in rows] == list(range(1, 601))
    with store.reading() as session:
        shelf = Shelf(session, "lathe-0")
        for k in (0, 299, 599):
            one = asdict(shelf.look_up(**pair, cut=JobCut.model_validate(cuts[k])).cut)
            for name in ("force_y_N", "force_z_N", "torque_N_m"):
                found, alone = rows[k]["cut"][name], one[name]
                assert_allclose(list(found.values()), list(alone.values()), rtol=SIX_DIGITS)


def test_a_line_that_cannot_be_answered_spoils_no_other(
    client: TestClient, pair: dict[str, str]
) -> None:
    lines = [json.dumps(CUT), "{", json.dumps(CUT | {"depth_mm": 0.0}), json.dumps(MILLED),
             "x" * 5000, "", json.dumps(CUT)]  # fmt: skip
    *rows, end = _batch(client, pair, lines)
    assert end == {"answered": 2, "refused": 4}
    assert [row["row"] for row in rows if "cut" in row] == [1, 6]
    said = [row["problem"] for row in rows if "problem" in row]
    assert ["JSON" in said[0], "depth_mm" in said[1], "longer than" in said[3]] == [True] * 3
    assert rows[0]["cut"] == rows[5]["cut"]


# What is read by name


def test_machines_page_by_page(client: TestClient, store: Store) -> None:
    for name in ("m1", "m2"):
        add_machine(store, name, LATHE)
    seen, after = [], ""
    while after is not None:
        got = client.get(f"{API}/machines", params={"most": 2, "after": after}).json()
        seen += [one["name"] for one in got["machines"]]
        after = got["next"]
    assert seen == ["a/b c", "lathe-0", "m1", "m2"]
    one = client.get(f"{API}/machines/a%2Fb%20c").json()
    assert (one["axes"], one["recordings"]) == (["x", "z", "spindle"], 0)


def test_what_a_machine_knows_leads_down_to_recordings(
    client: TestClient, pair: dict[str, str]
) -> None:
    pairs = client.get(f"{API}/machines/lathe-0/pairs").json()
    assert [one["cuts"] for one in pairs] == [8, 8]
    found = client.get(f"{API}/machines/lathe-0/lookup", params=pair | CUT).json()
    trace = client.get(f"{API}/trace/parameters/{found['behind']['parameters']}").json()
    assert "recording 1" in json.dumps(trace)
    for path in ("sensors", "calibrations", "mismatches", "coefficients"):
        assert client.get(f"{API}/machines/lathe-0/{path}").status_code == 200
    tool = client.get(f"{API}/tools").json()[0]
    assert tool["iso13399"]["RE"] > 0.0
    assert client.get(f"{API}/tools/{tool['name']}").json() == tool


# The state of the database


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


def test_any_tag_of_what_is_not_there_is_404(client: TestClient) -> None:
    got = client.get(f"{API}/machines/nobody", headers={"If-None-Match": "*"})
    assert got.status_code == 404


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
    shelves = Shelves(store, watched)
    first = shelves.grounds("lathe-0", **pair)
    writer = open_store(url)
    add_machine(writer, "another", LATHE)
    again = shelves.grounds("lathe-0", **pair)
    assert again.mark != first.mark
    assert again.grounds is first.grounds
    _newer_version(writer, first.grounds.known.behind.parameters or 0)
    assert shelves.grounds("lathe-0", **pair).grounds is not first.grounds
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


# Who may


def test_another_address_needs_a_token_for_all_but_health(url: str, store: Store) -> None:
    secret = add_token(store, "planner", "read", days=None)
    with _client(url, host="192.0.2.1") as client:
        assert client.get("/healthz").json() == {"status": "ok"}
        for path in (f"{API}/machines", "/metrics"):
            got = client.get(path)
            assert got.status_code == 401
            assert got.headers["www-authenticate"] == "Bearer"
            assert client.get(path, headers=_bearer(secret)).status_code == 200
        assert client.get(f"{API}/machines", headers=_bearer(secret + "x")).status_code == 401
        assert client.get(f"{API}/machines", headers={"Authorization": secret}).status_code == 401


def _bearer(secret: str) -> dict[str, str]:
    return {"Authorization": f"Bearer {secret}"}


def test_only_hashes_of_tokens_are_kept(url: str, store: Store) -> None:
    secret = add_token(store, "planner", "read", days=1)
    store.close()
    assert secret.encode() not in Path(url.removeprefix("sqlite:///")).read_bytes()


def test_roles_allow_what_they_say(url: str, store: Store, pair: dict[str, str]) -> None:
    reads, operates, admin = (add_token(store, r, r, days=1) for r in ("read", "operate", "admin"))
    job = {"name": "j", **pair, "cut": [CUT]}
    path = f"{API}/machines/lathe-0/predictions"
    with _client(url, writes=True) as client:
        assert client.post(path, json=job).status_code == 401
        refused = client.post(path, json=job, headers=_bearer(reads))
        assert (refused.status_code, _detail(refused)) == (403, "'read' may read, not operate")
        made = client.post(path, json=job, headers=_bearer(operates))
        assert made.status_code == 201
        assert client.get(made.headers["location"]).status_code == 200
        assert client.get(f"{API}/audit", headers=_bearer(operates)).status_code == 403
        log = client.get(f"{API}/audit", headers=_bearer(admin)).json()
        assert [one["entry"]["action"] for one in log] == [
            "prediction kept", *["token added"] * 3
        ]  # fmt: skip
        assert (log[0]["entry"]["who"], log[0]["entry"]["row_id"]) == ("operate", 1)
    with _client(url) as client:
        refused = client.post(path, json=job, headers=_bearer(operates))
        assert refused.status_code == 403
        assert "read-only" in _detail(refused)


def test_a_token_that_is_revoked_or_expired_is_refused(
    url: str, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("autodb.web.service.HELD_S", 0.0)
    secret, old = (add_token(store, name, "read", days=1) for name in ("a", "b"))
    with store.writing() as session:
        row = session.query(models.AccessToken).filter_by(name="b").one()
        row.expires_at = "2026-01-01T00:00:00+00:00"
    with _client(url, host="192.0.2.1") as client:
        assert client.get(f"{API}/machines", headers=_bearer(old)).status_code == 401
        assert client.get(f"{API}/machines", headers=_bearer(secret)).status_code == 200
        assert revoke_token(store, "a")
        assert client.get(f"{API}/machines", headers=_bearer(secret)).status_code == 401
    assert not revoke_token(store, "a")


def test_who_guesses_tokens_has_to_wait(url: str, store: Store) -> None:
    secret = add_token(store, "planner", "read", days=1)
    with _client(url, host="192.0.2.1") as client:
        for k in range(20):
            assert client.get(f"{API}/machines", headers=_bearer(f"guess {k}")).status_code == 401
        got = client.get(f"{API}/machines", headers=_bearer("one more"))
        assert got.status_code == 429
        assert 0 < int(got.headers["retry-after"]) <= 60
        as_long = client.get(f"{API}/machines", headers=_bearer(secret[:-1] + "~"))
        assert as_long.status_code == 429
        assert client.get(f"{API}/machines", headers=_bearer(secret)).status_code == 200
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
    with _client(url, **more) as client:
        assert client.get("/healthz").status_code == 200
        for path in (
            f"{API}/machines",
            f"{API}/openapi.json",
            "/metrics",
            "/",
            "/machines/lathe-0",
        ):
            assert client.get(path).status_code == 401, path
            assert client.get(path, headers=_bearer(secret)).status_code == 200, path


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
        httpx.get(f"{at}{API}/machines", headers=_bearer(secret) | said).raise_for_status()
        cookie = httpx.post(f"{at}/sign-in", data={"token": secret}, headers=said).headers
    assert {one.client for one in caplog.records if one.message == "answered"} == seen
    assert ("Secure" in cookie["set-cookie"]) == (seen == {"192.0.2.7"})


# What stands before every route


def test_every_answer_has_the_headers_of_safety(client: TestClient) -> None:
    for path in ("/healthz", f"{API}/machines", f"{API}/none", "/static/site.css"):
        got = client.get(path)
        assert HEADERS.items() <= dict(got.headers).items() | {
            (name, got.headers.get(name)) for name in HEADERS
        }
        assert len(got.headers["x-request-id"]) == 12
        assert "server" not in got.headers


def test_a_name_that_leads_here_from_elsewhere_is_refused(client: TestClient) -> None:
    for host in ("evil.example", "evil.example:8321", "localhost.evil.example"):
        got = client.get(f"{API}/machines", headers={"Host": host})
        assert got.status_code == 400, host
    for host in ("localhost", "127.0.0.1:8321", "[::1]:8321", "LOCALHOST:1"):
        assert client.get(f"{API}/machines", headers={"Host": host}).status_code == 200, host


def test_more_than_is_taken_is_refused(client: TestClient) -> None:
    path = f"{API}/machines/lathe-0/predict"
    large = b" " * (2**20 + 1)
    assert client.post(path, content=large).status_code == 413

    def parts() -> Iterator[bytes]:
        for _ in range(20):
            yield b" " * 100_000

    got = client.post(path, content=parts())
    assert got.status_code == 413
    assert "1 MiB" in _detail(got)


def test_counts_say_what_was_asked(client: TestClient, pair: dict[str, str]) -> None:
    client.get(f"{API}/machines/lathe-0/lookup", params=pair | CUT)
    client.get(f"{API}/machines/nobody")
    text = client.get("/metrics").text
    route = 'route="/machines/{machine:path}/lookup"'
    assert f'autodb_requests_total{{method="GET",{route},status="200"}} 1.0' in text
    assert 'status="404"} 1.0' in text
    assert "autodb_cuts_looked_up_total 1.0" in text
    assert f"autodb_request_seconds_count{{{route}}} 1.0" in text


def test_a_database_that_is_gone_is_503(url: str, tmp_path: Path) -> None:
    with _client(url) as client:
        Path(url.removeprefix("sqlite:///")).rename(tmp_path / "away")
        got = client.get(f"{API}/machines")
        assert got.status_code == 503
        assert "No such file" in _detail(got)


def test_the_document_says_units_examples_and_errors(client: TestClient) -> None:
    document = client.get(f"{API}/openapi.json").json()
    cut = document["components"]["schemas"]["PredictedCut"]["properties"]
    assert cut["force_x_N"]["x-unit"] == "N"
    assert cut["torque_N_m"]["x-unit"] == "N·m"
    look_up = document["paths"][f"{API}/machines/{{machine}}/lookup"]["get"]
    asked = {one["name"]: one for one in look_up["parameters"]}
    assert asked["feed_mm_rev"]["x-unit"] == "mm/rev"
    assert asked["depth_mm"]["example"] == 2.0
    assert {"200", "304", "401", "404", "422", "429", "503"} <= look_up["responses"].keys()
    for path, operations in document["paths"].items():
        for method, one in operations.items():
            assert one["summary"], (path, method)
            assert one["description"], (path, method)


# Decisions


@pytest.fixture
def mismatch(store: Store) -> int:
    """Return the number of a mismatch that nobody decided on."""
    with store.writing() as session:
        row = models.Mismatch(
            recording_id=1, channel="z.current", term="sensor_drift", kind="missing",
            confidence=0.9, parameters={}, statement="The reading drifts.",
            alternatives=["warmup"],
        )  # fmt: skip
        session.add(row)
        session.flush()
        return row.id


def test_a_decision_is_kept_with_who_took_it(url: str, store: Store, mismatch: int) -> None:
    reads, operates = (add_token(store, r, r, days=1) for r in ("read", "operate"))
    path = f"{API}/mismatches/{mismatch}"
    with _client(url, writes=True) as client:
        listed = client.get(f"{API}/machines/lathe-0/mismatches").json()
        assert [(one["id"], one["status"]) for one in listed] == [(mismatch, "open")]
        assert client.post(f"{path}/confirm", headers=_bearer(reads)).status_code == 403
        odd = client.post(f"{path}/confirm", json={"term": "chatter"}, headers=_bearer(operates))
        assert (odd.status_code, "may be sensor_drift or warmup" in _detail(odd)) == (422, True)
        done = client.post(f"{path}/confirm", json={"term": None}, headers=_bearer(operates))
        assert done.status_code == 200
        assert (done.json()["mismatch"]["decided_by"], done.json()["already"]) == ("operate", False)
        again = client.post(f"{path}/confirm", headers=_bearer(operates))
        assert again.json()["already"]
        refused = client.post(f"{path}/reject", headers=_bearer(operates))
        assert (refused.status_code, "a decision stands" in _detail(refused)) == (422, True)
        assert client.get(f"{API}/machines/lathe-0/mismatches").json() == []
    with store.reading() as session:
        (_, first), *_ = noted(session, most=5)
    assert (first.who, first.action, first.row_id) == ("operate", "mismatch confirmed", mismatch)


# As a process, and its client


def test_the_client_says_what_the_library_says(
    url: str, store: Store, pair: dict[str, str]
) -> None:
    cuts = [JobCut.model_validate(CUT | {"depth_mm": depth}) for depth in (1.0, 2.0)]
    job = Job(name="j", material=pair["material"], tool=pair["tool"], cut=tuple(cuts))
    with store.reading() as session:
        shelf = Shelf(session, "lathe-0")
        alone = [shelf.look_up(**pair, cut=cut) for cut in cuts]
        known = shelf.pairs()
    with served(Settings(url)) as at, Client(at) as client:
        assert [one.name for one in client.machines()] == ["a/b c", "lathe-0"]
        assert client.machine("a/b c").recordings == 0
        assert client.pairs("lathe-0") == known
        assert [client.look_up("lathe-0", **pair, cut=cut) for cut in cuts * 2] == alone * 2
        rows = list(client.look_up_many("lathe-0", **pair, cuts=cuts))
        assert [row.row for row in rows] == [1, 2]
        assert client.predict("lathe-0", job).job == job
        assert client.trace("recording", 1).text.startswith("recording 1")
        assert client.feels("lathe-0").not_sensed
        assert (client.calibrations("lathe-0"), client.mismatches("lathe-0")) == ([], [])
        with pytest.raises(NotThere, match="did you mean lathe-0"):
            client.machine("lathe")
        (refused,) = client.look_up_many("lathe-0", "unknown", "mill", [_slot()])
        assert "diameter_mm would work" in (refused.problem or "")
        with pytest.raises(UnusableInput, match="diameter_mm would work"):
            client.look_up("lathe-0", "unknown", "mill", _slot())
        with pytest.raises(Unanswered, match=r"a token is needed|read-only"):
            client.keep_prediction("lathe-0", job)
    with pytest.raises(Unanswered, match="no answer"), Client(at) as client:
        client.machine("lathe-0")


def _slot() -> JobCut:
    return JobCut.model_validate(MILLED)


def test_over_tls(url: str, tmp_path: Path) -> None:
    certificate = self_signed(tmp_path)
    with served(Settings(url), certificate) as at:
        with Client(at, ca=certificate.chain) as client:
            assert client.machine("lathe-0").name == "lathe-0"
        with pytest.raises(Unanswered, match="CERTIFICATE_VERIFY_FAILED"), Client(at) as client:
            client.machine("lathe-0")


def test_connections_that_say_nothing_keep_nobody_out(
    url: str, pair: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Silent ones and begun ones are ended; idle ones between requests and slow bodies are not."""
    monkeypatch.setattr("autodb.web.server.AT_ONCE", 6)
    monkeypatch.setattr("autodb.web.http.connections.HEAD_S", 1.0)
    line = json.dumps(CUT).encode()
    asked = f"POST {API}/machines/lathe-0/lookup/batch?{urlencode(pair)} HTTP/1.1\r\n"
    head = f"{asked}Host: localhost\r\nContent-Length: {len(line)}\r\n\r\n".encode()
    with served(Settings(url)) as at, httpx.Client(base_url=at) as client, ExitStack() as opened:
        slow, *held = (opened.enter_context(socket.socket()) for _ in range(5))
        where = ("127.0.0.1", httpx.URL(at).port or 0)
        slow.connect(where)
        slow.sendall(head)
        assert client.get("/healthz").status_code == 200
        for one in held:
            one.settimeout(10.0)
            one.connect(where)
        held[0].sendall(b"GET /healthz HTTP/1.1\r\nHost:")
        statuses = (client.get("/healthz").status_code for _ in range(200))
        assert 503 in statuses, "once all are accepted"
        assert [one.recv(12) for one in held] == [b"HTTP/1.1 408", b"", b"", b""]
        assert client.get("/healthz").status_code == 200
        slow.sendall(line)
        assert slow.recv(12) == b"HTTP/1.1 200"


HEALTH = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n"
CHUNKED = HEALTH + b"Transfer-Encoding: chunked\r\n\r\n"


@pytest.mark.parametrize(
    ("parts", "status"),
    [
        ([HEALTH + b"A: " + b"a" * 15_000, b"\r\n\r\n"], b"200"),
        ([HEALTH, *(b"A%d: a\r\n" % k for k in range(98)), b"\r\n"], b"200"),
        ([CHUNKED, *[b"1\r\na\r\n" * 20_000], b"0\r\n\r\n"], b"200"),
        ([HEALTH + b"A: ", *[b"a" * 65_536] * 1000], b"431"),
        ([HEALTH + b"A: " + b"a" * 16_384 + b"\r\n\r\n"], b"431"),
        ([HEALTH, b"A: a\r\n" * 99 + b"\r\n"], b"431"),
        ([b"GET /" + b"a" * 1_000_000], b"431"),
        ([b"\r\n" * 1_000_000], b"431"),
        ([b"no request\r\n\r\n"], b"400"),
    ],
    ids=["long", "many", "chunks", "endless", "too long", "too many", "path", "blank", "none"],
)
def test_a_head_that_goes_on_is_refused(url: str, parts: list[bytes], status: bytes) -> None:
    with served(Settings(url)) as at, socket.socket() as one:
        one.settimeout(20.0)
        one.connect(("127.0.0.1", httpx.URL(at).port or 0))
        with suppress(ConnectionError):  # it is ended before all is sent
            for part in parts:
                one.sendall(part)
        said = one.recv(4096)
        head, _, body = said.partition(b"\r\n\r\n")
        assert head.startswith(b"HTTP/1.1 " + status)
        assert b"x-content-type-options: nosniff" in head.lower()
        assert (status == b"200") or list(json.loads(body)) == ["detail"]
        with suppress(ConnectionError):
            assert one.recv(4096) == b""


def test_trailers_that_go_on_end_the_connection(url: str) -> None:
    with served(Settings(url)) as at, socket.socket() as one:
        one.settimeout(20.0)
        one.connect(("127.0.0.1", httpx.URL(at).port or 0))
        one.sendall(CHUNKED + b"1\r\na\r\n0\r\nT: ")
        with pytest.raises(ConnectionError):
            for _ in range(1000):
                one.sendall(b"t" * 65_536)


def test_blank_lines_between_requests_keep_no_connection(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("autodb.web.http.connections.HEAD_S", 0.5)
    with served(Settings(url)) as at, socket.socket() as one:
        one.settimeout(20.0)
        one.connect(("127.0.0.1", httpx.URL(at).port or 0))
        one.sendall(HEALTH.replace(b"close", b"keep-alive") + b"\r\n")
        assert one.recv(4096).startswith(b"HTTP/1.1 200")
        one.sendall(b"\r\n")
        assert one.recv(1) == b""


def test_a_body_that_goes_on_after_its_answer_is_not_waited_for(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("autodb.web.http.connections.HEAD_S", 0.5)
    with served(Settings(url)) as at, socket.socket() as one:
        one.settimeout(20.0)
        one.connect(("127.0.0.1", httpx.URL(at).port or 0))
        one.sendall(HEALTH.replace(b"close", b"keep-alive") + b"Content-Length: 1000\r\n\r\na")
        assert one.recv(4096).startswith(b"HTTP/1.1 200")
        one.sendall(b"a")
        assert one.recv(1) == b""


def test_requests_that_are_sent_at_once_wait_unread(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A thousand at once, each answered, and no more of them parsed than a piece has."""
    waiting: list[int] = []

    def count(connection: turns.InTurns, piece: bytes) -> None:
        parse(connection, piece)
        waiting.append(len(connection.pipeline))

    parse = turns.InTurns.take
    monkeypatch.setattr(turns.InTurns, "take", count)
    asked = b"GET /no HTTP/1.1\r\nHost: localhost\r\n\r\n"
    with served(Settings(url)) as at, socket.socket() as one:
        one.settimeout(20.0)
        one.connect(("127.0.0.1", httpx.URL(at).port or 0))
        one.sendall(asked * 1000 + HEALTH + b"\r\n")
        said = b"".join(iter(lambda: one.recv(65_536), b""))
    assert said.count(b"HTTP/1.1 404") == 1000
    assert said.count(b"HTTP/1.1 200") == 1
    assert 0 < max(waiting) <= turns.PIECE_BYTES / len(asked)


def test_who_sends_what_is_long_to_parse_gives_others_their_turn(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a body in chunks of one byte no more than a piece is parsed until another is answered."""
    monkeypatch.setattr(turns, "TURN_S", 0.0)
    monkeypatch.setattr(turns, "REST_S", 3600.0)
    with served(Settings(url)) as at, socket.socket() as one, httpx.Client(base_url=at) as other:
        one.settimeout(0.2)
        one.connect(("127.0.0.1", httpx.URL(at).port or 0))
        one.sendall(HEALTH.replace(b"close", b"keep-alive") + b"Transfer-Encoding: chunked\r\n\r\n")
        with pytest.raises(TimeoutError):  # it is read no more
            for _ in range(1000):
                one.sendall(b"1\r\na\r\n" * 20_000)
        assert other.get("/healthz").status_code == 200


def test_stopped_it_answers_what_is_on_its_way(
    url: str, pair: dict[str, str], tmp_path: Path
) -> None:
    log = tmp_path / "log"
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    child = os.fork()
    if child == 0:
        code = 99
        try:
            with log.open("w", buffering=1) as sys.stdout:
                sys.stderr = sys.stdout
                code = run(["serve", "--port", str(port), "--db", url])
        finally:
            os._exit(code)
    at, lines = f"http://127.0.0.1:{port}", (json.dumps(CUT) + "\n") * 3000
    wait_for(at)
    path = f"{at}{API}/machines/lathe-0/lookup/batch"
    got: list[str] = []
    with httpx.stream("POST", path, params=pair, content=lines, timeout=60.0) as response:
        for line in response.iter_lines():
            if not got:
                os.kill(child, signal.SIGTERM)
            got.append(line)
    assert json.loads(got[-1]) == {"answered": 3000, "refused": 0}
    assert os.waitpid(child, 0)[1] == 0
    first, *logged = log.read_text().splitlines()
    assert first == f"{at} (and {at}/api/v1): read-only; Ctrl-C stops it"
    said = [json.loads(line) for line in logged]
    answered = [one for one in said if one.get("route", "").endswith("/batch")]
    assert [one["status"] for one in answered] == [200]


# The command


def test_tokens_by_command(cli: Cli) -> None:
    cli("init")
    assert "no token" in cli("token", "list").out
    secret = cli("token", "add", "planner", "--role", "operate", "--days", 30).out.strip()
    assert secret.startswith("autodb_")
    again = cli("token", "add", "planner")
    assert (again.code, "another would work" in again.err) == (2, True)
    assert "valid" in cli("token", "list").out
    assert "revoked" in cli("token", "revoke", "planner").out
    assert "already" in cli("token", "revoke", "planner").out
    assert cli("token", "revoke", "plan").code == 2
    assert cli("token", "add", "x", "--role", "root").code == 2
    store = open_store("sqlite:///autodb.sqlite3")
    with store.reading() as session:
        said = [(one.who, one.action) for _, one in noted(session, most=9)]
    store.close()
    assert said == [("command line", "token revoked"), ("command line", "token added")]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--host", "0.0.0.0"), "autodb token add NAME --role read"),
        (("--write",), "autodb token add NAME --role operate"),
        (("--certificate", "c.pem"), "both would work"),
        (("--certificate", "c.pem", "--key", "k.pem"), "both as PEM would work"),
        (("--host", "203.0.113.9", "--port", "9"), "autodb token add"),
        (("--name", "shop.example"), "autodb token add NAME --role read"),
        (("--proxy", "127.0.0.1"), "autodb token add NAME --role read"),
        (("--proxy", "shop"), "127.0.0.1 or 192.0.2.0/24 would work"),
    ],
)
def test_a_service_that_nobody_could_use_does_not_begin(
    cli: Cli, options: tuple[str, ...], said: str
) -> None:
    cli("init")
    done = cli("serve", *options)
    assert (done.code, done.err.count("\n")) == (2, 1)
    assert said in done.err


def test_a_port_that_is_taken_is_said(cli: Cli) -> None:
    cli("init")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        done = cli("serve", "--port", taken.getsockname()[1])
    assert done.code == 2
    assert "another --port or --host would work" in done.err
