"""What networks showed on reference mills: P0's as published, and autodb's grey box beside it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autodb.proofs.runs.found import Check, CheckedScore, TextTable, percent, ratio
from autodb.proofs.runs.mill.mill_run import SCORED
from autodb.proofs.runs.mill.published_mill import MEAN_N as FOUR_MEAN_N
from autodb.proofs.runs.run_file import Finished, Origin
from autodb.proofs.runs.score import coverage_limits

FOUR, DRIVE, NETWORK = "P0's four steps", "drive model", "P0's LSTM"
GREY, FEW, FUSED = "grey box", "grey box, 20 recordings", "drive model and grey box"
BEST = "the better of both on recordings for training"
KNOWN = "truth of the sweep"
"""Every way; the last one is given all that there was when the sweep was run."""
OWN, ANOTHER = "its own", "another machine"
"""On what 95 % intervals are scored: cuts, and a machine, that the grey box did not train on."""
MEAN_N, MEDIAN_N = 50.2, 35.3
"""P0, section 3.2: RMSE of its LSTM over tests and axes."""
WITHIN, FOUR_WITHIN = 0.15, 0.25
"""Shares by which the published network's errors may differ, and those of the four steps."""
GREY_RATIO, ORACLE_RATIO, FEW_RATIO = 0.6, 1.2, 1.0
"""Times the published network's error, or the oracle's where that is larger, that the grey box may
have; and of 20 recordings, times the network's of 160."""
FUSED_RATIO, FUSED_SHARE = 1.10, 0.95
"""Times the better member's error that the fusion's may be, in what share of recordings."""
ABOVE = 1.0
"""Times the force's own power above the coherent band that may be estimated there."""


@dataclass(frozen=True)
class NetErrors:
    """RMSE of one way in one test cut, N."""

    way: str
    cut: str
    axis: str
    rmse_N: float


@dataclass(frozen=True)
class NetHeld:
    """Share of a cut's rows within its 95 % interval, whose median half width is ``width_N``.

    ``of``: on which machine or work.
    """

    way: str
    of: str
    cut: str
    axis: str
    share: float
    width_N: float


@dataclass(frozen=True)
class NetBand:
    """Mean power of what a grey box estimated above ``cutoff_hz``, and of the true force there,
    N²."""

    axis: str
    cutoff_hz: float
    estimated_N2: float
    true_N2: float


Judged = NetErrors | NetHeld | NetBand


@dataclass(frozen=True)
class WayRow:
    """One way: mean and median RMSE over cuts and axes, medians of the machines, N."""

    way: str
    mean_N: float
    median_N: float


@dataclass(frozen=True)
class HeldRow:
    """Rows within 95 % intervals of a way on something, all recordings alike; median half width.

    Rows of a recording go together: it counts as one run.
    """

    way: str
    of: str
    recordings: int
    share: float
    width_N: float


@dataclass(frozen=True)
class Networks(CheckedScore):
    """What was found: ways, coverage, the share of recordings in which the fusion is within
    FUSED_RATIO of BEST, and power above the coherent bands.
    """

    origin: Origin
    seeds: tuple[int, int]
    ways: tuple[WayRow, ...]
    held: tuple[HeldRow, ...]
    fused_within: float
    bands: tuple[NetBand, ...]

    def _of(self, way: str) -> WayRow:
        return next(row for row in self.ways if row.way == way)

    def checks(self) -> list[Check]:
        """Return what is checked, what it is, what it must be, and whether it is."""
        four, network, grey, few, fused, best, known = (
            self._of(way).mean_N for way in (FOUR, NETWORK, GREY, FEW, FUSED, BEST, KNOWN)
        )
        median = self._of(NETWORK).median_N
        limit = max(GREY_RATIO * network, ORACLE_RATIO * known)
        above = max(band.estimated_N2 / band.true_N2 for band in self.bands)
        rows = [
            ("gate: mean of the four steps", four, FOUR_MEAN_N, FOUR_WITHIN),
            ("gate: mean of P0's LSTM", network, MEAN_N, WITHIN),
            ("gate: median of P0's LSTM", median, MEDIAN_N, WITHIN),
        ]
        found = [
            (what, f"{here:.1f} N", f"{there:g} N ± {100 * by:.0f} %", abs(here / there - 1) <= by)
            for what, here, there, by in rows
        ]
        found += [
            ("mean of the grey box", f"{grey:.1f} N", f"≤ {limit:.1f} N", grey <= limit),
            (
                "mean of the grey box of 20 recordings", f"{few:.1f} N",
                f"≤ {FEW_RATIO * network:.1f} N", few <= FEW_RATIO * network,
            ),
            (
                "mean of drive model and grey box", f"{fused:.1f} N",
                f"≤ {best:.1f} N", fused <= best,
            ),
            (
                f"recordings in which that is ≤ {FUSED_RATIO:g} × the better's",
                percent(self.fused_within), f"≥ {percent(FUSED_SHARE)}",
                self.fused_within >= FUSED_SHARE,
            ),
            (
                "power estimated above the coherent band, × the force's", ratio(above),
                f"≤ {ABOVE:g}", above <= ABOVE,
            ),
        ]  # fmt: skip
        for row in self.held:
            low, high = coverage_limits(row.recordings)
            what = f"rows within 95 % intervals, {row.way}: {row.of}"
            limits = f"{percent(low)} to {percent(high)}"
            found.append((what, percent(row.share), limits, low <= row.share <= high))
        return found

    def tables(self) -> tuple[TextTable, ...]:
        """Return what must be, all ways, and how wide intervals are."""
        ways = tuple((row.way, f"{row.mean_N:.1f}", f"{row.median_N:.1f}") for row in self.ways)
        held = tuple(
            (row.way, row.of, str(row.recordings), percent(row.share), f"{row.width_N:.0f}")
            for row in self.held
        )
        return (
            self.limits("Limits"),
            TextTable(
                "RMSE over 21 tests and two axes, median of the machines",
                ("way", ">mean N", ">median N"), ways,
            ),
            TextTable(
                "95 % intervals",
                ("way", "on", ">recordings", ">rows within", ">median ± N"), held,
            ),
        )  # fmt: skip


def network_summary_of(runs: Sequence[Finished[Judged]], origin: Origin) -> Networks:
    """Return the summary of finished runs in the order of their seeds."""
    errors = [[one for one in run.judged if isinstance(one, NetErrors)] for run in runs]
    held = [one for run in runs for one in run.judged if isinstance(one, NetHeld)]
    bands = [one for run in runs for one in run.judged if isinstance(one, NetBand)]
    ways = dict.fromkeys(one.way for one in errors[0])
    rows = tuple(_way(way, errors) for way in ways)
    return Networks(
        origin=origin,
        seeds=(runs[0].seed, runs[-1].seed),
        ways=rows,
        held=_held_rows(held),
        fused_within=_fused_within(errors),
        bands=tuple(bands),
    )


def _way(way: str, every: Sequence[Sequence[NetErrors]]) -> WayRow:
    errors = [[one.rmse_N for one in machine if one.way == way] for machine in every]
    mean = float(np.median([np.mean(one) for one in errors]))
    return WayRow(way, mean, float(np.median([np.median(one) for one in errors])))


def _held_rows(held: Sequence[NetHeld]) -> tuple[HeldRow, ...]:
    kinds = dict.fromkeys((one.way, one.of) for one in held)
    found = []
    for way, of in kinds:
        some = [one for one in held if (one.way, one.of) == (way, of)]
        share = float(np.mean([one.share for one in some]))
        width = float(np.median([one.width_N for one in some]))
        found.append(HeldRow(way, of, len(some) // len(SCORED), share, width))
    return tuple(found)


def _fused_within(errors: Sequence[Sequence[NetErrors]]) -> float:
    """Return the share of cuts and axes in which the fusion is near its better member."""
    fused, best = (
        np.array([one.rmse_N for machine in errors for one in machine if one.way == way])
        for way in (FUSED, BEST)
    )
    return float(np.mean(fused <= FUSED_RATIO * best))
