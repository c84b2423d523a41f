"""Cases of real axes hold what they say: sizes come back, plans are even, fair names are fair."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.proofs.cases.real import injected, left_out_terms, real_nulls
from autodb.proofs.cases.real.friction_states import gone_at_reversals, rising_after_reversals
from autodb.proofs.cases.real.full_models import FULL_MODELS, full_model
from autodb.proofs.cases.real.held_out import BLOCKS, Blocks, block_numbers, fitted_sizes, held_out
from autodb.proofs.cases.real.injected import (
    INJECTED_INTO,
    LEAST_SEEN,
    STRENGTHS,
    Beside,
    effect_draws,
    injectable,
    injected_case,
)
from autodb.proofs.cases.real.left_out_terms import LEFT_OUT_OF, left_out_case
from autodb.proofs.cases.real.real_case import MISTUNED_BY, RealCase, RealSpec
from autodb.proofs.cases.real.real_cases import injected_specs, made_case, real_plan, real_specs
from autodb.proofs.cases.real.real_columns import REAL_TERMS, columns_of
from autodb.proofs.cases.real.real_effects import CHANGING, EFFECTS, PLACED, effect_on, effort_peak
from autodb.proofs.cases.real.real_nulls import (
    HALF_RATE,
    PARTS,
    SHORTEST_S,
    WHOLE_ONLY,
    null_case,
    rows_of,
    twin_of,
)
from autodb.proofs.cases.real.real_sources import READERS
from autodb.proofs.cases.real.rival_names import rivals_of
from autodb.proofs.cases.real.shown_cases import SHOWN, recording_of
from tests.conftest import shared
from tests.helpers.laid_axis import KNOWN, NOISE, fitted_laid_axis, laid_axis

ADDED = [term for term in PLACED if term not in KNOWN and term != "cross_coupling"]


@pytest.fixture
def laid(monkeypatch: pytest.MonkeyPatch) -> None:
    """Put the axis that is laid out by hand in the place of every recording."""
    for module in (injected, left_out_terms, real_nulls):
        monkeypatch.setattr(module, "fitted_axis", fitted_laid_axis)


def _injected(term: str, strength: str = "strong", tuning: str = "exact") -> RealCase:
    return injected_case(RealSpec("injected", "emps", term, strength, tuning))


def test_a_full_model_finds_the_terms_of_an_axis() -> None:
    axis = laid_axis()
    model = full_model(axis)
    found = dict(zip(model.names, model.coefficients, strict=True))
    for name, true in KNOWN.items():
        assert_allclose(found[name], true, rtol=0.05)
    assert_allclose(model.held_out(axis.effort).rms, NOISE, rtol=0.05)
    assert_allclose(model.whole, sum(model.part(term) for term in model.terms))


def test_a_held_out_error_is_that_of_fits_without_each_block() -> None:
    rng = np.random.default_rng(3)
    columns, y = rng.normal(size=(3, 400)), rng.normal(size=400)
    number, left = block_numbers(400), np.zeros(400)
    for block in range(BLOCKS):
        own = number == block
        left[own] = y[own] - fitted_sizes(columns[:, ~own], y[~own]) @ columns[:, own]
    assert_allclose(held_out(columns, y).rms, np.sqrt(np.mean(left**2)), rtol=1e-9)
    assert_allclose(Blocks.of(columns, y).held_out([]).rms, np.sqrt(np.mean(y**2)))


@pytest.mark.usefixtures("laid")
@pytest.mark.parametrize("term", ADDED)
def test_plain_least_squares_gives_an_injected_size_back(term: str) -> None:
    axis, model, rms = fitted_laid_axis("emps")
    case = _injected(term)
    assert case.true_size is not None
    shape = effect_on(term, axis, model, effect_draws(case.spec)).change(1.0)
    found = fitted_sizes(np.vstack([model.columns, shape]), case.axis.effort)[-1]
    assert_allclose(found, case.true_size, rtol=0.04)
    assert_allclose(Beside(model.columns).rms(case.axis.effort - axis.effort), 2.0 * rms, rtol=0.01)
    assert case.includes == model.terms
    assert_allclose(case.rms_full, NOISE, rtol=0.06)


@pytest.mark.usefixtures("laid")
def test_a_weak_effect_is_a_quarter_of_a_strong_one() -> None:
    weak, strong = (_injected("spring", strength).true_size or 0.0 for strength in STRENGTHS)
    assert_allclose(strong / weak, STRENGTHS["strong"] / STRENGTHS["weak"], rtol=1e-3)


@pytest.mark.usefixtures("laid")
def test_simulations_are_exact_mistuned_in_one_term_or_refitted() -> None:
    axis, model, _ = fitted_laid_axis("emps")
    exact, mistuned, refitted = (_injected("spring", tuning=one) for one in injected.TUNINGS)
    assert_allclose(exact.simulated, model.whole)
    (term,) = mistuned.retuned
    off = MISTUNED_BY * model.part(term)
    assert_allclose(np.abs(mistuned.simulated - model.whole), np.abs(off), atol=1e-9)
    assert_allclose(refitted.simulated, model.refitted(refitted.axis.effort).whole)
    assert set(refitted.retuned) == set(model.terms)
    for one in (exact, mistuned, refitted):
        assert_allclose(one.axis.effort, exact.axis.effort)  # one effect, however it is simulated
        assert_allclose(twin_of(one).axis.effort, axis.effort)
    assert_allclose(twin_of(mistuned).simulated, mistuned.simulated)


def test_what_changes_an_effort_changes_it_as_it_says() -> None:
    axis, model, _ = fitted_laid_axis("emps")
    rng = np.random.default_rng(1)
    change = {term: effect_on(term, axis, model, rng) for term in CHANGING}
    friction = model.part("coulomb") + model.part("viscous")
    still = np.abs(friction) < 1e-6
    assert np.max(np.abs(change["warmup"].change(0.3)[still])) < 1e-6
    delayed = axis.effort + change["lag"].change(0.02)
    assert_allclose(delayed[2:], axis.effort[:-2], atol=1e-9)
    clipped = axis.effort + change["saturation"].change(0.2)
    assert_allclose(np.max(np.abs(clipped)), 0.8 * np.max(np.abs(axis.effort)))
    assert np.all(axis.effort + change["lost_sign"].change(1.0) >= 0.0)
    gained = change["gain"].change(0.1) / axis.effort
    assert_allclose(gained[:700], 0.0)
    assert_allclose(np.abs(gained[-700:]), 0.1)
    assert np.max(np.abs(change["compliance"].change(0.5))) > 0.0
    assert effort_peak(axis) < np.max(np.abs(axis.effort))


def test_friction_remembers_where_it_turned_round() -> None:
    axis = laid_axis()
    rising = rising_after_reversals(axis, 2.0)
    assert np.all(np.abs(rising) <= 1.0)
    turned = np.flatnonzero(np.diff(np.sign(axis.v)) * axis.v[1:])[3]
    row = turned + 1
    assert rising[row] * np.sign(axis.v[row]) < 0.0  # still of the direction before
    far = np.abs(axis.position - axis.position[row]) > 12.0
    after = slice(row, row + int(np.flatnonzero(far[row:])[0]))
    assert rising[after.stop] * np.sign(axis.v[after.stop]) > 0.99
    gone = gone_at_reversals(axis, 1.0)
    moving = np.abs(axis.v) > 0.1 * axis.top_speed
    assert set(np.unique(gone[moving])) == {-1.0, 0.0, 1.0}
    assert np.all(gone * axis.direction <= 0.0)
    assert not np.any(gone_at_reversals(laid_axis(one_way=True), 1.0)[50:])


def test_what_cannot_be_told_apart_is_fair_too() -> None:
    axis = laid_axis("odrive-pull", one_way=True)
    axis = axis.with_effort(axis.effort + 3.0)
    model = full_model(axis)
    less = model.without("gravity")
    rms = model.held_out(axis.effort).rms
    assert "coulomb" in rivals_of("gravity", axis, less, less.whole, rms)
    both, known, rms = fitted_laid_axis("emps")
    assert "spring" not in rivals_of("inertia", both, known.without("inertia"), known.whole, rms)


def test_every_name_is_tried_with_columns_of_the_recording() -> None:
    axis, model, _ = fitted_laid_axis("emps")
    assert set(REAL_TERMS) == set(EFFECTS)
    for term in REAL_TERMS:
        shapes = columns_of(term, axis, model.whole, axis.effort - model.whole)
        assert bool(shapes) == (term != "cross_coupling")
        for shape in shapes:
            assert shape.shape[1] == len(axis)
            assert np.all(np.isfinite(shape))
    beside = replace(axis, other={"y.position": axis.position[::-1].copy()})
    (cross,) = columns_of("cross_coupling", beside, model.whole, axis.effort)
    assert np.corrcoef(cross[0], axis.a[::-1])[0, 1] > 0.9


@pytest.mark.usefixtures("laid")
def test_a_term_is_left_out_where_its_absence_shows() -> None:
    kept = left_out_case(RealSpec("left out", "emps", "coulomb", "", "kept"))
    assert kept.seen
    assert kept.concealed == "coulomb"
    assert "coulomb" not in kept.includes
    left = kept.axis.effort - kept.simulated
    assert_allclose(np.std(left - KNOWN["coulomb"] * kept.axis.direction), NOISE, rtol=0.1)
    refit = left_out_case(RealSpec("left out", "emps", "coulomb", "", "refit"))
    assert np.std(refit.axis.effort - refit.simulated) < np.std(left)
    assert set(refit.retuned) == set(refit.includes)


@pytest.mark.usefixtures("laid")
def test_nulls_lack_nothing() -> None:
    axis, model, rms = fitted_laid_axis("emps")
    exact = null_case(RealSpec("null", "emps", variant="exact"))
    assert exact.concealed is None
    assert_allclose(exact.rms_full, rms)
    more = null_case(RealSpec("null", "emps", "viscous", "", "more"))
    assert_allclose(more.simulated - model.whole, MISTUNED_BY * model.part("viscous"), atol=1e-12)
    half = null_case(RealSpec("null", "emps", variant=HALF_RATE))
    assert_allclose(half.axis.rate_hz, axis.rate_hz / 2.0)
    assert_allclose(half.axis.a, axis.a[::2])
    lengths = [len(range(len(axis))[rows_of(part, len(axis))]) for part in PARTS]
    assert sum(lengths) == 2 * len(axis)
    part = null_case(RealSpec("null", "emps", variant="first third, refitted"))
    assert_allclose(part.simulated, model.rows(rows_of("first third", len(axis))).refitted(
        part.axis.effort).whole)  # fmt: skip


def test_the_plan_has_what_it_must_have() -> None:
    specs = real_specs()
    kinds = Counter(spec.kind for spec in specs)
    assert kinds["injected"] >= 600
    assert kinds["null"] >= 200
    assert kinds["shown"] == len(SHOWN) == len(set(SHOWN))
    assert len({spec.name for spec in specs}) == len(specs)
    for spec in specs:
        if spec.kind == "injected":
            assert spec.term not in FULL_MODELS[spec.recording].terms
    assert {spec.recording for spec in specs if spec.kind == "left out"} == set(LEFT_OUT_OF)
    assert {spec.term for spec in injected_specs()} == set(EFFECTS)
    assert {spec.recording for spec in injected_specs()} == set(INJECTED_INTO)
    assert set(READERS) == set(FULL_MODELS) == {*INJECTED_INTO, "emps-loaded"}
    assert recording_of("laas-acc25Hz-no_inertia-kept") == "laas-acc"


def test_a_beginning_of_the_plan_is_evenly_mixed() -> None:
    specs = real_specs()
    first = specs[:200]
    kinds, every = Counter(s.kind for s in first), Counter(s.kind for s in specs)
    for kind, count in every.items():
        assert abs(kinds[kind] - 200 * count / len(specs)) <= 1
    injections = [spec for spec in first if spec.kind == "injected"]
    recordings = Counter(spec.recording for spec in injections)
    assert set(recordings) == set(INJECTED_INTO)
    assert max(recordings.values()) <= 2 * min(recordings.values())
    assert {spec.term for spec in injections} == set(EFFECTS)
    ways = Counter((spec.strength, spec.variant) for spec in injections)
    assert len(ways) == 6
    assert min(ways.values()) >= 10


def test_nothing_is_injected_that_cannot_act() -> None:
    assert "backlash" not in injectable("odrive-slow")
    assert "compliance" not in injectable("tiago-torso")
    assert "cross_coupling" in injectable("tx40-j1")
    assert "cross_coupling" not in injectable("emps")
    assert "gravity" not in injectable("tiago-torso")


@pytest.mark.parametrize("name", ["tx40-j1", "smart-x", "laas-acc"])
def test_an_injected_size_comes_back_from_a_real_recording(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("AUTODB_SHARED", str(shared("data", "real").parent.parent))
    spec = RealSpec("injected", name, "cogging", "strong", "exact")
    case = made_case(spec)
    axis, model, rms = injected.fitted_axis(name)
    shape = effect_on("cogging", axis, model, effect_draws(spec)).change(1.0)
    found = fitted_sizes(np.vstack([model.columns, shape]), case.axis.effort)[-1]
    assert case.true_size is not None
    assert_allclose(found, case.true_size, rtol=0.15)  # what the recording holds of it stays in
    assert case.seen == (Beside(model.columns).rms(case.axis.effort - axis.effort)
                         >= LEAST_SEEN * rms)  # fmt: skip


def test_parts_are_long_enough_to_be_asked_about(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AUTODB_SHARED", str(shared("data", "real").parent.parent))
    short = set()
    for name in INJECTED_INTO:
        t_s = injected.fitted_axis(name)[0].t
        if min(np.ptp(t_s[rows_of(part, len(t_s))]) for part in PARTS) < SHORTEST_S:
            short.add(name)
    assert short == WHOLE_ONLY
    parts = {spec.recording for spec in real_specs() if spec.variant.startswith("first third")}
    assert parts == set(INJECTED_INTO) - WHOLE_ONLY


def test_the_first_cases_of_the_plan_are_made(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AUTODB_SHARED", str(shared("data", "real").parent.parent))
    shared("data", "emps")
    shared("data", "odrive_cogging")
    cases = list(real_plan(10))
    assert [case.name for case in cases] == [spec.name for spec in real_specs()[:10]]
    for case in cases:
        assert next(iter(case.channels)) == "t"
        assert set(case.simulation) == {"t", case.channel}
        assert all(len(values) == len(case.axis) for values in case.channels.values())
        assert (case.concealed is None) == (case.true_size is None) == (not case.fair)
