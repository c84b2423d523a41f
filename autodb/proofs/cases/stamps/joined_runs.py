"""Two runs in one file, rates that change, and stamps that are missing or no numbers."""

import numpy as np

from autodb.proofs.cases.base.moves import log_uniform
from autodb.proofs.cases.stamps.axis_rows import AxisDraw
from autodb.proofs.cases.stamps.programme import Array
from autodb.proofs.cases.stamps.stamped import (
    Rng,
    StampedRows,
    StampKind,
    Write,
    even_rows,
    seconds_texts,
)

LATER_S = (5.0, 60.0)
SLOW_HZ = (400.0, 500.0, 800.0, 1000.0)
BLANKS = (0.001, 0.02)


def _two_runs(starts: str, *, divided: int = 1) -> Write:
    """Return what writes a run and the same moves again; ``divided``: the second's rate."""

    def write(rng: Rng, draw: AxisDraw) -> StampedRows:
        first, second_s = even_rows(draw), draw.grid_s[::divided]
        gap_s = float(rng.uniform(*LATER_S)) if starts == "later" else 1.0 / draw.rate_hz
        shift_s = 0.0 if starts == "at 0" else draw.grid_s[-1] + gap_s
        rows = first.then(draw.rows(second_s, run=1))
        stamps = seconds_texts(np.concatenate([draw.grid_s, second_s + shift_s]))
        return StampedRows(rows, stamps, "", {"second after": shift_s})

    return write


def _rate_changes(rng: Rng, draw: AxisDraw) -> StampedRows:
    from_s, divided = rng.uniform(0.3, 0.7) * draw.programme.seconds, int(rng.integers(2, 6))
    row = np.arange(len(draw.grid_s))
    true_s: Array = draw.grid_s[(draw.grid_s < from_s) | (row % divided == 0)]
    return StampedRows(draw.rows(true_s), seconds_texts(true_s), "", {"divided": divided})


def _replaced(text: str, *, once: bool = False) -> Write:
    """Return what writes a text in place of some stamps, or of one."""

    def write(rng: Rng, draw: AxisDraw) -> StampedRows:
        stamps = seconds_texts(draw.grid_s)
        count = 1 if once else max(int(log_uniform(rng, *BLANKS) * len(stamps)), 1)
        for row in rng.choice(np.arange(50, len(stamps) - 50), count, replace=False):
            stamps[row] = text
        return StampedRows(even_rows(draw), stamps, "", {"rows": count})

    return write


def _constant(rng: Rng, draw: AxisDraw) -> StampedRows:
    text = seconds_texts(rng.uniform(0.0, 2000.0, 1))[0]
    return StampedRows(even_rows(draw), [text] * len(draw.grid_s))


JOINED_RUNS = (
    StampKind("second run at 0", "Two runs in one file: the second one's stamps begin again at 0.",
              "Loggers that append.", _two_runs("at 0")),
    StampKind("second run later", "Two runs in one file: the second one begins 5 to 60 s later.",
              "shared/failures/logs/restart2.tdms.", _two_runs("later")),
    StampKind("second run at once", "Two runs in one file, stamped through; the axis jumps back.",
              "Files put together by hand.", _two_runs("at once")),
    StampKind("second run slower", "The second run begins later and has half the rate.",
              "A logger whose settings were changed.", _two_runs("later", divided=2),
              rates_hz=SLOW_HZ),
    StampKind("second run slower, at 0", "The second run has half the rate and begins at 0.",
              "A logger whose settings were changed.", _two_runs("at 0", divided=2),
              rates_hz=SLOW_HZ),
    StampKind("rate changes", "From a moment on every second to fifth row is written.",
              "Loggers that save space.", _rate_changes, rates_hz=(800.0, 1000.0, 1600.0, 2000.0)),
    StampKind("empty stamps", "Some rows have no stamp.", "Merged tables.", _replaced("")),
    StampKind("NaN stamps", "The stamp of some rows is NaN.", "pandas, MATLAB.", _replaced("NaN")),
    StampKind("text in one", "One stamp is a word.", "halsampler of LinuxCNC writes 'overrun'.",
              _replaced("overrun", once=True)),
    StampKind("constant", "All rows bear the same stamp.", "A clock that does not run.",
              _constant),
)  # fmt: skip
