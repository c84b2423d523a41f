"""Terms left out of least-squares models of public axes are named, at their size.

The full model is the truth; where rows left out are predicted decidably worse without the term, and
which names are fair, is in each case's truth.json.
"""

import json
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from autodb.explain import explain
from autodb.explain.answer import Cause, ChannelAnswer
from autodb.records import source as records
from tests.conftest import shared
from tests.helpers.campaigns import first

SURE, HALF = 0.9, 0.5
AXES = first(2, [
    "laas-acc-no_viscous-kept", "tx40-j1-no_coulomb-refit", "laas-acc-no_coulomb-kept",
    "laas-acc-no_coulomb-refit", "laas-acc-no_inertia-kept", "laas-acc-no_inertia-refit",
    "laas-map-no_cogging-kept", "laas-map-no_cogging-refit", "laas-roll-no_cogging-kept",
    "smart-x-no_coulomb-kept", "smart-x-no_coulomb-refit", "smart-y-no_coulomb-refit",
    "tiago-torso-no_coulomb-kept", "tiago-torso-no_gravity-kept", "tiago-torso-no_gravity-refit",
    "tx40-j1-no_inertia-kept", "tx40-j4-no_coulomb-kept", "tx40-j4-no_viscous-refit",
])  # fmt: skip


@cache
def _found(name: str) -> tuple[dict[str, Any], ChannelAnswer]:
    folder = shared("data", "real", name)
    truth = json.loads((folder / "truth.json").read_text("utf-8"))
    recording, simulation = _read(folder, "recording"), _read(folder, "simulation")
    found = explain(recording, simulation, includes=truth["includes"]).explanation.channels
    (answer,) = found.values()
    return truth, answer


def _read(folder: Path, name: str) -> Any:
    return records.read(folder / f"{name}.csv")


def _size(cause: Cause) -> float:
    return cause.parameters["size"].value


@pytest.mark.parametrize("name", AXES)
def test_what_was_left_out_of_a_public_axis_is_named_with_its_size(name: str) -> None:
    truth, answer = _found(name)
    missing = [c for c in answer.missing if c.kind == "missing" and c.confidence >= HALF]
    fair = [_size(c) / truth["true_size"] for c in missing if c.term in truth["fair"]]
    assert any(0.5 < ratio < 2.0 for ratio in fair)
    assert answer.fit.heldout_after < answer.fit.heldout_before


def test_at_one_frequency_a_shift_is_an_alternative_of_viscous_friction() -> None:
    """Velocity is there what jerk is, so that an effort logged late looks as an oil film does."""
    _, answer = _found("laas-acc-no_viscous-kept")
    (viscous,) = [c for c in answer.missing if c.term == "viscous"]
    assert viscous.confidence >= SURE
    assert viscous.alternatives == ("lag",)
    assert not {"lag", "compliance", "saturation"} & {c.term for c in answer.missing}


def test_pushes_beside_dry_friction_leave_it_its_name() -> None:
    """A curve over speed does more than all three where the pushes' rows are predicted from rows
    without them, which nothing can."""
    _, answer = _found("tx40-j1-no_coulomb-refit")
    (dry,) = [c for c in answer.missing if c.term == "coulomb"]
    assert dry.confidence >= SURE
    assert "external_load" in {c.term for c in answer.missing}
