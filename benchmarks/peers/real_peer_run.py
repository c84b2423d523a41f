"""`python -m benchmarks.peers.real_peer_run --python PEERS/bin/python --runs N`: on real axes.

The cases are the first N of `autodb prove real`, the columns those that decide which names are
fair. A table is printed; the greedy search of that proof stands in it too.
"""

import argparse
import os
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from autodb.proofs.cases.real.held_out import fitted_sizes, held_out
from autodb.proofs.cases.real.real_case import RealCase
from autodb.proofs.cases.real.real_cases import real_plan
from autodb.proofs.cases.real.real_columns import REAL_TERMS, columns_of
from autodb.proofs.runs.found import TextTable, piped
from autodb.proofs.runs.real.real_peers import PEERS, PeerAnswer, greedy
from autodb.proofs.runs.real.real_rows import PEER_HEADS, peer_group
from autodb.proofs.runs.real.real_score import JudgedReal, PeerScore, peer_score, unjudged
from benchmarks.peers.real_given import RealGiven

METHODS = {
    "FROLS (SysIdentPy)": "frols", "STLSQ (pysindy)": "sindy",
    "boosted trees (name nothing)": "boosting",
}  # fmt: skip
"""Methods by the name that a table has; the last one names nothing."""
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def given_of(case: RealCase) -> RealGiven:
    """Return a case as a method gets it: every shape of every name that is not included."""
    axis, own = case.axis, case.own.columns
    error = axis.effort - case.simulated
    left = error - fitted_sizes(own, error) @ own
    found = [
        (name, column)
        for name in REAL_TERMS
        if name not in case.includes
        for shape in columns_of(name, axis, case.simulated, left)
        for column in shape
    ]
    moves = [axis.t, axis.position, axis.v, axis.a, axis.direction, case.simulated]
    inputs = np.array(moves if axis.other_a is None else [*moves, axis.other_a])
    columns = np.array([column for _, column in found])
    return RealGiven(tuple(name for name, _ in found), columns, own, error, inputs)


def answered_by(method: str, given: RealGiven, python: str) -> PeerAnswer:
    """Let a method answer in a process of its own: its names, fitted beside the own columns."""
    with tempfile.TemporaryDirectory() as folder:
        asked, said = Path(folder, "given.npz"), Path(folder, "said.npz")
        given.save(asked)
        subprocess.run(
            [python, "-m", "benchmarks.peers.real_methods", method, str(asked), str(said)],
            env={**os.environ, **dict.fromkeys(ONE_THREAD, "1")}, check=True,
        )  # fmt: skip
        with np.load(said) as held:
            if "held_out" in held:
                return PeerAnswer({}, float(held["held_out"]))
            return fitted_answer(given, held["picked"].tolist())


def fitted_answer(given: RealGiven, picked: Sequence[int]) -> PeerAnswer:
    """Return names and peaks of the columns that were picked, and the held-out error with them."""
    own, chosen = given.own, given.columns[list(picked)]
    both = np.concatenate([own, chosen])
    parts = fitted_sizes(both, given.error)[len(own) :, None] * chosen
    names = [given.names[i] for i in picked]
    peaks = {
        name: float(np.max(np.abs(sum(p for n, p in zip(names, parts, strict=True) if n == name))))
        for name in dict.fromkeys(names)
    }
    return PeerAnswer(peaks, held_out(both, given.error).rms)


def judged_peers(case: RealCase, python: str) -> JudgedReal:
    """Return a case with the score of every method."""
    given, scores = given_of(case), dict[str, PeerScore]()
    for name, terms in PEERS.items():
        scores[name] = peer_score(case, greedy(case, terms))
    for name, method in METHODS.items():
        scores[name] = peer_score(case, answered_by(method, given, python))
    return replace(unjudged(case, case.axis.name), peers=scores)


def main() -> None:
    """Ask every method about the first cases and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--python", required=True, help="interpreter with the methods' packages")
    parser.add_argument("--runs", type=int, default=60)
    given = parser.parse_args()
    seen = [case for case in real_plan(given.runs) if case.seen]
    every = [judged_peers(case, given.python) for case in seen]
    clear = [one for one in every if not one.null and one.decidable]
    nulls = [one for one in every if one.null]
    rows = tuple(peer_group(name, clear, nulls).cells() for name in (*PEERS, *METHODS))
    print(piped(TextTable("", PEER_HEADS, rows)), end="")


if __name__ == "__main__":
    main()
