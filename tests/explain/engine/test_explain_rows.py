"""What explain makes of its rows: filtered by blocks, weighed, drawn to none, settled."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.signal import lfilter

from autodb.explain import explain
from autodb.explain.answer import ChannelAnswer
from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import Candidate, CandidateForm, Choice
from autodb.explain.engine.noise import Whitener
from autodb.explain.engine.normal import solved
from autodb.explain.engine.prior import coefficient_costs
from autodb.explain.engine.weighing import unweighed, weighing
from autodb.proofs.machines.axis.axis import air_moves
from autodb.records.tables import Recording
from tests.helpers.campaigns import first

ORDER = 25


@pytest.mark.parametrize("rows", [ORDER + 1, ORDER + 31, ORDER + 32, ORDER + 64, 1000])
def test_filtering_by_blocks_is_filtering(rows: int) -> None:
    rng = np.random.default_rng(rows)
    filter_ = Whitener(0.1 * rng.standard_normal(ORDER))
    values = rng.standard_normal((rows, 3))
    taps = np.concatenate([[1.0], -filter_.coefficients])
    assert_allclose(filter_(values), lfilter(taps, [1.0], values, axis=0)[ORDER:], atol=1e-12)


def test_a_column_that_the_rows_do_not_hold_gets_none_and_the_others_their_value() -> None:
    rng = np.random.default_rng(1)
    design = np.column_stack([rng.standard_normal(500), 1e-9 * rng.standard_normal(500)])
    found = solved(design, 3.0 * design[:, 0], weight=np.array([1e-6, 1.0]))
    assert_allclose(found, [3.0, 0.0], atol=1e-6)


def _rows(truth: np.ndarray, rng: np.random.Generator, *, slow: float) -> np.ndarray:
    noise = lfilter([1.0], [1.0, -slow], rng.standard_normal(len(truth)))
    return np.asarray(truth + 0.05 * noise)


def _law(column: np.ndarray) -> Choice:
    return Choice(Candidate("law", "viscous", (CandidateForm(lambda: column, names=("size",)),)), 0)


def test_white_rows_are_taken_where_the_law_is_exact_and_plain_ones_where_it_is_not() -> None:
    """A law that is wrong where it turns quickly: white rows follow that, plain ones what is large.

    n = 40 draws; exact laws are weighed plain by chance in 0.3 % each, here never.
    """
    noise = Whitener(np.array([0.95])), 0.05**2
    column = np.sin(np.linspace(0.0, 60.0, 4000))
    spikes = np.zeros(4000)
    spikes[::100] = np.sign(column[::100])
    rng = np.random.default_rng(3)
    plain = 0
    for _ in range(40):
        bench = WhiteRows(_rows(column, rng, slow=0.95), {}, 1)
        plain += weighing(bench, [_law(column)], noise) is not noise
    assert plain <= 2
    bench = WhiteRows(_rows(column, rng, slow=0.95), {}, 1)
    wrong = [_law(column - 8.0 * spikes)]
    assert len(weighing(bench, wrong, noise)[0].coefficients) == 0
    assert unweighed(noise)[1] == pytest.approx(0.05**2 / 0.05**2)


def test_a_curve_is_drawn_to_none_in_noise_and_not_where_it_is_clear() -> None:
    rng = np.random.default_rng(4)
    columns = rng.standard_normal((2000, 12))
    curve = Choice(Candidate("curve", "unknown", (CandidateForm(lambda: columns),)), 0)
    noise = Whitener(np.zeros(1)), 1.0
    weak = coefficient_costs(WhiteRows(rng.standard_normal(2000), {}, 1), [curve], noise)
    clear = coefficient_costs(WhiteRows(10.0 * columns.sum(axis=1), {}, 1), [curve], noise)
    assert np.all(weak > 1000.0)  # as much as the 2000 rows say, and more
    assert np.all(clear < 1.0)


def _explained(channels: dict[str, np.ndarray], simulation: np.ndarray) -> ChannelAnswer:
    recording = Recording(path=Path("recording.csv"), channels=channels)
    without = Recording(
        path=Path("simulation.csv"), channels={"t": channels["t"], "x.current": simulation}
    )
    return explain(recording, without).explanation.channels["x.current"]


@pytest.mark.parametrize("side", first(1, [-1.0, 1.0]))
def test_a_limit_one_way_is_saturation(side: float) -> None:
    channels, parts = air_moves(5, rate_hz=62.5)
    simulation = np.asarray(sum(parts.values())) - parts["gravity"]
    limit = 0.8 * float(np.max(side * simulation))
    level = channels["x.current"] - parts["gravity"]
    clipped = side * np.minimum(side * level, limit)
    answer = _explained({**channels, "x.current": clipped}, simulation)
    (cause,) = [c for c in answer.missing if c.kind == "missing"]
    assert cause.term == "saturation"
    assert_allclose(cause.parameters["limit"].value, limit, rtol=0.05)


@pytest.mark.parametrize("share", first(1, [0.0, 0.6]))
def test_what_is_recorded_while_the_drive_brakes(share: float) -> None:
    """A heavy slide gives power back: its drive shows 60 % of the effort then, or nothing."""
    channels, parts = air_moves(5, rate_hz=62.5)
    simulation = np.asarray(sum(parts.values())) - parts["gravity"] + 5.0 * parts["inertia"]
    noise = channels["x.current"] - np.asarray(sum(parts.values()))
    brakes = simulation * channels["x.velocity"] < 0.0
    current = simulation * np.where(brakes, share, 1.0) + noise
    answer = _explained({**channels, "x.current": current}, simulation)
    (cause,) = [c for c in answer.missing if c.kind == "missing"]
    assert (cause.term, cause.variables) == ("unknown", ("x.velocity", "x.acceleration"))
    assert "braking" in cause.statement
    assert answer.fit.heldout_after < 1.1 * answer.fit.noise_floor


def test_a_slow_ripple_in_time_is_found_under_slow_noise() -> None:
    channels, parts = air_moves(6, rate_hz=62.5)
    t = channels["t"]
    slow = lfilter([1.0], [1.0, -0.98], np.random.default_rng(7).standard_normal(len(t)))
    current = channels["x.current"] + 0.01 * slow + 0.06 * np.sin(2 * np.pi * 0.55 * t)
    answer = _explained({**channels, "x.current": current}, np.asarray(sum(parts.values())))
    assert [(c.term, c.variables) for c in answer.missing] == [("unknown", ("t",))]
    assert answer.fit.rms_after < 0.9 * answer.fit.rms_before


def test_rounds_that_do_not_settle_give_the_best_account() -> None:
    """A weight of 50 noises swallows what it stands beside, if a drift may take its place."""
    channels, parts = air_moves(4, rate_hz=62.5)
    y = air_moves(54, rate_hz=62.5)[0]["x.position"]
    y = y - y.min()
    across = 0.25 * np.tanh(channels["x.velocity"] / 0.2) * (y / y.max()) ** 1.5
    current = channels["x.current"] + across
    weightless = np.asarray(sum(part for name, part in parts.items() if name != "gravity"))
    answer = _explained({**channels, "y.position": y, "x.current": current}, weightless)
    assert {c.term for c in answer.missing if c.kind == "missing"} == {"gravity", "unknown"}
    assert answer.fit.heldout_after < 0.03 * answer.fit.heldout_before
