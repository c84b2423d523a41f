"""Cases of published tables hold what they say: sizes come back, plans are even, rivals fair."""

from collections import Counter
from collections.abc import Iterator

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb.proofs.cases.real.injected import Beside
from autodb.proofs.cases.real.real_case import MISTUNED_BY, RealSpec
from autodb.proofs.cases.tables import published_tables as tables
from autodb.proofs.cases.tables import table_cases, table_models
from autodb.proofs.cases.tables.published_tables import PublishedTable, published_tables
from autodb.proofs.cases.tables.table_cases import (
    STRENGTHS,
    table_specs,
    tabled_case,
    without_effect,
)
from autodb.proofs.cases.tables.table_columns import ModelledComponent, shapes_of
from autodb.proofs.cases.tables.table_effects import MAKERS, effect_in, effects_into
from autodb.proofs.cases.tables.table_models import (
    TABLE_TERMS,
    held_out_beside,
    mixed_held_out,
    table_model,
)

SHEAR, EDGE = np.array([900.0, 2000.0, 600.0]), np.array([60.0, 90.0, 50.0])
SOFTER, OFF_MM = 0.1, 0.05
NOISE_N = 0.5


@pytest.fixture(autouse=True)
def laid(monkeypatch: pytest.MonkeyPatch) -> Iterator[PublishedTable]:
    """Put tables with known laws in the place of `fnides`, and of `lin`, whose depth is off."""
    every = {"fnides": _laid("fnides", 0.0), "lin": _laid("lin", OFF_MM)}
    monkeypatch.setattr(table_models, "published_tables", lambda: every)
    for cached in (table_model, table_cases._fitted):
        cached.cache_clear()
    yield every["fnides"]
    for cached in (table_model, table_cases._fitted):
        cached.cache_clear()


def _laid(name: str, off_mm: float) -> PublishedTable:
    plain = published_tables()[name]
    depth, n = plain.depth + off_mm, len(plain.forces)
    softer = SOFTER if "speed_softening" in TABLE_TERMS[name] else 0.0
    chip = plain.feed * depth * (1.0 - softer * plain.log_speed)
    noise = NOISE_N * np.random.default_rng(3).normal(size=(n, len(plain)))
    return plain.with_forces(SHEAR[:n, None] * chip + EDGE[:n, None] * depth + noise)


def _spec(term: str, strength: str = "strong", variant: str = "exact 1") -> RealSpec:
    return RealSpec("injected", "fnides", term, strength, variant)


def test_published_tables_are_whole() -> None:
    every = tables.published_tables()
    assert set(every) == set(TABLE_TERMS)
    for table in every.values():
        assert len(table) in {27, 64}
        assert np.all(table.components > 0.0)
        assert table.edge.tolist() == sorted(table.edge)
        assert Counter(table.clock_s[np.diff(table.edge, prepend=0) > 0]) == {0.0: tables.EDGES}


def test_a_full_model_finds_its_laws(laid: PublishedTable) -> None:
    model = table_model("fnides")
    for place, channel in enumerate(model.channels.values()):
        found = dict(zip(channel.names, channel.coefficients, strict=True))
        assert found["shear"] == pytest.approx(SHEAR[place], rel=0.1)
        assert found["edge_force"] == pytest.approx(EDGE[place], rel=0.15)
        assert found["speed_softening"] / found["shear"] == pytest.approx(SOFTER, rel=0.3)
    errors = model.errors(laid.components)
    assert np.all((errors > 0.5 * NOISE_N) & (errors < 2.0 * NOISE_N))


def test_a_full_model_finds_the_depth_that_is_off() -> None:
    model = table_model("lin")
    assert model.off_mm == pytest.approx(OFF_MM, rel=0.1)
    assert model.channels["force.y"].coefficients[-1] == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("term", effects_into("fnides"))
@pytest.mark.parametrize("strength", STRENGTHS)
def test_an_effect_is_as_strong_as_it_says(laid: PublishedTable, term: str, strength: str) -> None:
    case = tabled_case(_spec(term, strength))
    model = table_model("fnides")
    change = case.table.components - laid.components
    rms = model.errors(laid.components)
    touched = np.flatnonzero(np.any(change != 0.0, axis=1))
    left = [
        Beside(channel.columns).rms(change[i]) / rms[i]
        for i, channel in enumerate(model.channels.values())
        if i in touched
    ]
    found = float(np.sqrt(np.mean(np.square(left))))
    rng = np.random.default_rng(
        [table_cases.SEED, table_cases.TABLES.index("fnides"), list(MAKERS).index(term), 1]
    )
    effect = effect_in(term, model, rng)
    at_most = np.allclose(change, effect.most * effect.shape)
    assert found == pytest.approx(STRENGTHS[strength], rel=1e-6) or at_most
    for place, one in enumerate(case.cases):
        if place in touched:
            assert one.true_size == pytest.approx(np.max(np.abs(change[place])))
        else:
            assert (one.concealed, one.kind, one.tuning) == (None, "null", "beside an effect")


def test_each_name_has_the_shape_of_its_own_effect() -> None:
    """Columns of the name beside the own laws leave nothing of an effect but what shapes miss."""
    model = table_model("fnides")
    names = list(model.channels)
    for term in effects_into("fnides"):
        effect = effect_in(term, model, np.random.default_rng(5))
        place = effect.touched[0]
        channel = ModelledComponent(model, names[place])
        own, shape = channel.model.columns, effect.shape[place]
        least = min(Beside(np.vstack([own, c])).rms(shape) for c in shapes_of(term, channel))
        assert least <= 0.5 * Beside(own).rms(shape), term


def test_errors_beside_columns_are_those_of_a_fit_with_them(laid: PublishedTable) -> None:
    channel = ModelledComponent(table_model("fnides"), "force.y")
    own, force = channel.model.columns, laid.forces["force.y"]
    shapes = [*shapes_of("hard_spot", channel)[:5], *shapes_of("tool_wear", channel)]
    expected = [mixed_held_out(np.concatenate([own, one]), force) for one in shapes]
    assert_allclose(held_out_beside(own, shapes, force), expected, rtol=1e-9)


def test_what_a_sensor_does_is_no_rival_of_what_a_cut_does() -> None:
    hard, sensor = (tabled_case(_spec(term)).cases for term in ("hard_spot", "gain"))
    assert not {"gain", "sensor_drift"} & {name for one in hard for name in one.fair}
    gain = next(one for one in sensor if one.concealed)
    assert set(gain.fair) <= {"gain", "sensor_drift"}
    assert gain.fair[0] == "gain"


def test_a_law_left_out_is_decided_by_cuts_left_out(laid: PublishedTable) -> None:
    kept, refit = (
        tabled_case(RealSpec("left out", "fnides", "edge_force", "", variant))
        for variant in ("kept", "refit")
    )
    assert all(one.seen for one in (*kept.cases, *refit.cases))
    missing = laid.components - kept.simulated
    assert_allclose(missing, table_model("fnides").part("edge_force"), atol=5.0 * NOISE_N)
    assert np.sum((laid.components - refit.simulated) ** 2) < np.sum(missing**2)
    assert refit.includes == kept.includes == ("shear", "speed_softening")
    assert all("size_effect" in one.fair or one.decidable for one in kept.cases)


def test_nulls_are_the_full_model_or_a_little_off() -> None:
    exact = tabled_case(without_effect(_spec("gain")))
    assert_allclose(exact.simulated, table_model("fnides").components)
    more = tabled_case(RealSpec("null", "fnides", "shear", "", "more"))
    assert_allclose(
        more.simulated - exact.simulated, MISTUNED_BY * table_model("fnides").part("shear")
    )
    part = tabled_case(RealSpec("null", "fnides", variant="part 1"))
    assert len(part.table) == 18
    assert all(one.concealed is None for case in (exact, more, part) for one in case.cases)


def test_every_beginning_of_the_plan_has_every_kind() -> None:
    specs = table_specs()
    assert len({spec.name for spec in specs}) == len(specs)
    whole = Counter(spec.kind for spec in specs)
    for end in (60, 200):
        some = Counter(spec.kind for spec in specs[:end])
        for kind, count in whole.items():
            assert some[kind] == pytest.approx(end * count / len(specs), abs=2)
    injected = [spec for spec in specs if spec.kind == "injected"]
    assert {(s.recording, s.term) for s in injected} == {
        (name, term) for name in TABLE_TERMS for term in effects_into(name)
    }
