"""A recording's stamps examined, and its rows laid out on even steps."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput, behind_name
from autodb.timing.clock import EVEN
from autodb.timing.layout import LaidPiece, Layout
from autodb.timing.pieces import COARSER, SHORTEST_ROWS, SHORTEST_S, Run, laid_pieces, run_of
from autodb.timing.places import PLACES, leaping
from autodb.timing.rates import runs_of_one_rate
from autodb.timing.runs import Ordered, in_order
from autodb.timing.verdict import StampFinding, Timing, even, merged
from autodb.wording import localized, phrase, stored_msgid

Array = NDArray[np.float64]

NEARLY = 0.02
"""The same as EVEN for recordings that are too short to be laid out: of a number of seconds since
1970 in 64 bits the last digit is 0.2 µs. Chosen."""
FEWEST_STAMPS = 0.9
"""Share of rows that must bear a stamp. Chosen."""
OTHER_RATE = stored_msgid("{count} rows at {rate} left out")
TOO_SHORT = stored_msgid("{count} rows in too short pieces left out")
SET_EVEN = stored_msgid("stamps set on even steps")


@dataclass(frozen=True)
class _Recorded:
    """What a recording holds beside its stamps; ``where``: what messages begin with."""

    channels: Mapping[str, Array]
    where: str

    @property
    def places(self) -> list[str]:
        """The names of the channels that say where an axis is, on every row."""
        names = [name for name in self.channels if name.endswith(PLACES)]
        return [name for name in names if np.isfinite(self.channels[name]).all()]

    @property
    def leaps(self) -> bool:
        """Whether a place leaps as no axis moves."""
        return any(leaping(self.channels[name]).size > 0 for name in self.places)


def examined(t_s: Array, channels: Mapping[str, Array], *, where: str) -> Timing:
    """Say what the stamps of a recording are, and how its rows lie on even steps.

    ``t_s`` (n,): stamps as written, s, NaN where there is none; ``channels`` (n,) each, NaN where
    a channel has no number. ``where``: what messages begin with.

    Raises UnusableInput where no even rows can be made of them, in one line.
    """
    recorded = _Recorded(channels, where)
    if is_even(t_s) and not recorded.leaps:
        return even(t_s)
    if len(t_s) < SHORTEST_ROWS:
        if is_even(t_s, within=NEARLY):
            return even(t_s)
        raise UnusableInput(behind_name(where, _first_uneven(t_s)))
    lost = ~np.isfinite(t_s)
    if np.mean(lost) > 1.0 - FEWEST_STAMPS:
        raise UnusableInput(
            phrase(
                "{where}: t, row {row}: no finite number ({count} such rows); record a time "
                "on every row",
                where=where,
                row=int(np.argmax(lost)) + 1,
                count=int(lost.sum()),
            )
        )
    places = [channels[name] for name in recorded.places]
    ordered = in_order(t_s, list(channels.values()), places)
    runs = _runs(ordered, recorded)
    if not runs:
        raise UnusableInput(
            phrase("{where}: column 't' stands still; record a time on every row", where=where)
        )
    return _laid_out(runs, ordered, recorded, len(t_s))


def is_even(t_s: Array, *, within: float = EVEN) -> bool:
    """Say whether stamps (n,) are even: off a straight line by less than this share of a step."""
    if len(t_s) < 2 or not np.isfinite(t_s[0]) or not t_s[-1] > t_s[0]:
        return False
    step = (t_s[-1] - t_s[0]) / (len(t_s) - 1)
    off = np.arange(float(len(t_s)))
    off *= -step
    off += t_s
    off -= t_s[0]
    np.abs(off, out=off)
    return bool(off.max() <= within * step)  # NaN is no even stamp


def _first_uneven(t_s: Array) -> str:
    """Say where the stamps of a recording that is too short to be laid out are not even."""
    lost = np.flatnonzero(~np.isfinite(t_s))
    if lost.size:
        return phrase("t, row {row}: no finite number; record a time on every row", row=lost[0] + 1)
    steps = np.diff(t_s)
    back = np.flatnonzero(steps <= 0)
    row = int(back[0] if back.size else np.argmax(np.abs(steps - np.median(steps)))) + 1
    return phrase(
        "column 't', row {row}: {steps} s after the row before; record even steps, or "
        "at least {shortest_rows} rows",
        row=row + 1,
        steps=localized(f"{steps[row - 1]:.6g}"),
        shortest_rows=SHORTEST_ROWS,
    )


def _runs(ordered: Ordered, recorded: _Recorded) -> list[Run]:
    """Return the runs of one clock and one rate each, in time.

    Raises UnusableInput where it cannot be told when the rows of one were taken.
    """
    runs = []
    for begin, end in pairwise((*ordered.starts, len(ordered.rows))):
        for part in runs_of_one_rate(ordered.t_s[begin:end]):
            rows = slice(begin + part.start, begin + part.stop)
            run = run_of(ordered.rows[rows], ordered.t_s[rows], recorded.channels, recorded.places)
            if run is not None and run.clock.unfit:
                raise UnusableInput(
                    phrase(
                        "{where}: column 't': {unfit}; record a time on every row, in full",
                        where=recorded.where,
                        unfit=run.clock.unfit,
                    )
                )
            if run is not None:
                runs.append(run)
    return runs


def _laid_out(runs: Sequence[Run], ordered: Ordered, recorded: _Recorded, rows: int) -> Timing:
    """Return the verdict on a file of so many rows, with its pieces of even rows.

    The step is that of most rows.
    """
    step_s = max(runs, key=lambda run: len(run.rows)).numbered.step_s
    findings, parts = list(ordered.findings), list[LaidPiece]()
    for run in runs:
        findings += run.findings
        if run.numbered.step_s > COARSER * step_s:
            sentence = OTHER_RATE.format(
                count=len(run.rows), rate=f"{1.0 / run.numbered.step_s:.6g} Hz"
            )
            findings.append(StampFinding("other rate", sentence, len(run.rows)))
            continue
        pieces, done = laid_pieces(run, step_s, recorded.channels, recorded.places)
        parts += pieces
        findings += done
    kept, short = _long_enough(parts, findings, step_s, recorded.where)
    if short:
        findings.append(StampFinding("short", TOO_SHORT.format(count=short), short))
    if not findings:
        findings.append(StampFinding("rounded", SET_EVEN, rows))
    ends = np.cumsum([0, *(len(part.t_s) for part in kept)])
    return Timing(
        step_s=step_s,
        pieces=tuple(slice(int(a), int(b)) for a, b in pairwise(ends)),
        rows=rows,
        findings=merged(findings),
        layout=Layout(tuple(kept), rows),
        blur_s=max(run.clock.blur_s for run in runs),
    )


def _long_enough(
    parts: Sequence[LaidPiece], findings: Sequence[StampFinding], step_s: float, where: str
) -> tuple[list[LaidPiece], int]:
    """Return the pieces that filters can run on, and how many rows the others have.

    Raises UnusableInput where there is none.
    """
    if len(parts) == 1:
        return list(parts), 0
    shortest = max(SHORTEST_ROWS, SHORTEST_S / step_s)
    kept = [part for part in parts if len(part.t_s) >= shortest]
    if not kept:
        said = "; ".join(finding.sentence for finding in merged(findings))
        raise UnusableInput(
            phrase(
                "{where}: column 't': no run of even rows is {step} s long ({said}); record "
                "with even steps",
                where=where,
                step=localized(f"{shortest * step_s:.3g}"),
                said=said,
            )
        )
    return kept, sum(len(part.rows) for part in parts if len(part.t_s) < shortest)
