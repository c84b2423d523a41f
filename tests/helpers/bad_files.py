"""Files that cannot be used, written into a folder."""

import contextlib
import io
from collections.abc import Callable
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


def text(name: str, *lines: str) -> Callable[[Path], object]:
    return lambda folder: (folder / name).write_text("".join(f"{line}\n" for line in lines))


def moves(name: str = "moves.csv", **changed: object) -> Callable[[Path], object]:
    columns = {**MOVES, **{k.replace("_", "."): v for k, v in changed.items()}}
    return lambda folder: write(folder / name, columns)


def one_round(folder: Path) -> None:
    """Passes there and back at eight speeds, each once."""
    write(folder / "moves.csv", dict(recorded(Axis(), 1, repeats=1).channels))


def braked(folder: Path) -> None:
    """Moves that end against a closed brake for a second, the current at three times its height."""
    t = np.round(np.arange(100) * 0.01 + T[-1] + 0.01, 6)
    held = {
        "t": t,
        "x.position": np.full(100, X[-1]),
        "x.velocity": np.zeros(100),
        "x.current": np.full(100, 3.0 * float(np.max(np.abs(I)))),
    }
    write(folder / "moves.csv", {name: np.concatenate([MOVES[name], held[name]]) for name in held})


def cut_off(name: str) -> Callable[[Path], object]:
    def make(folder: Path) -> None:
        path = write(folder / name, MOVES)
        whole = path.read_bytes()
        path.write_bytes(whole[: int(0.7 * len(whole))])

    return make


def with_side(side: str, name: str = "moves.csv") -> Callable[[Path], object]:
    def make(folder: Path) -> None:
        write(folder / name, {"t": T, "pos": X, "cur": I})
        (folder / name).with_suffix(".toml").write_text(side)

    return make


def two_rates(folder: Path) -> None:
    slow = {"t": T[::100], "spindle.temperature": 20.0 + T[::100]}
    write_groups(folder / "moves.h5", {"drive": MOVES, "climate": slow})


def locked(folder: Path) -> None:
    write(folder / "moves.csv", MOVES).chmod(0)


def gap() -> list[float]:
    values = I.copy()
    values[120] = np.nan
    return list(values)


def cuts(**columns: object) -> Callable[[Path], object]:
    rows = {"cut": [1, 2, 3], "cutting.feed": [0.1, 0.2, 0.3], "force.z": [100.0, 180.0, 260.0]}
    return lambda folder: write(folder / "cuts.csv", {**rows, **columns})


def lathe(**factors: float) -> Callable[[Path], object]:
    """The sample lathe's standard cuts with a dynamometer, some columns times a factor."""

    def make(folder: Path) -> None:
        columns = cut_table(SAMPLE_LATHE, SAMPLE_PAIR, standard_cuts(), 21, dynamometer=True)
        for name, factor in factors.items():
            columns[name.replace("_", ".")] = columns[name.replace("_", ".")] * factor
        write(folder / "cuts.csv", columns)

    return make


def exchanged(folder: Path) -> None:
    """The forces of the lightest and the heaviest turned cut stand in each other's row."""
    columns = cut_table(SAMPLE_LATHE, SAMPLE_PAIR, standard_cuts(), 21, dynamometer=True)
    turned = np.flatnonzero(columns["operation"] == "turn")
    order = turned[np.argsort(columns["force.y"][turned])]
    for name in ("force.x", "force.y", "force.z"):
        columns[name][order[[0, -1]]] = columns[name][order[[-1, 0]]]
    write(folder / "cuts.csv", columns)


def faced_in_diameters(folder: Path) -> None:
    cut = cut_at((0.75, 0.2, 1200.0, 60.0), operation="face", duration_s=2.0)
    columns = raw_cut(SAMPLE_LATHE, SAMPLE_PAIR, cut, 25, True)
    columns["x.position"] = 2.0 * columns["x.position"]
    write(folder / "cut.parquet", columns)
    side = '[cut]\noperation = "face"\ndepth_mm = 0.75\nfeed_mm_rev = 0.2\n'
    (folder / "cut.toml").write_text(side)
    database(folder)


def unmeasured(folder: Path) -> None:
    (folder / "cuts.csv").write_text("cut,t,cutting.feed\n1,0,0.2\n2,9,0.2\n")
    database(folder)


def database(folder: Path) -> None:
    """A database with one lathe."""
    url = f"sqlite:///{folder / 'autodb.sqlite3'}"
    for command in ("init", "machine add lathe-1"):
        with contextlib.redirect_stdout(io.StringIO()):
            run([*command.split(), "--db", url])


def job(*keys: str) -> Callable[[Path], object]:
    head = ['name = "shaft"', 'material = "steel bar"', 'tool = "insert"', "[[cut]]"]
    return text("job.toml", *head, "diameter_mm = 50", "depth_mm = 1.0", *keys)


def raw(
    what: CutDisturbance, *, duration_s: float = 5.0, from_s: float = 0.0
) -> Callable[[Path], object]:
    def make(folder: Path) -> None:
        channels = made(2, what, duration_s).channels
        later = channels["t"] >= from_s
        write_parquet(folder / "cut.parquet", {n: v[later] for n, v in channels.items()})

    return make
