"""Inputs that cannot be used, and the command that meets each."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from autodb.proofs.machines.lathe.disturbed import CutDisturbance
from tests.helpers.bad_files import (
    I,
    T,
    V,
    X,
    braked,
    cut_off,
    cuts,
    database,
    exchanged,
    faced_in_diameters,
    gap,
    job,
    lathe,
    locked,
    moves,
    one_round,
    raw,
    text,
    two_rates,
    unmeasured,
    with_side,
)
from tests.helpers.files import write

PROGRAM = "autodb standard program turning-aluminium --machine-file lathe.toml --dialect fanuc"
MACHINE = (
    "diameter = true",
    "spindle = { max_speed_rpm = 3000 }",
    "axes.x.limits = { travel_low_mm = -10, travel_high_mm = 160 }",
    "axes.z.limits = { travel_low_mm = -5, travel_high_mm = 520 }",
)
CLAMPED = (
    "[setup]",
    "tool = 3",
    'spindle = "M4"',
    "clearance_mm = 2",
    "retract = { x_mm = 150, z_mm = 300 }",
    "jaws = { z_mm = 60, diameter_mm = 200 }",
)


UPRIGHT = (
    'axes.x.vertical = "up"',
    "axes.x.limits = { travel_low_mm = -10, travel_high_mm = 160, speed_mm_min = 9000 }",
)
SLIDING = "axes.z.limits = { travel_low_mm = -5, travel_high_mm = 520, speed_mm_min = 9000 }"


@dataclass(frozen=True)
class Case:
    """What is wrong, the command that meets it, and how the files are made in a folder."""

    what: str
    command: str
    make: Callable[[Path], object]
    as_nobody: bool = False


LOOK = "autodb import moves.csv"
RAW_CUT = "autodb calibrate cut.parquet"
FILES = (
    Case("folder for a file", LOOK, lambda folder: (folder / "moves.csv").mkdir()),
    Case("empty file", LOOK, text("moves.csv")),
    Case("header only", LOOK, text("moves.csv", "t,x.position")),
    Case(
        "decimal comma, comma between columns", LOOK,
        text("moves.csv", "t,x.position", "0,00,1,5", "0,01,1,6"),
    ),
    Case(
        "decimal points and commas", LOOK,
        text("moves.csv", "t;x.position", "0.00;1", "0.01;2.5", "0,02;3"),
    ),
    Case("text in a number", LOOK, text("moves.csv", "t,x.position", "0,1", "1,two", "2,3")),
    Case("column named twice", LOOK, text("moves.csv", "t,t", "0,1", "1,2")),
    Case(
        "another encoding than stated", LOOK,
        lambda folder: (
            (folder / "moves.csv").write_bytes("t,länge\n0,1\n".encode("latin-1")),
            text("moves.toml", "[csv]", 'encoding = "utf-8"')(folder),
        ),
    ),
    Case(
        "a table that is not as stated", LOOK,
        lambda folder: (
            text("moves.csv", "t,x.position", "0,1", "1,2")(folder),
            text("moves.toml", "[csv]", 'separator = ";"', "header_line = 9")(folder),
        ),
    ),
    Case("damaged number", LOOK, text("moves.csv", "t,x.position", "0,1", "1,1e300", "2,3")),
    Case("unknown kind of file", "autodb import moves.doc", text("moves.doc", "t")),
    Case("a side file alone", "autodb import moves.toml", text("moves.toml", "[tool]")),
    Case("no such file", LOOK, lambda folder: folder),
    Case("a folder", "autodb import moves", lambda folder: (folder / "moves").mkdir()),
    Case("no permission", LOOK, locked, as_nobody=True),
    *(
        Case(f"cut-off {kind}", f"autodb import moves.{suffix}", cut_off(f"moves.{suffix}"))
        for kind, suffix in (
            ("Parquet", "parquet"), ("MAT", "mat"), ("TDMS", "tdms"), ("HDF5", "h5"), ("MF4", "mf4")
        )
    ),
)  # fmt: skip
TIME = (
    Case(
        "no time", LOOK,
        text("moves.csv", "time,x.position", "0,1", "1,2", "2,3"),
    ),
    Case("repeated time", LOOK, text("moves.csv", "t,x.position", "0,1", "0,2", "1,3")),
    Case("backward time", LOOK, text("moves.csv", "t,x.position", "0,1", "2,2", "1,3")),
    Case("gap in time", LOOK, text("moves.csv", "t,x.position", "0,1", ",2", "2,3")),
    Case(
        "too few rows", "autodb identify moves.csv",
        text("moves.csv", "t,x.position", "0,1", "1,2"),
    ),
    Case("several time bases", "autodb identify moves.h5", two_rates),
    Case("a group that is not there", "autodb identify moves.h5 --group drives", two_rates),
    Case("rates that share no time", "autodb identify moves.h5 --resample 0.1", two_rates),
)  # fmt: skip
CONTENT = (
    Case(
        "missing channel", "autodb identify moves.csv",
        lambda folder: write(folder / "moves.csv", {"t": T, "x.positon": X, "x.current": I}),
    ),
    Case("gap in a used channel", "autodb identify moves.csv", moves(x_current=gap())),
    Case("clipped channel", LOOK, moves(x_current=np.clip(I, -3.0, 3.0))),
    Case("implausible unit: 10⁶ rpm", LOOK, moves(spindle_speed=1e6 + T)),
    Case(
        "metres logged as mm", LOOK,
        lambda folder: write(
            folder / "moves.csv", {"t": T, "x.position": X / 1000.0, "x.current": I}
        ),
    ),
    Case("mm/min logged as mm/s", LOOK, moves(x_velocity=60.0 * V)),
    Case(
        "rev/s logged as rpm", "autodb import cuts.csv",
        cuts(**{
            "work.diameter": [50.0] * 3, "spindle.speed": [20.0] * 3, "cutting.speed": [188.0] * 3
        }),
    ),
    Case("one cut twice", "autodb import cuts.csv", cuts(cut=[1, 2, 2])),
    Case("a cut without number", "autodb import cuts.csv", cuts(cut=[1.0, float("nan"), 3.0])),
    Case("moves where cuts are needed", "autodb calibrate moves.csv", moves()),
)  # fmt: skip
SIDE_FILES = (
    Case("missing column", LOOK, with_side('[channels]\n"x.current" = "curr"\n')),
    Case("unknown key", LOOK, with_side('[channels]\n"x.current" = {colum = "cur"}\n')),
    Case("unknown section", LOOK, with_side("[chanels]\n")),
    Case("unknown channel", LOOK, with_side('[channels]\n"x.curent" = "cur"\n')),
    Case(
        "unit of another dimension", LOOK,
        with_side('[channels]\n"x.current" = {column = "cur", unit = "mm"}\n'),
    ),
    Case(
        "unknown unit", LOOK,
        with_side('[channels]\n"x.current" = {column = "cur", unit = "amp/"}\n'),
    ),
    Case("unknown operation", LOOK, with_side('[cut]\noperation = "knit"\n')),
    Case("not TOML", LOOK, with_side("[channels\n")),
    Case("nested without end", LOOK, with_side("channels = " + 5000 * "[")),
    Case("key of endless parts", LOOK, with_side("channels" + 5000 * ".x" + " = 1")),
    Case(
        "side file that is not there", "autodb import moves.csv --columns names.toml",
        moves(),
    ),
)  # fmt: skip
OTHERS = (
    Case(
        "job without a speed", "autodb predict job.toml --machine lathe-1",
        job("feed_mm_rev = 0.2"),
    ),
    Case(
        "job with an unknown key", "autodb predict job.toml --machine lathe-1",
        job("feed_mm_rev = 0.2", "speed_rpm = 900", "feed_mm = 3"),
    ),
    Case("mismatch that is not there", "autodb mismatch confirm 7", database),
    Case("no database yet", "autodb machine list", lambda folder: folder),
    Case("not a database", "autodb machine list", text("autodb.sqlite3", "text " * 300)),
)  # fmt: skip
STANDARD = (
    Case("protocol that is not there", "autodb standard show turning-steel", lambda folder: folder),
    Case(
        "dynamometer's file without forces", "autodb standard new mine cuts.csv",
        lambda folder: write(folder / "cuts.csv", {"cut": [1, 2], "z.current": [1.0, 1.1]}),
    ),
    Case("machine file without a clamping", PROGRAM, text("lathe.toml", *MACHINE)),
    Case(
        "travel too short for a cut", PROGRAM,
        text(
            "lathe.toml", *MACHINE[:-1],
            "axes.z.limits = { travel_low_mm = 90, travel_high_mm = 520 }",
            *CLAMPED, "zero = { x_mm = 0, z_mm = 120 }",
        ),
    ),
    Case(
        "jaws in the way of a cut", PROGRAM,
        text("lathe.toml", *MACHINE, *CLAMPED, "zero = { x_mm = 0, z_mm = 100 }"),
    ),
)  # fmt: skip
CALIBRATIONS = (
    Case("feed in inches", "autodb calibrate cuts.csv", lathe(cutting_feed=1 / 25.4)),
    Case("force.z in kN", "autodb calibrate cuts.csv", lathe(force_z=1e-3)),
    Case("diameter as a radius", "autodb calibrate cuts.csv", lathe(work_diameter=0.5)),
    Case(
        "two units at once", "autodb calibrate cuts.csv",
        lathe(force_y=1e-3, cutting_depth=0.01),
    ),
    Case("a force on the work", "autodb calibrate cuts.csv", lathe(force_y=-1.0, force_z=-1.0)),
    Case("a card of another kind", "autodb calibrate cuts.csv --card card.txt", cuts()),
    Case("two cuts exchanged", "autodb calibrate cuts.csv", exchanged),
    Case(
        "X logged as a diameter", "autodb import cut.parquet --machine lathe-1",
        faced_in_diameters,
    ),
    Case(
        "cuts of which nothing was measured", "autodb import cuts.csv --machine lathe-1",
        unmeasured,
    ),
)  # fmt: skip
AXES = (
    Case("current with its sign turned round", "autodb identify moves.csv", moves(x_current=-I)),
    Case(
        "another axis' current", "autodb identify moves.csv --axis x",
        moves(
            y_position=X, x_position=100.0 * np.sin(2.2 * T), x_velocity=220.0 * np.cos(2.2 * T)
        ),
    ),
    Case("a closed brake", "autodb identify moves.csv", braked),
    Case("a pitch that nothing takes", "autodb identify moves.csv --pitch 10", moves()),
    Case("no passes at constant speed", "autodb identify moves.csv --staged", moves()),
    Case("passes that were not repeated", "autodb identify moves.csv --staged", one_round),
    Case(
        "a linear drive with long poles",
        "autodb identify moves.csv --terms inertia,viscous,coulomb,spring,cogging --staged "
        "--pitch 60",
        one_round,
    ),
    Case(
        "stages of a spindle",
        "autodb identify moves.csv --axis spindle --staged",
        lambda folder: write(
            folder / "moves.csv", {"t": T, "spindle.speed": V, "spindle.current": I}
        ),
    ),
    Case(
        "loads without a model", "autodb reconstruct moves.csv", moves(),
    ),
    Case(
        "loads up to too high a frequency",
        "autodb reconstruct moves.csv --moves moves.csv --bandwidth 80", moves(),
    ),
    Case(
        "a scale by a standard cut that is not there",
        "autodb scale moves.csv --machine lathe-1 --standard-cut turning-aluminium:heaviest",
        moves(),
    ),
    Case(
        "a sweep with an axis that is not parked",
        "autodb sweep --machine-file lathe.toml --axis z --dialect fanuc",
        text("lathe.toml", *MACHINE[:3], SLIDING),
    ),
    Case(
        "a table dynamometer of no machine", "autodb calibrate moves.csv --table", moves(),
    ),
    Case(
        "a part measured beyond its bar", "autodb inspect part.toml",
        text(
            "part.toml", "[bar]", "diameter_mm = 24.0", "length_mm = 120.0",
            "modulus_MPa = 210000.0", "[measured]", "place_mm = [20, 80, 140]",
            "diameter_error_mm = [0.03, 0.05, 0.09]", "noise_mm = 0.002",
        ),
    ),
    Case(
        "a sweep of a vertical axis without a safe height",
        "autodb sweep --machine-file lathe.toml --axis x --dialect fanuc --park z=300",
        text("lathe.toml", *MACHINE[:2], *MACHINE[3:], *UPRIGHT),
    ),
)  # fmt: skip
RAW = (
    Case("a cut that stops in the middle", RAW_CUT, raw(CutDisturbance(stop_s=(4.0, 4.6)))),
    Case("chatter", RAW_CUT, raw(CutDisturbance(chatter_share=0.2, chatter_hz=137.0))),
    Case(
        "a spindle at its current limit", RAW_CUT,
        raw(CutDisturbance(limit_share=1.0, wander_share=0.06)),
    ),
    Case("a cut that is too short", RAW_CUT, raw(CutDisturbance(), duration_s=0.6)),
    Case("a recording that starts in the cut", RAW_CUT, raw(CutDisturbance(), from_s=3.0)),
)  # fmt: skip
PARTS = (
    ("Files", FILES),
    ("Time", TIME),
    ("Content", CONTENT),
    ("Calibrations", CALIBRATIONS),
    ("Raw recordings of a cut", RAW),
    ("Side files", SIDE_FILES),
    ("Jobs and databases", OTHERS),
    ("Standard cuts", STANDARD),
    ("Axes and their moves", AXES),
)
