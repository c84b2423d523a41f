"""What the program does most, each beside a limit that no program of its kind can beat by much.

Where there is no such limit, a command's time is counted in pieces of plain work: a loop of the
interpreter and products of matrices, about half and half. Ratios of either kind carry over from one
machine to another; seconds do not.
"""

import sqlite3
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pyarrow import csv as arrow_csv
from pyarrow import parquet
from sqlalchemy import select

from autodb.agent.answer.looking_up import PairReader
from autodb.agent.answer.predicting import predict_job
from autodb.agent.ingest.importing import import_file
from autodb.agent.operate.refreshing import refresh
from autodb.agent.rows.machines import add_machine
from autodb.agent.sense.calibrating import calibrate_machine
from autodb.assets import kit
from autodb.cli.start.demo import run_demo
from autodb.cutting import endmill, insert, shear
from autodb.cutting.elements import cut_forces
from autodb.explain import explain
from autodb.files.job import read_job
from autodb.files.job_cut import JobCut
from autodb.files.machine import LATHE
from autodb.fitting.linear import least_squares
from autodb.proofs.machines.axis.axis import air_moves
from autodb.records import source as records
from autodb.records.tables import CutTable, Recording
from autodb.records.timed import on_even_rows
from autodb.signals.filters import derivatives
from autodb.store import Store, create_store, models, open_store
from autodb.timing import examined
from benchmarks.timing import Work

Array = NDArray[np.float64]
Pair = tuple[Work, Work]

MACHINE = "lathe-1"
LOOK_UPS = 200
CSV_S, ROWS, CUTS = 3000.0, 200_000, 20_000
AXIS_S = 60.0
COSTS_MOST = 0.01
"""Share of an explanation's time that the examination of a recording's stamps may take. Chosen."""


@dataclass(frozen=True)
class Measure:
    """One thing that is timed: what, beside which limit, how often, and how both are made ready.

    ``most``: the ratio that it must not exceed, where there is one.
    """

    name: str
    limit: str
    runs: int
    prepared: Callable[[Path], Pair]
    most: float | None = None


def plain_work() -> None:
    """Keep the interpreter and BLAS busy for about 0.1 s."""
    total = 0
    for number in range(1_000_000):
        total += number & 7
    square = np.ones((600, 600))
    for _ in range(4):
        square @ square


def _read_csv(folder: Path) -> Pair:
    path = folder / "moves.csv"
    channels = _repeated(CSV_S)
    arrow_csv.write_csv(pa.table({name: np.round(v, 6) for name, v in channels.items()}), path)
    return lambda: records.read(path), lambda: arrow_csv.read_csv(path)


def _read_parquet(folder: Path) -> Pair:
    path = folder / "moves.parquet"
    parquet.write_table(pa.table(_repeated(CSV_S)), path)
    return lambda: records.read(path), lambda: parquet.read_table(path)


def _repeated(seconds: float, *, part_s: float = 600.0) -> dict[str, Array]:
    """Return air moves of a multiple of ``part_s``, the same over and over, in running time."""
    channels, _ = air_moves(1, seconds=part_s)
    times = round(seconds / part_s)
    long = {name: np.tile(values, times) for name, values in channels.items()}
    step_s = float(channels["t"][1] - channels["t"][0])
    long["t"] = np.asarray(np.arange(len(long["t"])) * step_s, dtype=np.float64)
    return long


def _least_squares(folder: Path) -> Pair:  # noqa: ARG001
    rng = np.random.default_rng(0)
    design, values = rng.normal(size=(ROWS, 10)), rng.normal(size=ROWS)
    return lambda: least_squares(design, values), lambda: design.T @ design


def _derivatives(folder: Path) -> Pair:  # noqa: ARG001
    t_s = np.arange(5.0 * ROWS) / 1000.0
    position, timing = np.sin(t_s), examined(t_s, {}, where="benchmark")
    return lambda: derivatives(t_s, position, cutoff_hz=20.0, timing=timing), _copied(position)


def _turned(folder: Path) -> Pair:  # noqa: ARG001
    rng = np.random.default_rng(1)
    none = np.zeros(CUTS)
    depths = rng.uniform(0.5, 3.0, CUTS)
    cuts = insert.TurnedCuts(rng.uniform(0.1, 0.4, CUTS), depths, none + 150.0, none + 30.0, none)
    tool = insert.Insert(nose_radius_mm=0.8, kappa_deg=95.0)
    theta = _law()
    elements = np.empty(CUTS * (insert.ON_NOSE + 1))
    return lambda: cut_forces(theta, insert.insert_elements(tool, cuts)), _copied(elements)


def _milled(folder: Path) -> Pair:  # noqa: ARG001
    mill = endmill.EndMill(diameter_mm=10.0, teeth=4, helix_deg=30.0)
    angles_rad = 2.0 * np.pi * 50.0 * np.arange(5000) / 5000
    one, theta, deep_mm = np.ones(1), _law(), 2.0
    cut = endmill.Milled(
        0.05 * one, deep_mm * one, 3000.0 * one,
        -mill.radius_mm * one, mill.radius_mm * one, 0.0 * one, 0.0 * one,
    )  # fmt: skip
    slices = np.empty(len(angles_rad) * mill.teeth * round(deep_mm / endmill.SLICE_MM))
    return lambda: endmill.waveform(theta, mill, cut, angles_rad), _copied(slices)


def _law() -> Array:
    names = dict.fromkeys(shear.NAMES, 0.0)
    law = {"shear_stress": 600.0, "friction_angle": 25.0, "chip_ratio": 0.4, "edge_mm": 0.02}
    return shear.law_coordinates({**names, **law, "K_te": 25.0, "K_re": 40.0, "flow_angle": 1.0})


def _copied(values: Array) -> Work:
    """Return work that moves so much memory once: reads it, and writes it elsewhere."""
    elsewhere = np.empty_like(values)
    return lambda: np.copyto(elsewhere, values)


def _looked_up(folder: Path) -> Pair:
    store = _shop(folder)
    calibrate_machine(store, MACHINE)
    refresh(store, MACHINE)
    with store.reading() as session:
        pair = session.scalars(select(models.Pair)).first()
        assert pair is not None
        number, material, tool = pair.id, pair.material.name, pair.tool.name
    plain = sqlite3.connect(folder / "shop.sqlite3")
    cut = JobCut(operation="turn", diameter_mm=50.0, depth_mm=2.0, feed_mm_rev=0.2, speed_m_min=180)
    select_row = "SELECT * FROM cutting_parameters WHERE pair_id = ?"

    def ours() -> None:
        with store.reading() as session:
            pair_reader = PairReader(session, MACHINE)
            for _ in range(LOOK_UPS):
                pair_reader.look_up(material, tool, cut)

    def rows() -> None:
        for _ in range(LOOK_UPS):
            plain.execute(select_row, (number,)).fetchone()

    return ours, rows


def _shop(folder: Path) -> Store:
    """Return a machine with the standard cuts and a week of the first sample job."""
    path = folder / "shop.sqlite3"
    for old in folder.glob("shop.sqlite3*"):
        old.unlink()
    create_store(f"sqlite:///{path}")
    store = open_store(f"sqlite:///{path}")
    add_machine(store, MACHINE, LATHE)
    for name in ("standard-cuts.csv", "shop-week-1.csv"):
        import_file(store, _sample(name), machine=MACHINE)
    return store


def _sample(name: str) -> Path:
    return kit("sample_jobs") / "stepped_shaft" / "recordings" / name


def _imported(folder: Path) -> Pair:
    return lambda: _shop(folder).close(), plain_work


def _calibrated(folder: Path) -> Pair:
    store = _shop(folder)
    return lambda: calibrate_machine(store, MACHINE), plain_work


def _refreshed(folder: Path) -> Pair:
    """A pair that is learned from the beginning: in a new copy of the machine each time."""
    store = _shop(folder)
    calibrate_machine(store, MACHINE)
    store.close()
    kept = (folder / "shop.sqlite3").read_bytes()

    def ours() -> None:
        (folder / "again.sqlite3").write_bytes(kept)
        again = open_store(f"sqlite:///{folder / 'again.sqlite3'}")
        refresh(again, MACHINE)
        again.close()

    return ours, plain_work


def _predicted(folder: Path) -> Pair:
    store = _shop(folder)
    calibrate_machine(store, MACHINE)
    refresh(store, MACHINE)
    job = read_job(kit("sample_jobs") / "stepped_shaft" / "job.toml")
    return lambda: predict_job(store, MACHINE, job), plain_work


def _explained_axis(folder: Path) -> Pair:  # noqa: ARG001
    channels, parts = air_moves(1, seconds=AXIS_S)
    current = np.asarray(sum(part for name, part in parts.items() if name != "gravity"))
    recording = Recording(path=Path("moves.csv"), channels=dict(channels))
    simulated = {"t": channels["t"], "x.current": current}
    simulation = Recording(path=Path("simulation.csv"), channels=simulated)
    return lambda: explain(recording, simulation), plain_work


def _even_stamps(folder: Path) -> Pair:
    return _stamps(folder, scatter=0.0)


def _uneven_stamps(folder: Path) -> Pair:
    return _stamps(folder, scatter=0.1)


def _stamps(folder: Path, *, scatter: float) -> Pair:
    """Examine stamps that scatter by a share of a step, and explain the same moves."""
    channels, _ = air_moves(1, seconds=AXIS_S)
    step_s = float(channels["t"][1] - channels["t"][0])
    off_s = np.random.default_rng(3).normal(0.0, scatter * step_s, len(channels["t"]))
    raw = Recording(path=Path("moves.csv"), channels=channels | {"t": channels["t"] + off_s})
    explained, _ = _explained_axis(folder)
    return lambda: on_even_rows(raw), explained


def _explained_cuts(folder: Path) -> Pair:  # noqa: ARG001
    rng = np.random.default_rng(2)
    cuts = 40
    feed, depth = rng.uniform(0.1, 0.4, cuts), rng.uniform(0.5, 3.0, cuts)
    held = {
        "cut": np.arange(1.0, cuts + 1.0), "cutting.feed": feed, "cutting.depth": depth,
        "cutting.speed": np.full(cuts, 180.0),
    }  # fmt: skip
    plain = 1800.0 * depth * feed
    force = {"force.y": plain + 60.0 * depth + rng.normal(0.0, 5.0, cuts)}
    texts = {"operation": ["turn"] * cuts}
    recording = CutTable(Path("cuts.csv"), {**held, **force}, texts)
    simulation = CutTable(Path("simulation.csv"), {**held, "force.y": plain}, texts)
    return lambda: explain(recording, simulation), plain_work


def _demo(folder: Path) -> Pair:
    return lambda: run_demo(folder / "demo", progress=lambda _: None), plain_work


MEASURES: Sequence[Measure] = (
    Measure("read CSV, 3000 s of three axes", "pyarrow's reader", 5, _read_csv),
    Measure("read Parquet, the same", "pyarrow's reader", 5, _read_parquet),
    Measure("least squares, 200 000 × 10", "BLAS: one product of the columns", 9, _least_squares),
    Measure("derivatives of 10⁶ positions", "memory: one copy", 9, _derivatives),
    Measure("forces of 20 000 turned cuts", "memory: a number an element", 9, _turned),
    Measure("forces of 1 s of milling", "memory: a number a slice", 9, _milled),
    Measure("200 look-ups of a pair", "SQLite: the row by its index", 9, _looked_up),
    Measure("import of two tables, new database", "plain work", 5, _imported),
    Measure("predict, stepped shaft", "plain work", 9, _predicted),
    Measure("refresh, a pair from 24 cuts", "plain work", 3, _refreshed),
    Measure("calibrate, three axes", "plain work", 3, _calibrated),
    Measure("explain, 60 s of an axis", "plain work", 3, _explained_axis),
    Measure("even stamps examined, 60 s of an axis", "explain", 3, _even_stamps, COSTS_MOST),
    Measure("uneven stamps examined, the same", "explain", 3, _uneven_stamps, COSTS_MOST),
    Measure("explain, 40 cuts", "plain work", 3, _explained_cuts),
    Measure("demo", "plain work", 2, _demo),
)
