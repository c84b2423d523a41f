"""X logged as a diameter: seen in how far x moves at the feed that is stated."""

import numpy as np
from numpy.typing import NDArray

from autodb.records.tables import CutTable, Recording
from autodb.sensing.ranges.faults.check import DataCheck
from autodb.wording import localized, msgid, phrase

Array = NDArray[np.float64]

TOLERANCE = 0.15
"""Relative difference to two up to which a ratio is two."""
STANDS = 0.1
"""Share of the feed below which a slide stands."""
REMEDY = msgid("set diameter = true under [recording] in the side file")


def x_travels(recording: Recording, cut: slice) -> list[DataCheck]:
    """Return whether x moves as far as the side file's feed and depth say, in a recording of cuts.

    In facing the slope of x.position (or x.velocity) is f n/60; between passes of turning,
    x.position steps by the depth. Twice that is a diameter. ``cut``: the samples in the cut.
    """
    side = recording.side.cut
    checks = []
    feed_mm_s = _feed_mm_s(recording, cut)
    if feed_mm_s is None:
        return []
    if side.operation == "face":
        slope = _slope_mm_s(recording, "x", cut)
        if slope is not None:
            checks.append(_check("x moves", abs(slope) / feed_mm_s, phrase("the feed")))
    if side.operation == "turn" and side.depth_mm is not None:
        steps = pass_steps_mm(recording, feed_mm_s)
        if steps.size:
            ratio = float(np.median(steps)) / side.depth_mm
            checks.append(
                _check(phrase("x.position steps between passes"), ratio, phrase("the depth"))
            )
    return checks


def x_over_diameter(table: CutTable) -> list[DataCheck]:
    """Return whether x.position of a table of turned cuts changes by half the work's diameter."""
    x_mm, diameter_mm = table.get("x.position"), table.get("work.diameter")
    if x_mm is None or diameter_mm is None:
        return []
    turned = np.array([o == "turn" for o in table.texts.get("operation", [""] * len(table))])
    rows = turned & np.isfinite(x_mm) & np.isfinite(diameter_mm)
    if rows.sum() < 3 or np.ptp(diameter_mm[rows]) == 0:
        return []
    x_mm, radius_mm = x_mm[rows] - x_mm[rows].mean(), 0.5 * diameter_mm[rows]
    slope = float(
        x_mm @ (radius_mm - radius_mm.mean()) / np.sum((radius_mm - radius_mm.mean()) ** 2)
    )
    return [_check(phrase("x.position changes"), slope, phrase("half of work.diameter"))]


def _check(what: str, ratio: float, of: str) -> DataCheck:
    """Return the check that a ratio is not two."""
    return DataCheck(
        name=what,
        statistic=abs(ratio / 2.0 - 1.0),
        operator=">",
        threshold=TOLERANCE,
        sentence=phrase(
            "{what} by {ratio} times {of}, as if X were logged as a diameter; {remedy}",
            what=what,
            ratio=localized(f"{ratio:.3g}"),
            of=of,
            remedy=phrase(REMEDY),
        ),
    )


def _feed_mm_s(recording: Recording, cut: slice) -> float | None:
    """Return the feed of the cut along its path, mm/s, as the side file or the spindle says it."""
    side = recording.side.cut
    speed = recording.get("spindle.speed")
    rpm = side.speed_rpm if speed is None else float(np.median(speed[cut]))
    return None if side.feed_mm_rev is None or not rpm else side.feed_mm_rev * rpm / 60.0


def _slope_mm_s(recording: Recording, axis: str, cut: slice) -> float | None:
    """Return the mean velocity of a slide in the cut, mm/s."""
    position, velocity = recording.get(f"{axis}.position"), recording.get(f"{axis}.velocity")
    if position is not None:
        t_s = recording.t_s[cut]
        return float((position[cut][-1] - position[cut][0]) / (t_s[-1] - t_s[0]))
    return None if velocity is None else float(np.mean(velocity[cut]))


def pass_steps_mm(recording: Recording, feed_mm_s: float) -> Array:
    """Return by how much x stands further in from one pass of turning to the next, (k,), mm.

    A pass is 0.3 s or more in which z feeds and x stands. Empty where there is only one.
    """
    x_mm, z_mm = recording.get("x.position"), recording.get("z.position")
    if x_mm is None or z_mm is None:
        return np.zeros(0)
    step = max(1, round(0.1 * recording.rate_hz))
    t_s, x_mm, z_mm = recording.t_s[::step], x_mm[::step], z_mm[::step]
    x_mm_s, z_mm_s = np.diff(x_mm) / np.diff(t_s), np.diff(z_mm) / np.diff(t_s)
    feeds = (np.abs(np.abs(z_mm_s) / feed_mm_s - 1.0) < STANDS) & (
        np.abs(x_mm_s) < STANDS * feed_mm_s
    )
    edges = np.flatnonzero(np.diff(np.concatenate(([0], feeds.astype(int), [0]))))
    levels = [
        float(np.median(x_mm[start:end]))
        for start, end in zip(edges[::2], edges[1::2], strict=True)
        if end - start >= 3
    ]
    steps = np.abs(np.diff(levels))
    moved: Array = steps[steps > 0]
    return moved
