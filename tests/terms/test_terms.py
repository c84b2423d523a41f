"""Every term: declared whole, finite everywhere, still at standstill, found again in its truth."""

import inspect
import math
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from autodb import signals
from autodb.terms.channel import ChannelPart
from autodb.terms.friction import STANDSTILL_MM_S, direction, presliding, since_reversal
from autodb.terms.term import Contribution, InputChange, OutputChange, Term
from autodb.terms.vocabulary import TERMS
from autodb.timing import examined
from tests.conftest import ROOT
from tests.helpers.recovery import Seen, recover, without_columns
from tests.helpers.truths import Array, Truth, cuts, drive, friction, table


def key_of(term: Term) -> str:
    return f"{term.name} {term.form}".strip()


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


BY_KEY = {key_of(term): term for term in TERMS}
MAKERS = (*friction.TRUTHS, *drive.TRUTHS, *cuts.TRUTHS, *table.TRUTHS)
TRUTHS = {made.key: made for made in (make() for make in MAKERS)}
EVERY_TERM = pytest.mark.parametrize("term", TERMS, ids=key_of)
USUAL = {"middle": 150.0, "period": 20.0, "start": 2.0, "end": 5.0, "first": 3.0, "last": 6.0,
         "duration": 1.0, "limit": 50.0}  # fmt: skip
"""Shape parameters that only a recording gives."""


def shape_of(term: Term) -> dict[str, float]:
    """Return a usual value of every shape parameter, by keyword."""
    return {p.keyword: p.starts[-1] if p.starts else USUAL[p.name] for p in term.shape}


def given(term: Term, values: dict[str, Array], n: int) -> Array:
    """Return what a term gives for named inputs (n,), 0 where a name is not among them."""
    arrays = [values.get(name, np.zeros(n)) for name in term.inputs]
    if isinstance(term, InputChange | OutputChange):
        first = term.changes[0] if isinstance(term, InputChange) else "effort"
        arrays = [values.get(first, np.zeros(n)), *arrays]
    return term.function(*arrays, **shape_of(term))


def varied(n: int) -> dict[str, Array]:
    """Return inputs (n,) that all change from row to row."""
    rng = np.random.default_rng(2)
    names = {name for term in TERMS for name in term.inputs} | {"thickness", "effort"}
    values = {name: rng.uniform(0.1, 3.0, n) for name in sorted(names)}
    walk = np.cumsum(rng.normal(0.0, 1.0, n)).astype(np.float64)
    velocity: Array = np.asarray(10.0 * np.sin(walk), dtype=np.float64)
    t: Array = np.arange(n, dtype=np.float64)
    return {
        **values,
        "position": walk,
        "velocity": velocity,
        "direction": direction(velocity),
        "t": t,
    }


# --- declarations


def test_every_term_is_there_once_and_has_a_truth() -> None:
    assert len(BY_KEY) == len(TERMS)
    assert set(TRUTHS) == set(BY_KEY)
    assert len(MAKERS) == len(TERMS)


@pytest.mark.parametrize(
    "path", sorted((ROOT / "tests" / "helpers" / "truths").glob("*.py")), ids=lambda path: path.stem
)
def test_a_truth_knows_no_term(path: Path) -> None:
    assert "autodb" not in path.read_text("utf-8")


@EVERY_TERM
def test_a_term_is_declared_whole(term: Term) -> None:
    assert term.channels
    assert term.statement.endswith(".")
    assert term.excited_by
    assert term.source
    assert bool(term.alike) == (term.distinguished_by is not None)
    names = {other.name for other in TERMS}
    assert {*term.alike, *term.modifies} <= names | {"*"}
    assert isinstance(term, Contribution) == bool(term.coefficients)
    assert isinstance(term, Contribution) or term.modifies


@EVERY_TERM
def test_a_function_takes_what_its_term_says_and_names_its_source(term: Term) -> None:
    text = str(inspect.getdoc(term.function))
    assert "Source:" in text or "by construction" in text
    taken = inspect.signature(term.function).parameters.values()
    keywords = [p.name for p in taken if p.kind is inspect.Parameter.KEYWORD_ONLY]
    changed = int(isinstance(term, InputChange | OutputChange))
    assert keywords == [p.keyword for p in term.shape]
    assert len(taken) - len(keywords) == len(term.inputs) + changed


@EVERY_TERM
def test_parameters_have_unit_meaning_bounds_and_starts_within(term: Term) -> None:
    names = [p.name for p in term.parameters]
    assert len(set(names)) == len(names)
    for parameter in term.parameters:
        assert parameter.unit
        assert len(parameter.meaning) > 5
        assert parameter.lower < parameter.upper
        assert all(parameter.lower <= start <= parameter.upper for start in parameter.starts)
        if parameter.prior is not None:
            assert parameter.lower <= parameter.prior.mean <= parameter.upper
            assert 0.0 < parameter.prior.sd < math.inf
            assert parameter.prior.source


# --- values


@EVERY_TERM
@pytest.mark.parametrize("n", [1, 2, 50])
@pytest.mark.parametrize("value", [0.0, 1.0, -40.0])
def test_output_is_finite_and_of_its_shape(term: Term, n: int, value: float) -> None:
    every = {name: np.full(n, value) for name in (*term.inputs, "effort", "thickness")}
    if "direction" in every or isinstance(term, InputChange):
        every["direction"] = direction(np.full(n, value))
    out = given(term, every | {"t": 0.01 * np.arange(n)}, n)
    columns = max(1, len(term.coefficients))
    assert out.reshape(n, -1).shape == (n, columns)
    assert out.dtype == np.float64
    assert np.isfinite(out).all()


REMEMBERS = {
    "sensor_drift", "warmup", "presliding", "backlash", "compliance", "lag",
    "thermal_drift",
}  # fmt: skip
"""Terms whose value in a row depends on other rows: on the first row or the past."""


@EVERY_TERM
def test_a_row_alone_gives_what_it_gives_among_others(term: Term) -> None:
    n = 30
    values = varied(n)
    whole = given(term, values, n)
    alone = [given(term, {k: v[i : i + 1] for k, v in values.items()}, 1) for i in range(n)]
    same = np.allclose(np.concatenate(alone), whole, rtol=1e-12, atol=1e-12)
    assert same == (key_of(term) not in REMEMBERS)


STANDING = {"coulomb", "viscous", "stribeck", "asymmetry", "position_friction", "backlash",
            "inertia", "windage", "compliance"}  # fmt: skip
ACTING = {"gravity", "spring", "cogging", "sensor_drift", "external_load"}


@EVERY_TERM
def test_at_standstill_friction_is_nothing_and_loads_act(term: Term) -> None:
    n = 200
    still = {"position": np.full(n, 7.0), "t": np.linspace(0.0, 10.0, n)}
    if term.name in STANDING:
        assert not given(term, still, n).any()
    if term.name in ACTING:
        assert given(term, still, n).any()
    assert not STANDING & ACTING


def noisy_stand(*, moves_s: float) -> tuple[Array, Array, Array]:
    """Return t, position and velocity: a move, then a stand with 1 µm of encoder noise at 1 kHz.

    Half a second at each end, where the filter has only one side, is cropped.
    """
    t = np.arange(0.0, 10.0, 1e-3)
    position = np.minimum(t, moves_s) * 5.0 + np.random.default_rng(4).normal(0.0, 1e-3, len(t))
    _, velocity, _ = signals.derivatives(
        t, position, cutoff_hz=10.0, timing=examined(t, {}, where="t")
    )
    inside = slice(500, -500)
    return t[inside], position[inside], velocity[inside]


def test_encoder_noise_at_standstill_makes_no_direction() -> None:
    _, position, velocity = noisy_stand(moves_s=0.0)
    assert 0.0 < np.abs(velocity).max() < STANDSTILL_MM_S
    sense = direction(velocity)
    assert np.abs(sense).max() < 1.0
    assert not since_reversal(sense, position)[0].any()
    assert not presliding(sense, position, distance_mm=0.003).any()
    backlash = BY_KEY["backlash"].function(sense, position, gap_mm=0.01)
    assert not backlash.any()


def test_what_a_move_left_is_held_through_encoder_noise() -> None:
    t, position, velocity = noisy_stand(moves_s=2.0)
    held = presliding(direction(velocity), position, distance_mm=0.01)[t > 2.5]
    assert_allclose(held, 1.0, atol=0.05)


# --- truths


@pytest.mark.parametrize("made", TRUTHS.values(), ids=lambda made: made.key)
def test_a_term_finds_its_effect_in_a_truth_of_another_form(made: Truth) -> None:
    inputs = dict(made.inputs)
    if "velocity" in inputs:
        inputs["direction"] = direction(inputs["velocity"])
    sought = part_of(made.key, made.of)
    parts = (*(part_of(key) for key in made.others), sought)
    found = recover(parts, Seen(inputs, made.measured, made.sd), made.begin_at)

    # what other terms could say equally well is nobody's
    shared = [part_of(key) for key in made.modulo]
    effect = without_columns(made.effect, shared, inputs)
    error = without_columns(found.effect(sought.key, inputs), shared, inputs) - effect
    assert rms(error) < made.within * rms(effect)
    if made.main is not None:
        name, true, tolerance = made.main
        assert_allclose(found.value(sought.key, name), true, rtol=tolerance)


def part_of(key: str, of: str = "") -> ChannelPart:
    """Return a part, its shape free but for the middle of the travel; `key@of` is an instance."""
    key, _, instance = key.partition("@")
    term = BY_KEY[key]
    shape = {p.name: p.starts[0] if p.starts else USUAL[p.name] for p in term.shape}
    return ChannelPart(
        term, shape, free=tuple(name for name in shape if name != "middle"), of=of or instance
    )
