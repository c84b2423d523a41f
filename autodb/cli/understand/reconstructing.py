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
    Json,
    Resample,
    SelfContained,
    check_page,
    default_machine,
    opened_store,
    say,
    say_json,
    show,
    table,
    working,
)
from autodb.cli._reader import headed, in_english, shown_again
from autodb.cli.understand.identifying import Axis
from autodb.cli.understand.over_time import moves_of, read_over_time, say_time, term_names
from autodb.wording import localized, phrase, shop_amount

if TYPE_CHECKING:
    from collections.abc import Callable

    from autodb.agent.sense.reconstructing import ReconstructedLoad, Scale
    from autodb.records import tables
    from autodb.store import Store

    Step = Callable[[str], None]


class ChosenEstimator(StrEnum):
    """What reconstructs a force."""

    DRIVE = "drive"
    LSTM = "lstm"
    TABLE = "table"
    FUSED = "fused"


DRIVE_HZ = 10.0
"""Frequency up to which drive models estimate loads unless another is asked for."""

Recording = Annotated[
    Path, typer.Argument(readable=False, help="A recording over time with position and effort.")
]
By = Annotated[
    ChosenEstimator,
    typer.Option(
        "--estimator",
        help="What the forces are sensed with: drive models, a network, a table dynamometer, or "
        "all of them put together.",
    ),
]
Owner = Annotated[
    str | None, typer.Option("--machine", help="Machine whose newest models of its axes are used.")
]
Moves = Annotated[
    Path | None,
    typer.Option(
        "--moves",
        readable=False,
        help="Recording of moves in air to identify the axis from.",
    ),
]
Terms = Annotated[
    str | None,
    typer.Option("--terms", metavar="TERM,TERM…", help="Terms to fit to --moves."),
]
Bandwidth = Annotated[
    float | None,
    typer.Option(
        "--bandwidth",
        metavar="HZ",
        min=0.1,
        help="Frequency up to which [default: 10; of a table dynamometer a fifth of the rate].",
    ),
]
Removed = Annotated[
    float | None,
    typer.Option(
        "--removed",
        metavar="KG",
        min=0.0,
        help="Mass that chips took from a table dynamometer since it was tared, evenly as it cuts.",
    ),
]
Observer = Annotated[
    bool,
    typer.Option("--observer", help="As a disturbance observer: nothing that comes later is used."),
]
PerAmpere = Annotated[
    float | None,
    typer.Option(
        "--newtons-per-ampere", metavar="N", min=1e-6, help="Force constant; ± 5 % is assumed."
    ),
]
Out = Annotated[
    Path | None,
    typer.Option("--out", metavar="FILE", help="CSV to write [default: ./RECORDING-load.csv]."),
]
Page = Annotated[
    Path | None, typer.Option("--page", metavar="FILE", help="Write a page with the loads, too.")
]


def reconstruct_command(
    recording: Recording,
    estimator: By = ChosenEstimator.DRIVE,
    machine: Owner = None,
    moves: Moves = None,
    terms: Terms = None,
    axis: Axis = None,
    bandwidth: Bandwidth = None,
    observer: Observer = False,
    newtons_per_ampere: PerAmpere = None,
    removed: Removed = None,
    columns: Columns = None,
    group: Group = None,
    resample: Resample = None,
    out: Out = None,
    page: Page = None,
    self_contained: SelfContained = False,
    json: Json = False,
    db: Database = None,
) -> None:
    """Reconstruct the load on each axis: its drive's effort less friction, inertia and weight.

    Or the forces that a machine's network, its table dynamometer, or all of them together measure.
    """
    from autodb.files.targets import check_target
    from autodb.reports.load_page import render_loads, write_table
    from autodb.reports.written import write_page

    if machine is None and moves is None:
        machine = default_machine(db)
    _check(
        _Given(estimator, machine, moves, terms, removed),
        of_drives=axis is not None or observer or newtons_per_ampere is not None,
    )
    out = out or Path(f"{recording.stem}-load.csv")
    check_target(out, suffix=".csv", option="--out")
    check_page(page, option="--page", self_contained=self_contained)
    how = _How(axis, bandwidth, observer, _scale(newtons_per_ampere), removed or 0.0)
    with working(f"reconstructing {recording.name}") as progress:
        if moves is not None:
            cut = moves_of(recording, axis, columns, group, resample)
            progress(f"identifying from {moves.name}")
            air = moves_of(moves, axis, columns, group, resample)
            with in_english():  # as its file and programs have it
                made = _Sensed([_by_moves(cut, air, term_names(terms), how)])
        else:
            cut = _cut_of(recording, axis, columns, group, resample)
            with in_english(), opened_store(db) as store:
                made = TELLERS[estimator](store, str(machine), cut, how, progress)
        progress(f"writing {out.name}")
        write_table(cut.t_s, made.sensed, out)
        if page is not None:
            made_page = render_loads(recording.name, cut.t_s, made.sensed)
            write_page(page, made_page, self_contained=self_contained)
    _say(cut, made, out, page, json=json)


def _say(
    cut: "tables.Recording", made: "_Sensed", out: Path, page: Path | None, *, json: bool
) -> None:
    """Print what was estimated, and where it is."""
    if json:
        say_json({"load": out, "page": page, "axes": _sizes(made), "not_used": made.not_heard})
        return
    say_time(cut)
    _show(made.sensed)
    for sentence in made.not_heard:
        say(phrase("not used: {why}", why=shown_again(sentence)))
    say(phrase("load: {out}", out=out))
    if page is not None:
        say(phrase("page: {page}", page=page))


def _cut_of(
    path: Path, axis: str | None, columns: Path | None, group: str | None, resample: float | None
) -> "tables.Recording":
    """Read a recording of one axis or several, refused where a channel cannot be what it claims."""
    from autodb.records.plausible import refuse_doubtful
    from autodb.records.summary import summary_of

    found = read_over_time(path, columns, group, resample)
    refuse_doubtful(path, summary_of(found, axis=axis), found.side)
    return found


@dataclass(frozen=True)
class _Given:
    """Options that exclude each other."""

    estimator: ChosenEstimator
    machine: str | None
    moves: Path | None
    terms: str | None
    removed: float | None


def _check(given: _Given, *, of_drives: bool) -> None:
    """Raise UnusableInput for options that do not go together."""
    from autodb.errors import UnusableInput

    if (given.machine is None) == (given.moves is None):
        raise UnusableInput(
            phrase("give either --machine NAME or --moves FILE: what moving an axis takes")
        )
    if given.estimator is not ChosenEstimator.DRIVE and given.machine is None:
        raise UnusableInput(
            phrase(
                "--estimator {estimator} goes with --machine: it is a machine's own",
                estimator=given.estimator,
            )
        )
    if given.estimator is not ChosenEstimator.DRIVE and of_drives:
        raise UnusableInput(
            phrase(
                "--axis, --observer and --newtons-per-ampere go with --estimator drive; the "
                "others estimate all forces"
            )
        )
    if given.removed is not None and given.estimator is not ChosenEstimator.TABLE:
        raise UnusableInput(phrase("--removed goes with --estimator table"))
    if given.terms is not None and given.moves is None:
        raise UnusableInput(phrase("--terms goes with --moves: a machine's model has its own"))


@dataclass(frozen=True)
class _How:
    """What was asked for."""

    axis: str | None
    bandwidth_hz: float | None
    observer: bool
    scale: "Scale | None"
    removed_kg: float


@dataclass(frozen=True)
class _Sensed:
    """The forces that sensors estimated, and which sensed nothing and why."""

    sensed: "list[ReconstructedLoad]"
    not_heard: tuple[str, ...] = ()


def _by_drives(
    store: "Store", machine: str, cut: "tables.Recording", how: _How, progress: "Step"
) -> _Sensed:
    from autodb.agent.sense.reconstructing import reconstruct_on_machine

    sensed = reconstruct_on_machine(
        store, machine, cut, axis=how.axis, bandwidth_hz=how.bandwidth_hz or DRIVE_HZ,
        observer=how.observer, scale=how.scale, progress=progress,
    )  # fmt: skip
    return _Sensed(sensed)


def _by_network(
    store: "Store", machine: str, cut: "tables.Recording", _how: _How, progress: "Step"
) -> _Sensed:
    from autodb.agent.sense.networks import forces_on_machine

    return _Sensed(forces_on_machine(store, machine, cut, progress=progress))


def _by_table(
    store: "Store", machine: str, cut: "tables.Recording", how: _How, _progress: "Step"
) -> _Sensed:
    from autodb.agent.sense.dynamometers import forces_on_table

    sensed = forces_on_table(
        store, machine, cut, bandwidth_hz=how.bandwidth_hz, removed_kg=how.removed_kg
    )
    return _Sensed(sensed)


def _by_all(
    store: "Store", machine: str, cut: "tables.Recording", how: _How, progress: "Step"
) -> _Sensed:
    from autodb.agent.sense.fusing import fused_on_machine

    made = fused_on_machine(store, machine, cut, bandwidth_hz=how.bandwidth_hz, progress=progress)
    return _Sensed(made.sensed, made.not_heard)


TELLERS = {
    ChosenEstimator.DRIVE: _by_drives,
    ChosenEstimator.LSTM: _by_network,
    ChosenEstimator.TABLE: _by_table,
    ChosenEstimator.FUSED: _by_all,
}


def _by_moves(
    cut: "tables.Recording",
    air: "tables.Recording",
    terms: tuple[str, ...] | None,
    how: _How,
) -> "ReconstructedLoad":
    from autodb.agent.sense.reconstructing import reconstruct_with
    from autodb.sensing.drives import feed_axis

    model = feed_axis.identify(air, axis=how.axis, terms=terms)
    return reconstruct_with(
        model, cut, moves=air.path.name, bandwidth_hz=how.bandwidth_hz or DRIVE_HZ,
        observer=how.observer, scale=how.scale,
    )  # fmt: skip


def _scale(newtons_per_ampere: float | None) -> "Scale | None":
    from autodb.agent.sense.reconstructing import LEAST_SHARE, Scale
    from autodb.fitting.gaussian import NORMAL_95

    if newtons_per_ampere is None:
        return None
    return Scale(newtons_per_ampere, "N", LEAST_SHARE / NORMAL_95, "--newtons-per-ampere")


def _sizes(made: _Sensed) -> "list[dict[str, object]]":
    """Return what was estimated of each axis: how large it is, and with what."""
    import numpy as np

    from autodb.reports.load_page import load_rms

    return [
        {
            "axis": one.load.axis,
            "unit": one.load.unit,
            "rms": load_rms(one.load.value),
            "largest": float(np.max(np.abs(one.load.value))),
            "median_sd": float(np.median(one.load.sd)),
            "bandwidth_hz": one.load.bandwidth_hz,
            "model": str(one.model),
        }
        for one in made.sensed
    ]


def _show(sensed: "list[ReconstructedLoad]") -> None:
    import numpy as np

    from autodb.reports.load_page import MARKS, load_rms, scale_words

    marks = MARKS if any(one.said is None for one in sensed) else ()
    sizes = (phrase("rms"), phrase("largest"), phrase("median sd"))
    rows = table(
        phrase("Load"), phrase("axis"), phrase("unit"),
        *map(headed, (*sizes, *(phrase(mark.replace("_", " ")) for mark in marks))),
    )  # fmt: skip
    words: dict[str, list[str]] = {}
    for one in sensed:
        load = one.load
        factor, unit = shop_amount(1.0, load.unit)
        largest, sd = float(np.max(np.abs(load.value))), float(np.median(load.sd))
        values = (load_rms(load.value), largest, sd)
        shares = (100.0 * float(np.mean(getattr(load, mark))) for mark in marks)
        rows.add_row(
            load.axis, unit, *(localized(f"{factor * value:.4g}") for value in values),
            *(f"{localized(f'{share:.1f}')} %" for share in shares),
        )  # fmt: skip
        said = phrase(
            "{model}; up to {frequency} Hz",
            model=shown_again(one.model), frequency=localized(f"{load.bandwidth_hz:g}")
        )  # fmt: skip
        for line in (said, shown_again(scale_words(one))):
            words.setdefault(line, []).append(load.axis)
    show(rows)
    for line, axes in words.items():
        say(phrase("{axes}: {what}", axes=", ".join(axes), what=line))
