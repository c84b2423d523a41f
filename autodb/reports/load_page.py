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
from autodb.wording import amount_words, localized, msgid, phrase
from autodb.wording.kept import said_again

Array = NDArray[np.float64]

MARKS = ("standing", "turned", "outside", "braking", "at_limit")
MARK_WORDS = {
    "standing": msgid("standing"), "turned": msgid("turned"), "outside": msgid("outside"),
    "braking": msgid("braking"), "at_limit": msgid("at limit"),
}  # fmt: skip
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
        title=phrase("{file}: load on the axes", file=name),
        name=name,
        version=__version__,
        axes=[_shown(t_s, one) for one in sensed],
    )


def _shown(t_s: Array, sensed: ReconstructedLoad) -> dict[str, object]:
    load = sensed.load
    largest, rms = float(np.max(np.abs(load.value))), load_rms(load.value)
    sizes = ((phrase("Largest"), largest), (phrase("Root mean square"), rms))
    return {
        "name": phrase("{axis} axis", axis=load.axis.upper()),
        "plot": _plot(t_s, load),
        "model": sensed.model,
        "scale": scale_words(sensed),
        "bandwidth": amounts.quantity(load.bandwidth_hz, "Hz"),
        "figures": [(what, amounts.quantity(size, load.unit)) for what, size in sizes],
        "sure": amounts.quantity(NORMAL_95 * float(np.median(load.sd)), load.unit),
        "shares": [
            (phrase(MARK_WORDS[mark]), _percent(100.0 * float(np.mean(getattr(load, mark)))))
            for mark in MARKS
            if getattr(load, mark).any()
        ],
    }


def _percent(percent: float, form: str = ".3g") -> str:
    return f"{localized(f'{percent:{form}}')} %"


def load_rms(values: Array) -> float:
    """Return the root mean square of values (n,)."""
    return float(np.sqrt(np.mean(values**2)))


def scale_words(sensed: ReconstructedLoad) -> str:
    """Say what made newtons of amperes, and how sure that is; of no drive, what there is to say."""
    if sensed.said is not None:
        return said_again(sensed.said)
    if sensed.scale is not None:
        percent = 100.0 * NORMAL_95 * sensed.scale.share
        return phrase(
            "force constant {constant} ± {share} (95 %), by {source}; that error is common to all "
            "rows and not in their sd",
            constant=amount_words(sensed.scale.per_ampere, f"{sensed.scale.unit}/A", ".4g"),
            share=_percent(percent, ".2g"),
            source=said_again(sensed.scale.source),
        )
    if sensed.load.unit == "A":
        return phrase(
            "in amperes; for newtons, determine the force constant with 'autodb scale', state "
            "torque constant and screw pitch in the machine's file, or use --newtons-per-ampere"
        )
    return phrase("the drive's effort is in {unit}", unit=sensed.load.unit)


def _plot(t_s: Array, load: DriveLoad) -> object:
    title = figures.bracketed(phrase("Load of {axis}", axis=load.axis), load.unit)
    made = figures.figure([title], x_title=phrase("Time [s]"))
    scale = figures.plot_scale(load.unit)
    value, half = scale * load.value, scale * NORMAL_95 * load.sd
    edge = {"width": 1.0}
    ends = ((value - half, phrase("95 %, low")), (value + half, phrase("95 %, high")))
    for values, name in ends:
        made.add_trace(figures.line_trace(t_s, values, tone="simulation", name=name, line=edge))
    made.add_trace(figures.line_trace(t_s, value, tone="corrected", name=phrase("load")))
    label = phrase("load of {axis} over time with its 95 % interval", axis=load.axis)
    return figures.as_html(made, f"load-{load.axis}", height_px=PLOT_PX, label=label)
