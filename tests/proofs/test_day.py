"""A lathe's day: its generator, the oracle, what is carried ahead, and how the proof judges."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from autodb.errors import UnusableInput
from autodb.explain.answer import Cause, ChannelAnswer, FitQuality, IntervalValue, Where
from autodb.explain.cuts.candidates.over_time import coldness, has_pause, warming_candidates
from autodb.explain.cuts.carried import ahead
from autodb.explain.cuts.cut_search import FoundInCuts, look_in_cuts, stack_of
from autodb.proofs.machines.lathe.day import CUTS, FORCES, HOURS, Day, draw_day
from autodb.proofs.runs.found import markdown
from autodb.proofs.runs.keeping import day_run
from autodb.proofs.runs.keeping.day_oracle import FEWEST, case_of, decidable_from, first_sure, sure
from autodb.proofs.runs.keeping.day_run import DayOutcome, EventOutcome, Invented, names_it, walked
from autodb.proofs.runs.keeping.day_summary import BETTER, DaySummary, day_summary_of
from autodb.proofs.runs.run_file import Finished, Origin
from autodb.records.tables import CutTable

SEED = 501


@cache
def _day(size: float = 1.0, count: int = CUTS) -> Day:
    return draw_day(SEED, size=size, count=count)


# The generator


def test_a_day_has_300_cuts_in_twelve_hours_and_three_edge_changes() -> None:
    cuts = _day().cuts
    ends = cuts.t_s + cuts.duration_s
    assert len(cuts.t_s) == CUTS
    assert_allclose(ends[-1], 3600.0 * HOURS)
    assert np.all(cuts.t_s[1:] > ends[:-1])
    assert_array_equal(np.unique(cuts.edge), [0.0, 1.0, 2.0, 3.0])
    changed = np.flatnonzero(np.diff(cuts.edge)) + 1
    assert_array_equal(cuts.used_s[[0, *changed]], 0.0)
    same = np.diff(cuts.edge) == 0
    assert_allclose(np.diff(cuts.used_s)[same], cuts.duration_s[:-1][same])


def test_effects_are_absent_where_they_must_be() -> None:
    day = _day()
    for event in day.events:
        outside = np.ones(CUTS, dtype=bool)
        outside[event.first - 1 : event.last] = False
        assert np.all(event.part[:, outside] == 0.0), event.name
    drift = day.events[-1]
    assert np.sum(np.any(drift.part != 0.0, axis=1)) == 1
    (hard,) = [event for event in day.events if event.term == "hard_spot"]
    assert np.unique(day.bar[hard.first - 1 : hard.last]).size == 1
    assert np.all(np.any(hard.part[:, hard.first - 1 : hard.last] > 0.0, axis=0))


def test_the_machine_is_cold_in_the_morning_and_after_pauses() -> None:
    day = _day()
    assert 0.9 < day.cold[0] <= 1.0
    assert abs(float(np.median(day.cold))) < 0.2
    longest = int(np.argmax(np.diff(day.cuts.t_s)))
    assert day.cold[longest + 1] > day.cold[longest] + 0.1


def test_a_seed_is_always_the_same_day_and_each_another() -> None:
    again = draw_day(SEED)
    assert_array_equal(again.measured, _day().measured)
    assert_array_equal(again.cuts.t_s, _day().cuts.t_s)
    assert not np.array_equal(draw_day(SEED + 1).cuts.feed_mm, again.cuts.feed_mm)


def test_a_day_without_size_is_the_stored_model_and_scatter() -> None:
    day = _day(0.0)
    white = (day.measured - day.expected) / day.scatter
    # 900 draws of sd 1: 4 standard errors of mean and of sd
    assert abs(float(white.mean())) < 4.0 / 30.0
    assert abs(float(white.std()) - 1.0) < 4.0 / np.sqrt(2.0 * 900.0)


def test_too_few_cuts_are_no_day() -> None:
    with pytest.raises(ValueError, match="12 cuts are no day; 60 are"):
        draw_day(SEED, count=12)


# The oracle


def test_ten_times_as_much_is_decidable_at_once_and_nothing_never() -> None:
    (hard,) = [event for event in _day(3.0).events if event.term == "hard_spot"]
    assert decidable_from(_day(3.0), hard) == max(hard.first, FEWEST)
    none = replace(hard, part=0.0 * hard.part, last=hard.first + 9)
    quiet = replace(
        _day(0.0, 60), events=(replace(none, part=0.0 * _day(0.0, 60).cold * np.ones((3, 1))),)
    )
    assert decidable_from(quiet, quiet.events[0]) is None


def test_the_judge_sees_no_later_cut_and_takes_others_off() -> None:
    day = _day()
    event = day.events[1]
    case = case_of(day, event, 50)
    changed = day.measured.copy()
    changed[:, 50:] += 1e6
    assert_array_equal(case_of(replace(day, measured=changed), event, 50).measured, case.measured)
    assert case.measured.shape == (3, 50)
    assert_array_equal(case.hidden[0].part, event.part[:, :50])


def test_the_first_sure_count_is_found_cut_by_cut() -> None:
    day, event = _day(3.0), _day(3.0).events[1]
    at = first_sure(lambda count: case_of(day, event, count), event.first, CUTS)
    assert at is not None
    assert sure(case_of(day, event, at))
    assert at == FEWEST or not sure(case_of(day, event, at - 1))


# What is carried ahead


def _table(day: Day, rows: slice, *, forces: bool) -> CutTable:
    channels = {name: values[rows] for name, values in day.channels.items()}
    if forces:
        channels |= dict(zip(FORCES, day.measured[:, rows], strict=True))
    return CutTable(Path("day.csv"), channels)


def _simulation(day: Day, rows: slice) -> dict[str, np.ndarray]:
    return dict(zip(FORCES, day.expected[:, rows], strict=True))


@cache
def _searched(size: float, count: int) -> FoundInCuts:
    rows, day = slice(0, count), _day(size)
    includes = list(day.world.parts)
    return look_in_cuts(
        stack_of(_table(day, rows, forces=True), _simulation(day, rows), includes), includes
    )


def test_wear_goes_on_and_begins_anew_with_an_edge() -> None:
    day = _day(2.0)
    change = day.events[2].first - 1
    seen = change - 5
    result = _searched(2.0, seen)
    assert "tool_wear" in result.found.keys
    rows = slice(seen, change + 5)
    predicted = ahead(result, _table(day, rows, forces=False), _simulation(day, rows))
    added = (predicted.force - day.expected[:, rows])[2] / day.cuts.depth_mm[rows]
    assert float(np.median(added[5:])) < 0.5 * float(np.median(added[:5]))
    before = np.sqrt(np.mean((day.measured - day.expected)[:, rows] ** 2))
    assert np.sqrt(np.mean((day.measured[:, rows] - predicted.force) ** 2)) < 0.7 * before
    assert np.all(predicted.sd > 0.0)


def test_where_nothing_was_found_the_simulation_stays() -> None:
    day, rows = _day(0.0), slice(40, 50)
    result = _searched(0.0, 40)
    assert not result.found.choices
    predicted = ahead(result, _table(day, rows, forces=False), _simulation(day, rows))
    assert_array_equal(predicted.force, day.expected[:, rows])


def test_cuts_ahead_need_what_the_table_has() -> None:
    day, rows = _day(0.0), slice(40, 50)
    table = _table(day, rows, forces=False)
    bare = CutTable(table.path, {n: v for n, v in table.channels.items() if n != "cutting.speed"})
    with pytest.raises(UnusableInput, match=r"no 'cutting\.speed' in every cut"):
        ahead(_searched(0.0, 40), bare, _simulation(day, rows))
    with pytest.raises(UnusableInput, match=r"no force\.z of the simulation"):
        ahead(
            _searched(0.0, 40),
            table,
            {n: v for n, v in _simulation(day, rows).items() if n != "force.z"},
        )


# The warm-up as it is searched for


def test_coldness_falls_in_work_and_comes_back_in_a_pause() -> None:
    stack = _searched(0.0, 40).stack
    t_s = np.concatenate([100.0 * np.arange(20), 20_000.0 + 100.0 * np.arange(20)])
    known = replace(stack.known, t_s=t_s, cutting_time_s=50.0 * np.arange(40.0))
    paused = replace(stack, known=known)
    cold = coldness(paused, 600.0)
    assert_allclose(cold[0], 1.0, atol=0.1)
    assert np.all(np.diff(cold[:20]) < 0.0)
    assert abs(cold[19]) < 0.1
    assert cold[20] > 0.9
    later = replace(paused, like=paused, known=replace(known, t_s=t_s[-1] + 100.0 + t_s))
    assert abs(coldness(later, 600.0)[0] - cold[-1]) < 0.1


def test_without_a_pause_no_warm_up_is_searched_for() -> None:
    stack = _searched(0.0, 40).stack
    even = replace(stack, known=replace(stack.known, t_s=100.0 * np.arange(40.0)))
    assert not has_pause(even.known)
    assert warming_candidates(even) == []


# Walking and summing up


Stretch = tuple[float, float] | None


def _answer(
    term: str, *, edge: str = "", low: float = 1.0, stretch: Stretch = None,
    others: tuple[str, ...] = (),
) -> ChannelAnswer:  # fmt: skip
    rate = IntervalValue(value=2.0, low=low, high=3.0, unit="N/s")
    cause = Cause(
        term=term, kind="missing", confidence=0.9, statement="", alternatives=others,
        parameters={"rate": rate} | ({edge: rate} if edge else {}),
    )  # fmt: skip
    where = Where(intervals=() if stretch is None else (stretch,))
    quality = FitQuality(
        rms_before=1, rms_after=1, heldout_before=1, heldout_after=1, noise_floor=1
    )
    return ChannelAnswer(unit="N", mismatch=True, where=where, missing=(cause,), fit=quality)


def test_an_edge_is_named_by_its_own_rate_and_a_bar_by_its_cuts() -> None:
    day = _day()
    second = day.events[2]
    (hard,) = [event for event in day.events if event.term == "hard_spot"]

    def everywhere(answer: ChannelAnswer) -> dict[str, ChannelAnswer]:
        return dict.fromkeys(FORCES, answer)

    assert names_it(everywhere(_answer("tool_wear", edge="rate edge 2")), second, CUTS)
    assert not names_it(
        everywhere(_answer("tool_wear", edge="rate edge 2", low=-1.0)), second, CUTS
    )
    assert not names_it(everywhere(_answer("tool_wear", edge="rate edge 1")), second, CUTS)
    own = float(hard.first), float(hard.last)
    assert names_it(everywhere(_answer("hard_spot", stretch=own)), hard, CUTS)
    assert not names_it(everywhere(_answer("hard_spot", stretch=(1.0, 300.0))), hard, CUTS)
    drift = day.events[-1]
    (which,) = np.flatnonzero(np.any(drift.part != 0.0, axis=1))
    other = FORCES[(which + 1) % 3]
    nothing = _answer("gain").model_copy(update={"missing": ()})
    elsewhere = {**everywhere(nothing), other: _answer("sensor_drift")}
    assert not names_it(elsewhere, drift, CUTS)
    (wrong,) = day_run.invented(day, {300: elsewhere})
    assert wrong == Invented("sensor_drift", other, 300, 1, double=False)
    doubled = {**everywhere(nothing), other: _answer("gain", others=("tool_wear",))}
    (wrong,) = day_run.invented(day, {300: doubled})
    assert wrong.double


@pytest.mark.campaign
def test_a_short_day_of_large_effects_is_walked_through() -> None:
    day = _day(2.5, 60)
    (hard,) = [event for event in day.events if event.term == "hard_spot"]
    others = np.sum([event.part for event in day.events if event is not hard], axis=0)
    outcome = walked(replace(day, events=(hard,), measured=day.measured - others), step=30)
    (bar,) = outcome.events
    assert bar.decidable == max(hard.first, FEWEST)
    assert bar.in_time
    assert outcome.explained == 3  # after 30 and 60 cuts, and ten after the bar began
    assert bar.named == 30


def _outcome(name: str, *, decidable: int | None = 50, in_time: bool = True) -> EventOutcome:
    found = in_time and decidable is not None
    said, sixty = found if decidable else None, 60 if found else None
    return EventOutcome(name, "x", 1, decidable, said, said, sixty, sixty, 1.0 if found else None)


def _summary(
    *, in_time: bool = True, invented: tuple[Invented, ...] = (), left: float = 0.5
) -> DaySummary:
    names = ("warm-up", "wear of edge 1", "wear of edge 2", "hard bar", "drifting sensor")
    events = tuple(_outcome(name, in_time=in_time or name != "hard bar") for name in names)
    days = [
        DayOutcome(seed, 20, events, invented, (50.0, 60.0, 70.0),
                   (50 * left, 60 * left, 70 * left), (20.0, 20.0, 20.0))
        for seed in (1, 2)
    ]  # fmt: skip
    runs = [Finished(day.seed, (day,)) for day in days]
    return day_summary_of(runs, Origin("day", "0", "g", "p"))


def test_the_summary_passes_and_each_limit_can_fail() -> None:
    good = _summary()
    assert good.passed
    assert_allclose(good.better, 0.5)
    assert [row.late for row in good.rows] == [10.0] * 5
    missed = _summary(in_time=False)
    assert [row.passed for row in missed.rows] == [True, True, True, False, True]
    assert not missed.passed
    named = _summary(invented=(Invented("gain", "force.y", 200, 2, double=False),))
    assert not named.passed
    assert named.invented == (("gain", "force.y", 2, 4, False),)
    assert not _summary(left=1.0 - 0.9 * BETTER).passed
    assert _summary(left=1.0 - 1.1 * BETTER).predicts


def test_a_summary_is_read_as_written_and_shown() -> None:
    summary = _summary(in_time=False, invented=(Invented("gain", "force.y", 200, 2, double=True),))
    assert DaySummary.from_json(summary.to_json()) == summary
    page = markdown(summary)
    assert "| hard bar | 2 | 2 | 0 of 2 |" in page
    assert "| gain | force.y | 2 | 4 | always |" in page
    assert page.count("FAILED") == 2
