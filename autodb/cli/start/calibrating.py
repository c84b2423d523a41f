"""`calibrate`: from currents to forces, axis by axis."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import (
    Columns,
    Database,
    Json,
    OptionalMachine,
    SelfContained,
    complain,
    default_machine,
    opened_store,
    say,
    say_json,
    show,
    table,
    working,
)
from autodb.cli.understand.fitting import AskedRecordings, level_command, train_command

if TYPE_CHECKING:
    from autodb.agent.sense.calibrating import Calibrated
    from autodb.sensing.ranges.calibration import Calibration
    from autodb.standard import CutProtocol

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


def calibrate_command(
    recordings: OptionalFiles = None,
    machine: OptionalMachine = None,
    columns: Columns = None,
    protocol: ProtocolName = None,
    card: CardFile = None,
    self_contained: SelfContained = False,
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
    from autodb.reports.card.card_data import card_of_calibrations
    from autodb.reports.card.files import write_card
    from autodb.reports.card.run_course import moved_over
    from autodb.standard import read_protocol

    chosen = read_protocol(protocol) if protocol else None
    if not recordings and machine is None:
        machine = default_machine(db)
    asked = AskedRecordings(recordings or [], machine, columns, db)
    _check(asked, card, update=update, self_contained=self_contained)
    tell = complain if json else say
    done = _calibrated(asked, chosen, tell, update=update)
    moved = moved_over(done, chosen)
    if json:
        from autodb.library.answers import CalibrateResult

        say_json(CalibrateResult(done, machine or "", chosen).to_dict())
    else:
        _say_calibrated(done, moved, stored=machine is not None)
    if card is not None:
        title = machine or ", ".join(name for name, _ in done.sources)
        with working(f"writing {card.name}") as progress:
            progress("estimating cuts without their groups")
            shown = card_of_calibrations(done, title=title, protocol=chosen, moved=moved)
            write_card(shown, card, self_contained=self_contained)
        tell(f"card: {card}")


def _check(
    asked: AskedRecordings, card: Path | None, *, update: bool, self_contained: bool
) -> None:
    """Raise UnusableInput for what cannot be calibrated, or written, before anything is stored."""
    from autodb.errors import UnusableInput
    from autodb.reports.card.files import check_card_target

    if not asked.files and asked.machine is None:
        raise UnusableInput("give a cut table, or --machine NAME to use its imported cuts")
    if update and (asked.machine is None or not asked.files):
        raise UnusableInput("--update needs --machine NAME and recordings to add")
    if card is not None:
        check_card_target(card, self_contained=self_contained)
    elif self_contained:
        raise UnusableInput("--self-contained goes with --card FILE.html")


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
