"""`python -m benchmarks.peers.real_peer_run --python PEERS/bin/python --out FILE`: on real axes.

The cases are those of the first N of `autodb prove real` whose effect shows and has one name, and
its nulls; the columns are those that decide which names are fair. FILE gets a line a case as JSON,
and what is there is not asked again; a table is printed, in which the greedy search of that proof
stands, too.
"""

import argparse
import os
import subprocess
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from pydantic import TypeAdapter

from autodb.proofs.cases.real.held_out import fitted_sizes, held_out
from autodb.proofs.cases.real.real_case import RealCase
from autodb.proofs.cases.real.real_cases import made_case
from autodb.proofs.cases.real.real_columns import REAL_TERMS, columns_of
from autodb.proofs.runs.found import TextTable, piped
from autodb.proofs.runs.real.real_peers import PEERS, PeerAnswer, greedy
from autodb.proofs.runs.real.real_rows import PEER_HEADS, PeerGroup, peer_group
from autodb.proofs.runs.real.real_run import planned
from autodb.proofs.runs.real.real_score import JudgedReal, PeerScore, peer_score
from benchmarks.peers.real_given import RealGiven

METHODS = {
    "FROLS (SysIdentPy)": "frols", "STLSQ (pysindy)": "sindy",
    "boosted trees (name nothing)": "boosting",
}  # fmt: skip
"""Methods by the name that a table has; the last one names nothing."""
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
RUNS = 1000


@dataclass(frozen=True)
class JudgedPeers:
    """A case by its place in the proof's plan; nothing is judged where it is not asked about."""

    seed: int
    null: bool
    peers: dict[str, PeerScore]


JUDGED = TypeAdapter(JudgedPeers)
GROUPS: TypeAdapter[list[PeerGroup]] = TypeAdapter(list[PeerGroup])


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


def answers(given: RealGiven, python: str) -> dict[str, PeerAnswer]:
    """Let the methods answer in a process of their own: their names, beside the own columns."""
    with tempfile.TemporaryDirectory() as folder:
        asked, said = Path(folder, "given.npz"), Path(folder, "said.npz")
        given.save(asked)
        subprocess.run(
            [python, "-m", "benchmarks.peers.real_methods", str(asked), str(said)],
            env={**os.environ, **dict.fromkeys(ONE_THREAD, "1")}, capture_output=True, check=True,
        )  # fmt: skip
        with np.load(said) as held:
            return {
                name: PeerAnswer({}, float(held[method]))
                if method == "boosting"
                else fitted_answer(given, held[method].tolist())
                for name, method in METHODS.items()
            }


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


def judged_peers(seed: int, python: str) -> JudgedPeers:
    """Return a case with the score of every method; nothing of one that nobody can decide."""
    case = made_case(planned(seed))
    null = case.concealed is None
    if not case.seen or not (null or case.decidable):
        return JudgedPeers(seed, null, {})
    found = {name: greedy(case, terms) for name, terms in PEERS.items()}
    found |= answers(given_of(case), python)
    return JudgedPeers(seed, null, {name: peer_score(case, one) for name, one in found.items()})


def groups(judged: Sequence[JudgedPeers]) -> list[PeerGroup]:
    """Return how each method did."""
    case = JudgedReal("", "", "", "", "", "", "", seen=True, decidable=True)
    asked = [(one.null, replace(case, peers=one.peers)) for one in judged if one.peers]
    clear, nulls = ([one for null, one in asked if null is wanted] for wanted in (False, True))
    return [peer_group(name, clear, nulls) for name in (*PEERS, *METHODS)]


def kept(path: Path) -> list[JudgedPeers]:
    """Return what a file holds; the last line may be cut off."""
    lines = path.read_bytes().splitlines(keepends=True) if path.exists() else []
    return [JUDGED.validate_json(line) for line in lines if line.endswith(b"\n")]


def main() -> None:
    """Ask every method about what is missing and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--python", required=True, help="interpreter with the methods' packages")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--runs", type=int, default=RUNS)
    parser.add_argument("--workers", type=int, choices=(1, 2), default=1)
    parser.add_argument("--table", type=Path, help="the table as JSON, too")
    given = parser.parse_args()
    done = kept(given.out)
    given.out.write_bytes(b"".join(JUDGED.dump_json(one) + b"\n" for one in done))
    missing = sorted(set(range(1, given.runs + 1)) - {one.seed for one in done})
    with ThreadPoolExecutor(given.workers) as pool, given.out.open("ab") as file:
        for one in pool.map(lambda seed: judged_peers(seed, given.python), missing):
            file.write(JUDGED.dump_json(one) + b"\n")
            file.flush()
            done.append(one)
    found = groups(done)
    if given.table:
        given.table.write_bytes(GROUPS.dump_json(found, indent=1))
    print(piped(TextTable("", PEER_HEADS, tuple(one.cells() for one in found))), end="")


if __name__ == "__main__":
    main()
