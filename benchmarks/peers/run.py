"""`python -m benchmarks.peers.run --python PEERS/bin/python --out FILE`: all methods, all cases.

A line of JSON for each case and method is appended to FILE; what is there is not done again.
"""

import argparse
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from pydantic import TypeAdapter

from autodb.proofs.cases.base.case import Case
from autodb.proofs.cases.plan import fixed_cases
from benchmarks.peers.answer import LIMIT_S
from benchmarks.peers.cases import problem_of
from benchmarks.peers.problem import read_answer
from benchmarks.peers.score import Score, scored, unscored

OURS = "ours"
METHODS = (
    OURS, "sindy_expert", "sindy_poly", "boosting", "gaussian", "gplearning", "gpelite",
    "adcd_search",
)  # fmt: skip
FORWARD = (OURS, "frols_expert", "frols_poly")
"""Asked in a run of their own, which keeps its own lines."""
CASES = 30
SCORE: TypeAdapter[Score] = TypeAdapter(Score)
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
XLA = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"


@dataclass(frozen=True)
class Asked:
    """A case and a method: ``python`` has what the method needs."""

    case: Case
    method: str
    python: str


def kept(path: Path) -> list[Score]:
    """Return the finished lines of a file, none where it is not there."""
    if not path.exists():
        return []
    return [SCORE.validate_json(line) for line in path.read_text("utf-8").splitlines()]


def answered(asked: Asked) -> Score:
    """Let a method answer a case in a process of its own, and score the answer."""
    with tempfile.TemporaryDirectory() as folder:
        given, taken = Path(folder) / "case.npz", Path(folder) / "answer.npz"
        problem_of(asked.case).save(given)
        module, files = "benchmarks.peers.answer", (str(given), str(taken))
        done = subprocess.run(
            [asked.python, "-m", module, asked.method, *files],
            env=_environment(), capture_output=True, text=True, check=False,
        )  # fmt: skip
        if done.returncode == -signal.SIGXCPU:
            return unscored(asked.case, asked.method, seconds=LIMIT_S, why="time")
        if done.returncode:
            why = (done.stderr.strip().splitlines() or ["no word"])[-1]
            return unscored(asked.case, asked.method, seconds=0.0, why=why)
        answer, seconds, version = read_answer(taken)
    return scored(asked.case, asked.method, answer, seconds=seconds, version=version)


def _environment() -> dict[str, str]:
    return {
        **os.environ,
        **dict.fromkeys(ONE_THREAD, "1"),
        "XLA_FLAGS": XLA,
        "JAX_PLATFORMS": "cpu",
    }


def _asked(python: str, methods: list[str], seeds: list[int], done: list[Score]) -> Iterator[Asked]:
    """What is missing, method by method; a case whose effects cannot show is asked of nobody."""
    have = {(one.seed, one.method) for one in done}
    cases = [case for case in fixed_cases(CASES) if case.reached and case.seed in seeds]
    for method in methods:
        for case in cases:
            if (case.seed, method) not in have:
                yield Asked(case, method, sys.executable if method == OURS else python)


def main() -> None:
    """Do what is missing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--python", required=True, help="interpreter with the methods' packages")
    parser.add_argument("--workers", type=int, choices=(1, 2), default=1)
    parser.add_argument("--methods", nargs="+", choices={*METHODS, *FORWARD}, default=list(METHODS))
    every = list(range(1, CASES + 1))
    parser.add_argument("--seeds", nargs="+", type=int, choices=every, default=every)
    given = parser.parse_args()
    asked = _asked(given.python, given.methods, given.seeds, kept(given.out))
    with ThreadPoolExecutor(given.workers) as pool, given.out.open("ab") as file:
        for score in pool.map(answered, asked):
            file.write(SCORE.dump_json(score) + b"\n")
            file.flush()
            print(
                f"{score.seed} {score.kind} {score.method}: {score.failed or list(score.named)}, "
                f"left {score.left}, alarm {score.alarm}, {score.seconds:.0f} s",
                flush=True,
            )


if __name__ == "__main__":
    main()
