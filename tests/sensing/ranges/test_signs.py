"""A force on the work, not said to be one, is asked about; forces of sound cuts are not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb.records.tables import CutTable
from autodb.sensing.ranges import faults
from tests.conftest import Cli
from tests.helpers.lathe_tables import SEEDS, lathe_cuts, with_channels

Array = NDArray[np.float64]

FORCES = ("force.x", "force.y", "force.z")


def turned_round(table: CutTable, *names: str) -> CutTable:
    """Return a table in which some channels have the other sign."""
    return replace(table, channels={**table.channels, **{name: -table[name] for name in names}})


def sentence(table: CutTable, known: faults.KnownOfCuts | None = None) -> str:
    """Return what is asked of a table; empty: nothing."""
    (check,) = faults.checks_of_signs(table, known)
    return "" if check.passed else check.sentence


@pytest.mark.parametrize("names", [("force.y",), ("force.z",), ("force.x",), FORCES])
def test_a_lathes_forces_on_the_work_are_asked_about(names: tuple[str, ...]) -> None:
    """20 lathes, turned and faced: as they are nothing is said, turned round each channel is."""
    for seed in SEEDS:
        table = lathe_cuts(seed)
        assert sentence(table) == ""
        asked = sentence(turned_round(table, *names))
        assert "the dynamometer reports the force on the work? set sign = -1 for" in asked
        for name in names:
            assert name in asked


def test_a_sign_that_is_stated_is_not_asked_about() -> None:
    table = turned_round(lathe_cuts(400), *FORCES)
    assert sentence(table, faults.KnownOfCuts(signs=frozenset(FORCES))) == ""
    assert "force.y" in sentence(table, faults.KnownOfCuts(signs=frozenset({"force.z"})))


def test_one_sound_cut_says_that_the_sign_is_right() -> None:
    table = turned_round(lathe_cuts(400), "force.y")
    force = table["force.y"].copy()
    force[3] *= -1.0
    assert sentence(with_channels(table, force__y=force)) == ""


def test_what_is_fed_the_other_way_is_pushed_the_other_way() -> None:
    """Faces cut outward and cylinders turned away from the chuck, where velocities say so."""
    table = lathe_cuts(400)
    faced = np.array(table.texts["operation"]) == "face"
    flipped = turned_round(table, "force.x", "force.z")
    assert sentence(flipped) != ""
    x, z = np.where(faced, 5.0, 0.0), np.where(faced, 0.0, 5.0)
    assert sentence(with_channels(flipped, x__velocity=x, z__velocity=z)) == ""
    assert "force.z" in sentence(with_channels(table, x__velocity=0.0 * x, z__velocity=z))


def test_power_that_the_spindle_takes_in_is_asked_about() -> None:
    table = lathe_cuts(400)
    power = np.abs(table["force.y"])
    assert sentence(with_channels(table, spindle__power=power)) == ""
    assert "spindle.power is negative in every cut" in sentence(
        with_channels(table, spindle__power=-power)
    )
    assert sentence(with_channels(table, torque__spindle=power)) == ""
    assert "set sign = -1 for torque.spindle" in sentence(
        with_channels(table, torque__spindle=-power)
    )


def slots(direction_deg: Array, operation: str = "slot") -> CutTable:
    """Return milled cuts: against the feed K_rc, to its left K_tc, N teeth · a_p · f/4 (slot)."""
    angle, one = np.radians(direction_deg), np.ones(len(direction_deg))
    against, left = 600.0 * 0.05, 2000.0 * 0.05
    return CutTable(
        path=Path("mill.csv"),
        channels={
            "cut": np.cumsum(one), "cutting.direction": direction_deg,
            "cutting.feed": 0.05 * one, "cutting.depth": one, "spindle.speed": 3000.0 * one,
            "force.x": -against * np.cos(angle) - left * np.sin(angle),
            "force.y": -against * np.sin(angle) + left * np.cos(angle),
        },
        texts={"operation": [operation] * len(one)},
        units={},
    )  # fmt: skip


@pytest.mark.parametrize("operation", ["slot", "ramp", "side-up", "side-down", "pocket"])
def test_a_mills_forces_on_the_work_are_asked_about(operation: str) -> None:
    every = slots(np.linspace(0.0, 330.0, 12), operation)
    assert sentence(every) == ""
    asked = sentence(turned_round(every, "force.x", "force.y"))
    assert "set sign = -1 for force.x and force.y" in asked


def test_a_mill_that_does_not_say_where_it_feeds_is_not_judged() -> None:
    unsaid = turned_round(slots(np.array([0.0, 90.0])), "force.x", "force.y")
    channels = {n: v for n, v in unsaid.channels.items() if n != "cutting.direction"}
    assert sentence(replace(unsaid, channels=channels)) == ""
    by_velocity = {
        **channels,
        "x.velocity": np.array([5.0, 0.0]),
        "y.velocity": np.array([0.0, 5.0]),
    }
    assert "force.x and force.y" in sentence(replace(unsaid, channels=by_velocity))


def test_a_drill_is_pushed_out_of_the_work() -> None:
    table = CutTable(
        path=Path("d.csv"),
        channels={"cut": np.arange(3.0), "force.z": np.array([200.0, 240.0, 260.0])},
        texts={"operation": ["drill"] * 3},
        units={},
    )
    assert sentence(table) == ""
    assert "force.z pulls the drill" in sentence(turned_round(table, "force.z"))


CUTS = "cut,t,operation,work.material,tool,spindle.speed,cutting.feed,cutting.depth,work.diameter"


def _written(path: Path) -> Path:
    """Write 24 turned cuts whose forces are those on the work, with currents that follow them."""
    rng = np.random.default_rng(3)
    rows = [f"{CUTS},force.y,force.z,z.current.range,z.current.air,spindle.current.range,"
            "spindle.current.air"]  # fmt: skip
    for k in range(24):
        feed, depth = float(rng.choice([0.1, 0.2, 0.3])), float(rng.choice([1.0, 1.5, 2.0]))
        force = 2000.0 * feed**0.8 * depth
        z_A = 5.0 + 0.45 * force / 200.0 + rng.normal(0.0, 0.02)
        spindle_A = 7.0 + force * (25.0 + 0.5 * depth) / 1000.0 + rng.normal(0.0, 0.05)
        rows.append(
            f"{k + 1},{60 * k},turn,steel,insert,1000,{feed},{depth},50,{-force},{-0.45 * force},"
            f"{z_A},5,{spindle_A},7"
        )
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


def _side(path: Path, sign: int) -> Path:
    said = "".join(f'"force.{c}" = {{column = "force.{c}", sign = {sign}}}\n' for c in "yz")
    path.write_text(f"[channels]\n{said}", encoding="utf-8")
    return path


def test_nothing_is_stored_of_a_table_whose_sign_is_in_question(cli: Cli, tmp_path: Path) -> None:
    cuts = _written(tmp_path / "cuts.csv")
    for command in ("init", "machine add lathe-1"):
        assert cli(*command.split()).code == 0
    for asked in (("import", cuts, "--machine", "lathe-1"), ("calibrate", cuts)):
        refused = cli(*asked)
        assert refused.code == 2
        assert "force.y is negative and force.z runs with the feed in every cut: the" in refused.err
        assert refused.err.count("\n") == 1
    assert "no imported cuts" in cli("calibrate", "--machine", "lathe-1").err


@pytest.mark.parametrize("sign", [-1, 1])
def test_a_sign_that_is_said_is_believed(cli: Cli, tmp_path: Path, sign: int) -> None:
    """By `import`, and by `calibrate` of what was imported."""
    cuts, side = _written(tmp_path / "cuts.csv"), _side(tmp_path / "side.toml", sign)
    for command in ("init", "machine add lathe-1"):
        assert cli(*command.split()).code == 0
    assert cli("import", cuts, "--machine", "lathe-1", "--columns", side).code == 0
    done = cli("calibrate", "--machine", "lathe-1")
    assert done.code == 0, done.err
    assert "usable" in done.out
