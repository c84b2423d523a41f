"""Look-ups, predictions and batches: what is answered, and what is refused in one line."""

import json
from dataclasses import asdict, replace
from itertools import product

import pytest
from fastapi.testclient import TestClient
from numpy.testing import assert_allclose
from pydantic import TypeAdapter

from autodb.agent.answer.bounds.lives import AskedLife, ToolLives, tool_lives
from autodb.agent.answer.looking_up import PairReader
from autodb.agent.answer.predicting import JobAnswer
from autodb.agent.answer.prediction_basis import LookedUp, PredictionBasis
from autodb.agent.operate.access import add_token
from autodb.files.channels import largest_of
from autodb.files.job import Job
from autodb.files.job_cut import LEAST, MOST_CUT, JobCut
from autodb.store import Store, models
from tests.helpers.asked import API, CUT, MILLED, batch, bearer, client_of, detail
from tests.helpers.worn_pairs import worn_posterior

SIX_DIGITS = 1e-6


def test_a_look_up_is_what_the_library_says(
    client: TestClient, store: Store, pair: dict[str, str]
) -> None:
    got = client.get(f"{API}/machines/lathe-0/lookup", params=pair | CUT)
    assert got.status_code == 200
    with store.reading() as session:
        found = PairReader(session, "lathe-0").look_up(**pair, cut=JobCut.model_validate(CUT))
    assert TypeAdapter(LookedUp).validate_json(got.content) == found


def test_a_pair_never_cut_is_answered_and_said(client: TestClient) -> None:
    asked = {"material": "unheard of", "tool": "any"} | CUT
    got = client.get(f"{API}/machines/a%2Fb%20c/lookup", params=asked)
    assert got.status_code == 200
    assert "has no parameters of unheard of / any" in got.json()["notes"][0]


@pytest.mark.parametrize(
    ("change", "status", "said"),
    [
        ({"depth_mm": "deep"}, 422, "depth_mm: 'deep' is not a number"),
        ({"depth_mm": "-1"}, 422, "depth_mm: must be greater than 0, not"),
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
    assert said in detail(got)


BEYOND = [
    ({"depth_mm": 1e308}, "depth_mm: must be at most 1000, not 1e+308"),
    ({"feed_mm_rev": 1e5}, "feed_mm_rev: must be at most 1000, not 100000"),
    ({"speed_m_min": 1e7}, "speed_m_min: must be at most 100000, not 10000000"),
    ({"diameter_mm": 1e308}, "diameter_mm: must be at most 100000, not 1e+308"),
    ({"cutting_time_s": 1e300}, "cutting_time_s: must be at most 100000000, not 1e+300"),
    ({"depth_mm": 1e-308}, "depth_mm: 1e-308 is below any machine; use at least 1e-06"),
]


@pytest.mark.parametrize(("change", "said"), BEYOND)
def test_what_no_machine_does_is_refused_in_the_same_words_everywhere(
    url: str, store: Store, pair: dict[str, str], change: dict[str, float], said: str
) -> None:
    """By a look-up, a batch, a job that is kept or not, and on the planner's page."""
    cut, at = CUT | change, f"{API}/machines/lathe-0"
    operates = bearer(add_token(store, "shop", "operate", days=1))
    job = {"name": "j", **pair, "cut": [CUT, cut]}
    with client_of(url, writes=True) as client:
        assert detail(client.get(f"{at}/lookup", params=pair | cut)) == said
        row, end = batch(client, pair, [json.dumps(cut)])
        assert (row["problem"], end) == (said, {"answered": 0, "refused": 1})
        for path in ("predict", "predictions"):
            got = client.post(f"{at}/{path}", json=job, headers=operates)
            assert (got.status_code, detail(got)) == (422, f"cut.1.{said}")
        page = client.get("/machines/lathe-0/plan", params=pair | cut)
        assert f"cut 1: {said}" in page.text


def test_the_furthest_that_is_taken_is_answered(client: TestClient, pair: dict[str, str]) -> None:
    ends = {
        "diameter_mm": (LEAST, largest_of("work.diameter")),
        "depth_mm": (LEAST, MOST_CUT["turning_insert"]["depth_mm"]),
        "feed_mm_rev": (LEAST, MOST_CUT["turning_insert"]["feed_mm_rev"]),
        "speed_m_min": (LEAST, largest_of("cutting.speed")),
    }
    for stated in product(*ends.values()):
        cut = CUT | dict(zip(ends, stated, strict=True))
        got = client.get(f"{API}/machines/lathe-0/lookup", params=pair | cut)
        assert got.status_code == 200, cut


@pytest.mark.parametrize(("key", "value"), [("depth_mm", 40.0), ("feed_mm_rev", 300.0)])
def test_what_no_tool_cuts_is_refused(
    client: TestClient, pair: dict[str, str], key: str, value: float
) -> None:
    got = client.get(f"{API}/machines/lathe-0/lookup", params=pair | CUT | {key: value})
    assert got.status_code == 422
    assert f"{key} {value:g} is beyond what a tool of operation 'turn' cuts" in detail(got)


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


def test_the_life_of_an_edge_is_asked_for(
    client: TestClient, pair: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the pair as it is, which learnt no wear, and with one that is known."""
    asked = f"{API}/machines/lathe-0/life"
    job = {"name": "j", **pair, "cut": [CUT | {"length_mm": 50.0}]}
    limit: dict[str, str | int] = {"limit": "torque.spindle=25", "sure": 90}
    answer = client.post(asked, json=job, params=limit).json()
    assert answer["lives"] == []
    assert "no wear was learnt" in answer["why"]
    wears = worn_posterior()
    monkeypatch.setattr(
        PredictionBasis, "of_lot", lambda self, _: replace(
            self, states=None, known=replace(self.known, posterior=wears)
        ),
    )  # fmt: skip
    answer = client.post(asked, json=job, params=limit).json()
    assert answer["why"] is None
    assert [one["channel"] for one in answer["lives"]] == ["torque.spindle"]
    assert answer["sure"] == 0.9
    for bad, said in (
        ("torque=25", "spindle"),
        ("torque.spindle", "spindle"),
        ("force.z=0", "above 0"),
    ):
        got = client.post(asked, json=job, params={"limit": bad})
        assert got.status_code == 422
        assert said in detail(got)


def test_the_lives_of_a_parts_edges_are_asked_for(
    client: TestClient, store: Store, pair: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    wears = worn_posterior()
    monkeypatch.setattr(
        PredictionBasis, "of_lot", lambda self, _: replace(
            self, states=None, known=replace(self.known, posterior=wears)
        ),
    )  # fmt: skip
    cuts = [CUT | {"length_mm": length} for length in (50.0, 400.0)]
    jobs = [{"name": f"j{k}", **pair, "cut": [cut]} for k, cut in enumerate(cuts)]
    asked = f"{API}/machines/lathe-0/lives"
    limit: dict[str, str | int] = {"limit": "torque.spindle=40", "sure": 90}
    got = client.post(asked, json={"jobs": jobs}, params=limit)
    assert got.status_code == 200, got.text
    answer = TypeAdapter(ToolLives).validate_json(got.content)
    with store.reading() as session:
        basis = PairReader(session, "lathe-0").basis(**pair)
        read = [Job.model_validate(job) for job in jobs]
        ours = tool_lives(
            [AskedLife(basis, job) for job in read], limits={"torque.spindle": 40.0}, sure=0.9
        )
    assert answer == ours
    assert answer.first is not None
    assert answer.first.edge == answer.edges[1].edge  # the longer cut
    for bad in ([], jobs * 20, [jobs[0] | {"cut": []}]):
        got = client.post(asked, json={"jobs": bad}, params=limit)
        assert got.status_code == 422
    of_none = client.post(asked, json={"jobs": jobs}, params={"limit": "other:force.z=900"})
    assert of_none.status_code == 422
    assert "other" in detail(of_none)


def test_a_job_that_names_a_file_is_refused(client: TestClient, pair: dict[str, str]) -> None:
    program = {"file": "/etc/passwd", "stock_diameter_mm": 50.0}
    job = {"name": "j", **pair, "program": program}
    got = client.post(f"{API}/machines/lathe-0/predict", json=job)
    assert got.status_code == 422
    assert "send a job with cuts" in detail(got)
    assert "root:" not in got.text


def test_a_batch_answers_each_line_as_a_look_up_does(
    client: TestClient, store: Store, pair: dict[str, str]
) -> None:
    cuts = [CUT | {"depth_mm": 0.5 + 0.01 * k} for k in range(600)]
    *rows, end = batch(client, pair, [json.dumps(cut) for cut in cuts])
    assert end == {"answered": 600, "refused": 0}
    assert [row["row"] for row in rows] == list(range(1, 601))
    with store.reading() as session:
        pair_reader = PairReader(session, "lathe-0")
        for k in (0, 299, 599):
            one = asdict(pair_reader.look_up(**pair, cut=JobCut.model_validate(cuts[k])).cut)
            for name in ("force_y_N", "force_z_N", "torque_N_m"):
                found, alone = rows[k]["cut"][name], one[name]
                assert_allclose(list(found.values()), list(alone.values()), rtol=SIX_DIGITS)


def test_a_line_that_cannot_be_answered_spoils_no_other(
    client: TestClient, pair: dict[str, str]
) -> None:
    lines = [json.dumps(CUT), "{", json.dumps(CUT | {"depth_mm": 0.0}), json.dumps(MILLED),
             "x" * 5000, "", json.dumps(CUT)]  # fmt: skip
    *rows, end = batch(client, pair, lines)
    assert end == {"answered": 2, "refused": 4}
    assert [row["row"] for row in rows if "cut" in row] == [1, 6]
    said = [row["problem"] for row in rows if "problem" in row]
    assert ["JSON" in said[0], "depth_mm" in said[1], "longer than" in said[3]] == [True] * 3
    assert rows[0]["cut"] == rows[5]["cut"]
