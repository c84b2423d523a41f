"""An axis identified from moves of a truth that is written here: numbers, doubts, versions."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from numpy.testing import assert_allclose
from pyarrow import csv

from autodb.errors import UnusableInput
from autodb.records.tables import Recording
from autodb.sensing.drives import feed_axis
from autodb.sensing.drives.fit.axis_model import (
    Identified,
    Posteriors,
    amplitudes,
    predicted_effort,
)
from autodb.sensing.drives.moves.motion import axis_motion, motion_blocks, term_inputs
from tests.conftest import Cli
from tests.helpers.trapezoids import (
    COULOMB,
    INERTIA,
    RATE_HZ,
    VISCOUS,
    WEIGHT,
    current,
    moves,
    recorded,
)

SYMMETRIC = feed_axis.default_terms("axis")


def test_numbers_hold_within_their_uncertainty() -> None:
    channels = moves(1)
    model = feed_axis.identify(recorded(channels, current(channels, 1)))
    found = {(t.term, t.parameter): t for t in model.fitted}
    for key, true in {("inertia", "coefficient"): INERTIA, ("gravity", "level"): WEIGHT}.items():
        sd = found[key].sd or 0.0
        assert abs(found[key].value - true) < 4.0 * sd
        assert sd < 0.02 * true
    assert model.not_excited == ()
    assert model.doubts == ()
    assert model.held_out_error < 1.1 * model.relative_error + 0.01


def test_friction_over_speed_is_known_where_the_law_is_off() -> None:
    channels = moves(2)
    model = feed_axis.identify(recorded(channels, current(channels, 2)))
    assert model.steady is not None
    speeds = np.array([-90.0, 15.0, 40.0, 90.0, 140.0])
    true = np.sign(speeds) * COULOMB + VISCOUS * speeds * 150.0 / (150.0 + 0.2 * np.abs(speeds))
    value, sd = model.steady.friction(speeds)
    assert np.all(np.abs(value - true) < 4.0 * sd)
    assert np.all(sd < 0.01)
    law = model.value("coulomb") * np.sign(speeds) + model.value("viscous") * speeds
    assert np.max(np.abs(law - true)) > np.max(np.abs(value - true))
    with pytest.raises(ValueError, match="no move was faster"):
        model.steady.friction(np.array([400.0]))


def test_moves_one_way_cannot_tell_weight_from_friction_and_say_so() -> None:
    channels = moves(3, forwards_only=True)
    moving = np.abs(channels["x.velocity"]) > 2.0
    kept = {name: values[moving] for name, values in channels.items()}
    kept["t"] = np.arange(moving.sum()) / RATE_HZ
    recording = recorded(kept, current(channels, 3)[moving])
    model = feed_axis.identify(recording)
    named = {t.term for t in model.fitted}
    assert {"inertia", "viscous"} <= named
    assert not {"coulomb", "gravity"} & named
    assert any(s.startswith("gravity level: passes in both directions") for s in model.not_excited)
    # what the terms add up to is right all the same
    total = predicted_effort(model.terms, term_inputs(recording, "x", cutoff_hz=100.0))
    assert_allclose(np.mean(total - recording["x.current"]), 0.0, atol=0.01)


def test_an_axis_that_stands_is_refused() -> None:
    channels = {name: np.zeros(5000) for name in moves(1)} | {"t": np.arange(5000) / RATE_HZ}
    effort = np.random.default_rng(0).normal(0, 0.1, 5000)
    with pytest.raises(UnusableInput, match="x does not move enough"):
        feed_axis.identify(recorded(channels, effort))


def test_a_turned_sign_is_doubted() -> None:
    channels = moves(4)
    model = feed_axis.identify(recorded(channels, -current(channels, 4)))
    assert any("coulomb level is -0." in s and "reversed" in s for s in model.doubts)


def test_encoder_noise_makes_no_friction() -> None:
    """1 µm at 1 kHz: filtered at 100 Hz it is faster than standstill, and turns nothing."""
    slow = moves(5)
    t = np.arange(0.0, 39.9, 0.001)
    clean = np.interp(t, slow["t"], slow["x.position"])
    effort = np.interp(t, slow["t"], current(slow, 5))
    position = clean + np.random.default_rng(9).normal(0, 1e-3, len(t))
    channels = {"t": t, "x.position": position, "x.current": effort}
    recording = Recording(path=Path("a.csv"), channels=channels)
    direction = axis_motion(recording, "x", cutoff_hz=100.0).direction
    standing = np.abs(np.gradient(clean, t)) < 1e-6
    assert standing.mean() > 0.1
    assert np.max(np.abs(direction[standing])) < 1.0
    assert_allclose(feed_axis.identify(recording).value("coulomb"), COULOMB, rtol=0.03)


def test_a_late_recording_is_seen_as_lag() -> None:
    channels = moves(5)
    late = current(channels, 5)[: -round(0.008 * RATE_HZ)]
    kept = {name: values[round(0.008 * RATE_HZ) :] for name, values in channels.items()}
    kept["t"] = kept["t"] - kept["t"][0]
    model = feed_axis.identify(recorded(kept, late), terms=(*SYMMETRIC, "lag"))
    assert_allclose(model.value("lag"), 0.008, atol=1e-3)  # a quarter of a row
    assert_allclose(model.value("inertia"), INERTIA, rtol=0.01)


SHAPED = (*SYMMETRIC, "stribeck", "lag")


@pytest.mark.parametrize("terms", [SYMMETRIC, SHAPED], ids=["symmetric", "shaped"])
def test_the_fit_ends_at_its_optimum(terms: tuple[str, ...]) -> None:
    """Another unit, and roundings of 1e-9: the same to 1e-6 of its own standard deviation."""
    channels = moves(13, rate_hz=250.0)
    v = channels["x.velocity"]
    falls = 0.3 * np.tanh(v / 0.1) * np.exp(-((v / 20.0) ** 2))
    effort = np.roll(current(channels, 13) + falls, 2)
    model = feed_axis.identify(recorded(channels, effort), terms=terms)
    assert {t.term for t in model.fitted} == set(terms), "every shape is shown"
    scaled = feed_axis.identify(recorded(channels, 1000.0 * effort), terms=terms)
    changed = effort * (1.0 + 1e-9 * np.random.default_rng(1).normal(size=len(effort)))
    rounded = feed_axis.identify(recorded(channels, changed), terms=terms)
    for one, other, again in zip(model.fitted, scaled.fitted, rounded.fitted, strict=True):
        unit = 1000.0 if "A" in one.unit else 1.0
        assert_allclose(other.value / unit, one.value, atol=1e-6 * (one.sd or 0.0), rtol=0)
        assert_allclose(again.value, one.value, atol=1e-6 * (one.sd or 0.0), rtol=0)


def _with_ripple(seed: int, *, flips: bool) -> Recording:
    channels = moves(seed, seconds=60.0)
    phase = 2 * np.pi * channels["x.position"] / 8.0
    ripple = 0.05 * (np.sin(phase) + 0.2 * np.sin(2 * phase))
    turned = np.tanh(channels["x.velocity"] / 0.1) if flips else 1.0
    return recorded(channels, current(channels, seed) + ripple * turned)


@pytest.mark.parametrize(("flips", "term"), [(False, "cogging"), (True, "position_friction")])
def test_a_ripple_is_found_and_classed_by_direction(flips: bool, term: str) -> None:
    recording = _with_ripple(6, flips=flips)
    model = feed_axis.identify(recording, terms=(*SYMMETRIC, "cogging"))
    (amplitude,) = amplitudes(model)
    assert amplitude.term == term
    assert_allclose(amplitude.value, 0.05, rtol=0.1)
    period = next(t.value for t in model.fitted if t.parameter == "period")
    assert_allclose(period, 8.0, rtol=0.002)
    without = feed_axis.identify(recording)
    assert model.relative_error < 0.85 * without.relative_error


@pytest.mark.parametrize("seed", range(5))
def test_no_ripple_is_invented(seed: int) -> None:
    channels = moves(seed)
    with pytest.raises(UnusableInput, match="no ripple over the travel stands out"):
        feed_axis.identify(
            recorded(channels, current(channels, seed)),
            terms=(*SYMMETRIC, "cogging"),
        )


def _posteriors(model: Identified) -> Posteriors:
    names = tuple((t.key, t.parameter) for t in model.fitted)
    return Posteriors(names, np.array([t.value for t in model.fitted]), model.covariance)


def test_a_version_starts_from_the_last_and_gets_surer() -> None:
    first, second = moves(7), moves(8)
    one = feed_axis.identify(recorded(first, current(first, 7)))
    alone = feed_axis.identify(recorded(second, current(second, 8)))
    both = feed_axis.identify(recorded(second, current(second, 8)), posteriors=_posteriors(one))
    assert both.moved == ()
    sd = [np.sqrt(np.diag(m.covariance))[0] for m in (one, alone, both)]
    assert_allclose(sd[2], (sd[0] ** -2 + sd[1] ** -2) ** -0.5, rtol=0.3)


def test_what_changed_on_the_machine_is_said_and_followed() -> None:
    first, second = moves(9), moves(10)
    one = feed_axis.identify(recorded(first, current(first, 9)))
    later = recorded(second, current(second, 10, coulomb=0.8))
    both = feed_axis.identify(later, posteriors=_posteriors(one))
    assert "coulomb" in [m.key for m in both.moved]
    assert "inertia" not in [m.key for m in both.moved]
    alone = feed_axis.identify(later)
    sd = next(t.sd for t in alone.fitted if t.term == "coulomb") or 0.0
    assert abs(both.value("coulomb") - alone.value("coulomb")) < sd


def test_what_new_moves_do_not_excite_is_kept_from_the_last_version() -> None:
    first, second = moves(11), moves(12, forwards_only=True)
    moving = np.abs(second["x.velocity"]) > 2.0
    kept = {name: values[moving] for name, values in second.items()}
    kept["t"] = np.arange(moving.sum()) / RATE_HZ
    one = feed_axis.identify(recorded(first, current(first, 11)))
    both = feed_axis.identify(
        recorded(kept, current(second, 12)[moving]), posteriors=_posteriors(one)
    )
    assert {"coulomb", "gravity"} <= {t.term for t in both.fitted}
    assert_allclose(both.value("gravity"), WEIGHT, atol=0.02)


def test_blocks_of_motion_begin_where_the_axis_turns() -> None:
    channels = moves(1)
    sense = np.clip(channels["x.velocity"] / 0.05, -1.0, 1.0)
    blocks = motion_blocks(channels["t"], sense)
    starts = np.flatnonzero(np.diff(blocks)) + 1
    assert len(starts) >= 7
    assert np.all(np.diff(channels["t"][starts]) >= 2.0 - 1e-9)
    assert np.all(np.abs(sense[starts]) >= 1.0)
    still = motion_blocks(channels["t"], np.zeros_like(sense))
    assert len(np.unique(still)) == 12


def test_a_spindle_is_identified_over_its_speed() -> None:
    rng = np.random.default_rng(1)
    t = np.arange(0.0, 60.0, 0.004)
    stops = [0, 2, 4, 10, 12, 20, 22, 30, 34, 42, 45, 52, 56, 60]
    speed = np.interp(
        t, stops, [0, 0, 500, 500, 1500, 1500, 3000, 3000, -1000, -1000, -2500, -2500, 0, 0]
    )
    effort = (
        1.2 * np.tanh(speed / 3.0) + 8e-4 * speed + 3e-7 * speed * np.abs(speed)
        + 2e-3 * np.gradient(speed, t) + rng.normal(0, 0.05, len(t))
    )  # fmt: skip
    channels = {
        "t": t, "spindle.speed": speed + rng.normal(0, 0.3, len(t)), "spindle.current": effort
    }  # fmt: skip
    model = feed_axis.identify(Recording(path=Path("s.csv"), channels=channels), axis="spindle")
    units = {t.term: t.unit for t in model.fitted}
    assert units == {
        "inertia": "A·s/rpm", "viscous": "A/rpm", "coulomb": "A", "windage": "A/rpm²"
    }  # fmt: skip
    assert_allclose(model.value("inertia"), 2e-3, rtol=0.03)
    assert_allclose(model.value("windage"), 3e-7, rtol=0.1)
    assert_allclose(model.value("coulomb"), 1.2, rtol=0.05)


def _written(name: str, seed: int, **effort: Any) -> Path:
    channels = moves(seed)
    table = {**channels, "x.current": current(channels, seed, **effort)}
    csv.write_csv(pa.table(table), name)
    return Path(name)


@pytest.fixture
def machine(cli: Cli) -> Cli:
    Path("m.toml").write_text("[axes.x]\n")
    cli("init")
    cli("machine", "add", "mill", "--file", "m.toml")
    return cli


def test_versions_follow_each_other(machine: Cli) -> None:
    first, second = _written("a.csv", 1), _written("b.csv", 2, coulomb=0.8)
    assert (
        "x.current: version 1 of machine 'mill'\n"
        in machine("identify", first, "--machine", "mill").out
    )
    again = machine("identify", first, "--machine", "mill")
    assert "version 1 of machine 'mill': already there" in again.out
    later = machine("identify", second, "--machine", "mill").out
    assert "moved since version 1: coulomb level from 0.70" in later
    assert "x.current: version 2 of machine 'mill', started from version 1" in later
    # other terms on the same recording do not count its rows twice
    fewer = machine("identify", second, "--machine", "mill", "--terms", "coulomb,viscous")
    assert "version 3 of machine 'mill', started from version 1" in fewer.out
    explained = machine("explain", second, "--machine", "mill", "--json")
    assert set(json.loads(explained.out)["channels"]) == {"x.current"}


def test_a_model_is_tested_on_a_second_recording(cli: Cli) -> None:
    done = cli("identify", _written("a.csv", 1), "--also", _written("b.csv", 2))
    assert "on b.csv: relative error" in done.out
    assert "on held-out blocks of motion" in " ".join(done.out.split())


TERMS_REFUSED = [
    (",", "--terms: names no term"),
    ("cogging,lag", "--terms: cogging, lag only change what others add"),
    ("inertia,coulomb,inertia", "'inertia' is named twice"),
    ("coulom", "'coulom' cannot be identified from moves of x (did you mean coulomb?)"),
    ("tool_wear", "'tool_wear' cannot be identified"),
    ("windage", "'windage' cannot be identified"),
    ("cross_coupling", "needs position and another axis' position, like 'y.position'"),
]


@pytest.mark.parametrize(("terms", "said"), TERMS_REFUSED)
def test_terms_that_cannot_be(refused: Callable[..., str], terms: str, said: str) -> None:
    assert said in refused("identify", _written("a.csv", 1), "--terms", terms)


def test_nothing_is_kept_where_identify_refuses(machine: Cli, refused: Callable[..., str]) -> None:
    refused("identify", _written("a.csv", 1), "--machine", "mill", "--terms", "cogging")
    assert "a.csv" not in machine("machine", "show", "mill").out
    done = machine("import", "a.csv", "--machine", "mill")
    assert "recording 1: a.csv: imported" in done.out
