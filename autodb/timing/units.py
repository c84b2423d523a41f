"""Stamps in another unit than seconds: a rate, or a motion, that no logger and no axis has."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST_HZ, MOST_HZ = 0.99, 1e6
"""Rates between which a recording may be. Chosen: 2.5 Hz are on record, and no logger of drives has
more than a few hundred kHz."""
USUAL_HZ = (5.0, 2e5)
"""Rates of recordings of drives. Chosen."""
LEAST_MM_S2, MOST_MM_S2 = 0.05, 1e6
"""Highest acceleration of an axis that moves by MOVED_MM, between: a thousandth of what slow axes
do, and a hundred times what linear motors do. Chosen."""
USUAL_MM_S2 = (5.0, 2e5)
MOVED_MM = 1.0
MOST_ROWS = 20_000
"""Rows that accelerations are looked for in: of more, one in a few."""
RESOLVED = 0.25
"""Share of its way in one step by which the way of a place may change, so that the change is seen
to last over rows. Chosen."""
UNITS: tuple[tuple[str, float, str], ...] = (
    ('unit = "ms"', 1e-3, "milliseconds"),
    ('unit = "us"', 1e-6, "microseconds"),
    ("scale = 1e-7", 1e-7, "ticks of 100 ns"),
    ('unit = "ns"', 1e-9, "nanoseconds"),
    ('unit = "min"', 60.0, "minutes"),
    ('unit = "h"', 3600.0, "hours"),
    ('unit = "day"', 86400.0, "days"),
)
"""What stamps come in: what a side file states of it, how many seconds, and its name."""


def doubtful_rate(step_s: float, sharpest: float | None) -> str:
    """Return what is implausible of stamps that are taken as seconds; empty where nothing is.

    ``sharpest``: the highest acceleration of what moves (mm/s² or deg/s²); None: not known.
    """
    rate = 1.0 / step_s
    beyond = sharpest is not None and not LEAST_MM_S2 <= sharpest <= MOST_MM_S2
    fits = [unit for unit in UNITS if _fits(unit[1], rate, sharpest)]
    if LEAST_HZ <= rate <= MOST_HZ and not (beyond and fits):
        return ""
    what = f"{rate:.3g} Hz"
    if beyond:
        what += f" and {sharpest:.2g} mm/s² at the most"
    if not fits:
        return f"as seconds its steps make {what}: no recording of a drive; state its unit"
    could = [f"as {name} {rate / factor:.6g} Hz ({stated})" for stated, factor, name in fits]
    if abs(step_s - 1.0) < 1e-9:
        could.append('as a count of rows what the logger had (row_in = "*", step_s = SECONDS)')
    return (
        f'as seconds its steps make {what}, {", ".join(could)}: state which, as in "t" = '
        f'{{column = "t", {fits[0][0]}}}, under [channels] in the side file (unit = "s" if it is '
        "in seconds)"
    )


def _fits(factor: float, rate: float, sharpest: float | None) -> bool:
    usual = USUAL_HZ[0] <= rate / factor <= USUAL_HZ[1]
    if sharpest is None:
        return usual
    return usual and USUAL_MM_S2[0] <= sharpest / factor**2 <= USUAL_MM_S2[1]


def highest_acceleration(t_s: Array, place: Array) -> float | None:
    """Return how sharply a place (n,) is accelerated at the most.

    Over the shortest time in which noise is small against it. None where it stands or never slows
    down, or where speeds change from row to row: then rows are too few to say.
    """
    if len(place) < 50 or np.ptp(place) < MOVED_MM:
        return None
    stride = max(1, len(place) // MOST_ROWS)
    place, step = place[::stride], stride * float(np.median(np.diff(t_s[:MOST_ROWS])))
    bends = [np.abs(np.diff(place, 3))]
    noise = 1.4826 * float(np.median(bends[0])) / np.sqrt(20.0)
    over = 1
    while True:
        bend = np.abs(place[2 * over :] - 2.0 * place[over:-over] + place[: -2 * over])
        top = float(np.quantile(bend, 0.999))
        if top > 30.0 * noise or 8 * over > len(place):
            ways = np.abs(place[over:] - place[:-over])
            slow, way = np.quantile(ways, [0.01, 0.999])
            seen = top < RESOLVED * way and slow < RESOLVED * way
            return top / (over * step) ** 2 if seen else None
        over *= 2
