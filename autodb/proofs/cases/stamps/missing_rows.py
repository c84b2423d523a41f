"""Rows that are lost, written twice, written on change only, or not in order; stamps are honest."""

import numpy as np
from numpy.typing import NDArray

from autodb.proofs.cases.base.moves import log_uniform
from autodb.proofs.cases.stamps.axis_rows import AxisDraw, SampledRows
from autodb.proofs.cases.stamps.programme import Array
from autodb.proofs.cases.stamps.stamped import (
    Rng,
    StampedRows,
    StampKind,
    even_rows,
    seconds_texts,
)

Rows = NDArray[np.intp]
GAP_S = (0.3, 3.0)
LOST = (0.001, 0.05)
BAND = (0.005, 0.05)
"""Dead band of a position, mm. Chosen: a reported change that still shows slow moves."""
BAND_A = (0.05, 0.2)


def _kept(draw: AxisDraw, keep: NDArray[np.bool_], drawn: dict[str, float]) -> StampedRows:
    rows = even_rows(draw).picked(keep)
    return StampedRows(rows, seconds_texts(rows.true_s), "", drawn)


def _ordered(draw: AxisDraw, order: Rows, drawn: dict[str, float]) -> StampedRows:
    rows = even_rows(draw).picked(order)
    return StampedRows(rows, seconds_texts(rows.true_s), "", drawn)


def _without(draw: AxisDraw, starts_s: Array, lengths_s: Array) -> NDArray[np.bool_]:
    keep = np.ones(len(draw.grid_s), dtype=np.bool_)
    for start_s, length_s in zip(starts_s, lengths_s, strict=True):
        keep &= (draw.grid_s < start_s) | (draw.grid_s >= start_s + length_s)
    return keep


def _gap(rng: Rng, draw: AxisDraw) -> StampedRows:
    length_s = rng.uniform(*GAP_S, 1)
    start_s = rng.uniform(0.1, 0.8, 1) * draw.programme.seconds
    return _kept(draw, _without(draw, start_s, length_s), {"gap": float(length_s[0])})


def _gaps(rng: Rng, draw: AxisDraw) -> StampedRows:
    count = int(rng.integers(3, 7))
    starts_s = (np.arange(count) + rng.uniform(0.2, 0.7, count)) / count * draw.programme.seconds
    keep = _without(draw, starts_s, rng.uniform(0.3, 1.0, count))
    return _kept(draw, keep, {"gaps": count})


def _lost(rng: Rng, draw: AxisDraw) -> StampedRows:
    share = log_uniform(rng, *LOST)
    keep = rng.random(len(draw.grid_s)) >= share
    keep[0] = True
    return _kept(draw, keep, {"share": share})


def _bursts(rng: Rng, draw: AxisDraw) -> StampedRows:
    count = int(rng.integers(10, 40))
    starts_s = rng.uniform(0.02, 0.95, count) * draw.programme.seconds
    keep = _without(draw, starts_s, rng.integers(3, 30, count) / draw.rate_hz)
    return _kept(draw, keep, {"bursts": count})


def _doubled(rng: Rng, draw: AxisDraw) -> StampedRows:
    share = log_uniform(rng, *LOST)
    times = 1 + (rng.random(len(draw.grid_s)) < share)
    times[len(times) // 2] = 2
    return _ordered(draw, np.repeat(np.arange(len(times)), times), {"share": share})


def _block_doubled(rng: Rng, draw: AxisDraw) -> StampedRows:
    first, count = _block(rng, draw)
    order = np.arange(len(draw.grid_s))
    return _ordered(draw, np.insert(order, first + count, order[first : first + count]),
                    {"rows": count})  # fmt: skip


def _block(rng: Rng, draw: AxisDraw) -> tuple[int, int]:
    count = int(rng.integers(20, 200))
    return int(rng.uniform(0.2, 0.7) * len(draw.grid_s)), count


def _stamp_doubled(rng: Rng, draw: AxisDraw) -> StampedRows:
    return _stamps_doubled(draw, rng.integers(100, len(draw.grid_s) - 100, 1))


def _some_stamps_doubled(rng: Rng, draw: AxisDraw) -> StampedRows:
    count = max(int(log_uniform(rng, *LOST) * len(draw.grid_s)), 2)
    return _stamps_doubled(draw, rng.integers(100, len(draw.grid_s) - 100, count))


def _stamps_doubled(draw: AxisDraw, where: NDArray[np.int64]) -> StampedRows:
    """Rows ``where`` bear the stamp of the row before them."""
    t_s = draw.grid_s.copy()
    t_s[where] = draw.grid_s[where - 1]
    return StampedRows(even_rows(draw), seconds_texts(t_s), "", {"stamps": len(where)})


def _swapped(rng: Rng, draw: AxisDraw) -> StampedRows:
    count, order = int(rng.integers(1, 30)), np.arange(len(draw.grid_s))
    for first in 2 * rng.choice(len(order) // 2 - 1, count, replace=False):
        order[[first, first + 1]] = order[[first + 1, first]]
    return _ordered(draw, order, {"pairs": count})


def _moved(rng: Rng, draw: AxisDraw) -> StampedRows:
    first, count = _block(rng, draw)
    order, later = np.arange(len(draw.grid_s)), int(rng.integers(count, 3 * count))
    block = order[first : first + count]
    rest = np.delete(order, block)
    return _ordered(draw, np.insert(rest, first + later, block), {"rows": count})


def _backwards(rng: Rng, draw: AxisDraw) -> StampedRows:
    del rng
    return _ordered(draw, np.arange(len(draw.grid_s))[::-1], {})


def _reports(values: Array, band: float) -> NDArray[np.bool_]:
    """Say for each value whether it is reported: it differs by ``band`` from the last that was."""
    said = np.zeros(len(values), dtype=np.bool_)
    last = np.inf
    for row, value in enumerate(values.tolist()):
        if abs(value - last) >= band:
            said[row], last = True, value
    return said


def _on_change(rng: Rng, draw: AxisDraw) -> StampedRows:
    band = log_uniform(rng, *BAND)
    return _kept(draw, _reports(even_rows(draw).position, band), {"band": band})


def _on_change_of_both(rng: Rng, draw: AxisDraw) -> StampedRows:
    """A row is written when either channel changes; both values of it are of that moment."""
    band, rows = log_uniform(rng, *BAND), even_rows(draw)
    keep = _reports(rows.position, band) | _reports(rows.current, log_uniform(rng, *BAND_A))
    return _kept(draw, keep, {"band": band})


def _held(rng: Rng, draw: AxisDraw) -> StampedRows:
    """A row is written when either channel changes; the other's last reported value is held."""
    band, rows = log_uniform(rng, *BAND), even_rows(draw)
    moved = _reports(rows.position, band)
    drawn = _reports(rows.current, log_uniform(rng, *BAND_A))
    held = _with_held(rows, _last(moved), _last(drawn)).picked(moved | drawn)
    return StampedRows(held, seconds_texts(held.true_s), "", {"band": band})


def _polled(rng: Rng, draw: AxisDraw) -> StampedRows:
    """Every row is written; the position is fetched every few rows, and held."""
    every = int(rng.integers(2, 11))
    row = np.arange(len(draw.grid_s))
    held = _with_held(even_rows(draw), row - row % every, row)
    return StampedRows(held, seconds_texts(held.true_s), "", {"every": every})


def _last(said: NDArray[np.bool_]) -> Rows:
    """Return for each row the last one that was reported; the first one always is."""
    return np.maximum.accumulate(np.where(said, np.arange(len(said)), 0))


def _with_held(rows: SampledRows, position: Rows, current: Rows) -> SampledRows:
    return SampledRows(
        rows.true_s, rows.position[position], rows.current[current],
        rows.position_s[position], rows.current_s[current],
    )  # fmt: skip


MISSING_ROWS = (
    StampKind("one gap", "0.3 to 3 s of rows are missing; stamps are honest.",
              "shared/failures/logs/gap.csv.", _gap),
    StampKind("several gaps", "Three to six gaps of 0.3 to 1 s.",
              "A buffer that overruns; LinuxCNC's halsampler says 'overrun'.", _gaps),
    StampKind("rows lost", "0.1 to 5 % of the rows are lost, here and there.",
              "UDP, CAN buses under load.", _lost),
    StampKind("bursts lost", "Ten to forty bursts of three to thirty rows are lost.",
              "A FIFO that fills while a disk is busy.", _bursts),
    StampKind("rows doubled", "0.1 to 5 % of the rows stand twice.",
              "Retries of a sender, exports that overlap.", _doubled),
    StampKind("block doubled", "A block of rows stands twice, one behind the other.",
              "A buffer that is sent again.", _block_doubled),
    StampKind("stamp doubled", "One row bears the stamp of the row before it.",
              "A tick that was missed.", _stamp_doubled),
    StampKind("stamps doubled", "0.1 to 5 % of the rows bear the stamp of the row before.",
              "Two rows fetched at once.", _some_stamps_doubled),
    StampKind("neighbours swapped", "Up to thirty pairs of neighbours are swapped.",
              "UDP keeps no order.", _swapped),
    StampKind("block moved", "A block of rows stands later in the file, with its own stamps.",
              "Several writers of one file.", _moved),
    StampKind("backwards", "The last row comes first.",
              "Exports of historians list the newest first.", _backwards),
    StampKind("on change of position", "A row is written where the position has moved by a band.",
              "OPC UA monitored items with a dead band (OPC 10000-4, 7.22.2).", _on_change),
    StampKind("on change of either", "A row is written where position or current has changed.",
              "MTConnect samples, CAN event frames.", _on_change_of_both),
    StampKind("on change, held", "As before, and the other channel's last reported value is held.",
              "Historians that join tags by their last value.", _held),
    StampKind("position polled", "The position is fetched every two to ten rows, and held.",
              "A slower bus beside a fast current.", _polled),
)  # fmt: skip
