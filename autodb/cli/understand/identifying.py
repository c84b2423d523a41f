"""`identify`: the terms of an axis from its moves."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import (
    Columns,
    Database,
    Group,
    Json,
    OptionalMachine,
    Resample,
    SelfContained,
    check_page,
    opened_store,
    say,
    say_json,
    working,
)
from autodb.cli._reader import in_english
from autodb.cli.understand.identified import show_fit, show_kept, show_masses, show_versions
from autodb.cli.understand.over_time import moves_of, term_names
from autodb.cli.understand.staging import (
    Pitch,
    Staging,
    check_staging,
    show_staged,
    try_stages,
)
from autodb.wording import phrase

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from autodb.agent.sense.identifying import KeptModel, ModelVersion
    from autodb.records import tables
    from autodb.sensing.drives.fit.axis_model import Identified
    from autodb.sensing.drives.masses import Mass
    from autodb.store import Store

    Step = Callable[[str], None]

Recording = Annotated[
    Path, typer.Argument(readable=False, help="A recording over time of the axis' moves.")
]
Axis = Annotated[str | None, typer.Option("--axis", help="Axis, where several were recorded.")]
Terms = Annotated[
    str | None,
    typer.Option(
        "--terms",
        metavar="TERM,TERM…",
        help="Terms to fit [default: those of the last version, or the symmetric four: "
        "inertia,viscous,coulomb,gravity].",
    ),
]
Also = Annotated[
    Path | None,
    typer.Option(
        "--also", readable=False, help="A second recording to test the model on; nothing is fitted."
    ),
]

Update = Annotated[
    bool,
    typer.Option("--update", help="Go on from the machine's last version, and list all versions."),
]
Page = Annotated[
    Path | None,
    typer.Option("--page", metavar="FILE", help="Write a page with maps of the effort, too."),
]


def identify_command(
    recording: Recording,
    axis: Axis = None,
    terms: Terms = None,
    also: Also = None,
    update: Update = False,
    page: Page = None,
    staged: Staging = False,
    pitch: Pitch = None,
    self_contained: SelfContained = False,
    machine: OptionalMachine = None,
    columns: Columns = None,
    group: Group = None,
    resample: Resample = None,
    json: Json = False,
    db: Database = None,
) -> None:
    """Identify inertia, friction, load and other terms of a feed axis from its moves."""
    from autodb.reports.axis import render_axis
    from autodb.reports.written import write_page
    from autodb.sensing.drives import feed_axis

    names = term_names(terms)
    _check_update(update=update, machine=machine)
    check_page(page, option="--page", self_contained=self_contained)
    check_staging(staged=staged, pitch=pitch)
    with working(f"identifying from {recording.name}") as progress:
        with in_english():  # what is found is kept
            moves = moves_of(recording, axis, columns, group, resample)
            other = moves_of(also, axis, columns, group, resample) if also else None
            seen = None
            if staged:
                progress("stages")
                seen = try_stages(
                    moves, axis=axis, machine=machine, terms=names, pitch=pitch, db=db
                )
            if machine is None:
                stored, model = None, _alone(moves, axis, names)
            else:
                with opened_store(db) as store:
                    stored = _on_machine(
                        store, machine, recording, moves,
                        columns=columns, axis=axis, terms=names, update=update, progress=progress,
                    )  # fmt: skip
                model = stored.kept.model
            progress("spread over filters")
            fitted = _fitted_names(model)
            spread = feed_axis.spread_over_filters(moves, axis=model.axis, terms=fitted)
        if page is not None:
            write_page(page, render_axis(model, moves), self_contained=self_contained)
    if json:
        _say_model(model, moves, stored)
        return
    show_fit(model, moves, other, spread)
    if seen is not None:
        show_staged(model, seen)
    if page is not None:
        say(phrase("page: {page}", page=page))
    _show_stored(stored, machine or "")


def _say_model(model: "Identified", moves: "tables.Recording", stored: "_Stored | None") -> None:
    """Print an identification as JSON."""
    from autodb.library.found import IdentifyResult

    version = stored.kept.version if stored else None
    with in_english():
        say_json(IdentifyResult(model, moves, version).to_dict())


def _check_update(*, update: bool, machine: str | None) -> None:
    """Raise UnusableInput where there is no version to go on from."""
    from autodb.errors import UnusableInput

    if update and machine is None:
        raise UnusableInput(
            phrase("--update goes with --machine: it goes on from a machine's last version")
        )


def _alone(
    moves: "tables.Recording", axis: str | None, names: tuple[str, ...] | None
) -> "Identified":
    """Return what is identified from moves of an axis of no machine."""
    from autodb.agent.sense.identifying import refuse_faults
    from autodb.sensing.drives import feed_axis

    refuse_faults(moves, axis)
    return feed_axis.identify(moves, axis=axis, terms=names)


@dataclass(frozen=True)
class _Stored:
    """A model that a machine keeps now, its earlier versions, and what its slides carry."""

    kept: "KeptModel"
    versions: "Sequence[ModelVersion]"
    masses: "Mapping[str, Mass]"


def _on_machine(
    store: "Store",
    machine: str,
    recording: Path,
    moves: "tables.Recording",
    *,
    columns: Path | None,
    axis: str | None,
    terms: tuple[str, ...] | None,
    update: bool,
    progress: "Step",
) -> _Stored:
    """Return what is identified from moves of a machine's axis, and keep it."""
    from autodb.agent.sense.carried_masses import slide_masses
    from autodb.agent.sense.identifying import identify_on_machine, versions_of

    kept = identify_on_machine(
        store, machine, recording, moves,
        columns=columns, axis=axis, terms=terms, update=update, progress=progress,
    )  # fmt: skip
    versions = versions_of(store, machine, kept.model.channel) if update else []
    return _Stored(kept, versions, slide_masses(store, machine))


def _show_stored(stored: _Stored | None, machine: str) -> None:
    """Print what of a model is stored, and what its machine carries and had before."""
    if stored is None:
        say(phrase("not stored: give --machine NAME to keep it"))
        return
    show_kept(stored.kept, machine)
    show_masses(stored.masses)
    show_versions(stored.versions)


def _fitted_names(model: "Identified") -> list[str]:
    """Return the names of a model's terms that have no shape: the spread is over their filter."""
    shaped = {t.key for t in model.terms if t.parameter == "period"}
    return list(dict.fromkeys(t.term for t in model.terms if t.key not in shaped))
