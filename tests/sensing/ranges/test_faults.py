"""Faults of a calibration: made on virtual lathes, each caught and named; sound data pass."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from autodb import records, standard
from autodb.agent.sense.calibrating import calibrate_table
from autodb.errors import UnusableInput
from autodb.files.machine import MachineFile
from autodb.files.side import SideFile
from autodb.proofs.machines.lathe.jobs import cut_at, standard_cuts
from autodb.proofs.machines.lathe.lathe import Lathe, cut_table
from autodb.proofs.machines.lathe.phases import raw_cut
from autodb.proofs.machines.lathe.process import ALUMINIUM, BRASS, STEEL
from autodb.proofs.machines.lathe.reference_lathe import campaign
from autodb.proofs.machines.sample import write_csv
from autodb.records import CutTable, Recording
from autodb.records.mistaken import Mistake, Radius
from autodb.sensing.ranges import calibration, faults, raw
from autodb.sensing.ranges.faults.travel import pass_steps_mm
from autodb.sensing.ranges.forms import LINE
from autodb.standard import CutProtocol
from tests.conftest import Cli

Array = NDArray[np.float64]

AXES = ("x", "z", "spindle")
MACHINES = 20
SEEDS = range(400, 400 + MACHINES)
"""Fixed before any was looked at."""
TEXTS = ("operation", "work.material", "tool", "tool.edge")
FORCES = ("force.x", "force.y", "force.z")


@cache
def lathe_cuts(seed: int) -> CutTable:
    """32 standard cuts, turned and faced, of one of three pairs on a lathe, with a dynamometer."""
    pair = (STEEL, BRASS, ALUMINIUM)[seed % 3]
    return as_table(cut_table(Lathe.draw(seed), pair, standard_cuts(), seed, dynamometer=True))


def as_table(columns: dict[str, NDArray[np.generic]]) -> CutTable:
    numbers = {n: v.astype(np.float64) for n, v in columns.items() if n not in TEXTS}
    texts = {n: [str(v) for v in columns[n]] for n in TEXTS}
    return CutTable(path=Path("cuts.csv"), channels=numbers, texts=texts)


KEPT: dict[tuple[object, ...], calibration.Calibration] = {}


@pytest.fixture
def calibrated_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """An axis is fitted once for the same cuts, whatever is done to the other axes' currents, and
    by a line alone.

    Which axes are calibrated, and on what, is asked in every test; how well is tested elsewhere.
    """
    calibrate = calibration.calibrate

    def once(
        table: CutTable, axis: str, *, force_N: Array | None = None, reference_share: float = 0.0
    ) -> calibration.Calibration:
        others = tuple(f"{other}.current" for other in AXES if other != axis)
        own = {n: v.tobytes() for n, v in table.channels.items() if not n.startswith(others)}
        force = None if force_N is None else force_N.tobytes()
        key = (axis, reference_share, force, *own.items(), str(table.texts))
        if key not in KEPT:
            KEPT[key] = calibrate(table, axis, force_N=force_N, reference_share=reference_share)
        return KEPT[key]

    monkeypatch.setattr(calibration, "calibrate", once)
    monkeypatch.setattr(calibration, "_forms", lambda *_: (LINE,))


def forces_of(table: CutTable) -> dict[str, Array]:
    return {c: table[f"force.{c}"] for c in "xyz" if f"force.{c}" in table}


def names_of(table: CutTable) -> list[str]:
    return [f"cut {number:g}" for number in table.cut]


def checks(table: CutTable, known: faults.KnownOfCuts | None = None) -> Iterator[faults.DataCheck]:
    forces = forces_of(table)
    yield from faults.silent_axes(table, forces, AXES).values()
    yield from faults.checks_of_units(table, AXES, known)
    yield from faults.exchanged(table, forces, AXES, names_of(table))


def with_channels(table: CutTable, **changed: Array) -> CutTable:
    new = {name.replace("__", "."): values for name, values in changed.items()}
    return replace(table, channels={**table.channels, **new})


def wrong(table: CutTable, mistake: Mistake) -> CutTable:
    """The table as it is logged when some channels are in another unit."""
    logged = {n: table[n] / mistake.factor for n in mistake.channels if n in table}
    return replace(table, channels={**table.channels, **logged})


def test_sound_machines_pass_every_check() -> None:
    """60 lathes, half of them with 118 cuts at drawn conditions; 6 checks each."""
    tables = [lathe_cuts(seed) for seed in range(30)]
    tables += [as_table(campaign(seed).calibration) for seed in range(30)]
    for table in tables:
        made = list(checks(table))
        assert [check for check in made if not check.passed] == []
        assert len(made) == 6


def test_real_turning_passes_every_check(vicomtech: Path, sample_jobs: Path) -> None:
    table = records.read(vicomtech, columns=sample_jobs / "vicomtech_turning_wear" / "columns.toml")
    assert isinstance(table, CutTable)
    made = list(checks(table))
    assert [check for check in made if not check.passed] == []
    assert {check.name for check in made} > {"units", "cuts exchanged", "z.current responds"}


# a) unplugged


def unplugged(table: CutTable, axis: str, seed: int, level_A: float) -> CutTable:
    rng = np.random.default_rng([seed, 77])
    noise = np.abs(level_A + 0.004 * rng.standard_normal((2, len(table))))
    names = (f"{axis}.current.range", f"{axis}.current.air")
    return replace(table, channels={**table.channels, **dict(zip(names, noise, strict=True))})


@pytest.mark.usefixtures("calibrated_once")
@pytest.mark.parametrize("level_A", [0.0, 0.05, 1.0])
@pytest.mark.parametrize("axis", AXES)
def test_a_sensor_that_gives_nothing_is_named_alone(axis: str, level_A: float) -> None:
    for seed in SEEDS:
        table = unplugged(lathe_cuts(seed), axis, seed, level_A)
        found = faults.silent(table, forces_of(table), AXES)
        assert list(found) == [axis]
        assert f"{axis}.current: the same in air, in light and in heavy" in found[axis].sentence
        assert "is it plugged in?" in found[axis].sentence
        done, left_out = calibrate_table(table, axes=AXES)
        assert {c.axis for c in done} == set(AXES) - {axis}
        assert any("is it plugged in?" in line for line in left_out)


def test_an_axis_that_stands_or_correlates_badly_is_not_unplugged() -> None:
    """X stands in turning; a current whose scatter is as large as its rise still has one."""
    for seed in SEEDS:
        table = lathe_cuts(seed)
        turned = [o == "turn" for o in table.texts["operation"]]
        rows = np.flatnonzero(turned)
        only = CutTable(
            path=table.path,
            channels={name: values[rows] for name, values in table.channels.items()},
            texts={"operation": ["turn"] * len(rows)},
        )
        assert "x" not in faults.silent_axes(only, forces_of(only), AXES)
        rise = table["z.current.range"] - table["z.current.air"]
        noise = rise.mean() * np.random.default_rng([seed, 78]).standard_normal(len(table))
        poor = with_channels(table, z__current__range=table["z.current.range"] + noise)
        assert not faults.silent(poor, forces_of(poor), AXES)


def test_without_an_operation_a_standing_axis_is_a_candidate_too() -> None:
    table = unplugged(lathe_cuts(SEEDS[0]), "x", 1, 0.9)
    untold = replace(table, texts={})
    (check,) = faults.silent(untold, forces_of(untold), AXES).values()
    assert "or x stands still in these cuts, which 'operation' would say" in check.sentence


def test_without_air_only_a_faint_current_is_silent() -> None:
    """A level like another axis' may be friction alone: the axis is refused by its R² instead."""
    for seed in SEEDS:
        for level_A, named in ((0.0, ["x"]), (1.0, [])):
            table = unplugged(lathe_cuts(seed), "x", seed, level_A)
            bare = {n: v for n, v in table.channels.items() if not n.endswith(".air")}
            found = faults.silent(replace(table, channels=bare), forces_of(table), AXES)
            assert list(found) == named
            assert all("the same in light and in heavy" in c.sentence for c in found.values())


def test_where_nothing_was_cut_no_axis_is_unplugged() -> None:
    table = lathe_cuts(SEEDS[0])
    for axis in AXES:
        table = unplugged(table, axis, 3, 0.5)
    assert faults.silent_axes(table, forces_of(table), AXES) == {}


# b) wrong units


CURRENTS = tuple((f"{axis}.current.range", f"{axis}.current.air") for axis in AXES)
NAMED = (
    Mistake(FORCES, "kN"),
    *(Mistake((force,), "kN") for force in FORCES),
    *(Mistake(names, "mA") for names in (*CURRENTS, sum(CURRENTS, ()))),
    *(Mistake((name,), u) for name in ("cutting.feed", "cutting.depth") for u in ("inch", "um")),
    *(Mistake(("spindle.speed",), unit) for unit in ("rev/s", "rad/s")),
    Mistake(("work.diameter",), "inch"),
    Radius(("work.diameter",), "radius"),
)


@pytest.mark.parametrize("mistake", NAMED, ids=str)
def test_a_wrong_unit_is_named(mistake: Mistake) -> None:
    for seed in SEEDS:
        (check,) = faults.checks_of_units(wrong(lathe_cuts(seed), mistake), AXES)
        assert not check.passed
        assert f"as if {mistake}; {mistake.remedy} would work" in check.sentence


def test_a_feed_a_minute_is_told_from_a_feed_in_micrometres() -> None:
    """Both are some hundreds; over several speeds only one goes with the force."""
    for seed in SEEDS:
        table = lathe_cuts(seed)
        a_minute = table["cutting.feed"] * table["spindle.speed"]
        (check,) = faults.checks_of_units(with_channels(table, cutting__feed=a_minute), AXES)
        assert "as if cutting.feed in mm/min; millimetres a revolution would work" in check.sentence


def test_what_cannot_be_singled_out_is_said_as_candidates() -> None:
    for seed in SEEDS:
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


def test_a_cut_that_states_zero_is_no_fault() -> None:
    table = lathe_cuts(SEEDS[0])
    changed = {}
    for name in ("cutting.feed", "cutting.speed", "force.y", "spindle.speed"):
        changed[name] = table[name].copy()
        changed[name][4] = 0.0
    zero = replace(table, channels={**table.channels, **changed})
    assert all(check.passed for check in checks(zero))


def test_noise_of_one_raw_cut_is_given_no_unit() -> None:
    """A phase that is not plugged in, in a recording of one cut: too little to judge."""
    for seed in SEEDS:
        cut = cut_at((2.0, 0.2, 1500.0, 60.0), duration_s=2.0)
        channels = raw_cut(Lathe.draw(seed), STEEL, cut, seed, True)
        rng = np.random.default_rng([seed, 82])
        for phase in "uvw":
            channels[f"z.current.{phase}"] = 0.01 * rng.standard_normal(len(channels["t"]))
        side = side_of("turn", 2.0, 0.2)
        one = raw.cut_of_recording(Recording(path=Path("a.csv"), channels=channels, side=side))
        assert all(check.passed for check in faults.checks_of_units(one.table, AXES))


def protocol_of(table: CutTable) -> CutProtocol:
    """A protocol whose references are the dynamometer's means of equal cuts."""
    keys = [
        (o, n, f, a)
        for o, n, f, a in zip(
            table.texts["operation"], np.round(table["spindle.speed"], 3),
            table["cutting.feed"], table["cutting.depth"], strict=True,
        )
    ]  # fmt: skip
    cuts = []
    for key in dict.fromkeys(keys):
        rows = [k == key for k in keys]
        means = {c: float(np.mean(table[f"force.{c}"][rows])) for c in "xyz"}
        bounds = {
            c: {"value": v, "lower": 0.95 * v, "upper": 1.05 * v, **SOURCE}
            for c, v in means.items()
        }
        cuts.append(
            {
                "name": str(key), "operation": key[0], "speed_rpm": float(key[1]),
                "feed_mm_rev": float(key[2]), "depth_mm": float(key[3]), "repeats": 1,
                "reference": bounds,
            }
        )  # fmt: skip
    whole = {"name": "mine", "material": "m", "tool": "t", "cut": cuts}
    return CutProtocol.model_validate(whole)


SOURCE = {"source": "test", "status": "known", "date": "2026-01-01"}


def without_forces(table: CutTable) -> CutTable:
    channels = {name: v for name, v in table.channels.items() if name not in FORCES}
    return replace(table, channels=channels)


@pytest.mark.parametrize("unit", ["lbf", "daN"])
def test_with_references_a_factor_of_four_is_named(unit: str) -> None:
    for seed in SEEDS:
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
def test_without_a_dynamometer_the_protocol_names_the_unit(mistake: Mistake) -> None:
    for seed in SEEDS:
        table = lathe_cuts(seed)
        protocol = protocol_of(table)
        bare = without_forces(table)
        bare = replace(
            bare, channels={n: v for n, v in bare.channels.items() if n[:2] != "cutting.s"}
        )
        calibrate_table(bare, axes=AXES, protocol=protocol)
        with pytest.raises(UnusableInput, match="would work") as refused:
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


@pytest.mark.usefixtures("calibrated_once")
def test_an_unplugged_sensor_is_told_with_a_protocol() -> None:
    for seed in SEEDS:
        table = lathe_cuts(seed)
        bare = unplugged(without_forces(table), "spindle", seed, 0.05)
        done, left_out = calibrate_table(bare, axes=AXES, protocol=protocol_of(table))
        assert {c.axis for c in done} == {"x", "z"}
        assert "spindle.current: the same in air, in light and in heavy cuts" in left_out[0]


# c) exchanged cuts


def exchange(table: CutTable, i: int, j: int) -> CutTable:
    changed = dict(table.channels)
    for name in FORCES:
        changed[name] = changed[name].copy()
        changed[name][[i, j]] = changed[name][[j, i]]
    return replace(table, channels=changed)


def drawn_pair(table: CutTable, seed: int) -> tuple[int, int]:
    """Two turned cuts of which one has more than twice the other's tangential force."""
    rng = np.random.default_rng([seed, 79])
    turned = np.flatnonzero([o == "turn" for o in table.texts["operation"]])
    force = table["force.y"]
    while True:
        i, j = sorted(rng.choice(turned, 2, replace=False).tolist())
        if max(force[i], force[j]) > 2.0 * min(force[i], force[j]):
            return i, j


def test_two_exchanged_cuts_are_named() -> None:
    """Forces apart by more than a factor of two: 55 of 60 at least, and never another pair."""
    named = 0
    for seed in range(400, 460):
        table = lathe_cuts(seed)
        i, j = drawn_pair(table, seed)
        swapped = exchange(table, i, j)
        for check in faults.exchanged(swapped, forces_of(swapped), AXES, names_of(table)):
            if not check.passed:
                assert f"cut {table.cut[i]:g} and cut {table.cut[j]:g}" in check.sentence
                named += 1
    assert named >= 55


@pytest.mark.usefixtures("calibrated_once")
def test_exchanged_cuts_of_a_protocol_are_named() -> None:
    """What the log calls cut i was cut j: its currents are the other's. 55 of 60 at least."""
    named = 0
    for seed in range(400, 460):
        table = lathe_cuts(seed)
        protocol = protocol_of(table)
        i, j = drawn_pair(table, seed)
        bare = without_forces(table)
        changed = dict(bare.channels)
        for name in ("spindle.speed", "cutting.feed", "cutting.depth", "cutting.speed"):
            changed[name] = changed[name].copy()
            changed[name][[i, j]] = changed[name][[j, i]]
        changed["work.diameter"] = (
            1000.0 * changed["cutting.speed"] / np.pi / changed["spindle.speed"]
        )
        try:
            calibrate_table(replace(bare, channels=changed), axes=AXES, protocol=protocol)
        except UnusableInput as error:
            assert f"cut {table.cut[i]:g} and cut {table.cut[j]:g}" in str(error)
            named += 1
    assert named >= 55


def test_one_odd_current_is_no_exchange() -> None:
    """A stop within a row lowers every axis' current of that cut."""
    for seed in SEEDS:
        table = lathe_cuts(seed)
        i, _ = drawn_pair(table, seed)
        halved = {}
        for axis in AXES:
            values = table[f"{axis}.current.range"].copy()
            values[i] = 0.5 * (values[i] + table[f"{axis}.current.air"][i])
            halved[f"{axis}__current__range"] = values
        odd = with_channels(table, **halved)
        found = faults.exchanged(odd, forces_of(odd), AXES, names_of(odd))
        assert all(check.passed for check in found)


def test_a_single_axis_does_not_tell_an_exchange() -> None:
    table = lathe_cuts(SEEDS[0])
    assert faults.exchanged(table, forces_of(table), ("z",), names_of(table)) == []


# d) X as a diameter


def side_of(operation: str, depth_mm: float, feed_mm: float) -> SideFile:
    cut = {"operation": operation, "depth_mm": depth_mm, "feed_mm_rev": feed_mm}
    return SideFile.model_validate({"cut": cut})


def faced(seed: int) -> Recording:
    rng = np.random.default_rng([seed, 80])
    feed_mm, speed_rpm = float(rng.uniform(0.1, 0.25)), float(rng.uniform(800, 2000))
    cut = cut_at((0.75, feed_mm, speed_rpm, 60.0), operation="face", duration_s=2.0)
    made = raw_cut(Lathe.draw(seed), STEEL, cut, seed, True)
    return Recording(path=Path("a.csv"), channels=made, side=side_of("face", 0.75, feed_mm))


def as_diameter(recording: Recording) -> Recording:
    doubled = {"x.position": 2.0 * recording["x.position"]}
    return replace(recording, channels={**recording.channels, **doubled})


def test_x_as_a_diameter_is_named_in_facing() -> None:
    for seed in SEEDS:
        sound = faced(seed)
        assert raw.cut_of_recording(sound).table["cutting.feed"] > 0
        with pytest.raises(UnusableInput, match=r"a\.csv: x moves by 2 times the feed, as if X"):
            raw.cut_of_recording(as_diameter(sound))


def test_a_velocity_alone_tells_a_diameter() -> None:
    sound = faced(SEEDS[0])
    channels = dict(sound.channels)
    velocity = np.gradient(channels.pop("x.position"), sound.t_s)
    for factor, passed in ((1.0, True), (2.0, False)):
        made = replace(sound, channels={**channels, "x.velocity": factor * velocity})
        (check,) = faults.x_travels(made, slice(2500, 4000))
        assert check.passed == passed


def passes(depth_mm: float, seed: int) -> Recording:
    """Three passes of turning: z feeds 8 mm, x steps out, z returns, x steps in by the depth."""
    rng = np.random.default_rng([seed, 81])
    radius = 30.0 - depth_mm * np.arange(3)
    z, x = [], []
    for r in radius:
        z += [np.linspace(8.0, 0.0, 2400), np.full(200, 0.0), np.linspace(0.0, 8.0, 200)]
        x += [np.full(2400, r), np.linspace(r, r + 2.0, 200), np.full(200, r + 2.0)]
    z_mm, x_mm = np.concatenate(z), np.concatenate(x)
    channels = {
        "t": 0.001 * np.arange(len(z_mm)),
        "x.position": x_mm + 0.001 * rng.standard_normal(len(x_mm)),
        "z.position": z_mm,
        "spindle.speed": np.full(len(z_mm), 1000.0),
    }
    return Recording(path=Path("a.csv"), channels=channels, side=side_of("turn", depth_mm, 0.2))


def test_x_as_a_diameter_is_named_between_passes() -> None:
    for seed in SEEDS:
        sound = passes(0.5 + 0.1 * (seed % 20), seed)
        assert all(check.passed for check in faults.x_travels(sound, slice(0, 2400)))
        (check,) = faults.x_travels(as_diameter(sound), slice(0, 2400))
        assert not check.passed
        assert "x.position steps between passes by 2 times the depth" in check.sentence
        assert "diameter = true under [recording]" in check.sentence


def test_one_pass_has_no_step() -> None:
    sound = passes(1.0, 1)
    one = replace(sound, channels={n: v[:2400] for n, v in sound.channels.items()})
    assert pass_steps_mm(one, 0.2 * 1000 / 60).size == 0


def test_x_as_a_diameter_is_named_in_a_table() -> None:
    for seed in SEEDS:
        table = lathe_cuts(seed)
        radius = 0.5 * table["work.diameter"] + 12.0
        sound = with_channels(table, x__position=radius)
        assert faults.x_over_diameter(sound)[0].passed
        (check,) = faults.x_over_diameter(with_channels(table, x__position=2.0 * radius))
        assert not check.passed


# The command


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
            'as if cutting.feed in inch; unit = "inch" for cutting.feed in the side file would work'
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
    assert "is it plugged in?" in " ".join(done.out.split())


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


def test_a_protocol_of_other_cuts_is_no_wrong_unit() -> None:
    table = without_forces(lathe_cuts(SEEDS[0]))
    slow = with_channels(table, cutting__feed=np.full(len(table), 0.23))
    with pytest.raises(UnusableInput, match="no row is a standard cut"):
        calibrate_table(slow, axes=AXES, protocol=standard.read_protocol("turning-aluminium"))
