"""`import`, `calibrate`, `refresh`: what a machine learns from."""

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import (
    Columns,
    Database,
    Json,
    MachineName,
    OptionalMachine,
    complain,
    default_machine,
    opened_store,
    say,
    say_json,
    show,
    table,
    working,
)
from autodb.cli.learn.fitting import AskedRecordings, level_command, train_command
from autodb.cli.learn.looking import show_file

if TYPE_CHECKING:
    from autodb.agent.ingest.importing import Imported
    from autodb.agent.sense.calibrating import Calibrated
    from autodb.sensing.ranges.calibration import Calibration
    from autodb.standard import CutProtocol
    from autodb.store import Store

Files = Annotated[
    list[Path], typer.Argument(readable=False, help="Recordings, cut tables or material cards.")
]
ProtocolName = Annotated[
    str | None,
    typer.Option("--protocol", help="Standard cuts whose reference forces to use: name or file."),
]
OptionalFiles = Annotated[
    list[Path] | None,
    typer.Argument(
        readable=False,
        help="Cut tables, and raw recordings of one cut each; default: all imported cuts of the "
        "machine.",
    ),
]


CardFile = Annotated[
    Path | None,
    typer.Option(
        "--card",
        metavar="FILE",
        help="Write the calibration card: FILE.html, or FILE.pdf where a browser can print it.",
    ),
]

Network = Annotated[
    bool,
    typer.Option(
        "--network",
        help="Train a network (LSTM) on recordings over time of drives and known forces, or of "
        "moves in air; needs the extra lstm.",
    ),
]

Update = Annotated[
    bool,
    typer.Option(
        "--update",
        help="Add the recordings to those that the calibrations in use were made on.",
    ),
]
OfTable = Annotated[
    bool,
    typer.Option(
        "--table",
        help="Identify a dynamometer on a table that tilts or turns, from moves without a cut.",
    ),
]


def import_(
    files: Files,
    machine: MachineName = None,
    columns: Columns = None,
    json: Json = False,
    db: Database = None,
) -> None:
    """Import recordings and cut tables; each file enters once.

    Where the database has several machines, or none, and --machine says none, it only looks.
    Material cards (CSV) belong to no machine.
    """
    from autodb.agent.ingest.gathering import each_used
    from autodb.pairs.cards import is_card

    cards = [file for file in files if is_card(file)]
    recordings = [file for file in files if file not in cards]
    if cards:
        with opened_store(db) as store:
            for file in cards:
                _import_cards(store, file)
    machine = machine or (default_machine(db) if recordings else None)
    if machine is None:
        for file in recordings:
            show_file(file, columns)
        if recordings:
            say("not stored: give --machine NAME to keep it")
    elif recordings:
        with opened_store(db) as store:
            done = each_used(
                recordings,
                lambda file: _import(store, file, machine, columns, quiet=json),
                tell=complain if json else say,
            )
        if json:
            say_json([{"file": str(file), **asdict(one)} for file, one in done])


def _import_cards(store: "Store", file: Path) -> None:
    """Import a table of material cards and say what became of each."""
    from autodb.agent.rows.imported_cards import keep_cards
    from autodb.pairs.cards import read_cards

    for card in keep_cards(store, read_cards(file)):
        what = "already there" if card.already_there else "imported"
        if card.replaced:
            what = f"replaces the one of this source: {'; '.join(card.replaced)}"
        say(f"{file.name}: card of {card.material} ({card.source}): {what}")


def _import(
    store: "Store", file: Path, machine: str, columns: Path | None, *, quiet: bool
) -> "tuple[Path, Imported]":
    """Import one file, say what became of it unless ``quiet``, and return it."""
    from autodb.agent.ingest.importing import import_file

    with working(f"importing {file.name}") as progress:
        done = import_file(store, file, machine=machine, columns=columns, progress=progress)
    if not quiet:
        _say_imported(file, done)
    return file, done


def _say_imported(file: Path, done: "Imported") -> None:
    what = "already there" if done.already_there and not done.looked_at else "imported"
    if done.withdrawn is not None:
        what = f"withdrawn ({done.withdrawn}), it does not count"
    if done.other_side:
        what += " (with another side file, which still holds)"
    again = f", {done.again} more are there already" if done.again else ""
    counted = f"{done.rows} rows, {done.cuts} cuts{again}"
    say(f"recording {done.recording_id}: {file.name}: {what}, {counted}")
    for note in (*(f"time: {sentence}" for sentence in done.timing), *done.notes):
        say(f"{file.name}: {note}")


def calibrate_command(
    recordings: OptionalFiles = None,
    machine: OptionalMachine = None,
    columns: Columns = None,
    protocol: ProtocolName = None,
    card: CardFile = None,
    json: Json = False,
    network: Network = False,
    of_table: OfTable = False,
    update: Update = False,
    db: Database = None,
) -> None:
    """Fit current to force per axis, tested on held-out groups; a rule decides if it is usable."""
    if network or of_table:
        asked = AskedRecordings(recordings or [], machine, columns, db)
        _refuse_both(asked, network, of_table, with_cuts=bool(protocol or card))
        (train_command if network else level_command)(asked)
        return
    from autodb.reports.card.run_course import moved_over
    from autodb.standard import read_protocol

    chosen = read_protocol(protocol) if protocol else None
    if not recordings and machine is None:
        machine = default_machine(db)
    asked = AskedRecordings(recordings or [], machine, columns, db)
    _check(asked, card, update=update)
    tell = complain if json else say
    done = _calibrated(asked, chosen, tell, update=update)
    moved = moved_over(done, chosen)
    if json:
        from autodb.library.answers import CalibrateResult

        say_json(CalibrateResult(done, machine or "", chosen).to_dict())
    else:
        _say_calibrated(done, moved, stored=machine is not None)
    if card is not None:
        _write_card(done, machine, chosen, moved, card, tell)


def _check(asked: AskedRecordings, card: Path | None, *, update: bool) -> None:
    """Raise UnusableInput for what cannot be calibrated, or written, before anything is stored."""
    from autodb.errors import UnusableInput
    from autodb.reports.card.files import check_card_target

    if not asked.files and asked.machine is None:
        raise UnusableInput("give a cut table, or --machine NAME to use its imported cuts")
    if update and (asked.machine is None or not asked.files):
        raise UnusableInput("--update needs --machine NAME and recordings to add")
    if card is not None:
        check_card_target(card)


def _calibrated(
    asked: AskedRecordings,
    protocol: "CutProtocol | None",
    tell: Callable[[str], None],
    *,
    update: bool,
) -> "Calibrated":
    """Calibrate a machine, or on files alone."""
    from autodb.library.alone import calibrate_files

    if asked.machine is not None:
        return _calibrate_machine(asked, protocol, tell, update=update)
    with working(f"calibrating on {', '.join(file.name for file in asked.files)}"):
        return calibrate_files(asked.files, columns=asked.columns, protocol=protocol, tell=tell)


def _say_calibrated(done: "Calibrated", moved: list[tuple[str, ...]], *, stored: bool) -> None:
    """Print calibrations, what moved over their cuts, and what is not there."""
    _show_calibrations(done.calibrations)
    for one, sentences in zip(done.calibrations, moved, strict=True):
        for sentence in sentences:
            say(f"axis {one.called}: {sentence}")
    for sentence in done.left_out:
        say(f"excluded: {sentence}")
    if not stored:
        say("not stored: give --machine NAME to keep it")
    elif not any(done.new):
        say("already there: the same cuts gave the same equations")


def _refuse_both(asked: AskedRecordings, network: bool, of_table: bool, *, with_cuts: bool) -> None:
    from autodb.errors import UnusableInput

    option = "--network" if network else "--table"
    if network and of_table:
        raise UnusableInput("--network and --table: use one at a time")
    if asked.machine is None or not asked.files:
        raise UnusableInput(f"{option} needs --machine NAME and recordings over time")
    if with_cuts:
        raise UnusableInput(f"--protocol and --card go with cuts, not with {option}")


def _calibrate_machine(
    asked: AskedRecordings,
    protocol: "CutProtocol | None",
    tell: Callable[[str], None],
    *,
    update: bool,
) -> "Calibrated":
    from autodb.agent.ingest.gathering import each_used
    from autodb.agent.ingest.importing import import_file
    from autodb.agent.sense.calibrating import calibrate_machine, calibrated_on

    machine = str(asked.machine)
    with opened_store(asked.db) as store, working(f"calibrating {machine}") as progress:

        def number_of(file: Path) -> int:
            done = import_file(store, file, machine=machine, columns=asked.columns)
            for note in done.notes:
                tell(f"{file.name}: {note}")
            return done.recording_id

        only = each_used(asked.files, number_of, tell=tell) if asked.files else None
        if only is not None and update:
            only = sorted({*only, *calibrated_on(store, machine)})
        return calibrate_machine(
            store, machine, recordings=only, protocol=protocol, progress=progress
        )


def _write_card(
    done: "Calibrated",
    machine: str | None,
    protocol: "CutProtocol | None",
    moved: list[tuple[str, ...]],
    path: Path,
    tell: Callable[[str], None],
) -> None:
    from autodb.reports.card.card_data import card_of_calibrations
    from autodb.reports.card.files import write_card

    title = machine or ", ".join(name for name, _ in done.sources)
    with working(f"writing {path.name}") as progress:
        progress("estimating cuts without their groups")
        write_card(card_of_calibrations(done, title=title, protocol=protocol, moved=moved), path)
    tell(f"card: {path}")


def _show_calibrations(done: "list[Calibration]") -> None:
    from autodb.sensing.ranges.outliers import outlier_sentences

    rows = table("Calibration", "axis", "force", "equation", ">RMSE", ">R² (95 %)", "")
    for c in done:
        s = c.scores
        rows.add_row(
            c.called,
            f"force.{c.component}",
            c.form.equation(c.coefficients, c.unit, c.current_unit),
            f"{s.rmse:.1f} {c.unit}",
            f"{s.r_squared:.3f} ({s.r_squared_low:.3f} to {s.r_squared_high:.3f})",
            "usable" if c.offered else "not usable",
        )
    show(rows)
    for c in done:
        s = c.scores
        say(f"axis {c.called}: I = {c.channel}; {s.n} cuts, scored on {s.groups} held-out "
            f"groups ({s.grouped_by})")  # fmt: skip
        say(f"axis {c.called}: RMSE {c.trials_words()}")
        if c.domain is not None:
            say(f"axis {c.called}: calibrated range: {c.domain.words(c.unit)}")
        for form in c.close:
            say(f"axis {c.called}: {form} is nearly as good a form")
        if not c.offered:
            say(f"axis {c.called}: {c.verdict}")
        for sentence in outlier_sentences(c.outliers):
            say(f"axis {c.called}: {sentence}")
        if c.transients:
            cuts = ", ".join(f"{cut:g}" for cut in c.transients)
            say(
                f"axis {c.called}: {len(c.transients)} transient rows excluded (cut {cuts}): "
                "the current jumps, the force does not. With them: RMSE "
                f"{c.scores_with_transients.rmse:.1f} {c.unit}, R² "
                f"{c.scores_with_transients.r_squared:.3f}"
            )
