"""`python -m benchmarks.anfis`: Sugeno systems on published examples, other libraries beside them.

    python -m benchmarks.anfis --series FOLDER [--python PEERS/bin/python] [--cars auto-mpg.data]
                               [--out anfis-peers.json]

FOLDER holds jang-example4-data.trn and .chk (Jang 1993, example 4). With ``--python``, an
environment of ``benchmarks/anfis_peers/requirements.txt``, three other libraries learn the same
rows, each in a process of its own, one thread, on the same machine in the same run. ``--cars``: the
table auto-mpg.data of the UCI repository (Quinlan 1993; CC BY 4.0), not kept here.
"""

import argparse
import os
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

from autodb.fitting import anfis

Array = NDArray[np.float64]

ANSWER = Path(__file__).parent / "anfis_peers" / "answer.py"
PEERS = ("anfis-toolbox", "torchanfis", "anfispy")
TRAINED = 500
"""Rows of the series that are learnt; as many others check."""
ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")


@dataclass(frozen=True)
class Learned:
    """What a library answers for train rows then check rows, and the seconds that learning took."""

    name: str
    answer: Array
    seconds: float


@dataclass(frozen=True)
class SeriesError:
    """Errors (RMSE) of a library on Jang's series, rows that it learnt and others; seconds."""

    name: str
    train: float
    check: float
    seconds: float


@dataclass(frozen=True)
class ThreeError:
    """Mean relative errors of a learner on Jang's second example, %: rows learnt and others."""

    name: str
    train: float
    check: float


@dataclass(frozen=True)
class PublishedErrors:
    """Errors on Jang's series, and autodb's on his second example."""

    series: tuple[SeriesError, ...]
    three: tuple[ThreeError, ...]


ERRORS = TypeAdapter(PublishedErrors)


def rms(values: Array) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def ours(train: Array, check: Array) -> list[Learned]:
    """Learn by variable projection from five starts, and as Jang does from one."""
    inputs = train.shape[1] - 1
    done = []
    for name, starts, learner in learners(inputs):
        began = time.perf_counter()
        model = anfis.fit_anfis(train[:, :-1], train[:, -1], starts, learner=learner)
        seconds = time.perf_counter() - began
        answer = anfis.evaluate(model, np.vstack([train, check])[:, :-1])
        done.append(Learned(name, answer, seconds))
    return done


def learners(inputs: int) -> list[tuple[str, tuple[anfis.Premises, ...], anfis.Learner]]:
    """Return what autodb learns with, two sets an input: name, starts and learner of each."""
    start = anfis.premise_grid((2,) * inputs)
    return [
        ("variable projection", anfis.nearby(start), anfis.Projection()),
        ("hybrid (Jang)", (start,), anfis.Hybrid(200)),
    ]


def peer(python: str, name: str, train: Array, check: Array) -> Learned:
    """Let one library learn in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        np.save(Path(folder) / "train.npy", train)
        np.save(Path(folder) / "check.npy", check)
        done = subprocess.run(
            [python, str(ANSWER), name, folder],
            env={**os.environ, **ONE_THREAD, "PYTHONPATH": ""},
            capture_output=True, text=True, check=True,
        )  # fmt: skip
        answer = np.load(Path(folder) / "answer.npy")
    return Learned(name, answer, float(done.stdout.split()[-1]))


def series(folder: Path, python: str | None) -> tuple[SeriesError, ...]:
    """Print errors on Jang's Mackey-Glass series: published 0.0016 train, 0.0015 check."""
    train, check = (np.loadtxt(folder / f"jang-example4-data.{part}") for part in ("trn", "chk"))
    done = ours(train, check)
    if python is not None:
        done += [peer(python, name, train, check) for name in PEERS]
    wanted = np.concatenate([train[:, -1], check[:, -1]])
    print("Mackey-Glass, 16 rules: RMSE train, check (ratio to the first), seconds (ratio)")
    rows = tuple(_error(one, one.answer - wanted) for one in done)
    for row in rows:
        print(
            f"  {row.name}: {row.train:.6f}, {row.check:.6f} ({row.check / rows[0].check:.2f}), "
            f"{row.seconds:.1f} s ({row.seconds / rows[0].seconds:.2f})"
        )
    return rows


def _error(one: Learned, off: Array) -> SeriesError:
    return SeriesError(one.name, rms(off[:TRAINED]), rms(off[TRAINED:]), one.seconds)


def three_inputs(x: Array) -> Array:
    """Return Jang's function of three inputs (1993, example 2), (n,)."""
    return np.asarray((1.0 + x[:, 0] ** 0.5 + 1.0 / x[:, 1] + x[:, 2] ** -1.5) ** 2)


def cube(levels: Array) -> Array:
    """Return the grid (m³, 3) of levels (m,)."""
    return np.array(np.meshgrid(levels, levels, levels, indexing="ij")).reshape(3, -1).T


def three() -> tuple[ThreeError, ...]:
    """Print and return errors on Jang's second example: published 0.043 % train, 1.066 % check."""
    train, check = cube(np.arange(1.0, 7.0)), cube(np.arange(1.5, 6.0))
    tables = [np.column_stack([x, three_inputs(x)]) for x in (train, check)]
    values = np.concatenate([one[:, -1] for one in tables])
    print("three inputs, 8 rules: mean relative error, % train, % check")
    done = []
    for learned in ours(*tables):
        off = 100.0 * np.abs(learned.answer / values - 1.0)
        row = ThreeError(
            learned.name, float(np.mean(off[: len(train)])), float(np.mean(off[len(train) :]))
        )
        print(f"  {row.name}: {row.train:.4f}, {row.check:.3f}")
        done.append(row)
    return tuple(done)


def cars(path: Path) -> None:
    """Print errors of fuel consumption over weight and year, odd rows train, even rows check."""
    lines = [line.split()[:8] for line in path.read_text("utf-8").splitlines()]
    table = np.array([[float(v) for v in line] for line in lines if "?" not in line])
    x, y = table[:, [4, 6]], table[:, 0]
    model = anfis.fit_anfis(x[::2], y[::2], anfis.nearby(anfis.premise_grid((2, 2))))
    off = anfis.evaluate(model, x) - y
    low, high = anfis.predict_anfis(model, x[1::2]).interval()
    held = np.mean((low <= y[1::2]) & (y[1::2] <= high))
    print(f"{len(table)} cars, 4 rules: RMSE {rms(off[::2]):.3f} train, {rms(off[1::2]):.3f} check")
    print(f"  95 % intervals hold {100.0 * held:.1f} % of the check rows")


def main() -> None:
    """Print all that the arguments give."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--series", type=Path, required=True)
    parser.add_argument("--python")
    parser.add_argument("--cars", type=Path)
    parser.add_argument("--out", type=Path, help="write the errors on Jang's examples as JSON")
    asked = parser.parse_args()
    found = PublishedErrors(series(asked.series, asked.python), three())
    if asked.out is not None:
        asked.out.write_bytes(ERRORS.dump_json(found, indent=1) + b"\n")
    if asked.cars is not None:
        cars(asked.cars)


if __name__ == "__main__":
    main()
