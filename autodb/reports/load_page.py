"""Writes reconstructed loads: a table at every row, and a page that shows them."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pyarrow import csv

from autodb import __version__
from autodb.agent.sense.reconstructing import ReconstructedLoad
from autodb.files.channels import LINEAR_AXES
from autodb.files.targets import hidden, replace_by
from autodb.fitting.gaussian import NORMAL_95
from autodb.reports import amounts, figures
from autodb.sensing.drives.reconstruct import DriveLoad

Array = NDArray[np.float64]

MARKS = ("standing", "turned", "outside", "braking", "at_limit")
PLOT_PX = 420


def write_table(t_s: Array, sensed: Sequence[ReconstructedLoad], path: Path) -> None:
    """Write t, and of each axis load, sd, state and force on the tool, as CSV; whole or not at all.

    Of sensors that were put together also by what weight each made a row; of a table dynamometer
    the envelopes of the force over a turn of the spindle.

    ``t_s`` (n,). An earlier file of that name is replaced.
    """
    columns: dict[str, object] = {"t": t_s}
    for one in sensed:
        load = one.load
        columns[f"{load.axis}.load"] = load.value
        columns[f"{load.axis}.load.sd"] = load.sd
        columns[f"{load.axis}.state"] = _states(load)
        if load.unit == "N" and load.axis in LINEAR_AXES:
            columns[f"force.{load.axis}"] = -load.value
        if one.envelope_N is not None:
            columns[f"force.{load.axis}.lower"], columns[f"force.{load.axis}.upper"] = (
                one.envelope_N
            )
        for name, weight in one.weight.items():
            columns[f"{load.axis}.weight.{name.replace(' ', '_')}"] = weight
    with hidden(path) as part:
        csv.write_csv(pa.table(columns), part)
        replace_by(part, path)


def _states(load: DriveLoad) -> list[str]:
    """Return the marks of each row, blank between them; 'at limit' is written 'at_limit'."""
    words = [np.where(getattr(load, mark), f"{mark} ", "") for mark in MARKS]
    whole = words[0]
    for word in words[1:]:
        whole = np.char.add(whole, word)
    return [str(text).strip() for text in whole]


def render_loads(name: str, t_s: Array, sensed: Sequence[ReconstructedLoad]) -> str:
    """Return the page: a page that loads nothing from outside."""
    return figures.whole_page(
        "loads.html.j2",
        title=f"{name}: load on the axes",
        name=name,
        version=__version__,
        axes=[_shown(t_s, one) for one in sensed],
    )


def _shown(t_s: Array, sensed: ReconstructedLoad) -> dict[str, object]:
    load = sensed.load
    sizes = (("Largest", np.max(np.abs(load.value))), ("Root mean square", load_rms(load.value)))
    return {
        "name": f"{load.axis.upper()} axis",
        "plot": _plot(t_s, load),
        "model": sensed.model,
        "scale": scale_words(sensed),
        "bandwidth": amounts.quantity(load.bandwidth_hz, "Hz"),
        "figures": [(what, amounts.quantity(float(size), load.unit)) for what, size in sizes],
        "sure": amounts.quantity(NORMAL_95 * float(np.median(load.sd)), load.unit),
        "shares": [
            (mark.replace("_", " "), f"{100.0 * float(np.mean(getattr(load, mark))):.3g} %")
            for mark in MARKS
            if getattr(load, mark).any()
        ],
    }


def load_rms(values: Array) -> float:
    """Return the root mean square of values (n,)."""
    return float(np.sqrt(np.mean(values**2)))


def scale_words(sensed: ReconstructedLoad) -> str:
    """Say what made newtons of amperes, and how sure that is; of no drive, what there is to say."""
    if sensed.said is not None:
        return sensed.said
    if sensed.scale is not None:
        percent = 100.0 * NORMAL_95 * sensed.scale.share
        return (
            f"force constant {sensed.scale.per_ampere:.4g} {sensed.scale.unit}/A ± {percent:.2g} % "
            f"(95 %), by {sensed.scale.source}; that error is common to all rows and not in their "
            "sd"
        )
    if sensed.load.unit == "A":
        return (
            "in amperes; for newtons, determine the force constant with 'autodb scale', state "
            "torque constant and screw pitch in the machine's file, or use --newtons-per-ampere"
        )
    return f"the drive's effort is in {sensed.load.unit}"


def _plot(t_s: Array, load: DriveLoad) -> object:
    made = figures.figure([f"Load of {load.axis} [{load.unit}]"], x_title="Time [s]")
    half = NORMAL_95 * load.sd
    edge = {"width": 1.0}
    for values, name in ((load.value - half, "95 %, low"), (load.value + half, "95 %, high")):
        made.add_trace(figures.line_trace(t_s, values, tone="simulation", name=name, line=edge))
    made.add_trace(figures.line_trace(t_s, load.value, tone="corrected", name="load"))
    label = f"load of {load.axis} over time with its 95 % interval"
    return figures.as_html(made, f"load-{load.axis}", height_px=PLOT_PX, label=label)
