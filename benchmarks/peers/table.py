"""`python -m benchmarks.peers.table FILE`: what the methods made of the cases, as tables."""

import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from autodb.proofs.runs.found import TextTable, piped, ratio
from benchmarks.peers.run import CASES, METHODS, OURS, kept
from benchmarks.peers.score import RECOVERED, Score

LABELS = {
    OURS: "`explain`",
    "sindy_expert": "STLSQ, expert dictionary",
    "sindy_poly": "STLSQ, cubic polynomials",
    "boosting": "boosted trees",
    "gaussian": "Gaussian process",
    "gplearning": "genetic programming",
    "gpelite": "genetic programming",
    "adcd_search": "corrections",
    "frols_expert": "FROLS, expert dictionary",
    "frols_poly": "FROLS, cubic polynomials",
}
WORDLESS = frozenset({"sindy_poly", "frols_poly", "boosting", "gaussian"})
"""Methods that name nothing, by construction."""
HEADS = (
    "method", ">cases", ">exact set", ">decidable: exact set", ">a wrong name",
    f">error left ≤ {RECOVERED:g}", ">median error left", ">least error left",
    ">false alarms", ">pieces", ">s", ">time-outs", ">failures",
)  # fmt: skip


def tables(
    scores: Sequence[Score], methods: Sequence[str] = METHODS
) -> tuple[TextTable, TextTable]:
    """Return a row a method, and the error left case by case."""
    by_method = {name: [one for one in scores if one.method == name] for name in methods}
    best = least(scores)
    rows = tuple(_row(name, found, best) for name, found in by_method.items())
    return TextTable("All cases", HEADS, rows), _cases(scores, best, methods)


def least(scores: Sequence[Score]) -> dict[int, float]:
    """Return the least error that any method leaves, by seed of a case with something hidden."""
    found: dict[int, float] = {}
    for one in scores:
        if one.hidden and one.left is not None:
            found[one.seed] = min(one.left, found.get(one.seed, one.left))
    return found


def _row(method: str, scores: Sequence[Score], best: dict[int, float]) -> tuple[str, ...]:
    hidden = [one for one in scores if one.hidden]
    nothing = [one for one in scores if not one.hidden]
    left = [one.left for one in hidden if one.left is not None]
    words = method not in WORDLESS
    return (
        label(method, scores),
        str(len(scores)),
        _count(hidden, lambda one: one.exact) if words else "names nothing",
        _count([one for one in hidden if one.decidable], lambda one: one.exact) if words else "",
        _count(hidden, lambda one: one.wrong) if words else "",
        _count(hidden, lambda one: one.recovered),
        ratio(float(np.median(left))) if left else "",
        _count(hidden, lambda one: one.left == best.get(one.seed)),
        _count(nothing, lambda one: one.alarm),
        f"{np.median([one.written for one in hidden]):g}" if hidden and _written(method) else "",
        f"{np.median([one.seconds for one in scores]):.0f}" if scores else "",
        str(sum(one.failed == "time" for one in scores)),
        str(sum(one.failed not in ("", "time") for one in scores)),
    )


def label(method: str, scores: Sequence[Score]) -> str:
    """Return package, version and what it is; without an answer only the latter."""
    version = next((one.version for one in scores if one.version), "")
    return f"{version} {LABELS[method]}" if version else LABELS[method]


def _written(method: str) -> bool:
    return method not in WORDLESS or method.startswith(("sindy", "frols"))


def _count(scores: Sequence[Score], holds: Callable[[Score], bool]) -> str:
    """Return how many of how many."""
    if not scores:
        return ""
    count = sum(holds(one) for one in scores)
    return f"{count} of {len(scores)}"


def _cases(scores: Sequence[Score], best: dict[int, float], methods: Sequence[str]) -> TextTable:
    """A row a case with something hidden: the error left by each method."""
    found = {(one.seed, one.method): one for one in scores}
    hidden = {one.seed: one for one in scores if one.hidden}
    rows = tuple(
        (
            str(seed),
            f"{'cuts' if one.table else 'axis'}: {one.kind}",
            "yes" if one.decidable else "no",
            *(_cell(found.get((seed, method)), best) for method in methods),
        )
        for seed, one in sorted(hidden.items())
    )
    heads = (">seed", "hidden", "decidable", *(f">{_short(method)}" for method in methods))
    title = "Error left, case by case; bold: the least; ✓: the set is named exactly"
    return TextTable(title, heads, rows)


def _short(method: str) -> str:
    return "autodb" if method == OURS else method


def _cell(score: Score | None, best: dict[int, float]) -> str:
    if score is None:
        return "not run"
    if score.failed:
        return "time" if score.failed == "time" else "failed"
    left = ratio(score.left)
    text = f"**{left}**" if score.left == best.get(score.seed) else left
    return f"{text}{' ✓' if score.exact else ''}"


def line(scores: Sequence[Score]) -> str:
    """Return what the scores came from, in one line; raises SystemExit where they do not agree."""
    origins = {one.origin for one in scores}
    if len(origins) != 1:
        sys.exit(f"the lines are of {len(origins)} versions; one file for each would work")
    (origin,) = origins
    asked = {one.seed for one in scores}
    missing = len(asked) * len(METHODS) - len(scores)
    return (
        f"{len(asked)} of the first {CASES} fixed cases, {len(METHODS)} methods"
        f"{f', {missing} answers not run yet' if missing else ''}; autodb {origin.version}, "
        f"generator {origin.generator}, product {origin.product}"
    )


def markdown(scores: Sequence[Score]) -> str:
    """Return the line of origin and the tables as a page has them."""
    whole = [f"**{table.title}**\n\n{piped(table)}" for table in tables(scores)]
    return "\n".join([f"{line(scores)}\n", *whole])


if __name__ == "__main__":
    print(markdown(kept(Path(sys.argv[1]))))
