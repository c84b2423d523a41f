"""`python -m benchmarks.pair_peers RUNS.jsonl OUT.json`: boosted trees on a learning curve's pairs.

RUNS.jsonl is what `autodb prove pair-curve` kept; the same pairs are drawn again by their seeds,
and scikit-learn's gradient boosting learns the same readings: log force over the logarithms of
feed, depth of cut and speed, settings as scikit-learn has them. Needs scikit-learn beside autodb.
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter

from autodb.errors import UnusableInput
from autodb.proofs.catalogue import proof
from autodb.proofs.runs.pairs.curve_case import draw_case
from autodb.proofs.runs.pairs.curve_peers import Peer
from autodb.proofs.runs.pairs.curve_run import OURS, LearningErrors, learnt
from autodb.proofs.runs.pairs.curve_summary import CurveRow, curve_rows_of

Array = NDArray[np.float64]
ROWS: TypeAdapter[tuple[CurveRow, ...]] = TypeAdapter(tuple[CurveRow, ...])


def boosted(cuts: Array, force_N: Array, asked: Array) -> Array:
    """Return what gradient-boosted trees expect of cuts asked."""
    from sklearn.ensemble import GradientBoostingRegressor

    trees = GradientBoostingRegressor(random_state=0).fit(cuts, np.log(force_N))
    return np.asarray(np.exp(trees.predict(asked)))


PEERS = (Peer("boosted trees (scikit-learn)", 2, boosted),)


def rows(path: Path) -> tuple[CurveRow, ...]:
    """Return autodb's rows from the runs kept, and the peers' of the same seeds."""
    _, *lines = path.read_text("utf-8").splitlines()
    if not lines:
        raise UnusableInput(f"{path}: no runs; the file that `autodb prove pair-curve` keeps would")
    runs = [proof("pair-curve").kept.validate_json(line) for line in lines]
    every = [
        one
        for run in sorted(runs, key=lambda run: run.seed)
        for one in (*_ours(run.judged), *_theirs(run.seed))
    ]
    return curve_rows_of(every)


def _ours(judged: tuple[object, ...]) -> list[LearningErrors]:
    return [one for one in judged if isinstance(one, LearningErrors) and one.method == OURS]


def _theirs(seed: int) -> list[LearningErrors]:
    case = draw_case(seed)
    return [one for peer in PEERS for one in learnt(peer, case)]


if __name__ == "__main__":
    Path(sys.argv[2]).write_bytes(ROWS.dump_json(rows(Path(sys.argv[1])), indent=1) + b"\n")
