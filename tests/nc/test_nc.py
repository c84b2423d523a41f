"""Every generated program, read by a reader of its own, keeps to the machine it was made for."""

import itertools
import re
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.files.machine import MachineFile
from autodb.nc import DIALECTS
from autodb.nc.placing import Lane, lane_distance_mm
from autodb.standard import read_protocol, run_order
from tests.helpers import nc
from tests.helpers.campaigns import first
from tests.helpers.nc_cases import (
    CLEAR_MM,
    LATHE,
    SHIPPED,
    Case,
    bar_case,
    block_case,
    case_of,
    changed,
)

Places = dict[str, NDArray[np.float64]]
CASES = list(itertools.product(SHIPPED, DIALECTS))


def _drawn(dialect: str, draws: int) -> list[Case]:
    """Return random protocols for a dialect, on a lathe and on a mill, that fit."""
    draw = np.random.default_rng(11)
    makers: Sequence[Callable[[np.random.Generator, str], Case]] = (bar_case, block_case)
    return [make(draw, dialect) for make in makers for _ in range(draws)]


def _inside(case: Case, at: Places, grown_mm: float = 0.0) -> NDArray[np.bool_]:
    """Say whether a tool at a place is in the stock as clamped, grown by a distance.

    Where an axis stands is not known before it first moves: then in the middle of the stock.
    """
    zero = case.setup["zero"]
    at = {axis: np.array(zero[f"{axis}_mm"] or 0.0) for axis in "xyz"} | at
    z = at["z"] - zero["z_mm"]
    if case.protocol.bar:
        radius = at["x"] - zero["x_mm"]
        outside = case.protocol.bar.diameter_mm / 2 + grown_mm
        return np.asarray((z < grown_mm) & (radius < outside), dtype=np.bool_)
    block, tool_mm = case.protocol.block, case.protocol.geometry.diameter_mm
    assert block and tool_mm
    out_x = np.maximum(np.abs(at["x"] - zero["x_mm"]) - block.size_x_mm / 2, 0.0)
    out_y = np.maximum(np.abs(at["y"] - zero["y_mm"]) - block.size_y_mm / 2, 0.0)
    near = np.hypot(out_x, out_y) < tool_mm / 2 + grown_mm
    return np.asarray((z < grown_mm) & near, dtype=np.bool_)


def _along(motion: nc.Motion, n: int = 100) -> Places:
    return {a: np.linspace(motion.before[a], motion.after[a], n) for a in motion.before}


def _check(case: Case) -> None:
    """Assert all that must hold of a program, with and without its dry run."""
    for skip in (False, True):
        motions = case.motions(skip=skip)
        _begins_with_the_retract(case, motions)
        for motion in motions:
            _keeps_to_the_machine(case, motion)
            if motion.before and (motion.modes.rapid or motion.optional):
                assert not _inside(case, _along(motion), CLEAR_MM - 0.01).any()
    cuts = [
        motion
        for motion in case.motions()
        if not motion.modes.rapid and _inside(case, _along(motion)).any()
    ]
    assert len(cuts) >= len(run_order(case.protocol))


def _begins_with_the_retract(case: Case, motions: list[nc.Motion]) -> None:
    first = ("x", "z") if case.protocol.bar else ("z",)
    retract = case.setup["retract"]
    for axis, motion in zip(first, motions, strict=False):
        assert motion.machine
        assert motion.modes.rapid
        assert_allclose(motion.after[axis], retract[f"{axis}_mm"], atol=1e-9)
        assert motion.modes.units == ("G21" if case.dialect == "fanuc" else "G710")
        assert motion.modes.plane == ("G18" if case.protocol.bar else "G17")
        assert motion.modes.feed_per == ("rev" if case.protocol.bar else "min")
        assert not case.protocol.bar or motion.modes.limit_rpm == 3000
    assert not any(motion.machine for motion in motions[len(first) :])
    last = motions[-1].after
    assert all(abs(last[a] - retract[f"{a}_mm"]) < 1e-9 for a in first)


def _keeps_to_the_machine(case: Case, motion: nc.Motion) -> None:
    for axis, mm in motion.after.items():
        limits = case.machine.axes[axis].limits
        assert limits.travel_low_mm is not None
        assert limits.travel_high_mm is not None
        assert limits.travel_low_mm <= mm <= limits.travel_high_mm
    assert motion.after.get("z", np.inf) >= case.setup["jaws"]["z_mm"] + CLEAR_MM
    if not motion.modes.rapid:
        assert motion.modes.turning == case.setup["spindle"]
        assert 0 < motion.modes.rpm <= (3000 if case.protocol.bar else 8000)
        assert motion.modes.feed


@pytest.mark.parametrize(("name", "dialect"), CASES)
def test_a_shipped_program_keeps_to_the_machine(name: str, dialect: str) -> None:
    _check(case_of(name, dialect))


@pytest.mark.parametrize("draws", first(1, [15, 50]))
@pytest.mark.parametrize("dialect", DIALECTS)
def test_drawn_programs_keep_to_the_machine(dialect: str, draws: int) -> None:
    made = 0
    for case in _drawn(dialect, draws):
        try:
            _ = case.text
        except UnusableInput as error:
            assert re.search(r"cut 'cut \d'", str(error))
            continue
        _check(case)
        made += 1
    assert made > 1.5 * draws


@pytest.mark.parametrize(("name", "dialect"), CASES)
def test_one_hundredth_less_travel_is_refused(name: str, dialect: str) -> None:
    case = case_of(name, dialect)
    reached = [motion.after for motion in case.motions(skip=False)]
    for axis in ("x", "z") if case.protocol.bar else ("x", "y", "z"):
        values = [at[axis] for at in reached if axis in at]
        for key, limit in (
            ("travel_low_mm", min(values) + 0.01),
            ("travel_high_mm", max(values) - 0.01),
        ):
            tight = changed(case, "axes", axis, "limits", key, to=limit)
            with pytest.raises(UnusableInput, match=rf"axis {axis} would go to .* beyond {key}"):
                _ = tight.text


@pytest.mark.parametrize("dialect", DIALECTS)
def test_the_tool_feeds_in_air_before_every_cut(dialect: str) -> None:
    """A bar is followed as it is cut away; at least ``air_s`` pass at cutting feed before it."""
    case = case_of("turning-aluminium", dialect)
    bar = case.protocol.bar
    assert bar
    zero = case.setup["zero"]
    radius, face, stock, entered = bar.diameter_mm / 2, 0.0, 1, 0
    for motion in case.motions():
        if motion.stops != stock:
            radius, face, stock = bar.diameter_mm / 2, 0.0, motion.stops
        x0, z0 = (motion.before.get(a, 0.0) - zero[f"{a}_mm"] for a in "xz")
        x1, z1 = (motion.after.get(a, 0.0) - zero[f"{a}_mm"] for a in "xz")
        if motion.modes.rapid or motion.modes.feed is None:
            continue
        mm_s = motion.modes.feed * motion.modes.rpm / 60
        if x0 == x1 and z1 < face < z0 and x1 < radius:
            assert (z0 - face) / mm_s >= case.protocol.air_s
            radius, entered = x1, entered + 1
        elif z0 == z1 < face and x1 < radius < x0:
            assert (x0 - radius) / mm_s >= case.protocol.air_s
            face, entered = z1, entered + 1
    assert entered == len(run_order(case.protocol))
    assert stock == 4


@pytest.mark.parametrize("name", ["milling-c45", "drilling-c45"])
def test_a_mill_feeds_in_air_before_every_cut(name: str) -> None:
    case, entered = case_of(name, "fanuc"), 0
    for motion in case.motions():
        if motion.modes.rapid or motion.modes.feed is None:
            continue
        cutting = _inside(case, _along(motion, 2000))
        if cutting.any() and not cutting[0]:
            length = np.linalg.norm([motion.after[a] - motion.before[a] for a in "xyz"])
            in_air = (int(np.argmax(cutting)) + 1) / 2000
            assert in_air * length / (motion.modes.feed / 60) >= case.protocol.air_s
            entered += 1
    assert entered == len(run_order(case.protocol))


def test_a_program_cuts_what_the_protocol_says() -> None:
    """Feeds, speeds and directions of a slot program are those of its cuts, in the order."""
    case = case_of("milling-c45", "siemens")
    cutting = [
        m
        for m in case.motions()
        if not m.modes.rapid and m.before["z"] == m.after["z"] and m.before != m.after
    ]
    for motion, cut in zip(cutting, run_order(case.protocol), strict=True):
        dx, dy = (motion.after[a] - motion.before[a] for a in "xy")
        assert cut.feed_direction_deg is not None
        assert cut.depth_mm is not None
        turned = np.degrees(np.arctan2(dy, dx)) - cut.feed_direction_deg
        assert abs((turned + 180) % 360 - 180) < 0.01
        assert_allclose(motion.after["z"], 150 - cut.depth_mm)
        assert motion.modes.feed == 4 * cut.feed_mm * cut.speed_rpm
        assert motion.modes.rpm == cut.speed_rpm


def test_no_two_slots_of_a_block_meet() -> None:
    case = case_of("milling-c45", "fanuc")
    lanes: dict[int, list[Lane]] = {}
    for m in case.motions():
        if not m.modes.rapid and m.before["z"] == m.after["z"] and m.before != m.after:
            at = _along(m, 400)
            over = np.flatnonzero((abs(at["x"] - 300) <= 100) & (abs(at["y"] - 200) <= 70))
            start, end = ((float(at["x"][i]), float(at["y"][i])) for i in over[[0, -1]])
            lanes.setdefault(m.stops, []).append(Lane(start, end))
    assert len(lanes) == 2
    for block in lanes.values():
        for a, b in itertools.combinations(block, 2):
            assert lane_distance_mm(a, b) >= 13 - 0.5


def test_lanes_are_as_far_apart_as_their_nearest_points() -> None:
    cross = Lane((0, -1), (0, 1)), Lane((-1, 0), (1, 0))
    assert lane_distance_mm(*cross) == 0
    assert_allclose(lane_distance_mm(Lane((0, 0), (10, 0)), Lane((4, 3), (4, 9))), 3)
    assert_allclose(lane_distance_mm(Lane((0, 0), (0, 0)), Lane((3, 4), (3, 4))), 5)


REFUSED = [
    (("setup", "jaws", "z_mm"), 78.5, "cut '.*': axis z .* setup.clearance_mm = 2 to setup.jaws"),
    (("setup", "max_speed_rpm"), 1500, "cut 'fast': 2000 rpm is above the spindle's limit 1500"),
    (("setup", "retract", "x_mm"), 50, r"cut '.*': axis x .* beyond setup\.retract\.x_mm = 50"),
    (("setup", "jaws", "diameter_mm"), 310, "axis x at 148.5 .* setup.jaws.diameter_mm = 310"),
    (
        ("setup", "tailstock"),
        {"z_mm": 118, "diameter_mm": 60},
        "cut '.*': axis x .*setup.tailstock",
    ),
    (("setup", "tailstock"), {"z_mm": 118}, r"setup\.tailstock\.diameter_mm is missing"),
]


@pytest.mark.parametrize(("path", "value", "line"), REFUSED)
def test_what_does_not_fit_is_refused_in_one_line(
    path: tuple[str, ...], value: object, line: str
) -> None:
    with pytest.raises(UnusableInput, match=line):
        _ = changed(case_of("turning-aluminium", "fanuc"), *path, to=value).text


def test_a_tailstock_out_of_the_way_is_no_reason_to_refuse() -> None:
    far = {"z_mm": 280, "diameter_mm": 60}
    _check(changed(case_of("turning-aluminium", "siemens"), "setup", "tailstock", to=far))


def test_the_dry_run_has_to_fit_too() -> None:
    """No hole needs more than 164 mm of z; lifted off the block, the first begins at 178 mm."""
    low = changed(case_of("drilling-c45", "fanuc"), "setup", "retract", "z_mm", to=170)
    with pytest.raises(UnusableInput, match=r"z would go to 178\.000 .*setup\.retract\.z_mm = 170"):
        _ = low.text


@pytest.mark.parametrize(
    ("key", "line"),
    [
        ("setup", r"m\.toml: no \[setup\]"),
        ("diameter", r"m\.toml: diameter is missing"),
    ],
)
def test_what_a_machine_file_does_not_say_is_asked_for(key: str, line: str) -> None:
    content = {k: v for k, v in LATHE.items() if k != key}
    with pytest.raises(UnusableInput, match=line):
        _ = Case(
            read_protocol("turning-aluminium"), MachineFile.model_validate(content), "fanuc"
        ).text


def test_an_unknown_dialect_names_those_there_are() -> None:
    with pytest.raises(UnusableInput, match=r"dialect 'fanuk' \(did you mean fanuc"):
        _ = case_of("turning-aluminium", "fanuk").text


def test_the_same_input_gives_the_same_program_and_another_seed_another_order() -> None:
    case = case_of("turning-aluminium", "fanuc")
    assert case.text == case.text
    again = case.protocol.model_copy(update={"seed": 2})
    assert Case(again, case.machine, "fanuc").text != case.text


def test_dialects_differ_in_their_words_and_not_in_their_motions() -> None:
    for name in SHIPPED:
        places = [
            list(dict.fromkeys(str(m.after) for m in case_of(name, d).motions(skip=False)))
            for d in DIALECTS
        ]
        assert sorted(places[0]) == sorted(places[1])


def test_the_header_says_what_it_is() -> None:
    text = case_of("turning-aluminium", "fanuc").text
    head = text.split("G21")[0]
    for part in ("NOT PROVEN ON YOUR MACHINE", "TURNING-ALUMINIUM", "PDJNR2525M15", "BAR DIA 80"):
        assert part in head
    assert "SYSTEM A" in head
    assert "1006" in head
