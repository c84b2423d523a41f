"""Figure of a virtual day: sensed force less the stored model, corrected, with what was named when.

The day is a development one, of no proof. What was named when takes minutes to find out: it is
kept beside this file (`python -m docs.make.day` walks through the day again) and drawn from there.
"""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray
from pydantic import TypeAdapter

from autodb.explain import explain
from autodb.proofs.machines.lathe.day import FORCES, Day, Event, draw_day
from autodb.proofs.runs.keeping.day_run import DayOutcome, EventOutcome, walked
from autodb.records.tables import CutTable
from docs.make.style import CORRECTED, INK, MUTED, RECORDING, SHADE, WARN, drawn, legend

Array = NDArray[np.float64]

SEED = 101
STEP = 50
KEPT = Path(__file__).parent / "day-walk.json"
WALK: TypeAdapter[tuple[DayOutcome, tuple[tuple[float, ...], ...]]] = TypeAdapter(
    tuple[DayOutcome, tuple[tuple[float, ...], ...]]
)
"""The day as it was explained, and what the last explanation adds to the stored model, 0.1 N, (3,
n)."""
COMPONENTS = ("x (radial)", "y (cutting)", "z (feed)")
EVENTS = {
    "warm-up": "warm-up", "hard bar": "hard bar", "drifting sensor": "drift",
    **{f"wear of edge {edge}": f"wear {edge}" for edge in range(1, 5)},
}  # fmt: skip


def walk() -> None:
    """Walk through the day and keep what was found."""
    day = draw_day(SEED)
    added = np.round(_corrected(day) - day.expected, 1).tolist()
    kept = walked(day, step=STEP), tuple(tuple(row) for row in added)
    KEPT.write_bytes(WALK.dump_json(kept) + b"\n")


def _corrected(day: Day) -> Array:
    """Return the forces (3, n) that the whole day's explanation corrects the model to."""
    path, sensed = Path("day.csv"), dict(zip(FORCES, day.measured, strict=True))
    expected = {"cut": day.channels["cut"], **dict(zip(FORCES, day.expected, strict=True))}
    tables = CutTable(path, day.channels | sensed), CutTable(path, expected)
    found = explain(*tables, includes=list(day.world.parts))
    return np.stack([found.traces[name].corrected for name in FORCES])


def draw() -> None:
    """Draw the day: the three components, below them what happened and when it was named."""
    day, (outcome, added) = draw_day(SEED), WALK.validate_json(KEPT.read_bytes())
    number = day.channels["cut"]
    left = day.measured - day.expected
    with drawn("day", height_in=6.6, rows=4, share_x=True) as (*forces, below):
        rows = zip(forces, left, np.array(added), COMPONENTS, strict=True)
        for axes, sensed, of_model, name in rows:
            _changes(axes, day)
            axes.plot(number, sensed, ".", color=RECORDING, ms=2.5, label="sensed")
            axes.plot(number, of_model, color=CORRECTED, lw=1.2, label="corrected")
            axes.set(title=f"{name}, N above the stored model")
        legend(forces[0])
        _events(below, day, outcome)
        below.set(xlim=(0, number[-1] + 1), xlabel="cut")


def _changes(axes: Axes, day: Day) -> None:
    """Mark where edges were changed, and the hard bar."""
    for at in np.flatnonzero(np.diff(day.cuts.edge)) + 1:
        axes.axvline(at + 0.5, color=MUTED, lw=0.7, dashes=(3, 3))
    (hard,) = [event for event in day.events if event.term == "hard_spot"]
    axes.axvspan(hard.first - 0.5, hard.last + 0.5, color=SHADE, alpha=0.35, lw=0)


def _events(axes: Axes, day: Day, outcome: DayOutcome) -> None:
    """A line for each event: while it acts, from when it is decidable, when it was named first."""
    _changes(axes, day)
    for place, (event, one) in enumerate(zip(day.events, outcome.events, strict=True)):
        _event(axes, -place, event, one)
    axes.plot([], [], "|", color=INK, ms=9, mew=1.6, label="decidable")
    axes.plot([], [], "o", color=WARN, ms=4.5, label="named first")
    axes.set_yticks([-i for i in range(len(day.events))], [EVENTS[e.name] for e in day.events])
    axes.set(title="What happened", ylim=(0.7 - len(day.events), 0.6))
    axes.grid(visible=False)
    legend(axes)


def _event(axes: Axes, height: float, event: Event, outcome: EventOutcome) -> None:
    axes.plot([event.first, event.last], [height, height], color=CORRECTED, lw=2.4, alpha=0.5)
    if outcome.decidable is not None:
        axes.plot(outcome.decidable, height, "|", color=INK, ms=9, mew=1.6)
    if outcome.named is not None:
        axes.plot(outcome.named, height, "o", color=WARN, ms=4.5)


if __name__ == "__main__":
    walk()
    draw()
