"""Recordings on the pages and in the API: listed, shown, withdrawn and taken again."""

import re
from typing import Any
from urllib.parse import quote

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import select

from autodb.agent.operate.access import add_token
from autodb.store import Store, models
from tests.helpers.asked import API, bearer, client_of, detail

MACHINE = "machines/lathe-0"


@pytest.fixture
def number(store: Store) -> int:
    """Return a recording that a pair was learnt from."""
    with store.reading() as session:
        force, link = models.SensedForce, models.cutting_parameters_force.c
        found = session.scalar(
            select(models.Cut.recording_id)
            .join(force, force.cut_id == models.Cut.id)
            .where(force.id == select(link.sensed_force_id).limit(1).scalar_subquery())
        )
    assert found is not None
    return found


def test_recordings_are_listed_newest_first_some_at_a_time(
    client: TestClient, store: Store, number: int
) -> None:
    with store.writing() as session:
        owner = session.get_one(models.StoredRecording, number).machine_id
        for name in ("a.csv", "b.csv"):
            row: dict[str, Any] = {
                "sha256": name,
                "path": name,
                "kind": "series",
                "rows": 9,
                "units": {},
            }
            session.add(models.StoredRecording(machine_id=owner, side={}, **row))
    every = client.get(f"{API}/{MACHINE}/recordings").json()
    numbers = [one["id"] for one in every]
    assert numbers == sorted(numbers, reverse=True)
    assert len(numbers) > 2
    some = client.get(f"{API}/{MACHINE}/recordings?most=1&before={numbers[0]}").json()
    assert [one["id"] for one in some] == numbers[1:2]
    assert client.get(f"{API}/machines/{quote('a/b c', safe='')}/recordings").json() == []
    assert "No recording yet" in client.get("/machines/a%2Fb%20c/recordings").text


def test_a_recording_says_what_rests_on_it(client: TestClient, number: int) -> None:
    said = client.get(f"{API}/{MACHINE}/recordings/{number}").json()
    assert said["seen"]["learnt_from"]
    assert said["seen"]["cuts"] > 0
    kinds = {one["kind"] for one in said["resting"]}
    assert "parameters" in kinds
    page = client.get(f"/{MACHINE}/recordings/{number}").text
    for one in said["resting"]:
        assert one["words"] in page


def test_another_machine_does_not_have_it(client: TestClient, number: int) -> None:
    other = client.get(f"{API}/machines/a%2Fb%20c/recordings/{number}")
    assert other.status_code == 404
    assert f"has no recording {number}" in detail(other)
    assert client.get(f"/machines/a%2Fb%20c/recordings/{number}/plot").status_code == 404


def test_withdrawing_takes_back_what_rests_on_it(url: str, store: Store, number: int) -> None:
    operates = bearer(add_token(store, "anna", "operate", days=1))
    path = f"{API}/{MACHINE}/recordings/{number}"
    with client_of(url, writes=True) as client:
        assert client.post(f"{path}/withdraw", json={"why": "a test"}).status_code == 401
        assert client.post(f"{path}/withdraw", headers=operates).status_code == 422
        done = client.post(f"{path}/withdraw", json={"why": "another tool"}, headers=operates)
        assert done.status_code == 200
        assert any("version 1" in one for one in done.json()["taken_back"])
        said = client.get(path).json()
        assert (said["seen"]["state"], said["withdrawn_why"]) == ("withdrawn", "another tool")
        assert all(one["undone"] for one in said["resting"])
        again = client.post(f"{path}/take-again", headers=operates)
        assert again.json()["cuts"] == said["seen"]["cuts"]
        assert client.get(path).json()["seen"]["state"] == "used"
    with store.reading() as session:
        actions = session.scalars(select(models.AuditEntry.action)).all()
    assert actions[-2:] == ["recording withdrawn", "recording taken again"]


def test_a_page_withdraws_with_a_reason_by_who_may(url: str, store: Store, number: int) -> None:
    tokens = {role: add_token(store, role, role, days=1) for role in ("read", "operate")}
    path = f"/{MACHINE}/recordings/{number}"
    word = {"word": "withdraw", "why": "the wrong tool", "sure": "yes"}
    with client_of(url, writes=True) as client:
        assert client.post(path, data=word).status_code == 401
        for role, status in (("read", 403), ("operate", 303)):
            client.post("/sign-in", data={"token": tokens[role]})
            found = re.search(r'data-csrf="([^"]+)"', client.get("/").text)
            assert found is not None
            mark = {"csrf": found[1]}
            assert client.post(path, data=word).status_code == 403
            if role == "operate":
                for lacking in ("why", "sure"):
                    less = word | mark | {lacking: ""}
                    refused = client.post(path, data=less)
                    assert (refused.status_code, "say why" in refused.text) == (422, True)
                assert client.post(path, data=word | mark | {"word": "x"}).status_code == 422
            got = client.post(path, data=word | mark, follow_redirects=False)
            assert got.status_code == status
        shown = client.get(path).text
        assert "the wrong tool" in shown
        assert "Take it again" in shown
        assert "taken back" in shown
        assert client.post(path, data={"word": "take-again"} | mark).status_code == 200
    with client_of(url) as client:
        assert "read-only" in client.get(path).text
