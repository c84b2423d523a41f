"""The cuts that tell two explanations apart, on tables that cannot: made from truth, they do.

The laws of the truth here are none of the vocabulary's own formulas.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.answer import Cause
from autodb.explain.cuts.candidates.laws import LawColumns
from autodb.explain.cuts.candidates.searched import gain_step, hard_spot_of_cuts
from autodb.explain.cuts.carried import elsewhere, fit_cuts_account
from autodb.explain.cuts.cut_search import FoundInCuts, look_in_cuts, stack_of
from autodb.explain.cuts.distinguishing import Parted, Trials, after_forces
from autodb.explain.cuts.fit import fit_cuts
from autodb.explain.cuts.trials import (
    CUTS,
    LEAST,
    MOST,
    CutTrial,
    joined_trials,
    paired,
    plain_trials,
    usual,
)
from autodb.explain.engine.candidates import Choice
from autodb.explain.engine.telling import SEPARATES
from autodb.records.tables import CutTable
from tests.helpers.campaigns import first

Array = NDArray[np.float64]
Table = dict[str, Array]
Forces = dict[str, Array]

STRENGTH_N_MM2 = {"force.x": 700.0, "force.y": 2100.0, "force.z": 1100.0}
SCATTER_N, SCATTER = 6.0, 0.02
ALL, TANGENTIAL, AXIAL = tuple(STRENGTH_N_MM2), ("force.y",), ("force.z",)
SHEAR = ["shear"]


def _table(kinds: list[tuple[float, float]], *, count: int) -> Table:
    """Return turning with one edge; ``kinds`` feeds and depths [mm] that cuts are made with."""
    rng = np.random.default_rng(2)
    cutting_s = np.concatenate([[0.0], np.cumsum(rng.uniform(20.0, 40.0, count))[:-1]])
    feed, depth = np.array(kinds)[rng.integers(0, len(kinds), count)].T
    return {
        "cut": np.arange(count) + 1.0, "t": 1.3 * cutting_s, "cutting.feed": feed,
        "cutting.depth": depth, "cutting.speed": np.full(count, 120.0),
        "tool.edge": np.ones(count), "tool.cutting_time": cutting_s,
    }  # fmt: skip


def _all_of(feeds: list[float], depths: list[float]) -> list[tuple[float, float]]:
    return [(feed, depth) for feed in feeds for depth in depths]


def _chip(table: Table) -> Forces:
    area = table["cutting.depth"] * table["cutting.feed"]
    return {name: k * area for name, k in STRENGTH_N_MM2.items()}


def _worn(table: Table) -> Forces:
    grown = 0.03 * table["cutting.depth"] * table["tool.cutting_time"]
    return {n: k * grown for n, k in zip(STRENGTH_N_MM2, (1.3, 0.8, 1.0), strict=True)}


def _drift(table: Table) -> Forces:
    return {n: 0.03 * table["t"] * (n == "force.z") for n in STRENGTH_N_MM2}


def _ploughed(table: Table) -> Forces:
    length = table["cutting.depth"] * np.tanh(table["cutting.feed"] / 0.008)
    return {n: k * length for n, k in zip(STRENGTH_N_MM2, (60.0, 90.0, 80.0), strict=True)}


def _deeper(table: Table) -> Forces:
    depth = table["cutting.depth"]
    return {n: f * (((depth + 0.1) / depth) ** 0.98 - 1.0) for n, f in _chip(table).items()}


def _thin(table: Table) -> Forces:
    return {n: f * 0.06 / (0.04 + table["cutting.feed"]) for n, f in _chip(table).items()}


@dataclass(frozen=True)
class Case:
    """A table, what its simulation leaves out, the name of that, and the components recorded."""

    table: Table
    truth: Callable[[Table], Forces]
    term: str
    rival: str
    names: tuple[str, ...]


NARROW, THREE = (_all_of(feeds, [1.0, 2.0]) for feeds in ([0.06, 0.1], [0.04, 0.06, 0.1]))
TOGETHER = [(0.06, 0.5), (0.1, 0.8), (0.15, 1.2)]
CASES = {
    "wear": Case(_table([(0.2, 1.0), (0.2, 1.2)], count=60), _worn, "tool_wear", "sensor_drift",
                 AXIAL),
    "drift": Case(_table([(0.2, 1.0), (0.2, 1.1)], count=60), _drift, "sensor_drift", "tool_wear",
                  AXIAL),
    "edge or thin": Case(_table(NARROW, count=150), _ploughed, "edge_force", "size_effect", ALL),
    "edge or depth": Case(_table(TOGETHER, count=150), _ploughed, "edge_force", "depth_error",
                          TANGENTIAL),
    "depth or edge": Case(_table(TOGETHER, count=150), _deeper, "depth_error", "edge_force", ALL),
}  # fmt: skip
EXPECTED = {
    "wear": "Change the edge and make",
    "drift": "Change the edge and make",
    "edge or thin": "with a feed of",
    "edge or depth": "with a ",
    "depth or edge": "with a ",
}


def _pair(case: Case, table: Table, *, seed: int = 3) -> tuple[CutTable, CutTable]:
    """Return cuts as the truth makes them, with scatter, and their simulation."""
    rng = np.random.default_rng([seed, 5])
    simulated = {n: f for n, f in _chip(table).items() if n in case.names}
    effect = case.truth(table)
    sensed = {
        n: f + effect[n] + np.hypot(SCATTER_N, SCATTER * f) * rng.normal(size=len(f))
        for n, f in simulated.items()
    }
    path = Path("cuts.csv")
    return CutTable(path, {**table, **sensed}), CutTable(path, {"cut": table["cut"], **simulated})


def _searched(case: Case) -> FoundInCuts:
    recording, simulation = _pair(case, case.table)
    simulated = {name: simulation[name] for name in case.names}
    return look_in_cuts(stack_of(recording, simulated, SHEAR), SHEAR)


def _as_named(case: Case) -> tuple[FoundInCuts, Choice]:
    """Return a table as searched, explained by the effect that it was made with alone."""
    result = _searched(case)
    offers = result.search.offers((), [s for s in result.search.candidates if s.term == case.term])
    best = max(offers, key=lambda offer: offer.worth)
    found = result.search.settled((best.choice,))
    return replace(result, found=found), found.choices[0]


def _best(case: Case) -> Parted:
    result, choice = _as_named(case)
    best = after_forces(result).best(choice, case.rival)
    assert best is not None
    return best


def _with(table: Table, trial: CutTrial) -> Table:
    """Return a table with the cuts of a trial after its own."""
    known = trial.known
    more = {
        "cut": known.number, "t": known.t_s, "cutting.feed": known.thickness_mm,
        "cutting.depth": known.depth_mm, "cutting.speed": known.speed_m_min,
        "tool.edge": known.edge, "tool.cutting_time": known.cutting_time_s,
    }  # fmt: skip
    assert all(values is not None for values in more.values())
    return {name: np.concatenate([values, more[name]]) for name, values in table.items()}


def _named(case: Case, table: Table) -> list[Cause]:
    answers = explain(*_pair(case, table), includes=SHEAR).explanation.channels
    return [c for answer in answers.values() for c in answer.missing if c.kind == "missing"]


def test_no_chip_but_a_thin_one_tells_an_edge_from_a_size_effect() -> None:
    """A thicker one would separate the two fits; laws that are only nearly right differ there."""
    case = Case(_table(THREE, count=150), _thin, "size_effect", "edge_force", ALL)
    result, choice = _as_named(case)
    assert after_forces(result).best(choice, case.rival) is None


@pytest.mark.parametrize("name", first(1, CASES))
def test_the_cuts_asked_for_tell_the_two_apart(name: str) -> None:
    case = CASES[name]
    best = _best(case)
    assert EXPECTED[name] in best.trial.words
    assert best.gap.odds > SEPARATES
    once_more = _with(case.table, plain_trials(_searched(case).stack.known)[0])
    for table in (case.table, once_more):
        before = _named(case, table)
        assert any({case.term, case.rival} <= {c.term, *c.alternatives} for c in before)
    after = [{c.term, *c.alternatives} for c in _named(case, _with(case.table, best.trial))]
    assert after
    assert all(case.term in names and case.rival not in names for names in after)


def test_the_answer_says_what_to_cut_and_what_it_would_show() -> None:
    (cause,) = _named(CASES["wear"], CASES["wear"].table)
    assert cause.alternatives == ("gain", "sensor_drift")
    assert cause.to_tell_apart is not None
    assert cause.to_tell_apart.startswith("Change the edge and make 10 cuts like cut ")
    assert "there tool_wear and sensor_drift would differ by up to " in cause.to_tell_apart
    best = _best(CASES["wear"])
    assert f"up to {best.gap.peak:.2g} N, scatter is {best.scatter:.2g} N" in cause.to_tell_apart
    assert f"together {np.sqrt(best.gap.odds):.2g} standard deviations." in cause.to_tell_apart


def test_without_alternatives_nothing_is_asked_for() -> None:
    case = CASES["wear"]
    (cause,) = _named(case, _with(case.table, _best(case).trial))
    assert cause.alternatives == ()
    assert cause.to_tell_apart is None


def test_what_no_cut_separates_is_not_asked_for() -> None:
    result, choice = _as_named(CASES["wear"])
    teller = after_forces(result)
    sets = result.found.choices, result.found.choices
    assert all(trials.best(*sets) is None for trials in teller.rounds)
    assert teller.distinguishing(choice, "tool_wear", []) is None
    assert teller.distinguishing(choice, "tool_wear", ["nose_radius"]) is None


def test_a_fresh_edge_parts_wear_from_drift_by_what_had_worn() -> None:
    """A drift stays at what it had come to; wear is gone, but for what the fit leaves open."""
    case = CASES["wear"]
    best = _best(case)
    last = {name: values[-1:] for name, values in case.table.items()}
    row = usual(_searched(case).stack.known)
    last["cutting.depth"] = case.table["cutting.depth"][row : row + 1]
    assert_allclose(best.gap.peak, _worn(last)["force.z"][0], rtol=0.25)


@pytest.mark.parametrize("make", [plain_trials, paired])
def test_trials_stay_near_what_the_table_shows(make: Callable[..., list[CutTrial]]) -> None:
    known = _searched(CASES["edge or thin"]).stack.known
    seen = {"feed": known.thickness_mm, "depth": known.depth_mm, "speed": known.speed_m_min}
    trials = make(known)
    assert len({trial.words for trial in trials}) == len(trials)
    for trial in trials:
        now = trial.known
        set_to = {"feed": now.thickness_mm, "depth": now.depth_mm, "speed": now.speed_m_min}
        for name, values in set_to.items():
            of = seen[name]
            assert values is not None
            assert of is not None
            assert len(values) == CUTS
            assert values.min() > 0.99 * LEAST * of.min()
            assert values.max() < 1.01 * MOST * of.max()
        assert now.t_s[0] > known.t_s[-1]
        assert now.number[0] > known.number[-1]


def test_only_what_the_table_has_is_changed() -> None:
    known = _searched(CASES["wear"]).stack.known
    bare = replace(
        known, thickness_mm=None, speed_m_min=None, edge=None, cutting_time_s=None,
        recorded=frozenset(), other={},
    )  # fmt: skip
    (once,) = plain_trials(bare)
    assert once.words == f"Make {CUTS} cuts like cut {known.number[usual(known)]:g}"
    assert paired(bare) == []


# The parts


def test_the_table_s_own_cuts_carried_to_themselves_are_the_fit() -> None:
    """Shapes, scales, knots, scatter and simulation come from the table, whatever follows it."""
    for name in ("wear", "edge or thin", "depth or edge"):
        result, _ = _as_named(CASES[name])
        stack = result.stack
        rows = np.flatnonzero(stack.known.depth_mm == stack.known.depth_mm[usual(stack.known)])
        there = elsewhere(result, stack.known, usual(stack.known))
        assert_allclose(there.stack.simulation, stack.simulation, rtol=1e-6)
        assert_allclose(there.stack.sd, stack.sd, rtol=1e-6)
        carried = fit_cuts_account(result, result.found.choices, there).force
        fitted = np.sum(fit_cuts(stack, result.own, result.found.choices).parts, axis=0)
        assert_allclose(carried[:, rows], fitted[:, rows], rtol=1e-3, atol=0.1)


def test_every_candidate_is_carried_as_it_is() -> None:
    """In every shape the columns of the table's own cuts are those that the table has."""
    result = _searched(CASES["depth or edge"])
    there = elsewhere(result, result.stack.known, usual(result.stack.known))
    for candidate in result.search.candidates:
        if candidate.anew is not None:  # those that a scan found are of rows, which go on
            continue
        for form in range(len(candidate.forms)):
            choice = Choice(candidate, form)
            own = there.columns(())
            columns = there.columns((choice,))[:, :, own.shape[2] :]
            here = candidate.forms[form].law().reshape(columns.shape)
            if "turns" in candidate.key:
                continue
            white = result.stack.white(columns).reshape(columns.shape)
            assert_allclose(white, here, rtol=1e-6, atol=1e-6 * np.abs(here).max() + 1e-12)


def test_runs_and_steps_go_on_where_they_reached_the_end() -> None:
    result = _searched(CASES["wear"])
    stack, count = result.stack, len(result.stack.known)
    (trial, *_) = plain_trials(stack.known)
    there = elsewhere(result, trial.known, usual(stack.known)).stack
    for end, share in ((count, 1.0), (count - 5, 0.0)):
        candidate = hard_spot_of_cuts(stack, 10, end, 0, tries=1)
        assert candidate.anew is not None
        law = candidate.anew(there).forms[0].law
        assert isinstance(law, LawColumns)
        assert_allclose(law.raw()[:, :, 0], share * there.simulation)
    step = gain_step(stack, 0, 30, 0)
    assert step.anew is not None
    law = step.anew(there).forms[0].law
    assert isinstance(law, LawColumns)
    assert_allclose(law.raw()[0, :, 0], there.simulation[0])


def test_trials_are_judged_each_by_itself() -> None:
    result, choice = _as_named(CASES["wear"])
    teller = after_forces(result)
    other = teller.instead(choice, "sensor_drift")
    assert other is not None
    best = teller.best(choice, "sensor_drift")
    assert best is not None
    alone = Trials(result, [best.trial]).best(result.found.choices, other.choices)
    assert alone is not None
    assert_allclose(alone.gap.odds, best.gap.odds, rtol=1e-9)


def test_conditions_join_in_their_order() -> None:
    known = _searched(CASES["wear"]).stack.known
    trials = plain_trials(known)
    whole = joined_trials([trial.known for trial in trials])
    assert len(whole) == CUTS * len(trials)
    ends = CUTS * np.arange(len(trials) + 1)
    for trial, (start, end) in zip(trials, pairwise(ends), strict=True):
        assert_allclose(whole.depth_mm[start:end], trial.known.depth_mm)
        assert whole.cutting_time_s is not None
        assert trial.known.cutting_time_s is not None
        assert_allclose(whole.cutting_time_s[start:end], trial.known.cutting_time_s)


def test_a_table_that_nothing_can_follow_asks_for_nothing() -> None:
    """A table without the columns that trials would change: there are none to follow it."""
    rng = np.random.default_rng(2)
    feed, depth = rng.uniform(0.1, 0.4, 40), rng.uniform(0.5, 3.0, 40)
    held = {
        "cut": np.arange(1.0, 41.0), "feed": feed, "depth": depth, "speed": np.full(40, 180.0),
    }  # fmt: skip
    plain = 1800.0 * depth * feed
    sensed = plain + 60.0 * depth + rng.normal(0.0, 5.0, 40)
    texts = {"operation": ["turn"] * 40}
    recording = CutTable(Path("cuts.csv"), {**held, "force.y": sensed}, texts)
    simulation = CutTable(Path("simulation.csv"), {**held, "force.y": plain}, texts)
    channel = explain(recording, simulation).explanation.channels["force.y"]
    assert channel.missing
    assert all(cause.to_tell_apart is None for cause in channel.missing)
