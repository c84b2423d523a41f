"""Predictions hold what excluded cuts showed, and say why, until a person decides."""

import json
from pathlib import Path

import pytest

from autodb.proofs.machines.lathe.lathe import TrueCut, mean_forces_N
from autodb.proofs.machines.lathe.process import STEEL
from tests.agent.conftest import MACHINE
from tests.conftest import Cli

pytestmark = pytest.mark.usefixtures("one_law")

PAIR = ("--material", "steel bar", "--tool", "carbide insert")
OLD_S = 1100.0
JOB = """
name = "shaft"
material = "steel bar"
tool = "carbide insert"
[[cut]]
diameter_mm = 50
depth_mm = 1.5
feed_mm_rev = 0.2
speed_m_min = 220
cutting_time_s = 1100
"""


@pytest.fixture
def waiting(worn_days: Cli) -> Cli:
    """Return the command line on a lathe whose worn week's mismatches nobody has decided on."""

    Path("job.toml").write_text(JOB)
    return worn_days


def looked_up(cli: Cli, cutting_time_s: float = OLD_S) -> tuple[dict[str, list[float]], list[str]]:
    """Return forces by component, as [value, low, high], and the notes."""
    done = cli(
        "lookup", *MACHINE, *PAIR, "--diameter", 50, "--depth", 1.5, "--feed", 0.2, "--speed", 220,
        "--cutting-time", cutting_time_s, "--json",
    )  # fmt: skip
    found = json.loads(done.out)
    forces = {name: found["cut"][f"force_{name}_N"] for name in "xyz"}
    return {n: [one[k] for k in ("value", "low", "high")] for n, one in forces.items()}, found[
        "notes"
    ]


def true_N() -> dict[str, float]:
    cut = TrueCut(220.0, 0.2, 1.5, 50.0, "turn", "unseen", OLD_S, 0.0, "steel bar")
    return dict(zip("xyz", mean_forces_N(STEEL, cut).tolist(), strict=True))


def test_intervals_hold_worn_cuts_until_the_mismatches_are_rejected(waiting: Cli) -> None:
    wide, notes = looked_up(waiting)
    (why,) = [note for note in notes if "mismatch" in note]
    assert "mismatches 1 (force.y: tool_wear), 2 (force.z: tool_wear) are decided" in why
    assert "'autodb mismatch confirm 1' or 'autodb mismatch reject 1'" in why
    truth = true_N()
    for name in "yz":
        assert wide[name][1] <= truth[name] <= wide[name][2]

    # All answers say so: a kept prediction, its table, a plan
    said = waiting("predict", "job.toml", *MACHINE)
    assert why in " ".join(said.out.split())
    assert "mismatches 1 (force.y" in " ".join(waiting("plan", "job.toml", *MACHINE).out.split())

    for number in (1, 2):
        waiting("mismatch", "reject", number)
    narrow, notes = looked_up(waiting)
    assert not [note for note in notes if "mismatch" in note]
    for name in "yz":
        assert narrow[name][0] == pytest.approx(wide[name][0])
        assert narrow[name][2] - narrow[name][0] < 0.8 * (wide[name][2] - wide[name][0])


def test_a_fresh_edge_is_hardly_wider(waiting: Cli) -> None:
    old, fresh = (looked_up(waiting, age)[0] for age in (OLD_S, 30.0))
    for name in "yz":
        up = [(one[name][2] - one[name][0]) / one[name][0] for one in (old, fresh)]
        assert up[1] < 0.7 * up[0]
