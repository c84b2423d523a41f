"""`import`, `calibrate`, `identify`, `refresh`: what a machine learns from."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import (
    Columns,
    Database,
    Group,
    MachineName,
    OptionalMachine,
    Resample,
    opened,
    read_one,
    say,
    show,
    table,
    working,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from autodb import records
    from autodb.agent.identifying import KeptModel
    from autodb.records.summary import BaseSummary
    from autodb.sensing.axis_model import Identified, IdentifiedTerm, PlainFit
    from autodb.sensing.ranges import Calibration
    from autodb.standard import Protocol

Files = Annotated[list[Path], typer.Argument(readable=False, help="Recordings or cut tables.")]
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
ProtocolName = Annotated[
    str | None,
    typer.Option("--protocol", help="Standard cuts whose reference forces to use: name or file."),
]
OptionalFile = Annotated[
    Path | None,
    typer.Argument(readable=False, help="A cut table; default: all imported cuts of the machine."),
]


SHOWN = 12
"""Columns that are listed before the rest is only counted."""


def import_(
    files: Files, machine: OptionalMachine = None, columns: Columns = None, db: Database = None
) -> None:
    """Import recordings and cut tables; each file enters once. Without --machine only look."""
    from autodb.agent.importing import import_file

    if machine is None:
        for file in files:
            _look(file, columns)
        say("not stored: give --machine NAME to keep it")
        return
    with opened(db) as store:
        for file in files:
            with working(f"importing {file.name}") as progress:
                done = import_file(store, file, machine=machine, columns=columns, progress=progress)
            what = "already there" if done.already_there else "imported"
            if done.other_side:
                what += " (with another side file, which still holds)"
            say(f"recording {done.recording_id}: {file.name}: {what}, {done.rows} rows, "
                f"{done.cuts} cuts")  # fmt: skip


def _look(file: Path, columns: Path | None) -> None:
    """Show what a file holds, and refuse it as an import would."""
    from autodb.records import open_source
    from autodb.records.plausible import refuse_implausible
    from autodb.records.summary import summarise

    with working(f"reading {file.name}") as progress:
        source = open_source(file, columns=columns)
        bases = summarise(source, progress=progress)
    for base in bases:
        _show_summary(f"{file.name} {base.name}".rstrip(), base)
    ignored = [column for base in source.bases for column in base.ignored]
    if ignored:
        more = f" and {len(ignored) - SHOWN} more" if len(ignored) > SHOWN else ""
        say(f"not read, no channel names it: {', '.join(ignored[:SHOWN])}{more}")
    refuse_implausible(source, bases)


def _show_summary(title: str, base: "BaseSummary") -> None:
    what = f"{base.rows} cuts"
    if base.rate_hz is not None:
        what = f"{base.rows} rows, {base.rate_hz:.6g} Hz, {base.start_s:g} to {base.end_s:g} s"
    rows = table(f"{title}: {what}", "channel", "unit", ">lowest", ">highest", ">mean", "gaps")
    for c in base.channels.values():
        numbers = [f"{v:.6g}" for v in (c.minimum, c.maximum, c.mean)] if c.finite else ["", "", ""]
        gaps = f"{c.rows - c.finite}, first in row {c.first_gap}" if c.first_gap else ""
        rows.add_row(c.name, c.unit, *numbers, gaps)
    show(rows)


def calibrate(
    recording: OptionalFile = None,
    machine: OptionalMachine = None,
    columns: Columns = None,
    protocol: ProtocolName = None,
    db: Database = None,
) -> None:
    """Fit current to force per axis, scored on groups left out; offered or refused by rule."""
    from autodb.errors import UnusableInput
    from autodb.standard import read_protocol

    chosen = read_protocol(protocol) if protocol else None
    if recording is None and machine is None:
        raise UnusableInput("give a cut table, or --machine NAME to use its imported cuts")
    if machine is None:
        assert recording is not None
        done, left_out = _calibrate_file(recording, columns, chosen)
        new = [False] * len(done)
    else:
        done, left_out, new = _calibrate_machine(machine, recording, columns, chosen, db)
    _show_calibrations(done)
    for sentence in left_out:
        say(f"left out: {sentence}")
    if machine is None:
        say("not stored: give --machine NAME to keep it")
    elif not any(new):
        say("already there: the same cuts gave the same lines")


def _calibrate_file(
    path: Path, columns: Path | None, protocol: "Protocol | None"
) -> "tuple[list[Calibration], list[str]]":
    from autodb import records
    from autodb.agent.calibrating import calibrate_table
    from autodb.errors import UnusableInput
    from autodb.records import CutTable
    from autodb.records.plausible import refuse_doubtful
    from autodb.records.summary import summary_of
    from autodb.sensing.ranges import COMPONENT_OF_AXIS

    with working(f"calibrating on {path.name}"):
        cuts = records.read(path, columns=columns)
        if not isinstance(cuts, CutTable):
            raise UnusableInput(f"{path}: no column 'cut'; calibrate needs a table of cuts")
        refuse_doubtful(path, summary_of(cuts), cuts.side)
        return calibrate_table(cuts, axes=tuple(COMPONENT_OF_AXIS), protocol=protocol)


def _calibrate_machine(
    machine: str,
    path: Path | None,
    columns: Path | None,
    protocol: "Protocol | None",
    db: str | None,
) -> "tuple[list[Calibration], list[str], list[bool]]":
    from autodb.agent.calibrating import calibrate_machine
    from autodb.agent.importing import import_file

    with opened(db) as store, working(f"calibrating {machine}") as progress:
        only = None
        if path is not None:
            only = [import_file(store, path, machine=machine, columns=columns).recording_id]
        return calibrate_machine(
            store, machine, recordings=only, protocol=protocol, progress=progress
        )


def _show_calibrations(done: "list[Calibration]") -> None:
    rows = table("Calibration", "axis", "force", "line", ">RMSE", ">R² (95 %)", "")
    for c in done:
        (c0, c1), s = c.coefficients, c.scores
        rows.add_row(
            c.axis,
            f"force.{c.component}",
            f"{c0:.4g} {c.unit} {c1:+.4g} {c.unit}/{c.current_unit} · I",
            f"{s.rmse:.1f} {c.unit}",
            f"{s.r_squared:.3f} ({s.r_squared_low:.3f} to {s.r_squared_high:.3f})",
            "offered" if c.offered else "refused",
        )
    show(rows)
    for c in done:
        s = c.scores
        say(f"axis {c.axis}: I = {c.channel}; {s.n} cuts, scored on {s.groups} x {s.grouped_by} "
            "left out")  # fmt: skip
        if not c.offered:
            say(f"axis {c.axis}: {c.verdict}")
        if c.transients:
            cuts = ", ".join(f"{cut:g}" for cut in c.transients)
            say(
                f"axis {c.axis}: {len(c.transients)} transient rows set aside (cut {cuts}): the "
                f"current jumps, the force does not. With them: RMSE "
                f"{c.scores_with_transients.rmse:.1f} {c.unit}, "
                f"R² {c.scores_with_transients.r_squared:.3f}"
            )


def identify(
    recording: Recording,
    axis: Axis = None,
    terms: Terms = None,
    also: Also = None,
    machine: OptionalMachine = None,
    columns: Columns = None,
    group: Group = None,
    resample: Resample = None,
    db: Database = None,
) -> None:
    """Identify inertia, friction, load and other terms of a feed axis from its moves."""
    from autodb.agent.identifying import identify_on_machine
    from autodb.sensing import drives

    names = tuple(name.strip() for name in terms.split(",")) if terms else None
    with working(f"identifying from {recording.name}") as progress:
        moves = _moves(recording, axis, columns, group, resample)
        other = _moves(also, axis, columns, group, resample) if also else None
        if machine is None:
            kept, model = None, drives.identify(moves, axis=axis, terms=names)
        else:
            with opened(db) as store:
                kept = identify_on_machine(
                    store, machine, recording, moves,
                    columns=columns, axis=axis, terms=names, progress=progress,
                )  # fmt: skip
            model = kept.model
        progress("spread over filters")
        spread = drives.spread_over_filters(moves, axis=model.axis, terms=_fitted_names(model))
    _show_model(model)
    if other is not None:
        _show_cross_test(model, other)
    _show_spread(spread)
    if kept is None:
        say("not stored: give --machine NAME to keep it")
        return
    _show_kept(kept, machine or "")


def _moves(
    path: Path, axis: str | None, columns: Path | None, group: str | None, resample: float | None
) -> "records.Recording":
    """Read moves over time, refused where physics says that a channel is not what it claims."""
    from autodb.errors import UnusableInput
    from autodb.records import CutTable
    from autodb.records.plausible import refuse_doubtful
    from autodb.records.summary import summary_of
    from autodb.sensing.prepared import effort_axis

    moves = read_one(path, columns=columns, group=group, resample_hz=resample)
    if isinstance(moves, CutTable):
        raise UnusableInput(f"{path}: a table of cuts; identify needs moves over time")
    refuse_doubtful(path, summary_of(moves, axis=effort_axis(moves, axis)), moves.side)
    return moves


def _fitted_names(model: "Identified") -> list[str]:
    """Return the names of a model's terms that have no shape: the spread is over their filter."""
    shaped = {t.key for t in model.terms if t.parameter == "period"}
    return list(dict.fromkeys(t.term for t in model.terms if t.key not in shaped))


def _show_model(model: "Identified") -> None:
    from autodb.sensing.axis_model import amplitudes

    plain = {(t.key, t.parameter): t for t in model.plain.terms}
    rows = table(
        f"{model.channel} of axis {model.axis}",
        "term", "parameter", ">value", ">sd", "unit", ">plain least squares", ">sd",
    )  # fmt: skip
    for term in [*model.fitted, *amplitudes(model)]:
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
        f"{100 * model.held_out_error:.2f} % on blocks of motion left out")  # fmt: skip
    say(f"protocol: {model.protocol}")
    if model.unit == "A":
        say("in amperes: newtons need a torque constant, a known mass, a push or a standard cut")
    for sentence in model.not_excited:
        say(f"not excited, no number: {sentence}")
    for sentence in model.doubts:
        say(f"doubtful: {sentence}")
    for t in amplitudes(model):
        flips = "flips with the direction" if t.form else "keeps its sign in both directions"
        say(f"ripple: {t.value:.3g} {t.unit}, {flips} ({t.term})")


def _show_cross_test(model: "Identified", other: "records.Recording") -> None:
    """Print how well the model does on a recording that it was not fitted to."""
    from autodb.sensing.drives import cross_test, without_ripple

    def error(terms: "Sequence[IdentifiedTerm]") -> str:
        return f"{100 * cross_test(other, model.axis, model.protocol, terms):.2f} %"

    plain = [*model.plain.terms, *model.plain.given]
    say(f"on {other.path.name}: relative error {error(model.terms)}; plain least squares "
        f"{error(plain)}")  # fmt: skip
    smooth = without_ripple(model.terms)
    if len(smooth) < len(model.terms):
        say(f"on {other.path.name} without the ripple: {error(smooth)}")


def _show_kept(kept: "KeptModel", machine: str) -> None:
    model = kept.model
    for m in model.moved:
        before, now = (f"{_scaled(v, m.unit):.6g}" for v in (m.before, m.now))
        sds = [f"{_scaled(v, m.unit):.2g}" for v in (m.before_sd, m.now_sd)]
        say(f"moved since version {kept.parent}: {m.key} {m.parameter} from {before} ± {sds[0]} to "
            f"{now} ± {sds[1]} {_shop_unit(m.unit)[1]}")  # fmt: skip
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
    if not spread:
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


def refresh(machine: MachineName, db: Database = None) -> None:
    """Sense the forces of new cuts and update the cutting parameters of their pairs."""
    from autodb.agent.refreshing import refresh as run

    with opened(db) as store, working(f"refreshing {machine}") as progress:
        done = run(store, machine, progress=progress)
    if not done.sensed and not done.versions:
        say("nothing new: every cut is sensed and every pair is up to date")
    else:
        say(f"{done.sensed} forces sensed, {done.not_sensed} not sensed")
    for pair, component, version, n in done.versions:
        say(f"{pair}: force.{component} version {version} from {n} cuts")
    for sentence in done.set_aside:
        say(f"set aside: {sentence}")
