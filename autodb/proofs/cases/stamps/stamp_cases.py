"""The recording of a seed: kinds in turn, drawn moves, and the simulation that lacks a term."""

from dataclasses import dataclass

import numpy as np

from autodb.proofs.cases.stamps.axis_rows import AxisDraw, draw_known_axis
from autodb.proofs.cases.stamps.clocks import CLOCKS
from autodb.proofs.cases.stamps.dates import DATES
from autodb.proofs.cases.stamps.joined_runs import JOINED_RUNS
from autodb.proofs.cases.stamps.missing_rows import MISSING_ROWS
from autodb.proofs.cases.stamps.positions import POSITIONS
from autodb.proofs.cases.stamps.resolutions import RESOLUTIONS
from autodb.proofs.cases.stamps.stamped import StampedRows, StampKind, even_rows, seconds_texts
from autodb.proofs.cases.stamps.time_units import TIME_UNITS

STAMP_KINDS = (
    *RESOLUTIONS, *CLOCKS, *MISSING_ROWS, *TIME_UNITS, *DATES, *JOINED_RUNS, *POSITIONS
)  # fmt: skip
"""Every kind, in the order in which seeds take their turns."""
FINE_DIGITS = 9


@dataclass(frozen=True)
class StampCase:
    """A recording: its kind, the axis, what was written, and its even twin."""

    seed: int
    kind: StampKind
    axis: AxisDraw
    stamped: StampedRows

    @property
    def twin(self) -> StampedRows:
        """Return the same moves, sampled evenly and stamped so."""
        return StampedRows(even_rows(self.axis), seconds_texts(self.axis.grid_s, FINE_DIGITS))

    def recording(self, of: StampedRows) -> str:
        """Return the text of a recording's file."""
        place, effort = (
            ("a.angle", "a.current") if self.axis.rotary else ("x.position", "x.current")
        )
        columns = zip(of.stamps, of.rows.position.tolist(), of.rows.current.tolist(), strict=True)
        lines = (f"{stamp},{x:.5f},{current:.4f}" for stamp, x, current in columns)
        return "\n".join([f"t,{place},{effort}", *lines, ""])

    def simulation(self, of: StampedRows) -> str:
        """Return the text of the simulation's file: the law at every row's instant, less a term."""
        law_A = self.axis.law_A(of.rows.true_s, self.axis.left_out).tolist()
        lines = (f"{stamp},{value:.6f}" for stamp, value in zip(of.stamps, law_A, strict=True))
        return "\n".join([f"t,{'a' if self.axis.rotary else 'x'}.current", *lines, ""])


def draw_stamped(seed: int) -> StampCase:
    """Draw the recording of a seed: kind number (seed − 1), modulo how many there are."""
    kind = STAMP_KINDS[(seed - 1) % len(STAMP_KINDS)]
    return stamped_of(kind, seed)


def stamped_of(kind: StampKind, seed: int) -> StampCase:
    """Draw a recording of one kind."""
    axis = draw_known_axis(seed, kind.rates_hz, rotary=kind.rotary)
    return StampCase(seed, kind, axis, kind.write(np.random.default_rng([seed, 43]), axis))
