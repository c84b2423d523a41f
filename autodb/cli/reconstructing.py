"""`reconstruct`: the load on each axis from its drive."""

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import (
    Columns,
    Database,
    Group,
    Resample,
    opened,
    say,
    show,
    table,
    working,
)
from autodb.cli.identifying import Axis, moves_of, names_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from autodb import records
    from autodb.agent.reconstructing import Felt, Scale


class Estimator(StrEnum):
    """What reconstructs a force."""

    DRIVE = "drive"
    LSTM = "lstm"


Recording = Annotated[
    Path, typer.Argument(readable=False, help="A recording over time with position and effort.")
]
By = Annotated[
    Estimator,
    typer.Option("--estimator", help="What the load is felt with: drive models, or a network."),
]
Owner = Annotated[
    str | None, typer.Option("--machine", help="Machine whose newest models of its axes are used.")
]
Moves = Annotated[
    Path | None,
    typer.Option(
        "--moves", readable=False, help="Recording of moves in air to identify the axis from."
    ),
]
Terms = Annotated[
    str | None,
    typer.Option("--terms", metavar="TERM,TERM…", help="Terms to fit to --moves."),
]
Bandwidth = Annotated[
    float, typer.Option("--bandwidth", metavar="HZ", min=0.1, help="Frequency up to which.")
]
Observer = Annotated[
    bool,
    typer.Option("--observer", help="As a disturbance observer: nothing that comes later is used."),
]
PerAmpere = Annotated[
    float | None,
    typer.Option(
        "--newtons-per-ampere", metavar="N", min=1e-6, help="What an ampere is; ± 5 % is assumed."
    ),
]
Out = Annotated[
    Path | None,
    typer.Option("--out", metavar="FILE", help="CSV to write [default: ./RECORDING-load.csv]."),
]
Page = Annotated[
    Path | None, typer.Option("--page", metavar="FILE", help="Write a page with the loads, too.")
]


def reconstruct(
    recording: Recording,
    estimator: By = Estimator.DRIVE,
    machine: Owner = None,
    moves: Moves = None,
    terms: Terms = None,
    axis: Axis = None,
    bandwidth: Bandwidth = 10.0,
    observer: Observer = False,
    newtons_per_ampere: PerAmpere = None,
    columns: Columns = None,
    group: Group = None,
    resample: Resample = None,
    out: Out = None,
    page: Page = None,
    db: Database = None,
) -> None:
    """Reconstruct the load on each axis: its drive's effort less friction, inertia and weight."""
    from autodb.errors import UnusableInput
    from autodb.loads import render, write_table
    from autodb.store.copies import check_target, write_text

    if (machine is None) == (moves is None):
        raise UnusableInput("give either --machine NAME or --moves FILE: what moving an axis takes")
    if estimator is Estimator.LSTM:
        _check_network(machine, axis, observer=observer, newtons_per_ampere=newtons_per_ampere)
    if terms is not None and moves is None:
        raise UnusableInput("--terms goes with --moves: a machine's model has its own")
    out = out or Path(f"{recording.stem}-load.csv")
    check_target(out, suffix=".csv", option="--out")
    if page is not None:
        check_target(page, suffix=".html", option="--page")
    how = _How(axis, bandwidth, observer, _scale(newtons_per_ampere))
    with working(f"reconstructing {recording.name}") as progress:
        cut = moves_of(recording, axis, columns, group, resample)
        if estimator is Estimator.LSTM:
            felt = _by_network(cut, machine or "", db, progress)
        elif moves is not None:
            progress(f"identifying from {moves.name}")
            air = moves_of(moves, axis, columns, group, resample)
            felt = [_by_moves(cut, air, names_of(terms), how)]
        else:
            felt = _by_machine(cut, machine or "", db, how, progress)
        progress(f"writing {out.name}")
        write_table(cut.t_s, felt, out)
        if page is not None:
            write_text(page, render(recording.name, cut.t_s, felt))
    _show(felt)
    say(f"load: {out}")
    if page is not None:
        say(f"page: {page}")


def _check_network(
    machine: str | None, axis: str | None, *, observer: bool, newtons_per_ampere: float | None
) -> None:
    from autodb.errors import UnusableInput

    if machine is None:
        raise UnusableInput("--estimator lstm goes with --machine: a network is a machine's own")
    if axis is not None or observer or newtons_per_ampere is not None:
        raise UnusableInput(
            "--axis, --observer and --newtons-per-ampere go with --estimator drive: a network "
            "tells what it was trained to"
        )


def _by_network(
    cut: "records.Recording", machine: str, db: str | None, progress: "Callable[[str], None]"
) -> "list[Felt]":
    from autodb.agent.networks import forces_on_machine

    with opened(db) as store:
        return forces_on_machine(store, machine, cut, progress=progress)


@dataclass(frozen=True)
class _How:
    """What was asked for."""

    axis: str | None
    bandwidth_hz: float
    observer: bool
    scale: "Scale | None"


def _by_machine(
    cut: "records.Recording",
    machine: str,
    db: str | None,
    how: _How,
    progress: "Callable[[str], None]",
) -> "list[Felt]":
    from autodb.agent.reconstructing import reconstruct_on_machine

    with opened(db) as store:
        return reconstruct_on_machine(
            store, machine, cut, axis=how.axis, bandwidth_hz=how.bandwidth_hz,
            observer=how.observer, scale=how.scale, progress=progress,
        )  # fmt: skip


def _by_moves(
    cut: "records.Recording",
    air: "records.Recording",
    terms: tuple[str, ...] | None,
    how: _How,
) -> "Felt":
    from autodb.agent.reconstructing import reconstruct_with
    from autodb.sensing import drives

    model = drives.identify(air, axis=how.axis, terms=terms)
    return reconstruct_with(
        model, cut, moves=air.path.name, bandwidth_hz=how.bandwidth_hz, observer=how.observer,
        scale=how.scale,
    )  # fmt: skip


def _scale(newtons_per_ampere: float | None) -> "Scale | None":
    from autodb.agent.reconstructing import LEAST_SHARE, Scale
    from autodb.fitting import NORMAL_95

    if newtons_per_ampere is None:
        return None
    return Scale(newtons_per_ampere, "N", LEAST_SHARE / NORMAL_95, "--newtons-per-ampere")


def _show(felt: "list[Felt]") -> None:
    import numpy as np

    from autodb.loads import MARKS, rms, scale_words

    rows = table(
        "Load", "axis", "unit", ">rms", ">largest", ">median sd",
        *(f">{mark.replace('_', ' ')}" for mark in MARKS),
    )  # fmt: skip
    for load in (one.load for one in felt):
        sizes = (rms(load.value), float(np.max(np.abs(load.value))), float(np.median(load.sd)))
        shares = [f"{100.0 * float(np.mean(getattr(load, mark))):.1f} %" for mark in MARKS]
        rows.add_row(load.axis, load.unit, *(f"{size:.4g}" for size in sizes), *shares)
    show(rows)
    for one in felt:
        say(f"{one.load.axis}: {one.model}; up to {one.load.bandwidth_hz:g} Hz")
        say(f"{one.load.axis}: {scale_words(one)}")
