"""The service keeps to its document: whatever is asked, an answer that stands there, and no error.

Every operation is asked with what its document allows, of what is in the database and of anything,
and with what it does not allow. A few seconds; `AUTODB_CONTRACT=10` asks ten times as much,
something else each time.
"""

import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import requests
import schemathesis
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis.errors import Unsatisfiable
from schemathesis import GenerationMode
from schemathesis.checks import CHECKS, load_all_checks
from schemathesis.core.failures import FailureGroup

from autodb.agent.answer.looking_up import PairReader
from autodb.agent.operate.access import add_token
from autodb.agent.operate.changed_edges import change_edge
from autodb.agent.operate.refreshing import refresh
from autodb.agent.rows.machines import add_machine, as_file, find_machine, update_machine
from autodb.files.machine import LATHE, AxisFile, AxisLimits
from autodb.proofs.machines.lathe import fleets
from autodb.store import create_store, models, open_store
from autodb.web.http.settings import RequestLimits, Settings
from autodb.web.routes.asked import EXAMPLES
from tests.helpers import shops
from tests.helpers.serving import served

TIMES = int(os.environ.get("AUTODB_CONTRACT", "1"))
REQUESTS = 2
"""Requests of an operation, of each of three kinds."""
NAMES = (
    "not_a_server_error", "status_code_conformance", "content_type_conformance",
    "response_schema_conformance", "response_headers_conformance",
)  # fmt: skip
API = "/api/v1"
SENT = (
    f"POST {API}/machines/{{machine}}/recordings",
    f"POST {API}/machines/{{machine}}/predict/program",
    f"POST {API}/machines/{{machine}}/stability",
)
LIFE = f"POST {API}/machines/{{machine}}/life"
LIVES = f"POST {API}/machines/{{machine}}/lives"
"""Drawn jobs seldom are of a kind that these take."""
CHANGES = f"POST {API}/machines/{{machine}}/edges"
IMPORT = f"GET {API}/imports/{{number}}"


@pytest.fixture(scope="module")
def known(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return what is in a database: a machine, a pair that it has learnt, who may do all."""
    url = f"sqlite:///{tmp_path_factory.mktemp('contract') / 'made.sqlite3'}"
    create_store(url)
    store = open_store(url)
    rng = np.random.default_rng(3)
    fleet = fleets.draw_fleet(rng, materials=1, tools=1)
    key = (fleet.materials[0], fleet.tools[0])
    shops.add(store, "lathe-0", fleets.on_machine(rng, fleet, [key]), cuts=8, rng=rng)
    add_machine(store, "a/b c", LATHE)
    refresh(store, "lathe-0")
    with store.reading() as session:
        file = as_file(find_machine(session, "lathe-0"))
    limited = AxisFile(carries="work", limits=AxisLimits(torque_N_m=200.0))
    update_machine(
        store, "lathe-0", file.model_copy(update={"axes": {**file.axes, "spindle": limited}})
    )
    with store.writing() as session:
        drifts = models.Mismatch(
            recording_id=1, channel="z.current", term="sensor_drift", kind="missing",
            confidence=0.9, parameters={}, statement="The reading drifts.", alternatives=[],
        )  # fmt: skip
        session.add(drifts)
    with store.reading() as session:
        pair = PairReader(session, "lathe-0").pairs()[0]
    change_edge(store, "lathe-0", pair.tool)
    token = add_token(store, "all", "admin", days=1)
    store.close()
    return {"url": url, "token": token, "material": pair.material, "tool": pair.tool}


@dataclass(frozen=True)
class Served:
    """A service, the operations of its document by what they are called, and who may do all."""

    at: str
    operations: dict[str, Any]
    headers: dict[str, str]


@pytest.fixture(scope="module")
def service(known: dict[str, str]) -> Iterator[Served]:
    """Return a service that answers on loopback."""
    limits = RequestLimits(a_minute=10**6, waiting=10**6)
    headers = {"Authorization": f"Bearer {known['token']}"}
    with served(Settings(known["url"], writes=True, limits=limits)) as at:
        schema = schemathesis.openapi.from_url(f"{at}{API}/openapi.json")
        found = [one.ok() for one in schema.get_all_operations()]  # type: ignore[union-attr]
        yield Served(at, {one.label: one for one in found}, headers)


LAST = ("POST /api/v1/machines/{machine}/recordings/{number}/withdraw",)


def _strategies(operation: Any, known: dict[str, str]) -> Iterator[Any]:
    """Give what an operation may be asked: anything, and of what is known."""
    yield operation.as_strategy(GenerationMode.POSITIVE)
    there = {"machine": "lathe-0", "number": 1, "kind": "parameters", "name": known["tool"]}
    path = {one: value for one, value in there.items() if f"{{{one}}}" in operation.path}
    asked = {one.name for one in operation.query}
    about = {one: known[one] for one in ("material", "tool") if one in asked}
    query = about | {one: value for one, value in EXAMPLES.items() if one in asked}
    if path:
        body = {"body": {"tool": known["tool"]}} if operation.label == CHANGES else {}
        yield operation.as_strategy(
            GenerationMode.POSITIVE, path_parameters=path, query=query or None, **body
        )


def _asked(service: Served, strategy: Any, wrong: list[str]) -> set[int]:
    """Ask what a strategy gives; note what is wrong with answers, and return their statuses."""
    checks, statuses = [CHECKS.get_one(name) for name in NAMES], set()

    @settings(
        max_examples=REQUESTS * TIMES,
        derandomize=TIMES == 1,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
        phases=[Phase.generate],
    )
    @given(case=strategy)
    def ask(case: Any) -> None:
        response = case.call(headers=service.headers)
        statuses.add(response.status_code)
        try:
            case.validate_response(response, checks=checks)
        except FailureGroup as error:
            wrong.append(f"{error}: {response.status_code} {response.text[:300]}")

    ask()
    return statuses


def _asked_wrongly(service: Served, operation: Any, wrong: list[str]) -> set[int]:
    """Ask what is not allowed; nothing where nothing can be said wrongly: a name is any text."""
    try:
        return _asked(service, operation.as_strategy(GenerationMode.NEGATIVE), wrong)
    except Unsatisfiable:
        return set()


def test_every_answer_is_one_of_the_document(service: Served, known: dict[str, str]) -> None:
    load_all_checks()
    schemathesis.serializer("application/x-ndjson")(lambda _, value: str(value).encode())
    wrong: list[str] = []
    without = set()
    # what is withdrawn takes what others ask for with it
    for operation in sorted(service.operations.values(), key=lambda one: one.label in LAST):
        statuses = [_asked(service, one, wrong) for one in _strategies(operation, known)]
        _asked_wrongly(service, operation, wrong)
        if not any(status < 300 for some in statuses for status in some):
            without.add(operation.label)
    assert wrong == []
    # a file of an ending that texts have may be made up, and is taken to be read later
    assert {*SENT[1:], IMPORT} <= without <= {*SENT, IMPORT, LIFE, LIVES}


def test_what_comes_of_files_that_are_sent_is_of_the_document(
    service: Served, known: dict[str, str], sample_jobs: Path
) -> None:
    """Nothing makes files up that can be read: these are real ones."""
    week = (sample_jobs / "stepped_shaft/recordings/shop-week-1.csv").read_bytes()
    program = (sample_jobs / "nc_profile/part.nc").read_bytes()
    job = {"name": "shaft", "material": known["material"], "tool": known["tool"],
           "program": {"stock_diameter_mm": 60.0, "stock_face_mm": 2.0}}  # fmt: skip
    with requests.Session() as client:
        client.headers.update(service.headers)
        at = f"{service.at}{API}/machines/lathe-0"
        sent = client.post(f"{at}/recordings", files={"recording": ("1.csv", week)})
        predicted = client.post(
            f"{at}/predict/program",
            data={"job": json.dumps(job)},
            files={"program": ("part.nc", program)},
        )
        cuts: Any = {**job, "program": None, "cut": [EXAMPLES]}
        mode = (
            b'[[mode]]\naxis = "x"\nfrequency_Hz = 603\ndamping_ratio = 0.04\nstiffness_N_m = 6e6'
        )
        stable = client.post(
            f"{at}/stability",
            data={"job": json.dumps(cuts)},
            files={"dynamics": ("point.toml", mode)},
        )
        importing = client.get(service.at + sent.headers["location"])
        limit = {"limit": "force.z=900"}
        lasting = client.post(f"{at}/life", json=cuts, params=limit)
        together = client.post(f"{at}/lives", json={"jobs": [cuts]}, params=limit)
    answers = (sent, predicted, stable, importing, lasting, together)
    assert [one.status_code for one in answers] == [202, 200, 200, 200, 200, 200]
    for label, answer in zip((*SENT, IMPORT, LIFE, LIVES), answers, strict=True):
        service.operations[label].validate_response(answer)
