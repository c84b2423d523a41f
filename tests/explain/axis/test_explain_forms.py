"""Short forms of effects without a name: a true one is said, none where there is none."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from autodb.explain import explain
from autodb.explain.answer import ChannelAnswer
from autodb.explain.axis.form import Short, short_form
from autodb.explain.axis.reading import AxisReading
from autodb.explain.axis.signals import axis_signals
from autodb.explain.axis.unknown import unknown_candidates
from autodb.explain.engine.bench import WhiteRows
from autodb.explain.engine.candidates import Choice
from autodb.explain.engine.fit import Folds, held_out_residual
from autodb.explain.engine.fitted import fit_white_rows
from autodb.explain.engine.inquiry import Inquiry
from autodb.explain.engine.search import CandidateSearch, FoundSet
from autodb.explain.engine.symbolic import Variable, forms, written
from autodb.proofs.machines.axis.axis import air_moves
from autodb.records.tables import Recording
from tests.helpers.campaigns import first

Array = NDArray[np.float64]

SAID = "On held-out stretches"


def _recording(seed: int, rate_hz: float = 125.0) -> tuple[Recording, Array]:
    """Return an axis in air beside another that begins at 0, and its simulation: all but noise."""
    channels, parts = air_moves(seed, rate_hz=rate_hz)
    other = air_moves(seed + 50, rate_hz=rate_hz)[0]["x.position"]
    recording = {**channels, "y.position": other - other.min()}
    return Recording(path=Path("r.csv"), channels=recording), np.asarray(sum(parts.values()))


def _reading(seed: int, key: str, effect: Array | float) -> AxisReading:
    """Return the reading in which the family ``key`` alone is found beside an added effect."""
    recording, simulation = _recording(seed)
    signals = axis_signals(recording, simulation, "x.current")
    bench = WhiteRows(recording["x.current"] + effect - simulation, signals.own, 1)
    choice = next(Choice(s, 0) for s in unknown_candidates(signals) if s.key == key)
    noise = bench.noise(bench.chosen([choice]))
    products = bench.products(bench.blocks([choice.candidate]), noise)
    search = CandidateSearch(products, [choice.candidate])
    inquiry = Inquiry(FoundSet((choice,)), search, *noise, {}, bench)
    fitted = fit_white_rows(bench, [choice], noise)
    return AxisReading(bench, inquiry, noise, (choice,), fitted, signals, frozenset(), "A", bench)


def _values(short: Short) -> dict[str, tuple[float, float]]:
    """Return coefficients and shape values of a form with their standard deviations."""
    form = short.law.choice.shape
    found, covariance = short.beside.fit(form)
    linear = zip(form.names, found, np.sqrt(np.diag(covariance)), strict=True)
    values = {name: (float(value), float(sd)) for name, value, sd in linear}
    return values | {name: (value, short.law.sd[name]) for name, value in form.shape.items()}


@pytest.mark.parametrize("seed", first(1, [4, 5]))
@pytest.mark.parametrize("power", [0.5, 1.5, 3.0])
def test_a_power_of_another_axis_place_is_found(seed: int, power: float) -> None:
    recording, _ = _recording(seed)
    y = recording["y.position"] / recording["y.position"].max()
    effect = 0.2 * np.tanh(recording["x.velocity"] / 0.2) * y**power
    short = short_form(_reading(seed, "direction × y.position", effect), 0)
    assert short is not None
    assert short.words.startswith({0.5: "direction · √(", 1.5: "direction · ("}.get(power, "dir"))
    assert short.words.endswith({0.5: "mm)", 1.5: "^1.5", 3.0: "³"}[power])
    value, sd = _values(short)["coefficient"]
    assert abs(value - 0.2) < 3.0 * sd + 0.01 * 0.2
    assert short.share > 0.97


@pytest.mark.parametrize("seed", first(1, [6, 7]))
def test_place_times_speed_is_found_with_its_place_and_speed(seed: int) -> None:
    recording, _ = _recording(seed)
    x, speed = recording["x.position"], np.abs(recording["x.velocity"])
    rest = float(np.quantile(x, 0.4))
    effect = 0.3 * (x - rest) / 200.0 * np.tanh(speed / 60.0)
    short = short_form(_reading(seed, "position × speed", effect), 0)
    assert short is not None
    values = _values(short)
    for name, truth in (("origin", rest), ("width", 60.0)):
        assert abs(values[name][0] - truth) < 4.0 * values[name][1]
    assert "tanh(speed/" in short.words
    assert short.share > 0.97


def test_a_pump_is_a_sine_in_the_answer_and_its_statement() -> None:
    recording, simulation = _recording(8)
    pump = 0.2 * np.sin(2.0 * np.pi * recording.t_s / 1.7)
    answer = _answer(recording, simulation, pump)
    (cause,) = answer.missing
    assert (cause.term, cause.kind, cause.variables) == ("unknown", "missing", ("t",))
    assert answer.fit.heldout_after < 0.3 * answer.fit.heldout_before
    assert SAID in cause.statement
    assert "A · sin(2π·(t − " in cause.statement
    assert "as much as the smooth curve" in cause.statement
    for name, truth in (("amplitude", 0.2), ("period", 1.7)):
        found = cause.parameters[name]
        assert found.low < truth < found.high
    assert cause.parameters["period"].unit == "s"
    assert f"{cause.parameters['amplitude'].value:.3g} A" in cause.statement


def _answer(recording: Recording, simulation: Array, effect: Array) -> ChannelAnswer:
    """Explain a recording to which an effect was added."""
    disturbed = {**recording.channels, "x.current": recording["x.current"] + effect}
    simulated = {"t": recording.t_s, "x.current": simulation}
    return explain(
        Recording(path=recording.path, channels=disturbed),
        Recording(path=Path("s.csv"), channels=simulated),
    ).explanation.channels["x.current"]


OF_NOISE = ("direction × y.position", "position × speed", "acceleration")


@pytest.mark.parametrize("key", OF_NOISE)
def test_noise_has_no_form(key: str) -> None:
    assert short_form(_reading(20, key, 0.0), 0) is None


@pytest.mark.campaign
def test_noise_hardly_has_a_form() -> None:
    """Of 18 readings two at most: were it one of a hundred (none of 360 others had one), it would
    be more once in 1400.
    """
    forms = [short_form(_reading(seed, key, 0.0), 0) for seed in range(20, 26) for key in OF_NOISE]
    assert sum(form is not None for form in forms) <= 2


def test_squares_of_folds_are_those_of_fits_without_them() -> None:
    rng = np.random.default_rng(1)
    columns = rng.normal(size=(3003, 4)) + rng.normal(size=4)
    target = columns @ [1.0, -2.0, 0.5, 0.0] + rng.normal(size=3003)
    folds = Folds(np.column_stack([target, columns]), 7)
    for chosen in ([1, 2, 3, 4], [2, 4], [3]):
        part = columns[:, np.subtract(chosen, 1)]
        values = np.asarray(np.linalg.lstsq(part, target, rcond=None)[0], dtype=np.float64)
        left = held_out_residual(part, target, values, gap=7)
        found = folds.squares(chosen, np.zeros(len(chosen)))
        assert_allclose(found, np.sum(left**2), rtol=2e-3)
    assert_allclose(folds.squares([], np.zeros(0)), np.sum(target**2))
    assert folds.squares([1], np.array([1e12])) > 0.999 * np.sum(target**2)


def test_a_short_recording_keeps_rows_to_fit() -> None:
    """4 s at 200 Hz with a gap of 0.25 s, longer than a block, around each."""
    rng = np.random.default_rng(5)
    columns = np.column_stack([np.ones(780), np.exp(-np.arange(780) / 40.0)])
    target = columns @ [3.0, 2.0] + rng.normal(scale=0.1, size=780)
    left = held_out_residual(columns, target, np.array([3.0, 2.0]), gap=50)
    assert_allclose(np.sqrt(np.mean(left**2)), 0.1, rtol=0.1)


def test_every_form_is_finite_on_any_range_and_says_its_variables() -> None:
    rng = np.random.default_rng(2)
    for low, high in ((0.0, 500.0), (-80.0, 420.0), (-600.0, -100.0), (300.0, 300.001)):
        place = Variable("position", "mm", rng.uniform(low, high, 200), ends=True)
        speed = Variable("speed", "mm/s", np.abs(rng.normal(size=200)), ends=False)
        surge = Variable("acceleration", "mm/s²", rng.normal(size=200), ends=False)
        for variables in ((place,), (surge,), (place, speed)):
            for form in forms(variables):
                columns = form.columns(np.ones(200), [v.values for v in variables], **form.shape)
                assert np.isfinite(columns).all()
                assert columns.shape == (200, len(form.names))
                said = written(form, {**form.shape, "cosine": 1.0, "sine": 0.5})
                assert all(v.name in said for v in variables)


def test_what_does_not_vary_has_no_form() -> None:
    assert forms([Variable("position", "mm", np.full(50, 3.0), ends=True)]) == []
