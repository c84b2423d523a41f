"""Figure of a virtual shop's weeks: cutting forces over their predictions, and what was named.

The shop is a development one, of no proof. What was predicted takes minutes to find out: it is kept
beside this file (`python -m docs.make.weeks` goes through the weeks again) and drawn from there.
"""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from pydantic import TypeAdapter

from autodb.proofs.machines.lathe.weeks import BATCHES, IN_BATCH, PAIRS, Weeks, draw_weeks
from autodb.proofs.runs.weeks.weeks_events import Named
from autodb.proofs.runs.weeks.weeks_run import Foreseen, run_weeks
from docs.make.style import CORRECTED, INK, MUTED, RECORDING, SHADE, WARN, drawn, legend

SEED = 101
COMPONENT = "y"
KEPT = Path(__file__).parent / "weeks-walk.json"
WALK: TypeAdapter[tuple[list[Foreseen], list[Named]]] = TypeAdapter(
    tuple[list[Foreseen], list[Named]]
)
OF_A_PAIR = IN_BATCH // len(PAIRS)
"""Cuts of a pair in a file."""
SHADED = ("built-up edge", "hard batch")
SAYS = {
    "edge change": "unrecorded edge", "built-up edge": "built-up edge",
    "hard batch": "harder bar", "calibration": "drive drifts", "wear": "wear",
}  # fmt: skip


def walk() -> None:
    """Go through the weeks and keep what was predicted and named."""
    found = run_weeks(SEED)
    foreseen = [
        replace(
            one, made=round(one.made, 1), value=round(one.value, 1), low=round(one.low, 1),
            high=round(one.high, 1), peers=None,
        )
        for one in found if isinstance(one, Foreseen) and one.component == COMPONENT
    ]  # fmt: skip
    named = [one for one in found if isinstance(one, Named)]
    KEPT.write_bytes(WALK.dump_json((foreseen, named)) + b"\n")


def draw() -> None:
    """Draw a panel for each pair, and below them what happened and when it was named."""
    weeks, (foreseen, named) = draw_weeks(SEED), WALK.validate_json(KEPT.read_bytes())
    with drawn("weeks", height_in=7.2, rows=len(PAIRS) + 1, share_x=True) as (*pairs, below):
        for place, axes in enumerate(pairs):
            _pair(axes, [one for one in foreseen if one.pair == place], weeks, place)
        pairs[0].legend(loc="lower left", ncols=3)
        _events(below, named)
        below.set(xlim=(0.5, BATCHES + 0.5), xlabel="file of cuts", xticks=range(1, BATCHES + 1))


def _pair(axes: Axes, cuts: list[Foreseen], weeks: Weeks, pair: int) -> None:
    """Draw made over predicted, the interval around 1, and where the edge was changed."""
    x = np.array([_place(one.batch, k % OF_A_PAIR) for k, one in enumerate(cuts)])
    made, low, high = (
        np.array([getattr(one, name) / one.value for one in cuts])
        for name in ("made", "low", "high")
    )
    later = np.array([one.batch > 1 for one in cuts])
    held = (made >= low) & (made <= high)
    strange = np.array([one.condition in SHADED for one in cuts])
    axes.fill_between(x[later], low[later], high[later], color=SHADE, alpha=0.5, lw=0, step="mid")
    for usual, style in ((~strange, "."), (strange, "^")):
        axes.plot(x[later & held & usual], made[later & held & usual], style, color=RECORDING, ms=4)
        axes.plot(x[later & ~held & usual], made[later & ~held & usual], style, color=WARN, ms=4.5)
    axes.plot([], [], ".", color=RECORDING, label="inside")
    axes.plot([], [], ".", color=WARN, label="outside")
    axes.plot([], [], "^", color=MUTED, label="built-up edge or harder bar")
    for at in _changes(weeks, pair):
        axes.axvline(at, color=MUTED, lw=0.7, dashes=(3, 3))
    axes.set(title=f"{PAIRS[pair]}: cutting force, made over predicted", ylim=(0.6, 1.5))


def _place(batch: int, cut: int) -> float:
    return batch - 0.5 + (cut + 0.5) / OF_A_PAIR


def _changes(weeks: Weeks, pair: int) -> list[float]:
    """Return where a pair's edge was changed, written down or not."""
    true = [
        (_place(number, k), cut.true.tool_edge)
        for number, batch in enumerate(weeks.batches, start=1)
        for k, cut in enumerate(one for one in batch.cuts if one.pair == pair)
    ]
    return [at - 0.5 / OF_A_PAIR for (_, before), (at, now) in pairwise(true) if now != before]


def _events(axes: Axes, named: list[Named]) -> None:
    """Draw a line for each event from the file in which it began to that in which it was named."""
    events = [one for one in named if one.event]
    for row, one in enumerate(events):
        ends = BATCHES if one.batch is None else one.batch
        axes.plot([one.first, ends], [-row, -row], color=CORRECTED, lw=2.4, alpha=0.5)
        axes.plot(one.first, -row, "|", color=INK, ms=9, mew=1.6)
        if one.batch is not None:
            axes.plot(one.batch, -row, "o", color=WARN, ms=4.5)
    axes.plot([], [], "|", color=INK, ms=9, mew=1.6, label="began")
    axes.plot([], [], "o", color=WARN, ms=4.5, label="named")
    axes.set_yticks([-row for row in range(len(events))], [SAYS[one.event] for one in events])
    axes.set(title="What happened", ylim=(0.7 - len(events), 0.6))
    axes.grid(visible=False)
    legend(axes)


if __name__ == "__main__":
    walk()
    draw()
