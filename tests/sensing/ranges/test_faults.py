"""Faults of a calibration: sound data pass every check, and the command names what is wrong."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from autodb.proofs.machines.lathe.jobs import standard_cuts
from autodb.proofs.machines.lathe.lathe import Lathe, cut_table
from autodb.proofs.machines.lathe.process import STEEL
from autodb.proofs.machines.lathe.reference_lathe import campaign
from autodb.proofs.machines.sample import write_csv
from autodb.records import source as records
from autodb.records.tables import CutTable
from autodb.sensing.ranges import faults
from tests.conftest import Cli
from tests.helpers.lathe_tables import (
    AXES,
    FORCES,
    SEEDS,
    as_table,
    forces_of,
    lathe_cuts,
    names_of,
)


def checks(table: CutTable, known: faults.KnownOfCuts | None = None) -> Iterator[faults.DataCheck]:
    forces = forces_of(table)
    yield from faults.silent_axes(table, forces, AXES).values()
    yield from faults.checks_of_units(table, AXES, known)
    yield from faults.checks_of_signs(table, known)
    yield from faults.exchanged(table, forces, AXES, names_of(table))


def test_sound_machines_pass_every_check() -> None:
    """60 lathes, half of them with 118 cuts at drawn conditions; 7 checks each."""
    tables = [lathe_cuts(seed) for seed in range(30)]
    tables += [as_table(campaign(seed).calibration) for seed in range(30)]
    for table in tables:
        made = list(checks(table))
        assert [check for check in made if not check.passed] == []
        assert len(made) == 7


def test_real_turning_passes_every_check(vicomtech: Path, sample_jobs: Path) -> None:
    table = records.read(vicomtech, columns=sample_jobs / "vicomtech_turning_wear" / "columns.toml")
    assert isinstance(table, CutTable)
    made = list(checks(table))
    assert [check for check in made if not check.passed] == []
    assert {check.name for check in made} > {"units", "cuts exchanged", "z.current responds"}


def test_a_cut_that_states_zero_is_no_fault() -> None:
    table = lathe_cuts(SEEDS[0])
    changed = {}
    for name in ("cutting.feed", "cutting.speed", "force.y", "spindle.speed"):
        changed[name] = table[name].copy()
        changed[name][4] = 0.0
    zero = replace(table, channels={**table.channels, **changed})
    assert all(check.passed for check in checks(zero))


def test_calibrate_names_the_fault_and_stores_nothing(
    cli: Cli, refused: Callable[..., str], tmp_path: Path
) -> None:
    columns = cut_table(Lathe.draw(1), STEEL, standard_cuts(), 5, dynamometer=True)
    columns["cutting.feed"] = columns["cutting.feed"] / 25.4
    path = tmp_path / "cuts.csv"
    write_csv(path, columns)
    assert cli("init").code == 0
    assert cli("machine", "add", "lathe-1").code == 0
    for arguments in ((path,), (path, "--machine", "lathe-1")):
        line = refused("calibrate", *arguments)
        assert "cuts.csv: force.y / (cutting.feed · cutting.depth) is " in line
        assert (
            'as if cutting.feed in inch; state unit = "inch" for cutting.feed in the side file'
            in line
        )
    assert "no imported cuts" in refused("calibrate", "--machine", "lathe-1")
    side = '[channels]\n"cutting.feed" = {column = "cutting.feed", unit = "in"}\n'
    path.with_suffix(".toml").write_text(side)
    assert cli("calibrate", path, "--machine", "lathe-1").code == 0


def test_calibrate_says_which_sensor_is_unplugged(cli: Cli, tmp_path: Path) -> None:
    columns = cut_table(Lathe.draw(1), STEEL, standard_cuts(), 5, dynamometer=True)
    noise = np.abs(0.004 * np.random.default_rng(83).standard_normal((2, 32)))
    columns["x.current.range"], columns["x.current.air"] = noise
    write_csv(tmp_path / "cuts.csv", columns)
    done = cli("calibrate", tmp_path / "cuts.csv")
    assert done.code == 0
    assert "cuts.csv: x.current: the same in air, in light and in heavy" in done.out
    assert "check its plug" in " ".join(done.out.split())


def test_exchanged_cuts_of_several_files_are_named_with_their_file(
    cli: Cli, refused: Callable[..., str], tmp_path: Path
) -> None:
    columns = cut_table(Lathe.draw(1), STEEL, standard_cuts(), 5, dynamometer=True)
    force = columns["force.y"]
    turned = np.flatnonzero(columns["operation"] == "turn")
    low, high = turned[np.argmin(force[turned])], turned[np.argmax(force[turned])]
    for name in FORCES:
        columns[name][[low, high]] = columns[name][[high, low]]
    half = len(force) // 2
    for name, rows in (("first.csv", slice(0, half)), ("second.csv", slice(half, None))):
        write_csv(tmp_path / name, {column: values[rows] for column, values in columns.items()})
    assert cli("init").code == 0
    assert cli("machine", "add", "lathe-1").code == 0
    done = cli("import", tmp_path / "first.csv", tmp_path / "second.csv", "--machine", "lathe-1")
    assert done.code == 0, done.err
    line = refused("calibrate", "--machine", "lathe-1")
    for k in sorted((low, high)):
        assert f"cut {k + 1} of {'first' if k < half else 'second'}.csv" in line
