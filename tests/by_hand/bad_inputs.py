"""Inputs that cannot be used, and the line that each one gets.

`python -m tests.by_hand.bad_inputs docs/bad-inputs.md` makes every one of them, gives it to its
command and writes the page; a test compares the page with what the commands say.
"""

import contextlib
import io
import os
import sys
import tempfile
import textwrap
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from autodb.cli import run
from autodb.proofs.machines.lathe.disturbed import CutDisturbance
from autodb.proofs.machines.lathe.jobs import cut_at, standard_cuts
from autodb.proofs.machines.lathe.lathe import cut_table
from autodb.proofs.machines.lathe.phases import raw_cut
from autodb.proofs.machines.sample import SAMPLE_LATHE, SAMPLE_PAIR, write_parquet
from tests.helpers.files import write, write_groups
from tests.helpers.raw_cuts import made
from tests.helpers.staged_axis import Axis, recorded

T = np.round(np.arange(400) * 0.01, 6)
X = np.round(100.0 * np.sin(2 * np.pi * 0.5 * T), 6)
V = np.round(100.0 * np.pi * np.cos(2 * np.pi * 0.5 * T), 6)
I = np.round(0.01 * V + 0.8 * np.sign(V) + np.random.default_rng(8).normal(0, 0.05, 400), 6)  # noqa: E741 - the symbol of current
MOVES = {"t": T, "x.position": X, "x.velocity": V, "x.current": I}
NOBODY = 65534
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


def _text(name: str, *lines: str) -> Callable[[Path], object]:
    return lambda folder: (folder / name).write_text("".join(f"{line}\n" for line in lines))


def _moves(name: str = "moves.csv", **changed: object) -> Callable[[Path], object]:
    columns = {**MOVES, **{k.replace("_", "."): v for k, v in changed.items()}}
    return lambda folder: write(folder / name, columns)


def _one_round(folder: Path) -> None:
    """Passes there and back at eight speeds, each once."""
    write(folder / "moves.csv", dict(recorded(Axis(), 1, repeats=1).channels))


def _braked(folder: Path) -> None:
    """Moves that end against a closed brake for a second, the current at three times its height."""
    t = np.round(np.arange(100) * 0.01 + T[-1] + 0.01, 6)
    held = {
        "t": t,
        "x.position": np.full(100, X[-1]),
        "x.velocity": np.zeros(100),
        "x.current": np.full(100, 3.0 * float(np.max(np.abs(I)))),
    }
    write(folder / "moves.csv", {name: np.concatenate([MOVES[name], held[name]]) for name in held})


def _cut_off(name: str) -> Callable[[Path], object]:
    def make(folder: Path) -> None:
        path = write(folder / name, MOVES)
        whole = path.read_bytes()
        path.write_bytes(whole[: int(0.7 * len(whole))])

    return make


def _with_side(side: str, name: str = "moves.csv") -> Callable[[Path], object]:
    def make(folder: Path) -> None:
        write(folder / name, {"t": T, "pos": X, "cur": I})
        (folder / name).with_suffix(".toml").write_text(side)

    return make


def _two_rates(folder: Path) -> None:
    slow = {"t": T[::100], "spindle.temperature": 20.0 + T[::100]}
    write_groups(folder / "moves.h5", {"drive": MOVES, "climate": slow})


def _locked(folder: Path) -> None:
    write(folder / "moves.csv", MOVES).chmod(0)


def _gap() -> list[float]:
    values = I.copy()
    values[120] = np.nan
    return list(values)


def _cuts(**columns: object) -> Callable[[Path], object]:
    rows = {"cut": [1, 2, 3], "cutting.feed": [0.1, 0.2, 0.3], "force.z": [100.0, 180.0, 260.0]}
    return lambda folder: write(folder / "cuts.csv", {**rows, **columns})


def _lathe(**factors: float) -> Callable[[Path], object]:
    """The sample lathe's standard cuts with a dynamometer, some columns times a factor."""

    def make(folder: Path) -> None:
        columns = cut_table(SAMPLE_LATHE, SAMPLE_PAIR, standard_cuts(), 21, dynamometer=True)
        for name, factor in factors.items():
            columns[name.replace("_", ".")] = columns[name.replace("_", ".")] * factor
        write(folder / "cuts.csv", columns)

    return make


def _exchanged(folder: Path) -> None:
    """The forces of the lightest and the heaviest turned cut stand in each other's row."""
    columns = cut_table(SAMPLE_LATHE, SAMPLE_PAIR, standard_cuts(), 21, dynamometer=True)
    turned = np.flatnonzero(columns["operation"] == "turn")
    order = turned[np.argsort(columns["force.y"][turned])]
    for name in ("force.x", "force.y", "force.z"):
        columns[name][order[[0, -1]]] = columns[name][order[[-1, 0]]]
    write(folder / "cuts.csv", columns)


def _faced_in_diameters(folder: Path) -> None:
    cut = cut_at((0.75, 0.2, 1200.0, 60.0), operation="face", duration_s=2.0)
    columns = raw_cut(SAMPLE_LATHE, SAMPLE_PAIR, cut, 25, True)
    columns["x.position"] = 2.0 * columns["x.position"]
    write(folder / "cut.parquet", columns)
    side = '[cut]\noperation = "face"\ndepth_mm = 0.75\nfeed_mm_rev = 0.2\n'
    (folder / "cut.toml").write_text(side)
    _database(folder)


def _unmeasured(folder: Path) -> None:
    (folder / "cuts.csv").write_text("cut,t,cutting.feed\n1,0,0.2\n2,9,0.2\n")
    _database(folder)


def _database(folder: Path) -> None:
    """A database with one lathe."""
    url = f"sqlite:///{folder / 'autodb.sqlite3'}"
    for command in ("init", "machine add lathe-1"):
        with contextlib.redirect_stdout(io.StringIO()):
            run([*command.split(), "--db", url])


def _job(*keys: str) -> Callable[[Path], object]:
    head = ['name = "shaft"', 'material = "steel bar"', 'tool = "insert"', "[[cut]]"]
    return _text("job.toml", *head, "diameter_mm = 50", "depth_mm = 1.0", *keys)


def _raw(
    what: CutDisturbance, *, duration_s: float = 5.0, from_s: float = 0.0
) -> Callable[[Path], object]:
    def make(folder: Path) -> None:
        channels = made(2, what, duration_s).channels
        later = channels["t"] >= from_s
        write_parquet(folder / "cut.parquet", {n: v[later] for n, v in channels.items()})

    return make


LOOK = "autodb import moves.csv"
RAW_CUT = "autodb calibrate cut.parquet"
FILES = (
    Case("folder for a file", LOOK, lambda folder: (folder / "moves.csv").mkdir()),
    Case("empty file", LOOK, _text("moves.csv")),
    Case("header only", LOOK, _text("moves.csv", "t,x.position")),
    Case("wrong separator", LOOK, _text("moves.csv", "t;x.position", "0;1", "1;2")),
    Case("decimal comma", LOOK, _text("moves.csv", "t;x.position", "0,5;1", "1,5;2")),
    Case(
        "decimal comma, comma between columns", LOOK,
        _text("moves.csv", "t,x.position", "0,00,1,5", "0,01,1,6"),
    ),
    Case(
        "decimal comma in quotes", LOOK,
        _text("moves.csv", "t,x.position", '"0,00",1', '"0,01",2', '"0,02",3'),
    ),
    Case("text in a number", LOOK, _text("moves.csv", "t,x.position", "0,1", "1,two", "2,3")),
    Case("column named twice", LOOK, _text("moves.csv", "t,t", "0,1", "1,2")),
    Case(
        "header in another encoding", LOOK,
        lambda folder: (folder / "moves.csv").write_bytes("t,länge\n0,1\n".encode("latin-1")),
    ),
    Case("damaged number", LOOK, _text("moves.csv", "t,x.position", "0,1", "1,1e300", "2,3")),
    Case("unknown kind of file", "autodb import moves.xls", _text("moves.xls", "t")),
    Case("no such file", LOOK, lambda folder: folder),
    Case("a folder", "autodb import moves", lambda folder: (folder / "moves").mkdir()),
    Case("no permission", LOOK, _locked, as_nobody=True),
    *(
        Case(f"cut-off {kind}", f"autodb import moves.{suffix}", _cut_off(f"moves.{suffix}"))
        for kind, suffix in (
            ("Parquet", "parquet"), ("MAT", "mat"), ("TDMS", "tdms"), ("HDF5", "h5"), ("MF4", "mf4")
        )
    ),
)  # fmt: skip
TIME = (
    Case(
        "no time", LOOK,
        _text("moves.csv", "time,x.position", "0,1", "1,2", "2,3"),
    ),
    Case("repeated time", LOOK, _text("moves.csv", "t,x.position", "0,1", "0,2", "1,3")),
    Case("backward time", LOOK, _text("moves.csv", "t,x.position", "0,1", "2,2", "1,3")),
    Case("gap in time", LOOK, _text("moves.csv", "t,x.position", "0,1", ",2", "2,3")),
    Case(
        "too few rows", "autodb identify moves.csv",
        _text("moves.csv", "t,x.position", "0,1", "1,2"),
    ),
    Case("several time bases", "autodb identify moves.h5", _two_rates),
    Case("a group that is not there", "autodb identify moves.h5 --group drives", _two_rates),
    Case("rates that share no time", "autodb identify moves.h5 --resample 0.1", _two_rates),
)  # fmt: skip
CONTENT = (
    Case(
        "missing channel", "autodb identify moves.csv",
        lambda folder: write(folder / "moves.csv", {"t": T, "x.positon": X, "x.current": I}),
    ),
    Case("gap in a used channel", "autodb identify moves.csv", _moves(x_current=_gap())),
    Case("clipped channel", LOOK, _moves(x_current=np.clip(I, -3.0, 3.0))),
    Case("implausible unit: 10⁶ rpm", LOOK, _moves(spindle_speed=1e6 + T)),
    Case(
        "metres logged as mm", LOOK,
        lambda folder: write(
            folder / "moves.csv", {"t": T, "x.position": X / 1000.0, "x.current": I}
        ),
    ),
    Case("mm/min logged as mm/s", LOOK, _moves(x_velocity=60.0 * V)),
    Case(
        "rev/s logged as rpm", "autodb import cuts.csv",
        _cuts(**{
            "work.diameter": [50.0] * 3, "spindle.speed": [20.0] * 3, "cutting.speed": [188.0] * 3
        }),
    ),
    Case("one cut twice", "autodb import cuts.csv", _cuts(cut=[1, 2, 2])),
    Case("a cut without number", "autodb import cuts.csv", _cuts(cut=[1.0, float("nan"), 3.0])),
    Case("moves where cuts are needed", "autodb calibrate moves.csv", _moves()),
)  # fmt: skip
SIDE_FILES = (
    Case("missing column", LOOK, _with_side('[channels]\n"x.current" = "curr"\n')),
    Case("unknown key", LOOK, _with_side('[channels]\n"x.current" = {colum = "cur"}\n')),
    Case("unknown section", LOOK, _with_side("[chanels]\n")),
    Case("unknown channel", LOOK, _with_side('[channels]\n"x.curent" = "cur"\n')),
    Case(
        "unit of another dimension", LOOK,
        _with_side('[channels]\n"x.current" = {column = "cur", unit = "mm"}\n'),
    ),
    Case(
        "unknown unit", LOOK,
        _with_side('[channels]\n"x.current" = {column = "cur", unit = "amp/"}\n'),
    ),
    Case("unknown operation", LOOK, _with_side('[cut]\noperation = "knit"\n')),
    Case("not TOML", LOOK, _with_side("[channels\n")),
    Case("nested without end", LOOK, _with_side("channels = " + 5000 * "[")),
    Case("key of endless parts", LOOK, _with_side("channels" + 5000 * ".x" + " = 1")),
    Case(
        "side file that is not there", "autodb import moves.csv --columns names.toml",
        _moves(),
    ),
)  # fmt: skip
OTHERS = (
    Case(
        "job without a speed", "autodb predict job.toml --machine lathe-1",
        _job("feed_mm_rev = 0.2"),
    ),
    Case(
        "job with an unknown key", "autodb predict job.toml --machine lathe-1",
        _job("feed_mm_rev = 0.2", "speed_rpm = 900", "feed_mm = 3"),
    ),
    Case("mismatch that is not there", "autodb mismatch confirm 7", _database),
    Case("no database yet", "autodb machine list", lambda folder: folder),
    Case("not a database", "autodb machine list", _text("autodb.sqlite3", "text " * 300)),
)  # fmt: skip
STANDARD = (
    Case("protocol that is not there", "autodb standard show turning-steel", lambda folder: folder),
    Case(
        "dynamometer's file without forces", "autodb standard new mine cuts.csv",
        lambda folder: write(folder / "cuts.csv", {"cut": [1, 2], "z.current": [1.0, 1.1]}),
    ),
    Case("machine file without a clamping", PROGRAM, _text("lathe.toml", *MACHINE)),
    Case(
        "travel too short for a cut", PROGRAM,
        _text(
            "lathe.toml", *MACHINE[:-1],
            "axes.z.limits = { travel_low_mm = 90, travel_high_mm = 520 }",
            *CLAMPED, "zero = { x_mm = 0, z_mm = 120 }",
        ),
    ),
    Case(
        "jaws in the way of a cut", PROGRAM,
        _text("lathe.toml", *MACHINE, *CLAMPED, "zero = { x_mm = 0, z_mm = 100 }"),
    ),
)  # fmt: skip
CALIBRATIONS = (
    Case("feed in inches", "autodb calibrate cuts.csv", _lathe(cutting_feed=1 / 25.4)),
    Case("force.z in kN", "autodb calibrate cuts.csv", _lathe(force_z=1e-3)),
    Case("diameter as a radius", "autodb calibrate cuts.csv", _lathe(work_diameter=0.5)),
    Case(
        "two units at once", "autodb calibrate cuts.csv",
        _lathe(force_y=1e-3, cutting_depth=0.01),
    ),
    Case("a card of another kind", "autodb calibrate cuts.csv --card card.txt", _cuts()),
    Case("two cuts exchanged", "autodb calibrate cuts.csv", _exchanged),
    Case(
        "X logged as a diameter", "autodb import cut.parquet --machine lathe-1",
        _faced_in_diameters,
    ),
    Case(
        "cuts of which nothing was measured", "autodb import cuts.csv --machine lathe-1",
        _unmeasured,
    ),
)  # fmt: skip
AXES = (
    Case("current with its sign turned round", "autodb identify moves.csv", _moves(x_current=-I)),
    Case(
        "another axis' current", "autodb identify moves.csv --axis x",
        _moves(
            y_position=X, x_position=100.0 * np.sin(2.2 * T), x_velocity=220.0 * np.cos(2.2 * T)
        ),
    ),
    Case("a closed brake", "autodb identify moves.csv", _braked),
    Case("a pitch that nothing takes", "autodb identify moves.csv --pitch 10", _moves()),
    Case("no passes at constant speed", "autodb identify moves.csv --staged", _moves()),
    Case("passes that were not repeated", "autodb identify moves.csv --staged", _one_round),
    Case(
        "a linear drive with long poles",
        "autodb identify moves.csv --terms inertia,viscous,coulomb,spring,cogging --staged "
        "--pitch 60",
        _one_round,
    ),
    Case(
        "stages of a spindle",
        "autodb identify moves.csv --axis spindle --staged",
        lambda folder: write(
            folder / "moves.csv", {"t": T, "spindle.speed": V, "spindle.current": I}
        ),
    ),
    Case(
        "loads without a model", "autodb reconstruct moves.csv", _moves(),
    ),
    Case(
        "loads up to too high a frequency",
        "autodb reconstruct moves.csv --moves moves.csv --bandwidth 80", _moves(),
    ),
    Case(
        "a scale by a standard cut that is not there",
        "autodb scale moves.csv --machine lathe-1 --standard-cut turning-aluminium:heaviest",
        _moves(),
    ),
    Case(
        "a sweep with an axis that is not parked",
        "autodb sweep --machine-file lathe.toml --axis z --dialect fanuc",
        _text("lathe.toml", *MACHINE[:3], SLIDING),
    ),
    Case(
        "a table dynamometer of no machine", "autodb calibrate moves.csv --table", _moves(),
    ),
    Case(
        "a part measured beyond its bar", "autodb inspect part.toml",
        _text(
            "part.toml", "[bar]", "diameter_mm = 24.0", "length_mm = 120.0",
            "modulus_MPa = 210000.0", "[measured]", "place_mm = [20, 80, 140]",
            "diameter_error_mm = [0.03, 0.05, 0.09]", "noise_mm = 0.002",
        ),
    ),
    Case(
        "a sweep of a vertical axis without a safe height",
        "autodb sweep --machine-file lathe.toml --axis x --dialect fanuc --park z=300",
        _text("lathe.toml", *MACHINE[:2], *MACHINE[3:], *UPRIGHT),
    ),
)  # fmt: skip
RAW = (
    Case("a cut that stops in the middle", RAW_CUT, _raw(CutDisturbance(stop_s=(4.0, 4.6)))),
    Case("chatter", RAW_CUT, _raw(CutDisturbance(chatter_share=0.2, chatter_hz=137.0))),
    Case(
        "a spindle at its current limit", RAW_CUT,
        _raw(CutDisturbance(limit_share=1.0, wander_share=0.06)),
    ),
    Case("a cut that is too short", RAW_CUT, _raw(CutDisturbance(), duration_s=0.6)),
    Case("a recording that starts in the cut", RAW_CUT, _raw(CutDisturbance(), from_s=3.0)),
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
HEAD = """\
# Bad inputs

What each unusable input gets: one line on standard error (folded here), exit status 2, nothing
stored. Every line below was printed by the command beside it, on a file made for this page.

<!-- made by python -m tests.by_hand.bad_inputs docs/bad-inputs.md -->
"""


@contextlib.contextmanager
def folder_of(case: Case) -> Iterator[Path]:
    """Give a new working folder that holds the case's files."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o755)
        case.make(folder)
        os.chdir(folder)
        try:
            yield folder
        finally:
            os.chdir(before)


def answer(case: Case) -> tuple[int, str]:
    """Return exit status and standard error of a case's command."""
    with folder_of(case):
        if case.as_nobody and os.geteuid() == 0:
            return _in_child(case)
        return _run(case)


def _run(case: Case) -> tuple[int, str]:
    error = io.StringIO()
    with contextlib.redirect_stderr(error), contextlib.redirect_stdout(io.StringIO()):
        code = run(case.command.split()[1:])
    return code, error.getvalue()


def _in_child(case: Case) -> tuple[int, str]:
    """Run as the user nobody: the superuser has every permission."""
    _run(Case("", "autodb import nothing.csv", case.make))  # imports what the child may not read
    reads, writes = os.pipe()
    child = os.fork()
    if child == 0:
        os.setuid(NOBODY)
        code, text = _run(case)
        os.write(writes, text.encode())
        os._exit(code)
    os.close(writes)
    with os.fdopen(reads, encoding="utf-8") as pipe:
        text = pipe.read()
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), text


def page() -> str:
    """Return the page, made by running every case."""
    parts = [HEAD]
    for title, cases in PARTS:
        parts.append(f"\n## {title}\n")
        parts += [entry(case, answer(case)[1]) for case in cases]
    return "".join(parts)


def entry(case: Case, said: str) -> str:
    """Return a case's entry on the page: what is wrong, the command, the line that it gets."""
    line = textwrap.fill(said.strip(), 96, break_on_hyphens=False, break_long_words=False)
    return f"\n**{case.what}** · `{case.command}`\n\n```text\n{line}\n```\n"


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python -m tests.by_hand.bad_inputs PAGE")
    Path(sys.argv[1]).write_text(page(), encoding="utf-8")
