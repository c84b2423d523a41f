"""Which cuts of a job the cuts are that were then made: by name, by conditions, by order."""

import pytest

from autodb.forward.matching import CutOfJob, MadeCut, matched


def _conditions(diameter: float, depth: float, feed: float, rpm: float = 1200) -> dict[str, float]:
    return {
        "work.diameter": diameter, "cutting.depth": depth, "cutting.feed": feed,
        "spindle.speed": rpm,
    }  # fmt: skip


SHAFT = {
    "rough 56": _conditions(56, 2.0, 0.30),
    "rough 48": _conditions(48, 2.0, 0.25),
    "rough 40": _conditions(40, 1.5, 0.25),
    "finish 39": _conditions(39, 1.0, 0.12),
}
GROOVES = {name: _conditions(50, 1.0, 0.1) for name in ("left", "middle", "right")}
"""Three cuts that no condition tells apart."""
BETWEEN = {
    "first": _conditions(50, 1.0, 0.1), "long": _conditions(60, 2, 0.3),
    "second": _conditions(50, 1.0, 0.1),
}  # fmt: skip


def _asked(job: dict[str, dict[str, float]]) -> list[CutOfJob]:
    return [CutOfJob(name, "turn", conditions) for name, conditions in job.items()]


def _found(job: dict[str, dict[str, float]], made: list[MadeCut]) -> list[str]:
    names = list(job)
    return ["/".join(names[k] for k in one.places) for one in matched(_asked(job), made)]


def _made(job: dict[str, dict[str, float]], *names: str, **other: float) -> list[MadeCut]:
    changed = {name.replace("_", "."): value for name, value in other.items()}
    return [MadeCut("turn", job[name] | changed) for name in names]


EVERY = "left/middle/right"


@pytest.mark.parametrize(
    ("job", "made", "found"),
    [
        (SHAFT, [*SHAFT], [*SHAFT]),
        (SHAFT, ["finish 39", "rough 48", "rough 56"], ["finish 39", "rough 48", "rough 56"]),
        (SHAFT, ["rough 56", "rough 40"], ["rough 56", "rough 40"]),
        (SHAFT, [*SHAFT, *SHAFT], [*SHAFT, *SHAFT]),
        (GROOVES, [*GROOVES], [*GROOVES]),
        (GROOVES, [*GROOVES, *GROOVES], [*GROOVES, *GROOVES]),
        (GROOVES, ["left", "left"], ["left/middle", "middle/right"]),
        (GROOVES, ["left"], [EVERY]),
        (BETWEEN, ["first", "long"], ["first", "long"]),
        (BETWEEN, ["long", "second"], ["long", "second"]),
        (BETWEEN, ["first"], ["first/second"]),
        (BETWEEN, ["first", "long", "second", "long"], ["first", "long", "first/second", "long"]),
    ],
    ids=[
        "in order", "out of order", "some missing", "two parts", "alike, all", "alike, two parts",
        "alike, one missing", "alike, alone", "told by what follows", "told by what went before",
        "not told by anything", "a part without its second",
    ],
)  # fmt: skip
def test_cuts_are_told_by_their_conditions_and_where_these_are_alike_by_their_order(
    job: dict[str, dict[str, float]], made: list[str], found: list[str]
) -> None:
    assert _found(job, _made(job, *made)) == found


def test_order_tells_nothing_where_it_was_not_kept() -> None:
    """The long cut comes first and last: of the other two nobody knows which is which."""
    made = _made(BETWEEN, "long", "first", "first", "long", "long")
    assert _found(BETWEEN, made)[1:3] == ["first/second", "first/second"]


@pytest.mark.parametrize(
    ("changed", "still"),
    [
        ({"cutting_feed": 0.2}, True),
        ({"cutting_feed": 0.14}, False),
        ({"spindle_speed": 700}, True),
        ({"spindle_speed": 2000}, False),
        ({"cutting_depth": 2.09}, True),
        ({"cutting_depth": 2.2}, False),
        ({"work_diameter": 56.5}, True),
        ({"work_diameter": 57}, False),
    ],
)
def test_feed_and_speed_may_be_overridden_what_is_cut_may_not(
    changed: dict[str, float], *, still: bool
) -> None:
    (found,) = _found(SHAFT, _made(SHAFT, "rough 56", **changed))
    assert found == ("rough 56" if still else "")


def test_another_operation_or_nothing_stated_fits_none() -> None:
    faced = MadeCut("face", SHAFT["rough 56"])
    silent = MadeCut("turn", {"tool.flank_wear": 0.1})
    assert _found(SHAFT, [faced, silent]) == ["", ""]


def test_a_face_is_told_by_any_diameter_that_it_goes_through() -> None:
    asked = CutOfJob("face", "face", _conditions(60, 1.0, 0.2), end_mm=20.0)
    made = [MadeCut("face", _conditions(mm, 1.0, 0.2)) for mm in (61.5, 60, 40, 20, 19)]
    assert [bool(one.places) for one in matched([asked], made)] == [False, True, True, True, False]


def test_a_name_counts_before_conditions() -> None:
    other = SHAFT["rough 56"]
    said = ("finish 39", "4", "4.0", "drill 5", "0", "5")
    named = [MadeCut("turn", other, name) for name in said]
    found = matched(_asked(SHAFT), named)
    assert [one.places for one in found] == [(3,), (3,), (3,), (), (), ()]
    assert all(one.by_name for one in found)


def test_cuts_of_one_name_are_told_by_their_order() -> None:
    asked = [CutOfJob("groove", "turn", GROOVES["left"]) for _ in range(2)]
    named = [MadeCut("turn", GROOVES["left"], "groove") for _ in range(2)]
    assert [one.places for one in matched(asked, named)] == [(0,), (1,)]


def test_grooves_that_nothing_else_tells_apart_are_told_by_how_long_they_took() -> None:
    """At 80 % of the feed a cut takes 1.25 times as long; what nobody timed may be any."""
    asked = [CutOfJob(f"{s}", "turn", GROOVES["left"], time_s=s) for s in (4.0, 6.0, 9.0)]
    times = {6.1: 0.1, 11.2: 0.08, 7.5: 0.1}
    made = [
        MadeCut("turn", GROOVES["left"] | {"cut.duration": lasted_s, "cutting.feed": feed})
        for lasted_s, feed in times.items()
    ]
    assert [matched(asked, [one])[0].places for one in made] == [(1,), (2,), ()]
    assert matched(asked, [MadeCut("turn", GROOVES["left"])])[0].places == (0, 1, 2)


def test_lines_of_a_program_are_told_by_their_number_or_by_speed_and_time() -> None:
    lines = {7: 5.0, 9: 8.0}
    asked = [
        CutOfJob(
            f"line {n}: G1", "turn", {"spindle.speed": 1200}, block=n, time_s=t, of_program=True
        )
        for n, t in lines.items()
    ]
    shaft = SHAFT["rough 56"]
    made = [
        MadeCut("turn", {}, block=9.0),
        MadeCut("turn", shaft),
        MadeCut("turn", shaft | {"cut.duration": 8.3}),
        MadeCut("turn", shaft | {"cut.duration": 6.3}),
        MadeCut("turn", shaft | {"cut.duration": 8.3, "spindle.speed": 1100}),
    ]
    assert [matched(asked, [one])[0].places for one in made] == [(1,), (), (1,), (), ()]


def test_several_lines_at_once_are_no_cut_of_known_conditions() -> None:
    rpm = {"spindle.speed": 1200}
    asked = CutOfJob("lines 4 to 9", "turn", rpm, time_s=8.0, of_program=True)
    made = [MadeCut("turn", SHAFT["rough 56"]), MadeCut("turn", {}, "lines 4 to 9")]
    assert [matched([asked], [one])[0].places for one in made] == [(), (0,)]
