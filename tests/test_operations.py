"""Parameters are learnt and used per operation; what stands still is not sensed, never zero."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sqlalchemy import select

from autodb.records import CutTable
from autodb.sensing import ranges
from autodb.store import models, open_store
from tests.conftest import Cli

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
def learnt(cli: Cli, sample_jobs: Path) -> Cli:
    """Return the command line on a machine that has learnt turning and facing."""
    recordings = sample_jobs / "stepped_shaft" / "recordings"
    cli("init")
    cli("machine", "add", "lathe-1")
    cli("import", recordings / "standard-cuts.csv", "--machine", "lathe-1")
    cli("calibrate", "--machine", "lathe-1")
    assert cli("refresh", "--machine", "lathe-1").code == 0
    return cli


def _predict(learnt: Cli, text: str) -> dict[str, Any]:
    Path("job.toml").write_text(HEAD + text)
    done = learnt("predict", "job.toml", "--machine", "lathe-1", "--json")
    answer: dict[str, Any] = json.loads(done.out)
    return answer


def test_facing_is_predicted_from_facing_and_holds_the_truth(learnt: Cli) -> None:
    """The virtual lathe's forces in facing lie in the intervals; z is passive, so it is not sensed.

    One pinned cut with fixed recordings, not a claim about every cut.
    """
    from autodb.virtual.jobs import cut_at
    from autodb.virtual.sample import job_forces_N

    answer = _predict(learnt, FACE + TURN)
    faced, turned = answer["cuts"]
    truth = job_forces_N([cut_at((0.8, 0.15, 1200.0, 60.0), operation="face")])[0]
    for component, force in zip("xy", truth, strict=False):
        found = faced[f"force_{component}_N"]
        assert found["low"] < force < found["high"], component
    assert faced["force_z_N"] is None
    assert turned["force_x_N"] is None
    assert set(answer["behind"]["face"]) == {"x", "y"}
    assert set(answer["behind"]["turn"]) == {"y", "z"}


def test_the_torque_arm_in_facing_is_the_radius_itself(learnt: Cli) -> None:
    faced, turned = _predict(learnt, FACE + TURN)["cuts"]
    assert_allclose(faced["torque_N_m"]["value"], faced["force_y_N"]["value"] * 30.0 / 1000.0)
    arm_mm = 28.0 + 0.75
    assert_allclose(turned["torque_N_m"]["value"], turned["force_y_N"]["value"] * arm_mm / 1000.0)


def test_each_operation_learns_from_its_own_cuts_only(learnt: Cli) -> None:
    del learnt
    store = open_store("sqlite:///autodb.sqlite3")
    with store.reading() as session:
        for row in session.scalars(select(models.CuttingParameters)):
            assert {force.cut.operation for force in row.forces} == {row.operation}
        passive = {"turn": "x", "face": "z"}
        forces = session.scalars(select(models.SensedForce)).all()
        still = [f for f in forces if f.component == passive[str(f.cut.operation)]]
        assert len(still) == 32
        assert all(f.value_N is None and "stands still" in str(f.reason) for f in still)
    store.close()


def test_an_operation_never_cut_is_refused_naming_those_that_were(
    learnt: Cli, refused: Callable[..., str]
) -> None:
    del learnt
    Path("job.toml").write_text(HEAD + TURN + FACE.replace('"face"\nd', '"taper"\nd'))
    line = refused("predict", "job.toml", "--machine", "lathe-1")
    assert (
        "never cut steel bar / carbide insert in operation 'taper'; it has cut: turn, face" in line
    )


def test_in_a_taper_both_axes_feed_and_are_sensed() -> None:
    """Only the axis that stands still is not sensed: turning x, facing z, in the others none."""
    n = 4
    table = CutTable(
        path=Path("cuts.csv"),
        channels={"cut": np.arange(float(n))},
        texts={"operation": ["turn", "face", "taper", "contour"]},
    )
    assert ranges.moving(table, "x").tolist() == [False, True, True, True]
    assert ranges.moving(table, "z").tolist() == [True, False, True, True]


def test_a_version_taken_back_is_not_used_and_its_number_not_given_again(learnt: Cli) -> None:
    store = open_store("sqlite:///autodb.sqlite3")
    with store.writing() as session:
        query = select(models.CuttingParameters).where(models.CuttingParameters.operation == "face")
        for row in session.scalars(query):
            row.undone_at = "2026-01-01T00:00:00+00:00"
    store.close()
    assert "has no parameters" in learnt("predict", _job(FACE), "--machine", "lathe-1").err
    assert "face: force.x version 2" in learnt("refresh", "--machine", "lathe-1").out


def _job(text: str) -> Path:
    Path("job.toml").write_text(HEAD + text)
    return Path("job.toml")


def test_a_face_may_end_at_the_centre(learnt: Cli) -> None:
    to_the_centre = FACE.replace("depth_mm", "end_diameter_mm = 0\ndepth_mm")
    assert _predict(learnt, to_the_centre)["cuts"] == _predict(learnt, FACE)["cuts"]
    refused = learnt("predict", _job(TURN + "end_diameter_mm = 40\n"), "--machine", "lathe-1")
    assert "keeps its diameter" in refused.err
