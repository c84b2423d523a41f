"""Three real axes of whose simulation one term was left out: what explain finds, drawn.

The recordings are not part of this program; what is drawn of them is thinned.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from autodb.explain import explain
from autodb.explain.answer import Array, Cause, ChannelAnswer, ChannelTrace
from autodb.records import source as records
from autodb.records.tables import Recording
from autodb.reports.amounts import quantity, span
from autodb.reports.explanation import headline
from autodb.reports.figures import keep_peaks
from docs.make.style import CORRECTED, RECORDING, SIMULATION, drawn, legend

LINE_POINTS = 480
"""Of a line: its peaks stay, and a figure stays below 60 kB."""


@dataclass(frozen=True)
class RealPicture:
    """A figure: the case's folder in `data/real`, the term left out of it, and the part shown.

    ``what``: the axis and what was left out, in words.
    """

    name: str
    folder: str
    term: str
    what: str
    shown_s: tuple[float, float]


PICTURES = (
    RealPicture(
        "real-coulomb", "smart-x-no_coulomb-kept", "coulomb",
        "The X axis of a CNC mill, simulated without its dry friction.", (0.0, 60.0),
    ),
    RealPicture(
        "real-inertia", "laas-acc-no_inertia-kept", "inertia",
        "A motor that swings to and fro, simulated without its inertia.", (0.0, 4.0),
    ),
    RealPicture(
        "real-weight", "tiago-torso-no_gravity-kept", "gravity",
        "The vertical axis of a robot, simulated without its weight.", (0.0, 80.0),
    ),
)  # fmt: skip


def draw(cases: Path) -> None:
    """Draw the figure of every case in a folder of them."""
    for picture in PICTURES:
        _draw(picture, *explained(cases / picture.folder))


def explained(case: Path) -> tuple[ChannelAnswer, ChannelTrace]:
    """Return what explain answers to a case, told which terms its simulation has."""
    recording = records.read(case / "recording.csv")
    assert isinstance(recording, Recording)
    simulation = records.read(case / "simulation.csv", like=recording)
    includes = json.loads((case / "truth.json").read_text("utf-8"))["includes"]
    done = explain(recording, simulation, includes=includes)
    ((channel, answer),) = done.explanation.channels.items()
    return answer, done.traces[channel]


def found_words(picture: RealPicture, answer: ChannelAnswer) -> str:
    """Return the term that was left out with its size, and how sure it is; it must be named."""
    cause: Cause = next(c for c in answer.missing if c.term == picture.term)
    size = cause.parameters["size"]
    return (
        f"{cause.term}: {quantity(size.value, size.unit)} "
        f"({span(size.low, size.high, size.unit)}), {100.0 * cause.confidence:.0f} % sure"
    )


def held_out_words(answer: ChannelAnswer) -> str:
    """Return the errors on parts left out of the fit, before and after."""
    before, after = (
        quantity(one, answer.unit) for one in (answer.fit.heldout_before, answer.fit.heldout_after)
    )
    return f"Residual, A; on parts left out of the fit {before} rms before, {after} after"


def _draw(picture: RealPicture, answer: ChannelAnswer, trace: ChannelTrace) -> None:
    first, takes = headline(answer, trace).split("; ")
    part = slice(*np.searchsorted(trace.x, picture.shown_s))
    t_s, recording = trace.x[part], trace.recording[part]
    with drawn(picture.name, height_in=5.4, rows=2, share_x=True) as (above, below):
        figure = above.get_figure()
        assert figure is not None
        words = (picture.what, f"{first};", takes, found_words(picture, answer))
        figure.suptitle("\n".join(words), x=0.01, ha="left", fontsize=10)
        _line(above, t_s, recording, color=RECORDING, label="recording", lw=2.2)
        for tone, values, label in (
            (SIMULATION, trace.simulation[part], "simulation"),
            (CORRECTED, trace.corrected[part], "corrected"),
        ):
            _line(above, t_s, values, color=tone, label=label, lw=1.1)
            _line(below, t_s, recording - values, color=tone, lw=1.0)
        above.set_title(f"Current, {answer.unit}")
        legend(above)
        below.set(title=held_out_words(answer), xlabel="time, s", xlim=picture.shown_s)


def _line(axes: Axes, t_s: Array, values: Array, **style: Any) -> None:
    kept = keep_peaks(values, LINE_POINTS)
    axes.plot(t_s[kept], values[kept], **style)
