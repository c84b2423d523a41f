"""Stability over the service: what the command says, and what is refused in one line."""

import json
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from autodb.agent.answer.bounds.stable import stable_cuts
from autodb.agent.answer.looking_up import PairReader
from autodb.errors import UnusableInput
from autodb.files.job import Job
from autodb.forward.stability.dynamics import read_tool_point
from autodb.store import Store
from autodb.web.client import Client
from autodb.web.http.settings import Settings
from tests.helpers.asked import API, CUT, detail
from tests.helpers.serving import served

ASKED = f"{API}/machines/lathe-0/stability"
MODE = b"""[[mode]]
axis = "x"
frequency_Hz = 603.0
damping_ratio = 0.039
stiffness_N_m = 5.59e6
"""
PROGRAM = {"file": "/etc/passwd", "stock_diameter_mm": 9.0}


def _job(pair: dict[str, str]) -> dict[str, Any]:
    return {"name": "j", **pair, "cut": [CUT, CUT | {"name": "fine", "depth_mm": 0.5}]}


def test_what_is_answered_is_what_the_library_says(
    url: str, store: Store, pair: dict[str, str], tmp_path: Path
) -> None:
    """Over HTTP, by the client; a depth that nothing limits comes back as none."""
    path = tmp_path / "point.toml"
    path.write_bytes(MODE)
    job = Job.model_validate(_job(pair))
    with store.reading() as session:
        basis = PairReader(session, "lathe-0").basis(job.material, job.tool)
        alone = stable_cuts(basis, job, read_tool_point(path))
    with served(Settings(url)) as at, Client(at) as client:
        found = client.stability("lathe-0", job, path)
        with pytest.raises(UnusableInput, match="cannot be"):
            client.stability("lathe-0", job, tmp_path / "cannot be.toml")
    assert [one.stable for one in found] == [one.stable for one in alone]
    assert all(one.loads is None and "states no limit" in one.why for one in found)


@pytest.mark.parametrize(
    ("change", "point", "said"),
    [
        ({}, ("point.csv", b"frequency_Hz,x_real_m_N\n"), "point.csv: needs the columns"),
        ({"cut": [CUT | {"depth_mm": -1.0}]}, ("p.toml", MODE), "job: cut.0"),
        ({"cut": None, "program": PROGRAM}, ("p.toml", MODE), "job: program: no depth of a"),
        ({}, None, "dynamics: missing; send job and dynamics"),
    ],
)  # fmt: skip
def test_what_cannot_be_answered_is_refused_in_one_line(
    client: TestClient,
    pair: dict[str, str],
    change: dict[str, Any],
    point: tuple[str, bytes] | None,
    said: str,
) -> None:
    stated = {key: one for key, one in (_job(pair) | change).items() if one is not None}
    files: dict[str, Any] = {"job": (None, json.dumps(stated))}
    if point is not None:
        files["dynamics"] = point
    got = client.post(ASKED, files=files)
    assert (got.status_code, said in detail(got)) == (422, True), got.text
