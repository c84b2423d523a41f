"""Explain: what was left out is named, nothing is named where nothing is missing.

Truth comes from the virtual machine, whose friction, loads and wear have other forms than the
terms; the simulation is the sum of its parts with one left out.
"""

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from pyarrow import csv

from autodb.errors import UnusableInput
from autodb.explain import Explained, explain
from autodb.explain.answer import ChannelAnswer
from autodb.explain.engine.noise import fitted_whitener
from autodb.proofs.machines.axis.axis import (
    AxisCogging,
    AxisExternalLoad,
    AxisWarmup,
    air_moves,
)
from autodb.records import source as records
from autodb.records.tables import CutTable, Recording
from autodb.reports.written import LIBRARY
from tests.conftest import Cli
from tests.helpers.campaigns import first

NULLS = 12
RATE_HZ = 125.0


def _pair(
    seed: int, without: tuple[str, ...], extra: tuple[object, ...] = ()
) -> tuple[Recording, Recording, dict[str, NDArray[np.float64]]]:
    """Return recording, simulation without some parts, and the parts."""
    channels, parts = air_moves(seed, rate_hz=RATE_HZ, extra=extra)  # type: ignore[arg-type]
    simulation = sum(part for name, part in parts.items() if name not in without)
    recording = Recording(path=Path("recording.csv"), channels=dict(channels))
    simulated = {"t": channels["t"], "x.current": np.asarray(simulation)}
    return recording, Recording(path=Path("simulation.csv"), channels=simulated), parts


@cache
def _explained(seed: int, without: tuple[str, ...], extra: tuple[object, ...] = ()) -> Explained:
    """Explain with the parts that the simulation has named by ``includes``; once for all tests."""
    recording, simulation, parts = _pair(seed, without, extra)
    return explain(recording, simulation, includes=[name for name in parts if name not in without])


def _answer(seed: int, without: tuple[str, ...], extra: tuple[object, ...] = ()) -> ChannelAnswer:
    return _explained(seed, without, extra).explanation.channels["x.current"]


def _missing(answer: ChannelAnswer) -> set[str]:
    return {cause.term for cause in answer.missing if cause.kind == "missing"}


@pytest.mark.parametrize("seed", first(1, range(NULLS)))
def test_nothing_is_named_where_nothing_is_missing(seed: int) -> None:
    recording, simulation, _ = _pair(100 + seed, ())
    done = explain(recording, simulation)
    answer = done.explanation.channels["x.current"]
    assert not answer.mismatch
    assert answer.missing == ()
    trace = done.traces["x.current"]
    assert_allclose(trace.corrected, trace.simulation)


@pytest.mark.parametrize("term", ["coulomb", "viscous", "inertia", "gravity"])
@pytest.mark.parametrize("seed", first(1, [1, 2]))
def test_a_part_left_out_is_named_with_its_size(seed: int, term: str) -> None:
    answer = _answer(seed, (term,))
    assert term in _missing(answer)
    _, _, parts = _pair(seed, ())
    truth = float(np.quantile(np.abs(parts[term]), 0.999))
    found = next(c for c in answer.missing if c.term == term).parameters["size"].value
    assert_allclose(found, truth, rtol=0.1)
    assert answer.fit.heldout_after < 1.1 * answer.fit.noise_floor


def test_a_weight_that_is_left_out_has_no_regime() -> None:
    assert _answer(1, ("gravity",)).where.regime == ()


def test_a_load_is_named_and_located() -> None:
    answer = _answer(3, ("external_load",), (AxisExternalLoad(20.0, 34.0, 0.6),))
    assert _missing(answer) == {"external_load"}
    ((start, end),) = answer.where.intervals
    assert abs(start - 20.0) < 0.5
    assert abs(end - 34.0) < 0.5
    assert_allclose(answer.missing[0].parameters["level"].value, 0.6, rtol=0.1)


OTHER_FORMS: list[tuple[str, object]] = [
    ("cogging", AxisCogging(0.3, 12.0)),
    ("warmup", AxisWarmup(0.3, 15.0)),
]


@pytest.mark.campaign  # one at every change: tests/explain/engine/test_where.py
@pytest.mark.parametrize(("term", "effect"), OTHER_FORMS)
def test_an_effect_of_another_form_than_its_term_is_named(term: str, effect: object) -> None:
    answer = _answer(4, (term,), (effect,))
    assert _missing(answer) == {term}
    assert answer.fit.heldout_after < 0.6 * answer.fit.heldout_before


def test_a_simulation_a_few_per_cent_off_is_mistuned_not_missing() -> None:
    recording, simulation, parts = _pair(5, ())
    off = simulation["x.current"] + 0.05 * parts["coulomb"]
    tuned = Recording(path=simulation.path, channels={"t": simulation.t_s, "x.current": off})
    answer = explain(recording, tuned).explanation.channels["x.current"]
    assert answer.mismatch
    assert _missing(answer) == set()
    assert {c.term for c in answer.missing} == {"coulomb"}


@pytest.mark.parametrize("seed", first(1, [11, 12]))
def test_position_alone_is_enough(seed: int) -> None:
    recording, simulation, _ = _pair(seed, ("coulomb", "stribeck"))
    channels = {n: recording[n] for n in ("t", "x.position", "x.current")}
    bare = Recording(path=recording.path, channels=channels)
    answer = explain(bare, simulation, includes=["viscous", "inertia", "gravity"])
    assert "coulomb" in _missing(answer.explanation.channels["x.current"])
    assert "x.velocity and x.acceleration derived from x.position" in answer.notes[-1]


def test_recording_and_simulation_alike_to_the_last_digit() -> None:
    recording, _, _ = _pair(13, ())
    done = explain(recording, recording)
    assert not done.explanation.channels["x.current"].mismatch
    zero = Recording(
        path=recording.path, channels={"t": recording.t_s, "x.current": 0.0 * recording.t_s}
    )
    assert explain(recording, zero).explanation.channels["x.current"].mismatch


def test_an_axis_that_stands_is_explained_too() -> None:
    recording, _, _ = _pair(14, ())
    n = len(recording)
    noise = np.random.default_rng(0).normal(0, 0.1, n)
    still = Recording(
        path=recording.path,
        channels={"t": recording.t_s, "x.position": np.full(n, 5.0), "x.current": 1.0 + noise},
    )
    constant = Recording(
        path=recording.path, channels={"t": recording.t_s, "x.current": np.full(n, 1.0)}
    )
    assert not explain(still, constant).explanation.channels["x.current"].mismatch


def test_includes_decides_between_missing_and_mistuned() -> None:
    recording, simulation, _ = _pair(6, ("gravity",))
    done = explain(recording, simulation, includes=["coulomb", "viscous", "inertia", "gravity"])
    answer = done.explanation.channels["x.current"]
    assert _missing(answer) == set()
    assert "gravity" in {c.term for c in answer.missing if c.kind == "mistuned"}


@pytest.mark.campaign  # at every change: "effort × 10" of test_scale_free.py
def test_scaling_both_scales_the_answer() -> None:
    recording, simulation, _ = _pair(7, ("coulomb",))
    includes = ["viscous", "inertia", "gravity"]
    plain = explain(recording, simulation, includes=includes).explanation.channels["x.current"]
    ten = [
        Recording(path=r.path, channels={**r.channels, "x.current": 10.0 * r["x.current"]})
        for r in (recording, simulation)
    ]
    scaled = explain(*ten, includes=includes).explanation.channels["x.current"]
    assert _missing(scaled) == _missing(plain)
    assert_allclose(
        scaled.missing[0].parameters["level"].value,
        10.0 * plain.missing[0].parameters["level"].value,
        rtol=1e-6,
    )


def _cuts(seed: int, wear: float, edge: float, n: int = 80) -> tuple[CutTable, CutTable]:
    rng = np.random.default_rng(seed)
    feed, depth = rng.uniform(0.08, 0.4, n), rng.uniform(0.8, 2.5, n)
    edges = np.asarray(np.arange(n) // 16 + 1.0, dtype=np.float64)
    time_s = np.asarray((np.arange(n) % 16) * 40.0, dtype=np.float64)
    base: dict[str, NDArray[np.float64]] = {
        "force.y": 1900.0 * depth * feed**0.8,
        "force.z": 900.0 * depth * feed**0.6,
    }
    known: dict[str, NDArray[np.float64]] = {
        "cut": np.linspace(1.0, n, n), "t": np.linspace(0.0, 60.0 * n, n), "tool.edge": edges,
        "tool.cutting_time": time_s, "cutting.feed": feed, "cutting.depth": depth,
    }  # fmt: skip
    share = {"force.y": 0.5, "force.z": 1.0}
    grown = wear * depth * (time_s / 600.0) ** 1.3
    sensed: dict[str, NDArray[np.float64]] = {
        name: (force + share[name] * (grown + edge * depth)) * (1 + rng.normal(0, 0.03, n))
        + rng.normal(0, 10.0, n)
        for name, force in base.items()
    }
    path = Path("cuts.csv")
    return (
        CutTable(path=path, channels={**known, **sensed}),
        CutTable(path=path, channels={"cut": known["cut"], **base}),
    )


def _named(tables: tuple[CutTable, CutTable]) -> set[str]:
    done = explain(*tables, includes=["shear"])
    channels = done.explanation.channels.values()
    return {c.term for a in channels for c in a.missing if c.kind == "missing"}


@pytest.mark.parametrize("seed", first(1, range(6)))
def test_cut_tables_with_nothing_missing(seed: int) -> None:
    assert _named(_cuts(200 + seed, 0.0, 0.0)) == set()


def test_wear_and_edge_force_are_told_apart() -> None:
    assert _named(_cuts(1, 150.0, 0.0)) == {"tool_wear"}
    assert _named(_cuts(2, 0.0, 60.0)) == {"edge_force"}


def test_an_edge_force_that_is_off_is_mistuned() -> None:
    recording, simulation = _cuts(4, 0.0, 60.0)
    depth = recording["cutting.depth"]
    share = {"force.y": 0.5, "force.z": 1.0}
    other = {n: simulation[n] + 100.0 * share[n] * depth for n in share}
    off = CutTable(path=simulation.path, channels={"cut": simulation["cut"], **other})
    done = explain(recording, off, includes=["shear", "edge_force"])
    causes = [c for a in done.explanation.channels.values() for c in a.missing]
    assert {(c.term, c.kind) for c in causes} == {("edge_force", "mistuned")}
    had = {n: float(v) for n, v in zip(share, (50.0, 100.0), strict=True)}
    for name, answer in done.explanation.channels.items():
        (cause,) = answer.missing
        change = cause.parameters["size"].value / float(depth.max())
        assert_allclose(change, 0.4 * had[name], rtol=0.35)


def test_shuffled_cutting_times_are_no_wear() -> None:
    recording, simulation = _cuts(3, 150.0, 0.0)
    rng = np.random.default_rng(0)
    time_s = recording["tool.cutting_time"].copy()
    for edge in np.unique(recording["tool.edge"]):
        rows = np.flatnonzero(recording["tool.edge"] == edge)
        time_s[rows] = rng.permutation(time_s[rows])
    shuffled = CutTable(
        path=recording.path, channels={**recording.channels, "tool.cutting_time": time_s}
    )
    assert "tool_wear" not in _named((shuffled, simulation))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"cutting.depth": 0.0}, "cutting.depth, row 3 (cut 3): 0 is not a cut"),
        ({"force.z": 1e8}, "force.z, row 3 (cut 3)"),
    ],
)
def test_cuts_that_are_none_are_named(change: dict[str, float], says: str) -> None:
    recording, simulation = _cuts(5, 0.0, 0.0)
    (name, value), channels = next(iter(change.items())), dict(recording.channels)
    channels[name] = channels[name].copy()
    channels[name][2] = value
    with pytest.raises(UnusableInput) as caught:
        explain(CutTable(path=recording.path, channels=channels), simulation)
    assert says in str(caught.value)


def test_edge_force_on_thick_chips_has_an_alternative() -> None:
    done = explain(*_cuts(2, 0.0, 60.0), includes=["shear"])
    cause = next(
        c for a in done.explanation.channels.values() for c in a.missing if c.term == "edge_force"
    )
    assert "size_effect" in cause.alternatives
    assert cause.to_tell_apart is not None  # so little is missing that no cuts near these would
    assert "a chip of 0.03 mm or less" in cause.to_tell_apart


def test_an_autoregression_makes_its_own_noise_white() -> None:
    rng = np.random.default_rng(1)
    noise, series = rng.normal(size=20000), np.zeros(20000)
    for i in range(1, 20000):
        series[i] = 0.9 * series[i - 1] + noise[i]
    white = fitted_whitener(series)(series[:, None])[:, 0]
    lag_one = np.corrcoef(white[1:], white[:-1])[0, 1]
    assert abs(lag_one) < 4 / np.sqrt(20000)


# Files and refusals


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    recording, simulation, _ = _pair(8, ("gravity",))
    csv.write_csv(pa.table(recording.channels), tmp_path / "rec.csv")
    csv.write_csv(
        pa.table({**simulation.channels, "y.current": simulation["x.current"]}),
        tmp_path / "sim.csv",
    )
    return tmp_path / "rec.csv", tmp_path / "sim.csv"


def test_the_three_files_are_written(cli: Cli, files: tuple[Path, Path]) -> None:
    done = cli("explain", files[0], "--simulation", files[1])
    assert done.code == 0
    assert "'y.current' is not in the recording, ignored" in done.err
    folder = Path("rec-explained")
    assert {p.name for p in folder.iterdir()} == {
        "corrected.csv", "report.html", "explanation.json", LIBRARY,
    }  # fmt: skip
    corrected, recording = records.read(folder / "corrected.csv"), records.read(files[0])
    assert list(corrected.channels) == ["t", "x.current"]
    assert_allclose(corrected["t"], recording["t"])
    answer = json.loads((folder / "explanation.json").read_text())
    fit = answer["channels"]["x.current"]["fit"]
    after = float(np.sqrt(np.mean((recording["x.current"] - corrected["x.current"]) ** 2)))
    assert_allclose(after, fit["rms_after"], rtol=1e-6)
    assert set(fit) == {"rms_before", "rms_after", "heldout_before", "heldout_after", "noise_floor"}


def test_a_folder_with_other_files_is_kept_before_anything_is_searched(
    refused: Callable[..., str],
    files: tuple[Path, Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delattr("autodb.cli.understand.explaining._against_file")
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.txt").write_text("years of work")
    asked = ("explain", files[0], "--simulation", files[1], "--out")
    assert "holds other files" in refused(*asked, mine)
    assert (mine / "thesis.txt").read_text() == "years of work"
    assert "is a file" in refused(*asked, files[1])
    several = ("explain", files[0], files[0], *("--simulation", files[1]) * 2, "--out", mine)
    assert "holds other files" in refused(*several)


def test_what_does_not_fit_together_says_so(
    refused: Callable[..., str], files: tuple[Path, Path], tmp_path: Path
) -> None:
    recording, simulation = (records.read(f) for f in files)
    late = tmp_path / "late.csv"
    csv.write_csv(pa.table({"t": simulation["t"] + 7.0, "x.current": simulation["t"]}), late)
    assert "nothing at t = 0 (row 1" in refused("explain", files[0], "--simulation", late)
    other = tmp_path / "other.csv"
    csv.write_csv(pa.table({"t": simulation["t"], "z.current": simulation["t"]}), other)
    line = refused("explain", files[0], "--simulation", other)
    assert "no channel 'z.current', which the simulation has (did you mean x.current?)" in line
    csv.write_csv(pa.table({"t": simulation["t"], "x.position": simulation["t"]}), other)
    assert "no drive effort or force in common" in refused(
        "explain", files[0], "--simulation", other
    )
    misspelt = {n if n != "x.current" else "x.curent": v for n, v in recording.channels.items()}
    csv.write_csv(pa.table(misspelt), other)
    line = refused("explain", other, "--simulation", files[1])
    assert "no channel 'x.current', which the simulation has (did you mean x.curent?)" in line
    line = refused("explain", files[0], "--simulation", files[1], "--includes", "colomb")
    assert "did you mean coulomb" in line
    few = {name: recording[name][:150] for name in ("t", "x.position", "x.current")}
    csv.write_csv(pa.table(few), tmp_path / "few.csv")
    assert "too few to hold" in refused("explain", tmp_path / "few.csv", "--simulation", files[1])
    glitch = recording["x.current"].copy()
    glitch[77] = 1e6
    table = {name: recording[name] for name in ("t", "x.position")} | {"x.current": glitch}
    csv.write_csv(pa.table(table), tmp_path / "glitch.csv")
    line = refused("explain", tmp_path / "glitch.csv", "--simulation", files[1])
    assert "row 78: 1e+06" in line
    bare = tmp_path / "bare.csv"
    csv.write_csv(pa.table({"t": recording["t"], "x.current": recording["x.current"]}), bare)
    assert "no channel 'x.position'" in refused("explain", bare, "--simulation", files[1])


def test_a_law_that_plain_rows_need_is_among_what_was_considered() -> None:
    done = _explained(1, ("coulomb",))
    (coulomb,) = [c for c in done.traces["x.current"].considered if c.name == "coulomb"]
    assert coulomb.verdict == "accepted"
    assert coulomb.evidence > 100.0
