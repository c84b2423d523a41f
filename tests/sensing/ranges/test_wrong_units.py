"""Channels in another unit are named with what would mend them; unusual cuts are let through."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from autodb import standard
from autodb.agent.sense.calibrating import calibrate_table
from autodb.errors import UnusableInput
from autodb.files.machine import MachineFile
from autodb.proofs.machines.lathe.jobs import cut_at
from autodb.proofs.machines.lathe.lathe import Lathe
from autodb.proofs.machines.lathe.phases import raw_cut
from autodb.proofs.machines.lathe.process import STEEL
from autodb.records.mistaken import Mistake, Radius
from autodb.records.tables import CutTable, Recording
from autodb.sensing.ranges import faults
from autodb.sensing.ranges.recorded import raw
from tests.helpers.campaigns import first
from tests.helpers.lathe_tables import (
    AXES,
    CURRENTS,
    FORCES,
    SEEDS,
    lathe_cuts,
    protocol_of,
    side_of,
    with_channels,
    without_forces,
    wrong,
)

NAMED = (
    Mistake(FORCES, "kN"),
    *(Mistake((force,), "kN") for force in FORCES),
    *(Mistake(names, "mA") for names in (*CURRENTS, sum(CURRENTS, ()))),
    *(Mistake((name,), u) for name in ("cutting.feed", "cutting.depth") for u in ("inch", "um")),
    *(Mistake(("spindle.speed",), unit) for unit in ("rev/s", "rad/s")),
    Mistake(("work.diameter",), "inch"),
    Radius(("work.diameter",), "radius"),
)


@pytest.fixture(
    params=first(1, [SEEDS[:6:2], SEEDS[1:6:2], SEEDS[6:]]), ids=["three", "six", "more"]
)
def lathes(request: pytest.FixtureRequest) -> Sequence[int]:
    """Return the numbers of drawn lathes: one for each work material, and in campaigns the rest."""
    seeds: Sequence[int] = request.param
    return seeds


@pytest.mark.parametrize("mistake", NAMED, ids=str)
def test_a_wrong_unit_is_named(mistake: Mistake, lathes: Sequence[int]) -> None:
    for seed in lathes:
        (check,) = faults.checks_of_units(wrong(lathe_cuts(seed), mistake), AXES)
        assert not check.passed
        assert f"as if {mistake}; {mistake.remedy}" in check.sentence


def test_a_feed_a_minute_is_distinguished_from_a_feed_in_micrometres(lathes: Sequence[int]) -> None:
    """Both are some hundreds; over several speeds only one goes with the force."""
    for seed in lathes:
        table = lathe_cuts(seed)
        a_minute = table["cutting.feed"] * table["spindle.speed"]
        (check,) = faults.checks_of_units(with_channels(table, cutting__feed=a_minute), AXES)
        assert (
            "as if cutting.feed in mm/min; give the feed in millimetres per revolution"
            in check.sentence
        )


def test_what_cannot_be_singled_out_is_said_as_candidates(lathes: Sequence[int]) -> None:
    for seed in lathes:
        daN = Mistake(("force.y",), "daN")
        (check,) = faults.checks_of_units(wrong(lathe_cuts(seed), daN), AXES)
        assert "force.y in daN or force.y in lbf; its unit" in check.sentence.replace(
            "force.x, force.y and force.z in daN or force.x, force.y and force.z in lbf or ", ""
        )
        bare = {n: v for n, v in lathe_cuts(seed).channels.items() if n != "cutting.speed"}
        slow = wrong(replace(lathe_cuts(seed), channels=bare), Mistake(("spindle.speed",), "rev/s"))
        (check,) = faults.checks_of_units(slow, AXES)
        if not check.passed:
            assert "spindle.speed in rev/s or spindle.speed in rad/s or work.d" in check.sentence


def test_two_units_at_once_are_not_given_one_name() -> None:
    table = wrong(lathe_cuts(SEEDS[0]), Mistake(("force.y",), "kN"))
    twice = wrong(table, Mistake(("cutting.depth",), "um"))
    (check,) = faults.checks_of_units(twice, AXES)
    assert "several channels are in another unit" in check.sentence


def test_a_rated_current_and_a_speed_limit_are_heeded() -> None:
    machine = MachineFile.model_validate(
        {
            "axes": {a: {"rated_A": 8.0} for a in AXES},
            "spindle": {"max_speed_rpm": 3000},
        }
    )
    bare = {n: v for n, v in lathe_cuts(SEEDS[0]).channels.items() if n not in FORCES}
    table = replace(lathe_cuts(SEEDS[0]), channels=bare)
    known = faults.KnownOfCuts(machine=machine)
    assert faults.checks_of_units(table, AXES, known)[0].passed
    mA = Mistake(sum(CURRENTS, ()), "mA")
    (check,) = faults.checks_of_units(wrong(table, mA), AXES, known)
    assert "x.current over its rated current is" in check.sentence
    assert f"as if {mA};" in check.sentence


def test_a_spindle_at_its_limit_is_no_wrong_unit() -> None:
    """Stated is the programmed surface speed; small diameters are cut at half of it and less."""
    table = lathe_cuts(SEEDS[0])
    stated = np.linspace(1.0, 3.0, len(table)) * table["cutting.speed"]
    (check,) = faults.checks_of_units(with_channels(table, cutting__speed=stated), AXES)
    assert check.passed


def test_unusual_cuts_are_no_wrong_unit() -> None:
    """Finishing with a depth below the feed, and a plastic with a fortieth of a metal's force."""
    table = lathe_cuts(SEEDS[0])
    bare = {n: v for n, v in table.channels.items() if "range" not in n}
    light = {force: 0.05 * table[force] for force in FORCES}
    shallow = {"cutting.depth": 0.3 * table["cutting.feed"]}
    finishing = replace(table, channels={**bare, **light, **shallow})
    assert faults.checks_of_units(finishing, AXES)[0].passed
    plastic = {**bare, **{force: table[force] / 40.0 for force in FORCES}}
    assert faults.checks_of_units(replace(table, channels=plastic), AXES)[0].passed


def test_noise_of_one_raw_cut_is_given_no_unit(lathes: Sequence[int]) -> None:
    """A phase that is not plugged in, in a recording of one cut: too little to judge."""
    for seed in lathes:
        cut = cut_at((2.0, 0.2, 1500.0, 60.0), duration_s=2.0)
        channels = raw_cut(Lathe.draw(seed), STEEL, cut, seed, True)
        rng = np.random.default_rng([seed, 82])
        for phase in "uvw":
            channels[f"z.current.{phase}"] = 0.01 * rng.standard_normal(len(channels["t"]))
        side = side_of("turn", 2.0, 0.2)
        one = raw.cut_of_recording(Recording(path=Path("a.csv"), channels=channels, side=side))
        assert all(check.passed for check in faults.checks_of_units(one.table, AXES))


@pytest.mark.parametrize("unit", ["lbf", "daN"])
def test_with_references_a_factor_of_four_is_named(unit: str, lathes: Sequence[int]) -> None:
    for seed in lathes:
        table = lathe_cuts(seed)
        known = faults.KnownOfCuts(protocol_of(table))
        assert faults.checks_of_units(table, AXES, known)[0].passed
        mistake = Mistake(FORCES, unit)
        (check,) = faults.checks_of_units(wrong(table, mistake), AXES, known)
        assert f"as if {mistake}; {mistake.remedy}" in check.sentence


@pytest.mark.usefixtures("calibrated_once")
@pytest.mark.parametrize(
    "mistake",
    [
        Mistake(("cutting.feed",), "inch"),
        Mistake(("spindle.speed",), "rad/s"),
        Mistake(CURRENTS[1], "mA"),
    ],
    ids=str,
)
def test_without_a_dynamometer_the_protocol_names_the_unit(
    mistake: Mistake, lathes: Sequence[int]
) -> None:
    for seed in lathes:
        table = lathe_cuts(seed)
        protocol = protocol_of(table)
        bare = without_forces(table)
        bare = replace(
            bare, channels={n: v for n, v in bare.channels.items() if n[:2] != "cutting.s"}
        )
        calibrate_table(bare, axes=AXES, protocol=protocol)
        with pytest.raises(UnusableInput, match=r"; (use|state|set|give|put) ") as refused:
            calibrate_table(wrong(bare, mistake), axes=AXES, protocol=protocol)
        assert f"as if {mistake}; {mistake.remedy}" in str(refused.value)


def test_a_reference_of_cuts_that_were_not_made_stops_no_other_axis() -> None:
    """Force.x has references in facing only, and the table holds turning only."""
    table = lathe_cuts(SEEDS[0])
    whole = protocol_of(table)
    cuts = [
        cut.model_copy(update={"reference": {c: r for c, r in cut.reference.items() if c != "x"}})
        if cut.operation == "turn"
        else cut
        for cut in whole.cut
    ]
    rows = np.flatnonzero([o == "turn" for o in table.texts["operation"]])
    bare = CutTable(
        path=table.path,
        channels={n: v[rows] for n, v in without_forces(table).channels.items()},
        texts={"operation": ["turn"] * len(rows)},
    )
    protocol = whole.model_copy(update={"cut": tuple(cuts)})
    done, left_out = calibrate_table(bare, axes=AXES, protocol=protocol)
    assert {c.axis for c in done} == {"z", "spindle"}
    assert "no reference for force.x yet" in left_out[0]


def test_a_protocol_of_other_cuts_is_no_wrong_unit() -> None:
    table = without_forces(lathe_cuts(SEEDS[0]))
    slow = with_channels(table, cutting__feed=np.full(len(table), 0.23))
    with pytest.raises(UnusableInput, match="no row is a standard cut"):
        calibrate_table(slow, axes=AXES, protocol=standard.read_protocol("turning-aluminium"))
