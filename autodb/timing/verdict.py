"""The verdict on a recording's stamps: what they are, what was done, and what that costs."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from autodb.timing.layout import Layout
from autodb.wording import listed, localized, phrase, stored_msgid

Array = NDArray[np.float64]
ROUNDING = 1e-9
"""Share by which steps of numbers of 64 bits differ, that are one."""
SHOWN = 3
"""Pieces whose times the verdict gives one by one."""
EVEN = stored_msgid("even, {rate}")
PIECES = stored_msgid("{rate}, {count} pieces of even rows")


@dataclass(frozen=True)
class StampFinding:
    """One thing that stamps are beside even: its ``kind`` (docs/formats.md), and the sentence.

    ``rows``: how many rows it concerns.
    """

    kind: str
    sentence: str
    rows: int


@dataclass(frozen=True)
class Timing:
    """What a recording's time is.

    ``step_s``: the step of its even rows · ``pieces``: its runs of even rows, in time · ``rows``:
    how many the file has · ``findings``: what its stamps are beside even, empty where they are ·
    ``layout``: how the file's rows became even ones; None where they are as they came ·
    ``blur_s``: standard deviation of what stamps may still be wrong by, s.
    """

    step_s: float
    pieces: tuple[slice, ...]
    rows: int
    findings: tuple[StampFinding, ...] = ()
    layout: Layout | None = None
    blur_s: float = 0.0

    @property
    def rate_hz(self) -> float:
        """Rows per second within a piece."""
        return 1.0 / self.step_s

    @cached_property
    def measured(self) -> NDArray[np.bool_] | None:
        """Whether each even row (n,) was measured; None where all were."""
        measured = None if self.layout is None else self.layout.measured
        return None if measured is None or measured.all() else measured

    @cached_property
    def placed(self) -> NDArray[np.bool_] | None:
        """Whether each even row (n,) was measured with a place that is not within a dead band.

        None where all were. Motor and load are apart there as by play.
        """
        placed = None if self.layout is None else self.layout.placed
        return None if placed is None or placed.all() else placed

    def at(self, rows: NDArray[np.intp]) -> "Timing":
        """Return what the time of some of its rows is, all of which were measured."""
        piece = np.searchsorted([one.start for one in self.pieces], rows, side="right")
        parted = np.flatnonzero((np.diff(rows) != 1) | (np.diff(piece) != 0)) + 1
        ends = [0, *parted.tolist(), len(rows)]
        pieces = tuple(slice(first, last) for first, last in pairwise(ends))
        return replace(self, pieces=pieces, rows=len(rows), layout=None)

    def known_within(self, reach_s: float) -> NDArray[np.bool_] | None:
        """Whether a filter that reaches so far sees nothing but what was measured, (n,); None:
        everywhere.

        Rows that are missing here and there lie between two that were measured: only they are left
        out. Rows that were not written since nothing changed may last, and so what is derived from
        them is unknown as far as a filter reaches.
        """
        from scipy.ndimage import minimum_filter1d

        if "on change" not in self.kinds or self.placed is None:
            return self.measured
        size = 2 * round(reach_s * self.rate_hz) + 1
        near = minimum_filter1d(self.placed.astype(np.uint8), size, mode="nearest")
        return np.asarray(near, dtype=np.bool_)

    @property
    def is_even(self) -> bool:
        """Whether the file's stamps were even as they came."""
        return not self.findings

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of the findings; `even` where there is none."""
        return tuple(dict.fromkeys(finding.kind for finding in self.findings)) or ("even",)

    def __str__(self) -> str:
        """Return one line for a person."""
        rate = f"{self.rate_hz:.6g} Hz"
        if self.is_even:
            return EVEN.format(rate=rate)
        said = "; ".join(finding.sentence for finding in self.findings)
        count = len(self.pieces)
        parts = rate if count == 1 else PIECES.format(rate=rate, count=count)
        return f"{said}; {parts}"

    def parted(self, t_s: Array) -> str:
        """Say where the pieces of a recording lie, whose time (n,) this is, in s."""
        ends = ((t_s[p.start], t_s[p.stop - 1]) for p in self.pieces[:SHOWN])
        shown = listed(
            phrase("{low} to {high} s", low=localized(f"{a:.6g}"), high=localized(f"{b:.6g}"))
            for a, b in ends
        )
        more = len(self.pieces) - SHOWN
        return phrase("{what} and {count} more", what=shown, count=more) if more > 0 else shown


def even(t_s: Array) -> Timing:
    """Return the verdict on stamps (n,) that are even as they came."""
    middle, mean = float(np.median(np.diff(t_s))), float(t_s[-1] - t_s[0]) / (len(t_s) - 1)
    step_s = middle if abs(middle - mean) <= ROUNDING * mean else mean
    return Timing(step_s, (slice(0, len(t_s)),), len(t_s))


def merged(findings: Sequence[StampFinding]) -> tuple[StampFinding, ...]:
    """Return findings with each sentence once, in the order in which they came."""
    rows: dict[tuple[str, str], int] = {}
    for one in findings:
        key = one.kind, one.sentence
        rows[key] = rows.get(key, 0) + one.rows
    return tuple(StampFinding(kind, sentence, count) for (kind, sentence), count in rows.items())
