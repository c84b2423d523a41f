"""What one edge makes of a part, cut after cut: a job's cuts, or the lines of its program.

Predicted at any age of the edge; of a program with many lines, those that load most.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from autodb.agent.answer.prediction_basis import PredictionBasis
from autodb.errors import UnusableInput
from autodb.files.job import Job
from autodb.forward.limits import QUANTITIES
from autodb.forward.line_parts import Followed
from autodb.forward.prediction import PredictedCut
from autodb.forward.tool_life import PartCut
from autodb.pairs.engaged import CUTTING_TIME, Conditions
from autodb.wording import phrase

Array = NDArray[np.float64]
AtAges = Callable[[Sequence[int], Array], list[list[PredictedCut]]]
"""What predicts some cuts of a part, by their places, at ages of the edge (n,), s."""

MOST_LOADED = 4
"""Cuts that are looked at closely for each force, torque and power. Chosen: those that load most
with a fresh edge, and as many with an old one."""


@dataclass(frozen=True)
class AgedPart:
    """Cuts of a part as ``once`` predicted, in their order, and ``at_ages``.

    ``part_s``: cutting time of all, None where the job does not state it; ``path_mm``: their way
    along the feed.
    """

    once: Sequence[PredictedCut]
    cut_of: Sequence[PartCut]
    part_s: float | None
    path_mm: float | None
    at_ages: AtAges

    def most_loaded(self, far_s: float) -> list[int]:
        """Return the places of cuts that may be the first to pass a limit: of few cuts, all."""
        if len(self.once) <= 2 * MOST_LOADED:
            return list(range(len(self.once)))
        old = [one[0] for one in self.at_ages(range(len(self.once)), np.array([far_s]))]
        found: set[int] = set()
        for what in QUANTITIES:
            for some in (self.once, old):
                loads = [what.of(one.peaks or one) for one in some]
                sizes = [0.0 if one is None else max(abs(one.low), abs(one.high)) for one in loads]
                found |= set(np.argsort(sizes)[-MOST_LOADED:].tolist())
        return sorted(found)


def part_of_cuts(basis: PredictionBasis, job: Job) -> AgedPart:
    """Return the part that a job's cuts make.

    At ages by the power that wear grows with as it is: lives weigh several. Raises UnusableInput
    where several cuts do not state how far they go.
    """
    once, _ = basis.predict(job.cut)
    times = [one.time_s for one in once]
    part_s = None if None in times else float(sum(one or 0.0 for one in times))
    if part_s is None and len(job.cut) > 1:
        lacking = [f"{k}" for k, one in enumerate(times, start=1) if one is None]
        raise UnusableInput(
            phrase(
                "job '{job}': state length_mm of cut {cuts}, to tell how old the edge is in each",
                job=job.name,
                cuts=", ".join(lacking),
            )
        )
    ways = [cut.path_mm for cut in job.cut]
    of_known_power = basis.of_known_power()

    def at_ages(which: Sequence[int], ages_s: Array) -> list[list[PredictedCut]]:
        rows = [
            job.cut[k].model_copy(update={"cutting_time_s": age})
            for k in which
            for age in ages_s.tolist()
        ]
        return _by_cut(of_known_power.predict(rows, aged=True)[0], len(ages_s))

    return AgedPart(
        once=once,
        cut_of=_begins(
            [cut.name for cut in job.cut],
            [one or 0.0 for one in times],
            range(1, len(job.cut) + 1),
        ),
        part_s=part_s,
        path_mm=None if None in ways else sum(one or 0.0 for one in ways),
        at_ages=at_ages,
    )


def part_of_program(basis: PredictionBasis, program: Followed, which: Sequence[int]) -> AgedPart:
    """Return the part that some lines of a program make, by their places: those of one edge."""
    from autodb.forward.along import ProgramLine, predict_lines

    known = basis.of_known_power().known
    posterior, tool = known.posterior, known.tool
    own = [program.lines[k] for k in which]

    def aged(line: ProgramLine, age_s: float) -> ProgramLine:
        def old(rows: Sequence[Conditions]) -> tuple[Mapping[str, float], ...]:
            return tuple({**row, CUTTING_TIME: age_s} for row in rows)

        first, last = old(line.ends)
        return replace(
            line, steps=old(line.steps), extremes=old(line.extremes), ends=(first, last),
            widest=old([line.widest])[0],
        )  # fmt: skip

    def at_ages(some: Sequence[int], ages_s: Array) -> list[list[PredictedCut]]:
        lines = [aged(own[k], age) for k in some for age in ages_s.tolist()]
        made = predict_lines(posterior, tool, lines, source=program.source)
        return _by_cut(basis.widened(made), len(ages_s))

    once = [one[0] for one in at_ages(range(len(own)), np.zeros(1))]
    times = [float(line.time_s.sum()) for line in own]
    names = [line.name for line in own]
    numbers = [k + 1 for k in which]
    return AgedPart(once, _begins(names, times, numbers), sum(times), None, at_ages)


def _by_cut(made: Sequence[PredictedCut], count: int) -> list[list[PredictedCut]]:
    return [list(made[at : at + count]) for at in range(0, len(made), count)]


def _begins(names: Sequence[str], times: Sequence[float], numbers: Sequence[int]) -> list[PartCut]:
    before = accumulate(times, initial=0.0)
    return [PartCut(*one) for one in zip(numbers, names, before, strict=False)]
