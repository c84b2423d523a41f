"""What is read by name, decided on by name, and the document that describes it."""

import json

import pytest
from fastapi.testclient import TestClient

from autodb.agent.operate.access import add_token, noted
from autodb.agent.rows.machines import add_machine
from autodb.files.machine import LATHE
from autodb.store import Store, models
from tests.helpers.asked import API, CUT, bearer, client_of, detail


def test_what_is_not_there_is_404(client: TestClient) -> None:
    for path, said in (
        ("machines/lathe", "did you mean lathe-0"),
        ("machines/nobody/lookup?material=a&tool=b&diameter_mm=5&depth_mm=1&feed_mm_rev=0.1"
         "&speed_rpm=100", "no machine 'nobody'"),
        ("trace/parameters/99", "there is no parameters 99"),
        ("trace/nonsense/1", "nothing called 'nonsense'"),
        ("mismatches/7", "no mismatch 7"),
        ("tools/none", "no tool 'none'"),
        ("nothing", "see /api/v1/openapi.json for what it accepts"),
    ):  # fmt: skip
        got = client.get(f"{API}/{path}")
        assert got.status_code == 404, path
        assert said in detail(got)


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


def test_any_tag_of_what_is_not_there_is_404(client: TestClient) -> None:
    got = client.get(f"{API}/machines/nobody", headers={"If-None-Match": "*"})
    assert got.status_code == 404


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
    with client_of(url, writes=True) as client:
        listed = client.get(f"{API}/machines/lathe-0/mismatches").json()
        assert [(one["id"], one["status"]) for one in listed] == [(mismatch, "open")]
        assert client.post(f"{path}/confirm", headers=bearer(reads)).status_code == 403
        bad = client.post(f"{path}/confirm", json={"term": "chatter"}, headers=bearer(operates))
        assert (bad.status_code, "may be sensor_drift or warmup" in detail(bad)) == (422, True)
        done = client.post(f"{path}/confirm", json={"term": None}, headers=bearer(operates))
        assert done.status_code == 200
        assert (done.json()["mismatch"]["decided_by"], done.json()["already"]) == ("operate", False)
        again = client.post(f"{path}/confirm", headers=bearer(operates))
        assert again.json()["already"]
        refused = client.post(f"{path}/confirm", json={"term": "warmup"}, headers=bearer(operates))
        assert (refused.status_code, "take that back first" in detail(refused)) == (422, True)
        assert client.get(f"{API}/machines/lathe-0/mismatches").json() == []
        why = {"why": "the amplifier was cold"}
        back = client.post(f"{path}/reopen", json=why, headers=bearer(operates))
        (_, second) = back.json()["mismatch"]["decisions"]
        assert second.endswith(": the amplifier was cold")
        again = client.post(f"{path}/reject", headers=bearer(operates)).json()
        assert again["mismatch"]["status"] == "rejected"
    with store.reading() as session:
        *_, (_, first) = noted(session, most=3)
    assert (first.who, first.action, first.row_id) == ("operate", "mismatch confirmed", mismatch)
