"""Protocols: their order, where their references come from, and the commands."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose
from scipy import stats

from autodb import standard
from autodb.agent.sense.measuring import new_protocol, read_measured, with_references
from autodb.errors import UnusableInput
from autodb.proofs.runs.keeping.writing_commands import A_LATHE
from autodb.records import source as records
from autodb.records.tables import CutTable
from autodb.sensing.ranges import calibration
from autodb.standard import CutProtocol, read_protocol, run_order
from autodb.standard.writing import as_toml
from tests.conftest import Cli

DAY = "2026-03-04"
TRUE_N = {"turn": (500.0, 300.0), "face": (200.0, 400.0)}
"""Force y and z of the made cuts."""


def _cuts(repeats: int = 6, noise_N: float = 10.0, seed: int = 1) -> pd.DataFrame:
    """Return turning and facing cuts of known force with scatter, and one cut made once."""
    random = np.random.default_rng(seed)
    rows = [
        {"operation": op, "spindle.speed": 1000.0, "cutting.feed": 0.2, "cutting.depth": 2.0,
         "force.y": y + noise_N * random.standard_normal(),
         "force.z": z + noise_N * random.standard_normal()}
        for op, (y, z) in TRUE_N.items() for _ in range(repeats)
    ]  # fmt: skip
    rows.append({**rows[0], "spindle.speed": 1500.0})
    table = pd.DataFrame(rows)
    table.insert(0, "cut", range(1, len(table) + 1))
    table.insert(1, "t", 60.0 * np.arange(len(table)))
    table["work.material"], table["tool"] = "steel", "insert"
    return table


def _written(folder: Path, table: pd.DataFrame) -> Path:
    path = folder / "dyno.csv"
    table.to_csv(path, index=False)
    return path


@pytest.mark.parametrize("name", standard.shipped())
def test_the_order_has_every_repeat_and_ends_as_it_began(name: str) -> None:
    protocol = read_protocol(name)
    order = run_order(protocol)
    made = [cut.name for cut in order[:-1]]
    assert {n: made.count(n) for n in made} == {c.name: c.repeats for c in protocol.cut}
    assert order[-1] == order[0]
    assert order == run_order(protocol)
    assert order != run_order(protocol.model_copy(update={"seed": protocol.seed + 1}))


def test_blocks_keep_drift_from_any_cut() -> None:
    """Over many seeds a linear drift of 1 over the run moves no cut's mean by more than a block."""
    protocol = read_protocol("turning-aluminium")
    worst = []
    for seed in range(50):
        order = run_order(protocol.model_copy(update={"seed": seed}))[:-1]
        clock = np.linspace(0, 1, len(order))
        means = [clock[[c.name == cut.name for c in order]].mean() for cut in protocol.cut]
        worst.append(np.abs(np.array(means) - 0.5).max())
    assert max(worst) < 1 / 3


def test_a_protocol_reads_back_as_it_was_written(tmp_path: Path) -> None:
    for name in standard.shipped():
        protocol = read_protocol(name)
        path = tmp_path / f"{name}.toml"
        path.write_text(as_toml(protocol), encoding="utf-8")
        assert read_protocol(str(path)) == protocol


@pytest.mark.parametrize("name", ["milling-c45", "drilling-c45"])
def test_what_has_no_published_force_ships_none(name: str) -> None:
    assert not any(cut.reference for cut in read_protocol(name).cut)


def test_an_operation_says_which_axis_is_passive() -> None:
    """The axis that the protocol calls passive is the one that a calibration does not use."""
    from autodb.standard.protocol import PASSIVE

    rows = 20
    current = np.linspace(1, 2, rows)
    for operation, axis in PASSIVE.items():
        channels = {"cut": np.arange(rows, dtype=float), f"{axis}.current": current,
                    f"force.{axis}": 100 * current}  # fmt: skip
        table = CutTable(Path("c.csv"), channels, {"operation": [operation] * rows})
        with pytest.raises(UnusableInput, match="0 independent groups"):
            calibration.calibrate(table, axis)


def test_references_hold_the_true_force_and_are_students_interval(tmp_path: Path) -> None:
    frame = _cuts()
    table = read_measured(_written(tmp_path, frame))
    done = new_protocol("mine", [table], date=DAY)
    assert [cut.operation for cut in done.protocol.cut] == ["turn", "face"]
    assert done.without == ("1 cuts made once: no repeats, no interval",)
    for cut in done.protocol.cut:
        for component, true in zip("yz", TRUE_N[cut.operation], strict=True):
            forces = frame[(frame.operation == cut.operation) & (frame["spindle.speed"] == 1000)]
            values = forces[f"force.{component}"]
            expected = stats.t.interval(0.95, 5, values.mean(), stats.sem(values))
            reference = cut.reference[component]
            assert_allclose([reference.lower, reference.upper], expected, atol=6e-3)
            assert abs(reference.value - true) < 20
            assert reference.source.startswith("dyno.csv")
            assert (reference.date, cut.repeats) == (DAY, 6)


def test_nineteen_of_twenty_intervals_hold_the_true_force(tmp_path: Path) -> None:
    held = []
    for seed in range(100):
        table = read_measured(_written(tmp_path, _cuts(repeats=3, seed=seed)))
        for cut in new_protocol("mine", [table], date=DAY).protocol.cut:
            for component, true in zip("yz", TRUE_N[cut.operation], strict=True):
                held.append(cut.reference[component].lower < true < cut.reference[component].upper)
    assert 0.92 < np.mean(held) < 0.98


def test_a_protocol_gets_its_references_from_cuts_that_are_its_own(tmp_path: Path) -> None:
    table = read_measured(_written(tmp_path, _cuts()))
    before = read_protocol("turning-aluminium")
    done = with_references(before, [table], date=DAY)
    cuts = {cut.name: cut for cut in done.protocol.cut}
    assert set(cuts["published"].reference) == {"y", "z"}
    assert cuts["published"].reference["y"].source.startswith("dyno.csv")
    assert cuts["published"].repeats == 12
    assert not cuts["light"].reference
    assert "'light' not measured" in done.without
    assert done.without[-1] == "7 rows are none of the protocol's cuts"
    assert done.protocol.bar == before.bar


def test_a_new_protocol_calibrates(cli: Cli) -> None:
    """Forces measured once stand in for a dynamometer: a known line comes back from currents."""
    rows = []
    random = np.random.default_rng(2)
    for feed in (0.1, 0.2, 0.3, 0.4):
        for depth in (1.0, 2.0):
            force = 1200 * feed * depth + 100 * depth
            for _ in range(4):
                current = (force + 5 * random.standard_normal()) / 240
                rows.append((feed, depth, force + 5 * random.standard_normal(), current))
    names = ["cutting.feed", "cutting.depth", "force.z", "z.current"]
    frame = pd.DataFrame(rows, columns=names)
    frame.insert(0, "cut", range(len(frame)))
    frame.insert(1, "t", 60.0 * np.arange(len(frame)))
    frame["spindle.speed"], frame["operation"] = 1000.0, "turn"
    frame["work.material"], frame["tool"] = "steel", "insert"
    frame.to_csv("dyno.csv", index=False)
    frame.drop(columns="force.z").to_csv("shop.csv", index=False)
    assert cli("standard", "new", "mine", "dyno.csv", "--date", DAY).code == 0
    done = cli("calibrate", "shop.csv", "--protocol", "mine.toml")
    assert done.code == 0
    line = next(line for line in done.out.splitlines() if "force.z" in line)
    assert_allclose(float(line.split("+")[1].split()[0]), 240, rtol=0.02)


def test_a_recording_with_forces_alone_is_one_cut(tmp_path: Path) -> None:
    """Air, then a slot of 250 N across the noise: its mean and its direction come back."""
    t = np.arange(0, 8, 0.002)
    noise = np.random.default_rng(5).normal(0, 4, (2, len(t)))
    force = np.where((t > 3) & (t < 7), 250.0, 0.0)
    pd.DataFrame(
        {"t": t, "force.x": -force + noise[0] + 7, "force.y": 0.4 * force + noise[1]}
    ).to_csv(tmp_path / "slot.csv", index=False)
    side = (
        '[recording]\nwork = "C45"\n[tool]\nname = "mill"\n[cut]\noperation = "slot"\n'
        "depth_mm = 3.0\nfeed_mm_tooth = 0.04\nspeed_rpm = 3000\nfeed_direction_deg = 180\n"
    )
    (tmp_path / "slot.toml").write_text(side)
    table = read_measured(tmp_path / "slot.csv")
    assert_allclose(table["force.x"], -250, atol=2)
    assert_allclose(table["force.y"], 100, atol=2)
    done = with_references(read_protocol("milling-c45"), [table, table], date=DAY)
    known = [cut.name for cut in done.protocol.cut if cut.reference]
    assert known == ["x minus, 3 deep"]


def test_a_table_that_cannot_tell_directions_is_refused(tmp_path: Path) -> None:
    frame = _cuts().assign(operation="slot")
    frame["spindle.speed"], frame["cutting.feed"], frame["cutting.depth"] = 3000, 0.04, 3.0
    table = read_measured(_written(tmp_path, frame))
    with pytest.raises(UnusableInput, match=r"row 1 is 'x plus, 3 deep' and 'x minus, 3 deep'"):
        with_references(read_protocol("milling-c45"), [table], date=DAY)


def test_two_cuts_that_a_table_cannot_tell_apart_do_not_calibrate(tmp_path: Path) -> None:
    known = {"value": 1.0, "lower": 0.5, "upper": 2.0, "source": "s", "status": "s", "date": DAY}
    cuts = [
        {"name": str(deg), "operation": "slot", "speed_rpm": 3000.0, "feed_mm_tooth": 0.04,
         "depth_mm": 3.0, "feed_direction_deg": deg, "repeats": 1, "reference": {"x": known}}
        for deg in (0.0, 180.0)
    ]  # fmt: skip
    protocol = CutProtocol.model_validate({"name": "p", "material": "m", "tool": "t", "cut": cuts})
    frame = _cuts(1).assign(operation="slot")
    frame["spindle.speed"], frame["cutting.feed"], frame["cutting.depth"] = 3000, 0.04, 3.0
    table = records.read(_written(tmp_path, frame))
    assert isinstance(table, CutTable)
    with pytest.raises(UnusableInput, match="direction of feed"):
        standard.reference_forces(table, protocol, "x")


BROKEN: list[tuple[str, Any, str]] = [
    ("operation", "trun", r"row 1: no operation 'trun' \(did you mean turn\?\)"),
    ("tool", [*["a"] * 6, *["b"] * 7], "tool: several: a, b"),
    ("cutting.feed", 0.0, "row 1: 0; a standard cut needs"),
    ("spindle.speed", np.arange(1000, 14000, 1000), "no cut was made twice"),
]


@pytest.mark.parametrize(("column", "values", "line"), BROKEN)
def test_what_makes_no_protocol_is_refused(
    refused: Callable[..., str], column: str, values: Any, line: str
) -> None:
    _written(Path(), _cuts().assign(**{column: values}))
    assert re.search(line, refused("standard", "new", "mine", "dyno.csv"))
    assert not Path("mine.toml").exists()


def test_a_table_without_forces_is_refused(refused: Callable[..., str]) -> None:
    _written(Path(), _cuts().drop(columns=["force.y", "force.z"]))
    assert "no channel force.x, force.y or force.z" in refused("standard", "new", "m", "dyno.csv")


def test_list_and_show_say_what_has_no_reference(cli: Cli) -> None:
    listed = cli("standard", "list").out
    for name in standard.shipped():
        assert name in listed
    shown = cli("standard", "show", "turning-aluminium").out
    assert "y 485.78 (465.61 to 505.95)" in shown
    assert "turn, x stands still" in shown
    assert "5 of 6 cuts have no reference force" in shown
    assert "12 of 12 cuts have no reference force" in cli("standard", "show", "milling-c45").out


def test_new_is_written_once_and_never_over_another(cli: Cli, refused: Callable[..., str]) -> None:
    _written(Path(), _cuts())
    asked = ("standard", "new", "mine", "dyno.csv", "--date", DAY)
    assert "mine.toml: written, 2 of 2 cuts have a reference force" in cli(*asked).out
    assert "already there" in cli(*asked).out
    assert "differs" in refused(*asked[:-1], "2026-03-05")
    assert "a day as" in refused(*asked[:-1], "4.3.2026")


def test_a_program_is_printed_or_written_whole(cli: Cli, refused: Callable[..., str]) -> None:
    Path("m.toml").write_text(A_LATHE)
    asked = ("standard", "program", "turning-aluminium", "--machine-file", "m.toml", "--dialect")
    printed = cli(*asked, "siemens")
    assert printed.code == 0
    assert "dry run it" in cli(*asked, "siemens", "--out", "a.mpf").out
    assert Path("a.mpf").read_text() == printed.out
    Path(".a.mpf.lock").touch()  # of one that was killed
    assert "already there" in cli(*asked, "siemens", "--out", "a.mpf").out
    assert not Path(".a.mpf.lock").exists()
    Path("m.toml").write_text(A_LATHE.replace("travel_high_mm = 160", "travel_high_mm = 40"))
    assert "retract position: axis x" in refused(*asked, "fanuc", "--out", "b.nc")
    assert not Path("b.nc").exists()


def test_what_is_clamped_does_not_enter_the_database(cli: Cli) -> None:
    Path("m.toml").write_text(A_LATHE)
    cli("init")
    assert cli("machine", "add", "m", "--file", "m.toml").code == 0
    assert "already there" in cli("machine", "add", "m", "--file", "m.toml").out
    assert "already there" in cli("machine", "update", "m", "--file", "m.toml").out
    assert "setup" not in cli("machine", "show", "m").out
