"""Rotary axes are explained as linear ones, in degrees; their weight turns with the angle."""

from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pyarrow as pa
import pytest
from numpy.typing import NDArray
from pyarrow import csv

from autodb.explain import explain
from autodb.explain.answer import Cause
from autodb.explain.axis.moves import LIBRARY, Reach
from autodb.explain.axis.reading import AxisReading, own_along
from autodb.explain.axis.signals import axis_signals
from autodb.records.tables import Recording
from autodb.reports.explanation import headline
from autodb.terms.drive import tilt
from tests.conftest import Cli
from tests.helpers.campaigns import first

Array = NDArray[np.float64]
Channels = dict[str, Array]

T_S = np.arange(4000) / 100.0
LEVEL, PHASE_DEG = 2.5, -40.0


def _table(effort: str, **extra: Array) -> tuple[Channels, Channels]:
    """Return a recording of a rotary axis, and what its effort is made of beside noise."""
    angle = 170.0 * np.sin(2.0 * np.pi * T_S / 17.0) + 60.0 * np.sin(2.0 * np.pi * T_S / 5.3)
    velocity = np.gradient(angle, T_S)
    acceleration = np.gradient(velocity, T_S)
    weight = np.array([np.cos(np.radians(PHASE_DEG)), np.sin(np.radians(PHASE_DEG))])
    parts = {
        "coulomb": 0.8 * np.tanh(velocity / 0.5), "viscous": 0.004 * velocity,
        "inertia": 0.002 * acceleration, "gravity": LEVEL * (tilt(angle) @ weight), **extra,
    }  # fmt: skip
    noise = np.random.default_rng(1).normal(0.0, 0.05, len(T_S))
    recording = {
        "t": T_S, "a.angle": angle, "a.velocity": velocity, "a.acceleration": acceleration,
        effort: np.asarray(sum(parts.values(), start=noise)),
    }  # fmt: skip
    return recording, parts


def _simulated(effort: str, parts: Channels, without: set[str]) -> Channels:
    left = [part for name, part in parts.items() if name not in without]
    return {"t": T_S, effort: np.asarray(sum(left))}


def _missing(effort: str, without: set[str], beside: Channels, **extra: Array) -> list[Cause]:
    recording, parts = _table(effort, **extra)
    done = explain(
        Recording(path=Path("r.csv"), channels=recording | beside),
        Recording(path=Path("s.csv"), channels=_simulated(effort, parts, without)),
    )
    return [c for c in done.explanation.channels[effort].missing if c.kind == "missing"]


@pytest.mark.parametrize(
    ("effort", "unit"), first(1, [("a.current", "A"), ("a.drive_torque", "N·m")])
)
def test_a_swinging_weight_has_level_and_phase(effort: str, unit: str) -> None:
    (cause,) = _missing(effort, {"gravity"}, {})
    assert (cause.term, cause.variables, cause.alternatives) == ("gravity", ("a.angle",), ())
    level, phase = cause.parameters["level"], cause.parameters["phase"]
    assert level.low < LEVEL < level.high
    assert phase.low < PHASE_DEG < phase.high
    assert (level.unit, phase.unit) == (unit, "deg")
    assert cause.statement.startswith("The weight of a table or its work")


def test_a_constant_load_beside_a_simulated_weight_is_found() -> None:
    """An amplifier's zero, say: over the angle the simulation has all of the weight."""
    recording, parts = _table("a.current", load=np.full(len(T_S), 1.2))
    done = explain(
        Recording(path=Path("r.csv"), channels=recording),
        Recording(path=Path("s.csv"), channels=_simulated("a.current", parts, {"load"})),
        includes=["coulomb", "viscous", "inertia", "gravity"],
    )
    (cause,) = done.explanation.channels["a.current"].missing
    assert (cause.term, cause.kind, cause.variables) == ("gravity", "mistuned", ())
    assert cause.parameters["size"].value == pytest.approx(1.2, rel=0.02)


@pytest.mark.parametrize("a_unit", [1.0, 1000.0], ids=["A", "mA"])
@pytest.mark.parametrize(("had", "now"), [(1.0, 3.0), (0.3, 1.3), (1.0, -0.5)])
def test_a_constant_load_that_is_simulated_wrong_is_said(
    had: float, now: float, a_unit: float
) -> None:
    """It was taken into the correction, or thrown away with it, without a word."""
    recording, parts = _table("a.current", load=np.full(len(T_S), now))
    simulated = _simulated("a.current", parts, {"load"})
    effort = {"a.current": a_unit * recording["a.current"]}
    done = explain(
        Recording(path=Path("r.csv"), channels=recording | effort),
        Recording(
            path=Path("s.csv"),
            channels=simulated | {"a.current": a_unit * (simulated["a.current"] + had)},
        ),
        includes=["coulomb", "viscous", "inertia", "gravity"],
    )
    (cause,) = done.explanation.channels["a.current"].missing
    assert (cause.term, cause.kind, cause.variables) == ("gravity", "mistuned", ())
    assert cause.confidence >= 0.9
    assert cause.parameters["level"].value == pytest.approx(a_unit * now, rel=0.02)
    assert cause.parameters["size"].value == pytest.approx(a_unit * abs(now - had), rel=0.02)


def test_a_weight_and_a_constant_load_that_are_both_simulated_wrong_are_two_entries() -> None:
    recording, parts = _table("a.current", load=np.full(len(T_S), 2.0))
    simulated = sum(parts.values()) - 1.0 - 0.3 * parts["gravity"]
    done = explain(
        Recording(path=Path("r.csv"), channels=recording),
        Recording(path=Path("s.csv"), channels={"t": T_S, "a.current": simulated}),
        includes=["coulomb", "viscous", "inertia", "gravity"],
    )
    answer = done.explanation.channels["a.current"]
    found = {c.variables: c.parameters["level"].value for c in answer.missing}
    assert [(c.term, c.kind) for c in answer.missing] == 2 * [("gravity", "mistuned")]
    assert found == pytest.approx({("a.angle",): LEVEL, (): 2.0}, rel=0.02)


def test_a_law_is_not_as_large_as_what_own_terms_do_to_each_other() -> None:
    """A joint that turns by 20°: its weight is nearly the constant load, and both changed by ten
    times what friction by direction adds, whose size was said to be that."""
    angle = 10.0 * np.sin(T_S)
    columns = np.column_stack([np.cos(np.radians(angle)), np.ones_like(T_S), np.sign(angle)])
    fitted = SimpleNamespace(
        own=("gravity", "constant load", "coulomb"), retuned=(0, 1, 2),
        design=columns, values=np.array([33.0, -32.6, 0.1]), correction=np.zeros_like(T_S),
        of_own=lambda name: (33.0 if name == "gravity" else 0.1, 1.0),
    )  # fmt: skip
    signals = SimpleNamespace(had={"gravity": 31.0, "coulomb": 1.0})
    reading = cast("AxisReading", SimpleNamespace(fitted=fitted, signals=signals))
    assert not np.any(own_along(reading, np.full_like(T_S, 2.0)))
    fitted.values = np.array([33.0, 0.0, 0.1])
    assert own_along(reading, np.full_like(T_S, 2.0)) == pytest.approx(33.0 * columns[:, 0])


@pytest.mark.parametrize("fitted", [False, True], ids=["kept", "fitted again"])
def test_a_weight_comes_before_a_spring_that_does_as_well(fitted: bool) -> None:
    """A robot's joint turns by 146° while others move, whose pull no signal here tells."""
    rng, t = np.random.default_rng(1), np.arange(0.0, 25.76, 0.005)
    turn = 2.0 * np.pi * t / 12.88
    angle = 5.0 * np.sin(3.0 * turn) + 3.0 * np.cos(2.0 * turn)
    angle -= 42.0 * np.sin(turn) + 60.0 * np.cos(turn)
    velocity = np.gradient(angle, t)
    parts = [2.8 * np.tanh(velocity / 0.5), 0.309 * velocity, 0.02 * np.gradient(velocity, t)]
    torque = 13.2 * np.sin(np.radians(angle) + 0.1) + sum(parts)
    torque += 2.0 * np.sin(2.0 * turn + 1.0) + 1.4 * np.cos(3.0 * turn)
    torque += rng.normal(0.0, 0.3, len(t))
    columns = np.column_stack(parts)
    simulated = sum(parts)
    if fitted:
        simulated = columns @ np.linalg.lstsq(columns, torque, rcond=None)[0]
    done = explain(
        Recording(Path("r.csv"), {"t": t, "a.angle": angle, "a.drive_torque": torque}),
        Recording(Path("s.csv"), {"t": t, "a.drive_torque": np.asarray(simulated)}),
        includes=["coulomb", "viscous", "inertia"],
    )
    weight = done.explanation.channels["a.drive_torque"].missing[0]
    assert (weight.term, weight.alternatives) == ("gravity", ("spring",))
    assert 0.8 <= weight.confidence <= 0.95
    assert weight.parameters["level"].value == pytest.approx(13.2, rel=0.15)


def test_a_weight_is_likelier_where_a_spring_does_hardly_better() -> None:
    """A joint that turns by 140° and whose weight, as the arm beyond it folds, is nearly straight
    over the angle: the two differ by less than real effects leave either by."""
    rng, t = np.random.default_rng(3), np.arange(0.0, 25.0, 0.01)
    turn = 2.0 * np.pi * t / 12.5
    angle = 62.0 * np.sin(turn) + 9.0 * np.sin(3.0 * turn + 1.0) - 5.0 * np.cos(2.0 * turn)
    line = 0.0145 * angle
    weight = 13.2 * (0.35 * np.sin(np.radians(angle)) + 0.65 * line)
    friction = 2.8 * np.tanh(np.gradient(angle, t) / 0.5)
    torque = weight + friction + 0.5 * np.sin(2.7 * turn) + rng.normal(0.0, 0.1, len(t))
    done = explain(
        Recording(Path("r.csv"), {"t": t, "a.angle": angle, "a.drive_torque": torque}),
        Recording(Path("s.csv"), {"t": t, "a.drive_torque": friction}),
        includes=["coulomb"],
    )
    first = done.explanation.channels["a.drive_torque"].missing[0]
    assert (first.term, first.alternatives) == ("gravity", ("spring",))
    assert first.confidence == pytest.approx(0.8, abs=0.02)  # of odds 4 : 1
    assert headline(done.explanation.channels["a.drive_torque"]).startswith(
        "The cause (likely, 80 %): a weight that turns with the axis is missing"
    )


def test_a_constant_load_beside_a_weight_is_an_entry_of_its_own() -> None:
    constant = np.full_like(T_S, 0.7)
    causes = _missing("a.current", {"gravity", "offset"}, {}, offset=constant)
    assert [(c.term, c.variables) for c in causes] == [("gravity", ("a.angle",)), ("gravity", ())]
    assert causes[1].alternatives == ("sensor_drift",)
    level = causes[1].parameters["level"]
    assert level.low < 0.7 < level.high


def test_a_ripple_has_its_period_in_degrees() -> None:
    recording, _ = _table("a.current")
    ripple = 0.4 * np.sin(2.0 * np.pi * recording["a.angle"] / 12.0)
    causes = _missing("a.current", {"ripple"}, {}, ripple=ripple)
    cause = next(c for c in causes if c.term == "cogging")
    period = cause.parameters["period"]
    assert period.low < 12.0 < period.high
    assert period.unit == "deg"


def test_another_rotary_axis_loads_this_one() -> None:
    other = 80.0 * np.sin(2.0 * np.pi * T_S / 3.7)
    push = 0.003 * np.gradient(np.gradient(other, T_S), T_S)
    (cause,) = _missing("a.drive_torque", {"push"}, {"c.angle": other}, push=push)
    assert (cause.term, cause.variables) == ("cross_coupling", ("c.acceleration",))
    assert cause.parameters["coefficient"].unit == "N·m·s²/deg"


def test_a_simulated_weight_is_read_off_with_its_phase() -> None:
    recording, parts = _table("a.current")
    simulation = _simulated("a.current", parts, set())["a.current"]
    read = axis_signals(Recording(path=Path("r.csv"), channels=recording), simulation, "a.current")
    assert read.had["gravity"] == pytest.approx(LEVEL, rel=1e-3)
    assert read.phase_deg == pytest.approx(PHASE_DEG, abs=0.1)
    assert read.unit == "deg"
    assert read.channel("position") == "a.angle"


@pytest.mark.parametrize("move", LIBRARY, ids=lambda move: move.words(Reach(0, 1, 1, 1))[:24])
def test_moves_are_said_in_degrees(move: object) -> None:
    words = getattr(move, "words")(Reach(-180.0, 180.0, 90.0, 400.0, unit="deg"))  # noqa: B009
    assert "mm" not in words


def _write(name: str, channels: Channels) -> None:
    csv.write_csv(pa.table(channels), name)


def test_the_command_takes_a_rotary_axis(cli: Cli) -> None:
    recording, parts = _table("a.drive_torque")
    bare = {name: recording[name] for name in ("t", "a.angle", "a.drive_torque")}
    _write("moves.csv", bare)
    _write("simulation.csv", _simulated("a.drive_torque", parts, {"gravity"}))
    done = cli("explain", "moves.csv", "--simulation", "simulation.csv", "--out", "said")
    assert done.code == 0
    assert "a.velocity and a.acceleration derived from a.angle" in done.out + done.err
    report = Path("said", "report.html").read_text()
    assert "a.angle" in report
    assert "[mm" not in report
