"""Parameters are learnt and used per operation; what stands still is not sensed, never zero."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sqlalchemy import select

from autodb.records.tables import CutTable
from autodb.sensing.ranges import feeding
from autodb.store import models, open_store
from tests.conftest import Cli

pytestmark = pytest.mark.usefixtures("one_law")

HEAD = 'name = "j"\nmaterial = "steel bar"\ntool = "carbide insert"\n'
FACE = (
    '[[cut]]\nname = "face"\noperation = "face"\ndiameter_mm = 60\ndepth_mm = 0.8\n'
    "feed_mm_rev = 0.15\nspeed_rpm = 1200\n"
)
TURN = (
    '[[cut]]\nname = "turn"\ndiameter_mm = 56\ndepth_mm = 1.5\n'
    "feed_mm_rev = 0.2\nspeed_rpm = 1200\n"
)


@pytest.fixture
def learnt(standard_learnt: Cli) -> Cli:
    """Return the command line on a machine that has learnt turning and facing."""
    return standard_learnt


def _predict(learnt: Cli, text: str) -> dict[str, Any]:
    Path("job.toml").write_text(HEAD + text)
    done = learnt("predict", "job.toml", "--machine", "lathe-1", "--json")
    answer: dict[str, Any] = json.loads(done.out)
    return answer


def test_facing_is_predicted_from_facing_and_holds_the_truth(learnt: Cli) -> None:
    """The virtual lathe's forces in facing lie in the intervals, passive ones too: measured.

    One pinned cut with fixed recordings, not a claim about every cut.
    """
    from autodb.proofs.machines.lathe.jobs import cut_at
    from autodb.proofs.machines.sample import job_forces_N

    answer = _predict(learnt, FACE + TURN)
    faced, turned = answer["cuts"]
    truth = job_forces_N([cut_at((0.8, 0.15, 1200.0, 60.0), operation="face")])[0]
    for component, force in zip("xyz", truth, strict=True):
        found = faced[f"force_{component}_N"]
        assert found["low"] < force < found["high"], component
    assert (faced["passive"], turned["passive"]) == (None, None)
    assert answer["behind"]["cuts"] == 32


def test_the_torque_arm_in_facing_is_the_radius_itself(learnt: Cli) -> None:
    faced, turned = _predict(learnt, FACE + TURN)["cuts"]
    assert_allclose(faced["torque_N_m"]["value"], faced["force_y_N"]["value"] * 30.0 / 1000.0)
    arm_mm = 28.0 + 0.75
    assert_allclose(turned["torque_N_m"]["value"], turned["force_y_N"]["value"] * arm_mm / 1000.0)


def test_what_stands_still_is_not_sensed_and_one_posterior_learns_from_all(learnt: Cli) -> None:
    del learnt
    store = open_store("sqlite:///autodb.sqlite3")
    with store.reading() as session:
        (row,) = session.scalars(select(models.CuttingParameters))
        assert {force.cut.operation for force in row.forces} == {"turn", "face"}
        assert {force.component for force in row.forces} == {"x", "y", "z"}
        passive = {"turn": "x", "face": "z"}
        forces = session.scalars(select(models.SensedForce)).all()
        sensed = [f for f in forces if f.errors is None]
        still = [f for f in sensed if f.component == passive[str(f.cut.operation)]]
        assert len(still) == 32
        assert all(f.value_N is None and "stands still" in str(f.reason) for f in still)
    store.close()


def test_an_operation_never_cut_is_predicted_wider_and_says_so(learnt: Cli) -> None:
    """A taper from turning and facing; one without a direction is refused."""
    bare = FACE.replace('"face"\nd', '"taper"\nd')
    taper = bare.replace("depth_mm", "direction_deg = 20\ndepth_mm")
    answer = _predict(learnt, TURN + taper)
    turned, tapered = answer["cuts"]
    assert _width(tapered["force_y_N"]) > _width(turned["force_y_N"])
    alone = "its forces come from the law alone, with wider intervals"
    assert f"operation 'taper' was never cut; {alone}" in answer["notes"]
    refused = learnt("predict", _job(bare), "--machine", "lathe-1")
    assert refused.code == 2
    assert "operation 'taper' needs direction_deg" in refused.err


def _width(interval: dict[str, float]) -> float:
    return (interval["high"] - interval["low"]) / interval["value"]


def test_in_a_taper_both_axes_feed_and_are_sensed() -> None:
    """Only the axis that stands still is not sensed: turning x, facing z, in the others none."""
    n = 4
    table = CutTable(
        path=Path("cuts.csv"),
        channels={"cut": np.arange(float(n))},
        texts={"operation": ["turn", "face", "taper", "contour"]},
    )
    assert feeding.moving(table, "x").tolist() == [False, True, True, True]
    assert feeding.moving(table, "z").tolist() == [True, False, True, True]


def test_a_version_taken_back_is_not_used_and_its_number_not_given_again(learnt: Cli) -> None:
    store = open_store("sqlite:///autodb.sqlite3")
    with store.writing() as session:
        for row in session.scalars(select(models.CuttingParameters)):
            row.undone_at = "2026-01-01T00:00:00+00:00"
    store.close()
    assert "has no parameters of" in learnt("predict", _job(FACE), "--machine", "lathe-1").out
    assert "carbide insert: version 2" in learnt("refresh", "--machine", "lathe-1").out


def _job(text: str) -> Path:
    Path("job.toml").write_text(HEAD + text)
    return Path("job.toml")


def test_a_face_may_end_at_the_centre(learnt: Cli) -> None:
    to_the_centre = FACE.replace("depth_mm", "end_diameter_mm = 0\ndepth_mm")
    (whole,), (start,) = (_predict(learnt, one)["cuts"] for one in (to_the_centre, FACE))
    for name in ("force_y_N", "torque_N_m", "power_W"):
        assert whole["start"][name] == start[name]
    refused = learnt("predict", _job(TURN + "end_diameter_mm = 40\n"), "--machine", "lathe-1")
    assert "operation 'turn' has no end_diameter_mm" in refused.err
