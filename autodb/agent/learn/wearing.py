"""Wear that a pair's belief holds, in words: how much, and what it is of a cut asked for."""

from collections.abc import Iterator, Sequence

import numpy as np

from autodb.files.job import JobCut
from autodb.fitting import NORMAL_95
from autodb.forward.prediction import PredictedCut, ToolOf
from autodb.pairs.engaged import BY_NAME
from autodb.pairs.forecast import worn
from autodb.pairs.posterior import WEAR, PairPosterior


def wear_words(belief: PairPosterior) -> str:
    """Return how a belief says that edges wear."""
    wear = belief.wear
    assert wear is not None
    place = belief.columns(WEAR)
    half = NORMAL_95 * np.sqrt(np.diag(belief.state.covariance)[place])
    along, across = (
        f"{value:.3g} ({value - one:.3g} to {value + one:.3g})"
        for value, one in zip(belief.state.mean[place], half, strict=True)
    )
    differ = f"edges differ by {100 * wear.between:.0f} %" if wear.between else "edges alike"
    return (
        f"{WEAR}: each mm of an edge takes {along} N more along the cutting speed and {across} N "
        f"across the edge after {wear.reference_s:.0f} s, as T^{wear.power:.2g}; {differ}"
    )


def said_of_wear(
    belief: PairPosterior, tool: ToolOf, asked: Sequence[JobCut], found: Sequence[PredictedCut]
) -> Iterator[str]:
    """Say what wear is of the forces predicted, and which cuts count as made with a fresh edge.

    ``asked``: none for the lines of a program, which state nothing of their edge.
    """
    if belief.wear is None:
        return
    fresh = [k for k, cut in enumerate(asked, start=1) if cut.cutting_time_s is None]
    if fresh or not asked:
        which = f"cut {', '.join(map(str, fresh))}" if fresh else "every line"
        yield (
            f"{which}: predicted for a fresh edge; the pair's edges wear, and cutting_time_s of a "
            "cut says how long its edge has cut before"
        )
    for number, cut in enumerate(asked, start=1):
        if cut.cutting_time_s and found[number - 1].state is None:
            name = f" '{cut.name}'" if cut.name else ""
            yield f"cut {number}{name}: {_of_cut(belief, tool, cut)}"


def _of_cut(belief: PairPosterior, tool: ToolOf, cut: JobCut) -> str:
    """Return what wear is of each force of a cut, with 95 % intervals."""
    assert belief.wear is not None
    assert cut.cutting_time_s is not None
    conditions = [cut.conditions(tool.diameter_mm)]
    added = worn(belief, BY_NAME[cut.operation].cuts(tool.numbers, conditions, called=tool.name))
    place, by = belief.columns(WEAR), added.slopes[0, :3]
    covariance = belief.state.covariance[place, place]
    half = NORMAL_95 * np.sqrt(np.einsum("qi,ij,qj->q", by, covariance, by) + added.own[0, :3])
    forces = ", ".join(
        f"force.{component} {value:.0f} N ({value - one:.0f} to {value + one:.0f})"
        for component, value, one in zip("xyz", added.mean[0, :3], half, strict=True)
    )
    longest_s = belief.wear.reference_s
    beyond = (
        f"; no edge was seen beyond {longest_s:.0f} s" if cut.cutting_time_s > longest_s else ""
    )
    return f"its edge has cut {cut.cutting_time_s:g} s before; {WEAR} is {forces} of it{beyond}"
