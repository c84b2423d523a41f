"""`python -m benchmarks.axis_peers.run --python PEERS/bin/python --out FILE`: axes, identified.

Axes of `autodb prove axis-intervals`, of seeds that no proof and no test has. Each method gets the
recording in air and says what current steady motion takes at four places and speeds, which the
truth knows. An error is over the axis' Coulomb friction. FILE gets a row a method as JSON. Needs an
environment of `benchmarks/axis_peers/requirements.txt`; settings were fixed before an error was
looked at.
"""

import argparse
import os
import subprocess
import tempfile
import time
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

import autodb
from autodb.proofs.catalogue import proof
from autodb.proofs.machines.axis.axes import AxisRun, draw_run
from autodb.proofs.machines.axis.quantities import EFFORT_AT, TrueQuantity, effort_name, quantities
from autodb.proofs.runs.axis.axis_intervals import identified_axis, quantity_intervals
from autodb.proofs.runs.oracle import oracle
from autodb.records.tables import Recording

Array = NDArray[np.float64]

PEERS = ("figaroh", "stribeck", "sindy", "frols", "boosting")
OURS, ORACLE = "autodb", "oracle"
SIGNALS = ("position", "velocity", "acceleration", "current")
FIRST, AXES = 7001, 24
ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")


@dataclass(frozen=True)
class AxisErrors:
    """A method's errors over Coulomb friction: median and 90th percentile of ``currents``.

    ``seconds``: the median time of one axis; ``product``: the hash of the program judged.
    """

    method: str
    version: str
    axes: int
    currents: int
    median: float
    tenth: float
    seconds: float
    product: str


Answer = tuple[list[float], str, float]
"""Currents, package and version, seconds."""
ROWS: TypeAdapter[tuple[AxisErrors, ...]] = TypeAdapter(tuple[AxisErrors, ...])


def asked_of(run: AxisRun) -> list[TrueQuantity]:
    """Return the currents that are asked of an axis, with their truth."""
    names = {effort_name(x, v) for x, v in EFFORT_AT}
    return [one for one in quantities(run.axis, run.motion) if one.name in names]


def ours(run: AxisRun, seed: int) -> Answer:
    """Return autodb's currents, its version and seconds."""
    begun = time.perf_counter()
    recording = Recording(path=Path(f"axis-{seed}.csv"), channels=run.channels)
    given = quantity_intervals(identified_axis(recording))
    took = time.perf_counter() - begun
    return [given[one.name][0] for one in asked_of(run)], f"autodb {autodb.__version__}", took


def theirs(run: AxisRun, python: str) -> dict[str, Answer]:
    """Let the methods answer in a process of their own."""
    with tempfile.TemporaryDirectory() as folder:
        given, taken = Path(folder) / "case.npz", Path(folder) / "answer.npz"
        x, v, a, current = (run.channels[f"x.{name}"] for name in SIGNALS)
        np.savez(given, x=x, v=v, a=a, current=current, asked=np.array(EFFORT_AT))
        subprocess.run(
            [python, "-m", "benchmarks.axis_peers.answer", str(given), str(taken)],
            env={**os.environ, **ONE_THREAD}, capture_output=True, check=True,
        )  # fmt: skip
        with np.load(taken) as held:
            return {
                name: (
                    held[f"{name}/current"].tolist(),
                    str(held[f"{name}/version"]),
                    float(held[f"{name}/seconds"]),
                )
                for name in PEERS
            }


def rows(python: str, seeds: range) -> tuple[AxisErrors, ...]:
    """Return a row a method, autodb's first and the oracle's last."""
    product = proof("axis-intervals").origin().product
    off, took = defaultdict[str, list[float]](list), defaultdict[str, list[float]](list)
    versions: dict[str, str] = {}
    for seed in seeds:
        run = draw_run(seed)
        best = oracle(run)
        known = [sum(best.interval(one)) / 2.0 for one in asked_of(run)]
        answers = {OURS: ours(run, seed), **theirs(run, python)}
        answers[ORACLE] = (known, "", 0.0)
        for name, (values, versions[name], seconds) in answers.items():
            truth = [one.truth for one in asked_of(run)]
            off[name] += [
                abs(value - true) / run.axis.coulomb_A
                for value, true in zip(values, truth, strict=True)
            ]
            took[name].append(seconds)
        print(
            f"{seed}: {', '.join(f'{n} {100 * np.median(e):.2f} %' for n, e in off.items())}",
            flush=True,
        )
    return tuple(
        AxisErrors(
            name, versions[name], len(seeds), len(errors), float(np.median(errors)),
            float(np.quantile(errors, 0.9)), float(np.median(took[name])), product,
        )
        for name, errors in off.items()
    )  # fmt: skip


def main() -> None:
    """Run all methods on all axes and write the rows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--python", required=True, help="interpreter with the methods' packages")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--axes", type=int, default=AXES)
    given = parser.parse_args()
    found = rows(given.python, range(FIRST, FIRST + given.axes))
    given.out.write_bytes(ROWS.dump_json(found, indent=1) + b"\n")


if __name__ == "__main__":
    main()
