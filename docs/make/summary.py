"""The summary: of each job the figures that say most, met or missed, from the page of all."""

from collections.abc import Sequence
from pathlib import Path

from autodb.proofs.runs.found import TextTable, piped
from docs.make import field, standing
from docs.make.standing import MISSING, between, unbroken
from docs.make.standing_rows import Figure

PAGE = Path(__file__).parent.parent / "summary.md"
TABLE = ("<!-- results -->\n", "<!-- end of results -->\n")
COUNT = ("<!-- counts -->\n", "<!-- end of counts -->\n")
HEADS = ("what", ">figure", ">asked", "", "best rival, same data", ">oracle", "repeat")
CHOSEN = (
    "Force on X of a lathe, median error",
    "Force on Z of a lathe, median error",
    "Force in a mill's cuts by the grey box, mean RMSE",
    "Current of steady motion, median error over Coulomb friction",
    "95 % intervals of all quantities of an axis that hold",
    "Current of a contour on another day, y, off by",
    "95 % intervals of the next cut's forces that hold",
    "95 % intervals of the passive force in turning that hold",
    "Cutting force after five cuts of a pair, median error",
    "Intervals outside the range of the cuts that hold",
    "Clear cases that can be decided, named exactly",
    "Something named where nothing is missing",
    "Corrected simulations within 10 % or 1.5 × the oracle's error",
    "Real axes: what is missing is named",
    "Forces of a shop's weeks that intervals hold, predicted before the cuts come in",
    "The cutting force of those weeks, error (rms) after five files",
    "Refreshes that ended in other rows after a kill",
)
"""Of every job what it is for, and its worst miss."""


class NoSuchFigure(Exception):  # noqa: N818 - says what happened
    """The summary asks for a figure that the page of all figures has not."""


def filled(page: str) -> str:
    """Return the page with its counts and its table between their comments."""
    return between(between(page, COUNT, counts()), TABLE, results(CHOSEN))


def results(chosen: Sequence[str]) -> str:
    """Return the table of figures by what they are; raises NoSuchFigure naming one not there."""
    known = {one.what: one for one in standing.figures()}
    absent = [what for what in chosen if what not in known]
    if absent:
        raise NoSuchFigure(f"no figure '{absent[0]}' on {standing.PAGE.name}")
    return piped(TextTable("", HEADS, tuple(_row(known[what]) for what in chosen)))


def _row(one: Figure) -> tuple[str, ...]:
    what, _, asked, verdict, rival, oracle, source = standing.cells(one)
    return (
        what,
        unbroken(f"{one.said}<br>n = {one.cases_or_runs}"),
        asked,
        verdict,
        "–" if rival == MISSING[0] else rival,
        "–" if oracle == MISSING[1] else oracle,
        source.split("<br>")[0],
    )


def counts() -> str:
    """Return how many limits are met, and how often a rival is ahead."""
    found = standing.figures()
    missed = sum(one.missed for one in found)
    rivals = [field.won(one)[0] for contest in field.contests() for one in contest.rivals]
    behind = sum(winner not in (field.OURS, field.EVEN) for winner in rivals)
    return (
        f"Of {len(found)} limits {len(found) - missed} are met and {missed} missed "
        f"([all figures](where-it-stands.md)); of {len(rivals)} comparisons with other methods a "
        f"rival wins {behind} ([the field](peers.md)).\n"
    )
