"""Forward along a program: what each of its lines will take, in the mean and at its largest."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autodb.cutting.turning import PASSIVE_AXIS
from autodb.errors import UnusableInput
from autodb.forward.prediction import (
    COLUMNS,
    Interval,
    Peaks,
    PredictedCut,
    ToolOf,
    intervals,
    not_read,
)
from autodb.pairs.engaged import BY_NAME, DEPTH, FEED, RPM, SPEED, Conditions
from autodb.pairs.forecast import Forecast, Shares, expected_means, forecast
from autodb.pairs.observed import PairCuts
from autodb.pairs.posterior import PairPosterior

Array = NDArray[np.float64]

PEAKED = 3.0
"""Largest over mean of a line from which it is spoken of. Chosen."""
QUANTITIES = 4
"""Force x, y, z and torque: the columns of a forecast that peaks are of."""


@dataclass(frozen=True)
class ProgramLine:
    """A line of a program that cuts: its steps (n,), and the deepest moment within each.

    ``time_s`` (n,): how long each takes. ``steps``: conditions as of a cut, means over each in
    time, ``deepest``: those where the chip is largest in it; ``widest``: those at the line's
    largest diameter. ``fastest_rpm`` of the spindle along it.
    """

    name: str
    number: int
    operation: str
    time_s: Array
    steps: tuple[Conditions, ...]
    deepest: tuple[Conditions, ...]
    widest: Conditions
    fastest_rpm: float

    def ranges(self, _tool_diameter_mm: float | None = None) -> Mapping[str, tuple[float, float]]:
        """Return mean and largest depth and feed, by channel: a tool enters from depth 0."""
        return {
            channel: (
                float(np.average([row[channel] for row in self.steps], weights=self.time_s)),
                max(row[channel] for row in self.deepest),
            )
            for channel in (DEPTH, FEED)
        }


def predict_lines(
    posterior: PairPosterior, tool: ToolOf, lines: Sequence[ProgramLine], *, source: str
) -> tuple[PredictedCut, ...]:
    """Predict the lines of a program.

    Raises UnusableInput naming ``source`` and the line that the tool cannot cut.
    """
    found: dict[int, PredictedCut] = {}
    for name in dict.fromkeys(line.operation for line in lines):
        some = [line for line in lines if line.operation == name]
        means, peaks = _expected(posterior, tool, some, source)
        passive = COLUMNS.get(PASSIVE_AXIS.get(name, ""))
        known = posterior.passive.get(name)
        largest = intervals(peaks, passive=passive, known=known)
        whole = intervals(means, passive=passive, known=known)
        for at, (line, mean) in enumerate(zip(some, whole, strict=True)):
            first = QUANTITIES * at
            peak = _peaks(line, largest[first : first + QUANTITIES])
            found[line.number] = _predicted(posterior, line, mean, peak)
    return tuple(found[line.number] for line in lines)


def _expected(
    posterior: PairPosterior, tool: ToolOf, lines: Sequence[ProgramLine], source: str
) -> tuple[Forecast, Forecast]:
    """Return means of lines (n,), and steps (4 n,), where each quantity is largest in its line."""
    begins = np.cumsum([0, *(len(line.steps) for line in lines)])
    share = np.concatenate([line.time_s / line.time_s.sum() for line in lines])
    steps = _cuts(tool, lines, [row for line in lines for row in line.steps], source)
    means = forecast(posterior, steps, Shares(begins[:-1], share))

    deepest = [row for line in lines for row in line.deepest]
    size = np.abs(expected_means(posterior, _cuts(tool, lines, deepest, source)))
    largest = [
        begin + int(np.argmax(size[begin:end, quantity]))
        for begin, end in pairwise(begins.tolist())
        for quantity in range(QUANTITIES)
    ]
    at_peak = _cuts(tool, lines, [deepest[row] for row in largest], source)
    return means, forecast(posterior, at_peak)


def _cuts(
    tool: ToolOf, lines: Sequence[ProgramLine], rows: Sequence[Conditions], source: str
) -> PairCuts:
    operation = BY_NAME[lines[0].operation]
    try:
        return operation.cuts(tool.numbers, rows, called=tool.name)
    except UnusableInput as error:
        raise UnusableInput(f"{source}: line {_refused(tool, lines)}: {error}") from error


def _refused(tool: ToolOf, lines: Sequence[ProgramLine]) -> int:
    """Return the first of lines, one of which is refused, that is refused alone."""
    for line in lines[:-1]:
        try:
            BY_NAME[line.operation].cuts(
                tool.numbers, [*line.steps, *line.deepest], called=tool.name
            )
        except UnusableInput:
            return line.number
    return lines[-1].number


def _peaks(line: ProgramLine, at_peak: Sequence[Sequence[Interval]]) -> Peaks:
    x, y, z, torque = (one[k] for k, one in enumerate(at_peak))
    return Peaks(x, y, z, torque, speed_rpm=line.fastest_rpm)


def _predicted(
    posterior: PairPosterior, line: ProgramLine, means: Sequence[Interval], peaks: Peaks
) -> PredictedCut:
    return PredictedCut(
        name=line.name,
        operation=line.operation,
        speed_rpm=line.widest[RPM],
        speed_m_min=line.widest[SPEED],
        force_x_N=means[0],
        force_y_N=means[1],
        force_z_N=means[2],
        torque_N_m=means[3],
        power_W=means[4],
        peaks=peaks,
        passive=not_read(posterior, line.operation),
    )


def peaked(cuts: Sequence[PredictedCut]) -> Iterator[str]:
    """Say which lines have a torque that is far above the line's mean for a moment."""
    for number, cut in enumerate(cuts, start=1):
        if cut.peaks is None or cut.peaks.speed_rpm is None:
            continue
        times = cut.peaks.torque_N_m.value / cut.torque_N_m.value
        if times > PEAKED:
            yield (
                f"cut {number} '{cut.name}': its largest torque is {times:.1f} times its mean; "
                "the model takes the edge as square to the axis, so it meets the allowance of a "
                "shoulder all at once"
            )
