"""Search which columns a difference needs: forward steps by evidence, then backward elimination.

The difference d = recording − simulation is a sum of the simulation's own columns (re-tuned: they
may have swallowed part of what is missing), of candidate blocks of columns, and noise. Evidence of
a block of p columns, of which one was searched among K: 2·ΔlogL − p·ln n − 2·ln K.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MARGIN = 6.0
"""Evidence above which a candidate is accepted. Chosen: a further factor e³ against one."""
MAX_STEPS = 8


@dataclass(frozen=True)
class Block:
    """A candidate: columns (n, p) on the working rows.

    ``key`` is unique; ``term`` its name in the vocabulary or `unknown`; ``tries`` how many places
    were searched for it; ``extra_parameters`` those that the search itself has fixed.
    """

    key: str
    term: str
    columns: Array
    variables: tuple[str, ...]
    tries: int = 1
    extra_parameters: int = 0

    @property
    def parameters(self) -> int:
        """Number of parameters that the block costs."""
        return int(self.columns.shape[1]) + self.extra_parameters


class Gram:
    """Inner products of all columns and the difference: every fit is then a small linear solve."""

    def __init__(self, own: Array, blocks: list[Block], difference: Array) -> None:
        matrix = np.column_stack([own, *(b.columns for b in blocks), difference])
        norm = np.linalg.norm(matrix, axis=0)
        norm[norm == 0] = 1.0
        scaled = matrix / norm
        self.products = scaled.T @ scaled
        self.rows = len(difference)
        self.total = float(norm[-1] ** 2)
        edges = np.cumsum([own.shape[1], *(b.columns.shape[1] for b in blocks)])
        self.own = list(range(own.shape[1]))
        self.of = {b.key: list(range(edges[i], edges[i + 1])) for i, b in enumerate(blocks)}

    def rss(self, columns: list[int]) -> float:
        """Return the residual sum of squares of the difference on these columns."""
        if not columns:
            return self.total
        inner = self.products[np.ix_(columns, columns)]
        right = self.products[columns, -1]
        values, vectors = np.linalg.eigh(inner)
        keep = values > 1e-10 * values[-1]
        part = vectors[:, keep].T @ right
        return self.total * max(1e-15, 1.0 - float(part @ (part / values[keep])))

    def columns(self, keys: list[str]) -> list[int]:
        """Return the own columns and those of the blocks ``keys``."""
        return [*self.own, *(i for key in keys for i in self.of[key])]


def evidence(gram: Gram, active: list[str], block: Block, candidates: int) -> float:
    """Return 2·ΔlogL − p·ln n − 2·ln(tries · candidates) of adding ``block`` to ``active``."""
    without = gram.rss(gram.columns(active))
    with_it = gram.rss(gram.columns([*active, block.key]))
    gain = gram.rows * float(np.log(without / with_it))
    return gain - _penalty(gram, block, candidates)


def _penalty(gram: Gram, block: Block, candidates: int) -> float:
    return block.parameters * float(np.log(gram.rows)) + 2.0 * float(
        np.log(block.tries * candidates)
    )


@dataclass(frozen=True)
class Step:
    """The best candidate of one step, and the evidence of all of them then."""

    best: Block
    evidence: dict[str, float]

    @property
    def accepted(self) -> bool:
        """Whether the best candidate is worth its parameters."""
        return self.evidence[self.best.key] > MARGIN


def step(gram: Gram, active: list[str], blocks: list[Block]) -> Step | None:
    """Return the best block not yet active; None when there is none."""
    open_blocks = [b for b in blocks if b.key not in active]
    if not open_blocks:
        return None
    values = {b.key: evidence(gram, active, b, len(blocks)) for b in open_blocks}
    best = max(open_blocks, key=lambda b: values[b.key])
    return Step(best, values)


def eliminate(gram: Gram, active: list[str], blocks: list[Block]) -> list[str]:
    """Drop blocks that are no longer worth their parameters, the least first.

    A named block is judged among the named ones only: an unnamed family can imitate it and would
    otherwise push the simple cause out.
    """
    kept = list(active)
    by_key = {b.key: b for b in blocks}
    while kept:
        named = [key for key in kept if by_key[key].term != "unknown"]
        worth = {
            key: evidence(
                gram,
                [k for k in (named if key in named else kept) if k != key],
                by_key[key],
                len(blocks),
            )
            for key in kept
        }
        worst = min(kept, key=lambda k: worth[k])
        if worth[worst] > MARGIN:
            break
        kept.remove(worst)
    return kept


def confidence(values: dict[str, float], key: str, *, ceiling: float = 0.99) -> float:
    """Return the probability of ``key`` among the candidates from their evidence (as −BIC/2)."""
    best = max(values.values())
    weights = {k: float(np.exp(0.5 * max(v - best, -200.0))) for k, v in values.items()}
    return min(ceiling, weights[key] / sum(weights.values()))
