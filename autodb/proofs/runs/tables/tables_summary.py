"""What the proof on published tables found: its limits; tables are those of real axes."""

from collections.abc import Sequence
from dataclasses import dataclass

from autodb.proofs.runs.found import Check, ratio
from autodb.proofs.runs.real.real_score import JudgedReal
from autodb.proofs.runs.real.real_summary import RealSummary, at_least, at_most
from autodb.proofs.runs.run_file import Finished, Origin

NAMED, WRONG, STRONG_FALSE, SURE_RIGHT = 0.90, 0.03, 0.02, 0.90
MEDIAN_FIT = 1.1


@dataclass(frozen=True)
class TablesSummary(RealSummary):
    """The score: cases are components of tables."""

    def checks(self) -> list[Check]:
        """Return every limit: what it is, what it must be, whether it is."""
        every = self.both.cases + self.others.cases + self.nulls.cases
        fit = self.both.fit
        return [
            at_least("left out: named", self.real.named, self.real.cases, NAMED),
            at_most("left out: wrong", self.real.wrong, self.real.cases, WRONG),
            at_least("injected: named", self.injected.named, self.injected.cases, NAMED),
            at_most("injected: wrong", self.injected.wrong, self.injected.cases, WRONG),
            at_most("harmed", self.harmed, every, 0.0),
            ("held-out error / full model's, median", ratio(fit), f"≤ {MEDIAN_FIT:g}",
             fit is not None and fit <= MEDIAN_FIT),
            at_least("nulls: own laws within 30 %", self.nulls.own_ok, self.nulls.cases, 1.0),
            at_least("entries at 0.9 or more: right", self.sure_right, self.sure, SURE_RIGHT),
            at_most("injected, strong: named without it too", self.strong.false,
                    self.strong.twins, STRONG_FALSE),
        ]  # fmt: skip


def tables_summary_of(runs: Sequence[Finished[JudgedReal]], origin: Origin) -> TablesSummary:
    """Return the score of finished runs in the order of their seeds."""
    every = [one for run in runs for one in run.judged]
    return TablesSummary.of(every, origin, (runs[0].seed, runs[-1].seed))
