"""What was found of fleets: how soon a new machine predicts, and who was named.

Standard errors are over fleets; that of the ratio of cuts comes from fleets drawn again with
replacement (Efron 1979, the bootstrap).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binom

from autodb.proofs.runs.found import Check, CheckedScore, TextTable, percent
from autodb.proofs.runs.keeping.fleet_run import CAUSES, LEARNT, MACHINES, WAYS, Joined, NamedOne
from autodb.proofs.runs.run_file import Finished, Origin

Array = NDArray[np.float64]

ENOUGH = 0.1
"""Error from which on a machine predicts well enough."""
HALF = 0.5
"""Share of the cuts that it needs alone which it may need among others."""
HELD = 0.93
"""Share of forces that 95 % intervals must hold: machines, not forces, are independent."""
FALSE = 0.01
"""Chance of a fleet whose machines agree to have one named."""
WRONG = 0.05
"""Share of named causes that may be the other one."""
SHOWN = (0, 1, 2, 5, 12, 20)
AGAIN = 2000


@dataclass(frozen=True)
class FleetWay:
    """Over new machines: mean cuts needed, mean error and share held after each of LEARNT.

    A machine that does not come to stay below ENOUGH needs one cut more than were made.
    """

    way: str
    needed: float
    needed_se: float
    never: int
    errors: tuple[float, ...]
    held: tuple[float, ...]


@dataclass(frozen=True)
class OfCause:
    """Fleets by what was off: how many, named as what, and in how many another machine was."""

    truth: str
    fleets: int
    named: dict[str, int]
    others: int


@dataclass(frozen=True)
class Fleets(CheckedScore):
    """The score; ``ratio`` of cuts needed among others that have its tool, to alone."""

    origin: Origin
    seeds: tuple[int, int]
    ways: tuple[FleetWay, ...]
    ratio: float
    ratio_se: float
    causes: tuple[OfCause, ...]

    def checks(self) -> list[Check]:
        """Return what must be."""
        by_way = {one.way: one for one in self.ways}
        held = min(min(by_way[way].held) for way in WAYS[1:])
        quiet = next(one for one in self.causes if one.truth == CAUSES[0])
        most = int(binom.ppf(0.999, quiet.fleets, FALSE))
        right = sum(one.named.get(one.truth, 0) for one in self.causes)
        wrong = sum(
            count
            for one in self.causes
            for name, count in one.named.items()
            if name in CAUSES and name != one.truth
        )
        share = wrong / max(right + wrong, 1)
        return [
            ("cuts to 10 % among others, of those alone",
             f"{self.ratio:.2f} ± {self.ratio_se:.2f}", f"≤ {HALF}", self.ratio <= HALF),
            ("least share of forces held among others", percent(held), f"≥ {percent(HELD)}",
             held >= HELD),
            (f"fleets of {MACHINES} that agree with one named", str(quiet.others), f"≤ {most}",
             quiet.others <= most),
            ("causes named that are the other", percent(share), f"≤ {percent(WRONG)}",
             share <= WRONG),
        ]  # fmt: skip

    def tables(self) -> tuple[TextTable, ...]:
        """Return what must be, how soon machines predict, and who was named as what."""
        heads = tuple(f">{n} cuts" for n in SHOWN)
        rows = tuple(
            (
                one.way, f"{one.needed:.2f} ± {one.needed_se:.2f}", str(one.never),
                *(f"{percent(one.errors[k])} ({percent(one.held[k])})"
                  for k in map(LEARNT.index, SHOWN)),
            )
            for one in self.ways
        )  # fmt: skip
        kinds = (*CAUSES[1:], "either")
        named = tuple(
            (one.truth, str(one.fleets), *(str(one.named.get(kind, 0)) for kind in kinds),
             str(one.fleets - sum(one.named.values())), str(one.others))
            for one in self.causes
        )  # fmt: skip
        return (
            self.limits("A new machine, and one that is off"),
            TextTable(
                "Cuts until the error stays below 10 %; error after so many (and share held)",
                ("starts from", ">cuts needed", ">never", *heads), rows,
            ),
            TextTable(
                "What is off, and what it was named as",
                ("off", ">fleets", *(f">{kind}" for kind in kinds), ">not named",
                 ">others named"), named,
            ),
        )  # fmt: skip


def needed(errors: Sequence[float]) -> int:
    """Return after how many cuts errors stay at ENOUGH or below; where they do not, one more."""
    above = [k for k, error in enumerate(errors) if error > ENOUGH]
    if not above:
        return LEARNT[0]
    return LEARNT[above[-1] + 1] if above[-1] + 1 < len(LEARNT) else LEARNT[-1] + 1


def fleet_summary_of(runs: Sequence[Finished[Joined | NamedOne]], origin: Origin) -> Fleets:
    """Return the score of finished runs in the order of their seeds."""
    every = [one for run in runs for one in run.judged]
    joined = [one for one in every if isinstance(one, Joined)]
    by_way = {way: [one for one in joined if one.way == way] for way in WAYS}
    counts = {
        way: np.array([needed(one.errors) for one in some], dtype=np.float64)
        for way, some in by_way.items()
    }
    ratio, ratio_se = _ratio(counts[WAYS[1]], counts[WAYS[0]])
    fleets = [one for one in every if isinstance(one, NamedOne)]
    return Fleets(
        origin,
        (runs[0].seed, runs[-1].seed),
        tuple(_way(way, by_way[way], counts[way]) for way in WAYS),
        ratio,
        ratio_se,
        tuple(_of_cause(cause, fleets) for cause in CAUSES),
    )


def _way(way: str, some: Sequence[Joined], counts: Array) -> FleetWay:
    return FleetWay(
        way,
        float(np.mean(counts)),
        float(np.std(counts, ddof=1) / np.sqrt(len(counts))),
        int(np.sum(counts > LEARNT[-1])),
        *(
            tuple(np.mean([getattr(one, name) for one in some], axis=0).tolist())
            for name in ("errors", "held")
        ),
    )


def _ratio(among: Array, alone: Array) -> tuple[float, float]:
    """Return the ratio of all cuts needed, and its standard error."""
    drawn = np.random.default_rng(0).integers(len(alone), size=(AGAIN, len(alone)))
    again = among[drawn].sum(axis=1) / np.maximum(alone[drawn].sum(axis=1), 1.0)
    return float(among.sum() / max(alone.sum(), 1.0)), float(np.std(again))


def _of_cause(cause: str, fleets: Sequence[NamedOne]) -> OfCause:
    own = [one for one in fleets if one.truth == cause]
    kinds = [one.named for one in own if one.named is not None]
    return OfCause(
        cause,
        len(own),
        {kind: kinds.count(kind) for kind in dict.fromkeys(kinds)},
        sum(one.others > 0 for one in own),
    )
