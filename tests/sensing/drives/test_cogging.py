"""Cogging of a pole: its period, and the form that blocks of motion left out decide on."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from pyarrow import csv

from autodb.agent.sense.identifying import KeptModel
from autodb.cli.understand.identified import show_kept
from autodb.records.tables import Recording
from autodb.sensing.drives import feed_axis
from autodb.sensing.drives.fit.axis_model import (
    ChangedParameter,
    Identified,
    amplitudes,
    predicted_effort,
)
from autodb.sensing.drives.masses import Mass, own_masses
from autodb.sensing.drives.moves.motion import term_inputs
from autodb.terms.ripple import NODES, cogging_harmonics, cogging_table
from tests.conftest import Cli

Array = NDArray[np.float64]

RATE_HZ, POLE_MM, NOISE = 100.0, 12.0, 0.02
TERMS = (*feed_axis.default_terms("axis"), "cogging")


def _motion() -> dict[str, Array]:
    """Passes of 130 mm there and back at four speeds, with dwells and soft starts."""
    speed = []
    for level in (8.0, 20.0, 45.0, 90.0):
        rows = round(130.0 / level * RATE_HZ)
        for way in (1.0, -1.0):
            speed += [np.full(rows, way * level), np.zeros(40)]
    v = np.concatenate([np.zeros(60), *speed, np.zeros(60)])
    for _ in range(3):
        v = np.convolve(v, np.full(6, 1.0 / 6.0), mode="same")
    t = np.arange(float(len(v))) / RATE_HZ
    return {
        "t": t,
        "x.position": 20.0 + (np.cumsum(v) - 0.5 * v) / RATE_HZ,
        "x.velocity": v,
        "x.acceleration": np.gradient(v, t),
    }


def _recorded(ripple: Array, channels: dict[str, Array]) -> Recording:
    v, a = channels["x.velocity"], channels["x.acceleration"]
    noise = np.random.default_rng(3).normal(0.0, NOISE, len(v))
    effort = 0.6 * np.tanh(v / 0.1) + 0.002 * v + 0.001 * a + 0.1 + ripple + noise
    return Recording(path=Path("moves.csv"), channels={**channels, "x.current": effort})


def _teeth(position: Array) -> Array:
    """Narrow teeth, three a pole of unequal height: the third harmonic is the largest."""
    off = [(position - where + 6.0) % POLE_MM - 6.0 for where in (1.0, 5.3, 9.0)]
    return np.asarray(
        sum(h * np.exp(-((o / 0.5) ** 2)) for h, o in zip((0.5, 0.3, 0.4), off, strict=True))
    )


def _kept(found: Identified) -> str:
    return next(one.form for one in found.cogging if one.kept)


@pytest.fixture(scope="module")
def toothed() -> tuple[Recording, Identified]:
    """An axis with narrow teeth, and what is identified of it."""
    channels = _motion()
    recording = _recorded(_teeth(channels["x.position"]), channels)
    return recording, feed_axis.identify(recording, terms=TERMS)


def test_a_table_wins_on_narrow_teeth_and_finds_the_pole(
    toothed: tuple[Recording, Identified],
) -> None:
    _, found = toothed
    assert _kept(found) == "table"
    errors = {one.form: one.held_out_error for one in found.cogging}
    assert errors["table"] < 0.8 * errors["harmonics"] < 0.8 * errors[""]
    period = next(t.value for t in found.fitted if t.parameter == "period")
    assert_allclose(period, POLE_MM, rtol=0.01)


def test_a_table_stores_and_predicts_like_any_term(toothed: tuple[Recording, Identified]) -> None:
    recording, found = toothed
    place = 40.0 + 0.02 * np.arange(600.0)
    zero = np.zeros_like(place)
    inputs = {"position": place, "velocity": zero, "acceleration": zero, "direction": zero}
    cogging = [t for t in found.terms if t.term == "cogging"]
    assert len(cogging) == NODES
    true = _teeth(place)
    assert_allclose(predicted_effort(cogging, inputs), true - true.mean(), atol=0.06)
    whole = predicted_effort(found.terms, term_inputs(recording, "x", cutoff_hz=40.0))
    left = (recording["x.current"] - whole)[60:-60]
    assert np.sqrt(np.mean(left**2)) < 2.5 * NOISE
    (amplitude,) = amplitudes(found)
    first = 2.0 * abs(np.mean(true * np.exp(2j * np.pi * place / POLE_MM)))
    assert_allclose(amplitude.value, first, atol=0.003)


@pytest.mark.parametrize(
    ("form", "higher"), [("", (0.0, 0.0)), ("harmonics", (0.05, 0.04))], ids=["sine", "harmonics"]
)
def test_harmonics_win_on_a_ripple_that_has_few(form: str, higher: tuple[float, float]) -> None:
    channels = _motion()
    phase = 2.0 * np.pi * channels["x.position"] / POLE_MM
    second, third = higher
    ripple = 0.2 * np.sin(phase) + second * np.cos(2.0 * phase) + third * np.sin(3.0 * phase)
    found = feed_axis.identify(_recorded(ripple, channels), terms=TERMS)
    assert _kept(found) == form
    period = next(t.value for t in found.fitted if t.parameter == "period")
    assert_allclose(period, POLE_MM, rtol=0.002)
    (amplitude,) = amplitudes(found)
    assert_allclose(amplitude.value, 0.2, rtol=0.03)


def test_the_nodes_are_values_and_the_mean_over_a_pole_is_none() -> None:
    values = np.random.default_rng(1).normal(0.0, 1.0, NODES - 1)
    nodes = POLE_MM * np.arange(float(NODES)) / NODES
    told = cogging_table(nodes + 5.0 * POLE_MM, period_mm=POLE_MM) @ values
    assert_allclose(told[:-1], values, atol=1e-9)
    fine = cogging_table(POLE_MM * np.arange(7200.0) / 7200.0, period_mm=POLE_MM) @ values
    assert_allclose(fine.mean(), 0.0, atol=1e-3)
    assert_allclose(fine[0], cogging_table(np.array([-POLE_MM]), period_mm=POLE_MM) @ values)
    phase = cogging_harmonics(np.array([3.0]), period_mm=POLE_MM)[0]
    assert_allclose(phase[:4], [0.0, 1.0, -1.0, 0.0], atol=1e-12)


def test_masses_of_slides_that_carry_each_other() -> None:
    moved = {"x": Mass(220.0, 3.0), "y": Mass(390.0, 4.0), "z": Mass(90.0, 1.0)}
    own = own_masses(moved, {"x": "y", "y": None, "z": "x"})
    assert {axis: mass.kg for axis, mass in own.items()} == {"x": 130.0, "y": 170.0, "z": 90.0}
    assert_allclose(own["x"].sd_kg, np.hypot(3.0, 1.0))
    assert_allclose(own["y"].sd_kg, 5.0)
    assert own["z"] == moved["z"]
    assert own_masses(moved, dict.fromkeys("xyz")) == moved


def test_the_command_says_which_form_was_kept_and_what_each_leaves(cli: Cli) -> None:
    channels = _motion()
    effort = _recorded(_teeth(channels["x.position"]), channels)["x.current"]
    csv.write_csv(pa.table({**channels, "x.current": effort}), "moves.csv")
    out = cli("identify", "moves.csv", "--terms", ",".join(TERMS)).out
    said = re.search(r"cogging: a table of 36 nodes over (\S+) mm kept; on held-out blocks:", out)
    assert said is not None
    assert_allclose(float(said.group(1)), POLE_MM, rtol=0.01)
    assert re.search(r"one sine \S+ %, 6 harmonics \S+ %, a table of\s+36 nodes \S+ %", out)
    assert "node_" not in out


def test_nodes_that_moved_are_counted(
    toothed: tuple[Recording, Identified], capsys: pytest.CaptureFixture[str]
) -> None:
    _, found = toothed
    moved = [
        ChangedParameter(key, parameter, "A", 0.1, 0.01, 0.2, 0.01)
        for key, parameter in (
            ("cogging table", "node_3"),
            ("cogging table", "node_4"),
            ("coulomb", "level"),
        )
    ]
    show_kept(KeptModel(replace(found, moved=tuple(moved)), 2, 1, already_there=False), "mill")
    out = capsys.readouterr().out
    assert "moved since version 1: 2 nodes of cogging table" in out
    assert "moved since version 1: coulomb level from 0.1" in out
    assert "node_" not in out


MOVED_KG = {"x": 220.0, "y": 390.0, "z": 90.0}


def _written(axis: str) -> str:
    channels = _motion()
    v, a = channels["x.velocity"], channels["x.acceleration"]
    noise = np.random.default_rng(4).normal(0.0, 1.0, len(v))
    effort_N = 60.0 * np.tanh(v / 0.1) + 0.2 * v + MOVED_KG[axis] / 1000.0 * a + 5.0 + noise
    named = {name.replace("x.", f"{axis}."): values for name, values in channels.items()}
    csv.write_csv(pa.table({**named, f"{axis}.drive_force": effort_N}), f"{axis}.csv")
    return f"{axis}.csv"


def test_masses_are_told_when_every_axis_of_a_chain_is_known(cli: Cli) -> None:
    Path("mill.toml").write_text(
        '[axes.x]\ncarried_by = "y"\n[axes.y]\n[axes.z]\ncarried_by = "x"\n'
    )
    cli("init")
    cli("machine", "add", "mill", "--file", "mill.toml")
    outs = [cli("identify", _written(axis), "--machine", "mill").out for axis in "xzy"]
    assert all("slides alone" not in out for out in outs[:2])
    said = re.findall(r"([xyz]) (\S+) ± (\S+) kg", outs[2].split("slides alone", 1)[1])
    assert [axis for axis, _, _ in said] == ["x", "y", "z"]
    for (_, kg, sd), true in zip(said, (130.0, 170.0, 90.0), strict=True):
        assert abs(float(kg) - true) < 4.0 * float(sd)
        assert float(sd) < 0.03 * true
