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
    show,
    table,
    working,
)
from autodb.cli.understand.over_time import moves_of, say_time, term_names
from autodb.cli.understand.staging import (
    Pitch,
    Staging,
    check_staging,
    show_staged,
    show_sweep,
    try_stages,
)
from autodb.wording import significant

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from autodb.agent.sense.identifying import KeptModel, ModelVersion
    from autodb.records import tables
    from autodb.sensing.drives.fit.axis_model import Identified, IdentifiedTerm, PlainFit
    from autodb.sensing.drives.fit.discrepancy import FrictionDiscrepancy
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

KEEPS = "keeps its sign in both directions"
TWICE = 2.0
"""Times its friction of before that no axis comes to by wear between two sweeps. Chosen."""
Update = Annotated[
    bool,
    typer.Option("--update", help="Go on from the machine's last version, and list all versions."),
]
Page = Annotated[
    Path | None,
    typer.Option("--page", metavar="FILE", help="Write a page with maps of the effort, too."),
]

MOST_IN_SPREAD = 8
"""Coefficients that a table over filters has room for."""


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
        moves = moves_of(recording, axis, columns, group, resample)
        other = moves_of(also, axis, columns, group, resample) if also else None
        seen = None
        if staged:
            progress("stages")
            seen = try_stages(moves, axis=axis, machine=machine, terms=names, pitch=pitch, db=db)
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
        spread = feed_axis.spread_over_filters(moves, axis=model.axis, terms=_fitted_names(model))
        if page is not None:
            write_page(page, render_axis(model, moves), self_contained=self_contained)
    if json:
        from autodb.library.found import IdentifyResult

        version = stored.kept.version if stored else None
        say_json(IdentifyResult(model, moves, version).to_dict())
        return
    _show_fit(model, moves, other, spread)
    if seen is not None:
        show_staged(model, seen)
    if page is not None:
        say(f"page: {page}")
    _show_stored(stored, machine or "")


def _check_update(*, update: bool, machine: str | None) -> None:
    """Raise UnusableInput where there is no version to go on from."""
    from autodb.errors import UnusableInput

    if update and machine is None:
        raise UnusableInput(
            "--update goes with --machine: it goes on from a machine's last version"
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
        say("not stored: give --machine NAME to keep it")
        return
    show_kept(stored.kept, machine)
    _show_masses(stored.masses)
    _show_versions(stored.versions)


def _show_fit(
    model: "Identified",
    moves: "tables.Recording",
    other: "tables.Recording | None",
    spread: "list[PlainFit]",
) -> None:
    """Print the terms, how far off they are, and what they owe to the filter."""
    _show_model(model)
    say_time(moves)
    show_sweep(model, moves)
    if other is not None:
        _show_cross_test(model, other)
    _show_spread(spread)


def _show_masses(masses: "Mapping[str, Mass]") -> None:
    """Print the mass of each slide alone, where it is known."""
    if not masses:
        return
    said = (f"{axis} {mass.kg:.4g} ± {mass.sd_kg:.2g} kg" for axis, mass in masses.items())
    say(f"slides alone (± 1 sd): {', '.join(said)}")


def _show_versions(versions: "Sequence[ModelVersion]") -> None:
    """Print the numbers of each version: how the axis drifted."""
    from autodb.sensing.drives.fit.axis_model import readable

    if not versions:
        return
    every = [t for v in versions for t in readable(v.terms)]
    names = list(dict.fromkeys((t.key, t.parameter) for t in every))
    units = {(t.key, t.parameter): _shop_unit(t.unit)[1] for v in versions for t in v.terms}
    heads = (f">{key} {parameter} [{units[key, parameter]}]" for key, parameter in names)
    rows = table("Versions", ">version", "day", "from", *heads)
    for version in versions:
        known = {(t.key, t.parameter): t for t in version.terms}
        numbers = (_with_sd(known.get(name)) for name in names)
        rows.add_row(str(version.number), version.day, ", ".join(version.recordings), *numbers)
    show(rows)


def _with_sd(term: "IdentifiedTerm | None") -> str:
    if term is None:
        return ""
    return f"{_scaled(term.value, term.unit):.4g} ± {_scaled(term.sd or 0.0, term.unit):.2g}"


def _fitted_names(model: "Identified") -> list[str]:
    """Return the names of a model's terms that have no shape: the spread is over their filter."""
    shaped = {t.key for t in model.terms if t.parameter == "period"}
    return list(dict.fromkeys(t.term for t in model.terms if t.key not in shaped))


def _show_model(model: "Identified") -> None:
    from autodb.sensing.drives.fit.axis_model import amplitudes, readable

    plain = {(t.key, t.parameter): t for t in model.plain.terms}
    rows = table(
        f"{model.channel} of axis {model.axis}",
        "term", "parameter", ">value", ">sd", "unit", ">plain least squares", ">sd",
    )  # fmt: skip
    for term in [*readable(model.fitted), *amplitudes(model)]:
        other = plain.get((term.key, term.parameter))
        rows.add_row(
            term.key,
            term.parameter,
            *_numbers(term),
            _shop_unit(term.unit)[1],
            *(_numbers(other) if other else ("", "")),
        )
    show(rows)
    rms = f"{model.residual_rms:.3f} {model.unit}"
    say(f"relative error {100 * model.relative_error:.2f} %, rms {rms}")
    say(f"plain least squares: {100 * model.plain.relative_error:.2f} %, and "
        f"{100 * model.held_out_error:.2f} % on held-out blocks of motion")  # fmt: skip
    say(f"protocol: {model.protocol}")
    if model.unit == "A":
        say(
            "in amperes; determine the force constant (N/A) with 'autodb scale', from a known "
            "mass, a push or a standard cut"
        )
    for sentence in model.not_excited:
        say(f"not excited, not estimated: {sentence}")
    for sentence in model.doubts:
        say(f"doubtful: {sentence}")
    for t in amplitudes(model):
        if t.form == "tilt":
            say(
                f"weight: at most {significant(t.value)} {t.unit} at the angle that lifts it "
                f"({t.term})"
            )
            continue
        flips = "flips with the direction" if t.form == "periodic" else KEEPS
        first = ", its first harmonic" if t.form in ("table", "harmonics") else ""
        say(f"ripple: {significant(t.value)} {t.unit}{first}, {flips} ({t.term})")
    _show_cogging(model)


def _show_cogging(model: "Identified") -> None:
    """Print which form of cogging was kept, and what each leaves of blocks left out."""
    for kept in (one for one in model.cogging if one.kept):
        tried = ", ".join(
            f"{one.called} {100.0 * one.held_out_error:.2f} %" for one in model.cogging
        )
        unit = "deg" if model.axis in "abc" else "mm"
        say(f"cogging: {kept.called} over {kept.period:.5g} {unit} kept; on held-out blocks: "
            f"{tried}")  # fmt: skip


def _show_cross_test(model: "Identified", other: "tables.Recording") -> None:
    """Print how well the model does on a recording that it was not fitted to."""
    from autodb.sensing.drives.feed_axis import cross_test, without_ripple

    def error(
        terms: "Sequence[IdentifiedTerm]", off_law: "FrictionDiscrepancy | None" = None
    ) -> str:
        left = cross_test(other, model.axis, model.protocol, terms, off_law)
        return f"{100 * left:.2f} %"

    plain = [*model.plain.terms, *model.plain.given]
    whole = error(model.terms, model.off_law)
    say(f"on {other.path.name}: relative error {whole}; plain least squares {error(plain)}")
    smooth = without_ripple(model.terms)
    if len(smooth) < len(model.terms):
        say(f"on {other.path.name} without the ripple: {error(smooth)}")


def show_kept(kept: "KeptModel", machine: str) -> None:
    """Print which version a model became, and what moved since the one it started from."""
    model = kept.model
    nodes = [m for m in model.moved if m.parameter.startswith("node_")]
    if nodes:
        say(f"moved since version {kept.parent}: {len(nodes)} nodes of {nodes[0].key}")
    for m in (m for m in model.moved if m not in nodes):
        before, now = (f"{_scaled(v, m.unit):.6g}" for v in (m.before, m.now))
        sds = [f"{_scaled(v, m.unit):.2g}" for v in (m.before_sd, m.now_sd)]
        say(f"moved since version {kept.parent}: {m.key} {m.parameter} from {before} ± {sds[0]} to "
            f"{now} ± {sds[1]} {_shop_unit(m.unit)[1]}")  # fmt: skip
        if m.key == "coulomb" and m.now > TWICE * m.before:
            say(f"{model.axis} takes more than {TWICE:g} times the friction it took: a brake that "
                "drags, a clamp, or a dry way?")  # fmt: skip
    what = f"{model.channel}: version {kept.version} of machine '{machine}'"
    if kept.already_there:
        say(f"{what}: already there")
    elif kept.parent is not None:
        still = "" if model.moved else "; nothing moved by more than its uncertainty"
        say(f"{what}, started from version {kept.parent}{still}")
    else:
        say(what)


def _numbers(term: "IdentifiedTerm") -> tuple[str, str]:
    sd = "given" if term.sd == 0 else f"{_scaled(term.sd or 0.0, term.unit):.2g}"
    return f"{_scaled(term.value, term.unit):.6g}", sd


def _scaled(value: float, unit: str) -> float:
    return value * _shop_unit(unit)[0]


def _shop_unit(unit: str) -> tuple[float, str]:
    """Return factor and unit that a shop reads: kg and N·s/m where the effort is in newtons."""
    known = {"N·s²/mm": (1000.0, "kg"), "N·s/mm": (1000.0, "N·s/m")}
    return known.get(unit, (1.0, unit))


def _show_spread(spread: "list[PlainFit]") -> None:
    if not spread or len(spread[0].terms) > MOST_IN_SPREAD:
        return
    names = [f"{t.key} {t.parameter}" for t in spread[0].terms]
    heads = [name.replace(" level", "").replace(" coefficient", "") for name in names]
    heads = heads if len(set(heads)) == len(heads) else names
    rows = table(
        "Plain least squares over filters",
        ">low-pass Hz", "anti-alias", *(f">{n}" for n in heads), ">error %",
    )  # fmt: skip
    for fit in spread:
        values = [_scaled(t.value, t.unit) for t in fit.terms]
        rows.add_row(
            f"{fit.protocol.cutoff_hz:g}",
            "yes" if fit.protocol.anti_alias else "no",
            *(f"{value:.5g}" for value in values),
            f"{100 * fit.relative_error:.2f}",
        )
    show(rows)
