"""Forward along a program: what each of its lines will take, in the mean and at its largest."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput
from autodb.forward.job_cuts import OverTime, over_time, teeth_of, turn_peaks
from autodb.forward.prediction import OBLIQUE, PredictedCut, ToolOf, not_read
from autodb.pairs.engaged import (
    BAND_HIGH,
    BAND_LOW,
    BANDS,
    BY_NAME,
    DEPTH,
    DIRECTION,
    FEED,
    RPM,
    SPEED,
    Conditions,
)
from autodb.pairs.observed import PairCuts
from autodb.pairs.posterior import PairPosterior
from autodb.wording import localized, phrase

Array = NDArray[np.float64]

TOLD_MM = 0.01
"""What a nose leaves from which on it is spoken of. Chosen."""
PEAKED = 3.0
"""Largest over mean of a line from which it is spoken of. Chosen."""


@dataclass(frozen=True)
class ProgramLine:
    """A line of a program that cuts: its steps (n,), and the deepest moment within each.

    ``time_s`` (n,): how long each takes. ``steps``: conditions as of a cut, means over each in
    time, ``extremes``: those where the chip is largest in it; ``widest``: those at the line's
    largest diameter, ``ends``: where it begins and where it ends to cut. ``fastest_rpm`` of the
    spindle along it; ``numbers``: of its own tool, None where that is the job's; ``tool``: what
    the program calls it.
    """

    name: str
    number: int
    operation: str
    time_s: Array
    steps: tuple[Conditions, ...]
    extremes: tuple[Conditions, ...]
    ends: tuple[Conditions, Conditions]
    widest: Conditions
    fastest_rpm: float
    numbers: Mapping[str, float] | None = None
    tool: str | None = None

    def ranges(self, _tool_diameter_mm: float | None = None) -> Mapping[str, tuple[float, float]]:
        """Return mean and largest depth and feed, by channel: a tool enters from depth 0."""
        return {
            channel: (
                float(np.average([row[channel] for row in self.steps], weights=self.time_s)),
                max(row[channel] for row in self.extremes),
            )
            for channel in (DEPTH, FEED)
        }


MOST_LINES = 10
"""Lines of a program that are listed one by one."""


def first_lines(numbers: Sequence[str]) -> str:
    """Return the numbers of lines as a note lists them: the first, and how many more."""
    some = ", ".join(numbers[:MOST_LINES])
    more = len(numbers) - MOST_LINES
    return phrase("{what} and {count} more", what=some, count=more) if more > 0 else some


def nose_leaves(
    lines: Sequence[ProgramLine], beside: Collection[int], nose_mm: float | None
) -> Iterator[str]:
    """Say what a nose leaves on cones and arcs that no G41 or G42 compensates.

    A nose of radius r that goes with its imaginary tip on a line at the angle θ to the axis leaves
    r (|sin θ| + |cos θ| - 1) more than the program says. ``beside``: lines that are compensated.
    """
    slanted = [one for one in lines if one.operation in OBLIQUE and one.number not in beside]
    if not slanted or not nose_mm:
        return
    inward = np.radians([row[DIRECTION] for one in slanted for row in one.steps])
    most_mm = nose_mm * float(np.max(np.abs(np.sin(inward)) + np.abs(np.cos(inward)) - 1.0))
    if most_mm < TOLD_MM:
        return
    numbers = list(dict.fromkeys(f"{one.number}" for one in slanted))
    which = phrase("line {number} goes", number=numbers[0])
    if len(numbers) > 1:
        which = phrase("lines {numbers} go", numbers=first_lines(numbers))
    yield (
        phrase(
            "{which} at an angle without G41 or G42: where the program is of the tip and "
            "not of the nose's path, a nose of {nose} mm leaves up to {most} mm more, and "
            "the depth of the first pass over a cylinder is less by that",
            which=which,
            nose=localized(f"{nose_mm:g}"),
            most=localized(f"{most_mm:.2g}"),
        )
    )


def predict_lines(
    posterior: PairPosterior, tool: ToolOf, lines: Sequence[ProgramLine], *, source: str
) -> tuple[PredictedCut, ...]:
    """Predict the lines of a program.

    Raises UnusableInput naming ``source`` and the line that the tool cannot cut.
    """
    found: dict[int, PredictedCut] = {}
    for name, numbers in dict.fromkeys((one.operation, _key(one)) for one in lines):
        some = [line for line in lines if (line.operation, _key(line)) == (name, numbers)]

        def engaged(rows: Sequence[Conditions], some: Sequence[ProgramLine] = some) -> PairCuts:
            return _cuts(tool, some, rows, source)

        for line, its in zip(some, over_time(posterior, some, engaged), strict=True):
            whole = _predicted(posterior, tool, line, its)
            mills = name in BANDS
            found[id(line)] = _in_turns(whole, posterior, tool, line) if mills else whole
    return tuple(found[id(line)] for line in lines)


def _key(line: ProgramLine) -> tuple[tuple[str, float], ...]:
    return tuple((line.numbers or {}).items())


def _cuts(
    tool: ToolOf, lines: Sequence[ProgramLine], rows: Sequence[Conditions], source: str
) -> PairCuts:
    operation = BY_NAME[lines[0].operation]
    try:
        return operation.cuts(lines[0].numbers or tool.numbers, rows, called=tool.name)
    except UnusableInput as error:
        raise UnusableInput(
            phrase(
                "{source}: line {line}: {error}",
                source=source,
                line=_refused(tool, lines),
                error=error,
            )
        ) from error


def _refused(tool: ToolOf, lines: Sequence[ProgramLine]) -> int:
    """Return the first of lines, one of which is refused, that is refused alone."""
    for line in lines[:-1]:
        try:
            BY_NAME[line.operation].cuts(
                line.numbers or tool.numbers,
                [*line.steps, *line.extremes],
                called=tool.name,
            )
        except UnusableInput:
            return line.number
    return lines[-1].number


def _in_turns(
    cut: PredictedCut, posterior: PairPosterior, tool: ToolOf, line: ProgramLine
) -> PredictedCut:
    """Return a mill's line with the peaks within a turn where its chip is largest."""
    most = max(line.extremes, key=lambda row: row[DEPTH] * (row[BAND_HIGH] - row[BAND_LOW]))
    its = ToolOf(tool.name, line.numbers or tool.numbers)
    peaks = turn_peaks(posterior, its, line.operation, most)
    return replace(cut, peaks=replace(peaks, speed_rpm=line.fastest_rpm), start=None, end=None)


def _predicted(
    posterior: PairPosterior, tool: ToolOf, line: ProgramLine, its: OverTime
) -> PredictedCut:
    x, y, z, torque, power = its.mean
    feed = max(row[FEED] * row[RPM] for row in (*line.steps, *line.extremes))
    return PredictedCut(
        name=line.name,
        operation=line.operation,
        speed_rpm=line.widest[RPM],
        speed_m_min=line.widest[SPEED],
        force_x_N=x,
        force_y_N=y,
        force_z_N=z,
        torque_N_m=torque,
        power_W=power,
        peaks=replace(its.peaks, speed_rpm=line.fastest_rpm),
        passive=not_read(posterior, line.operation),
        start=its.start,
        end=its.end,
        feed_mm_min=feed * teeth_of(line.operation, line.numbers or tool.numbers),
        removal_mm3_min=its.removal_mm3_min,
        time_s=float(line.time_s.sum()),
    )


def peaked(cuts: Sequence[PredictedCut]) -> Iterator[str]:
    """Say which lines have a torque that is far above the line's mean for a moment."""
    for number, cut in enumerate(cuts, start=1):
        if cut.peaks is None or cut.peaks.speed_rpm is None:
            continue
        times = cut.peaks.torque_N_m.value / cut.torque_N_m.value
        if times > PEAKED:
            yield (
                phrase(
                    "cut {number} '{cut}': its largest torque is {times} times its mean; a "
                    "shoulder or a step is met within a short part of its way",
                    number=number,
                    cut=cut.name,
                    times=localized(f"{times:.1f}"),
                )
            )
