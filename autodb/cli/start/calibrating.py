"""`calibrate`: from currents to forces, axis by axis."""

from collections.abc import Callable, Iterator
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
from autodb.cli._reader import for_reader, in_english, shown_again, table_number
from autodb.cli.understand.fitting import AskedBare, AskedRecordings, level_command, train_command
from autodb.wording import listed, localized, phrase, phrase_many, shop_amount

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
Bare = Annotated[
    list[Path] | None,
    typer.Option(
        "--bare",
        metavar="FILE",
        readable=False,
        help="With --table: moves without the work, which separate the sensor's gain from the "
        "mass; needs --work-mass.",
    ),
]
WorkMass = Annotated[
    float | None,
    typer.Option("--work-mass", metavar="KG", help="What the work weighs that --bare is without."),
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
    bare: Bare = None,
    work_mass: WorkMass = None,
    db: Database = None,
) -> None:
    """Fit current to force per axis, tested on held-out groups; a rule decides if it is usable."""
    of_work = AskedBare(bare or [], work_mass)
    _refuse_half(of_work, of_table=of_table)
    if network or of_table:
        asked = AskedRecordings(recordings or [], machine, columns, db)
        _refuse_both(asked, network, of_table, with_cuts=bool(protocol or card))
        with in_english():
            if network:
                train_command(asked)
            else:
                level_command(asked, of_work)
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
    tell = for_reader(complain if json else say)
    with in_english():
        done = _calibrated(asked, chosen, tell, update=update)
        moved = moved_over(done, chosen)
    if json:
        from autodb.library.answers import CalibrateResult

        with in_english():
            say_json(CalibrateResult(done, machine or "", chosen).to_dict())
    else:
        _say_calibrated(done, moved, stored=machine is not None)
    if card is not None:
        title = machine or ", ".join(name for name, _ in done.sources)
        with working(f"writing {card.name}") as progress:
            progress("estimating cuts without their groups")
            shown = card_of_calibrations(done, title=title, protocol=chosen, moved=moved)
            write_card(shown, card, self_contained=self_contained)
        tell(phrase("card: {file}", file=card))


def _check(
    asked: AskedRecordings, card: Path | None, *, update: bool, self_contained: bool
) -> None:
    """Raise UnusableInput for what cannot be calibrated, or written, before anything is stored."""
    from autodb.errors import UnusableInput
    from autodb.reports.card.files import check_card_target

    if not asked.files and asked.machine is None:
        raise UnusableInput(phrase("give a cut table, or --machine NAME to use its imported cuts"))
    if update and (asked.machine is None or not asked.files):
        raise UnusableInput(phrase("--update needs --machine NAME and recordings to add"))
    if card is not None:
        check_card_target(card, self_contained=self_contained)
    elif self_contained:
        raise UnusableInput(phrase("--self-contained goes with --card FILE.html"))


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
            _say_of_axis(one, shown_again(sentence))
    for sentence in done.left_out:
        say(phrase("excluded: {what}", what=shown_again(sentence)))
    if not stored:
        say(phrase("not stored: give --machine NAME to keep it"))
    elif not any(done.new):
        say(phrase("already there: the same cuts gave the same equations"))


def _say_of_axis(one: "Calibration", said: str) -> None:
    say(phrase("axis {axis}: {said}", axis=one.called_words, said=said))


def _refuse_both(asked: AskedRecordings, network: bool, of_table: bool, *, with_cuts: bool) -> None:
    from autodb.errors import UnusableInput

    option = "--network" if network else "--table"
    if network and of_table:
        raise UnusableInput(phrase("--network and --table: use one at a time"))
    if asked.machine is None or not asked.files:
        raise UnusableInput(
            phrase("{option} needs --machine NAME and recordings over time", option=option)
        )
    if with_cuts:
        raise UnusableInput(
            phrase("--protocol and --card go with cuts, not with {option}", option=option)
        )


def _refuse_half(bare: AskedBare, *, of_table: bool) -> None:
    from autodb.errors import UnusableInput

    if bool(bare.files) != (bare.work_kg is not None) or (bare.files and not of_table):
        raise UnusableInput(phrase("--bare FILE and --work-mass KG go together, with --table"))


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
    """Print a table of calibrations, and below it what is known of each."""
    rows = table(
        phrase("Calibration"),
        *(phrase("axis"), phrase("force"), phrase("equation"), ">RMSE", ">R² (95 %)", ""),
    )
    for c in done:
        s = c.scores
        ends = (s.r_squared_low, s.r_squared_high)
        low, high = (localized(f"{end:.3f}") for end in ends)
        r_squared = localized(f"{s.r_squared:.3f}")
        rows.add_row(
            c.called_words,
            f"force.{c.component}",
            c.form.equation(c.coefficients, c.unit, c.current_unit),
            _error(c, s.rmse),
            phrase("{value} ({low} to {high})", value=r_squared, low=low, high=high),
            phrase("usable") if c.offered else phrase("not usable"),
        )
    show(rows)
    for c in done:
        for sentence in _of_calibration(c):
            _say_of_axis(c, sentence)


def _error(c: "Calibration", rmse: float) -> str:
    return f"{table_number(rmse, c.unit, 1)} {shop_amount(1.0, c.unit)[1]}"


def _of_calibration(c: "Calibration") -> Iterator[str]:
    """Yield what is known of a calibration: its cuts, its form, its range, and what to look at."""
    from autodb.sensing.ranges.outliers import outlier_sentences

    s = c.scores
    yield phrase_many(
        "I = {channel}; {cuts} cuts, scored on {count} held-out group ({group})",
        "I = {channel}; {cuts} cuts, scored on {count} held-out groups ({group})",
        s.groups,
        channel=c.channel,
        cuts=s.n,
        group=shown_again(s.grouped_by),
    )
    yield phrase("RMSE {forms}", forms=c.trials_words())
    if c.domain is not None:
        ranges = listed(map(shown_again, c.domain.each(c.unit, c.current_unit)))
        yield phrase("calibrated range: {what}", what=ranges)
    for form in c.close:
        yield phrase("{form} is nearly as good a form", form=shown_again(form))
    if not c.offered:
        yield shown_again(c.verdict)
    yield from outlier_sentences(c.outliers)
    if c.transients:
        yield phrase_many(
            "{count} transient row excluded (cut {cuts}): the current jumps, the force does not. "
            "With it: RMSE {rmse}, R² {r_squared}",
            "{count} transient rows excluded (cut {cuts}): the current jumps, the force does not. "
            "With them: RMSE {rmse}, R² {r_squared}",
            len(c.transients),
            cuts=", ".join(f"{cut:g}" for cut in c.transients),
            rmse=_error(c, c.scores_with_transients.rmse),
            r_squared=localized(f"{c.scores_with_transients.r_squared:.3f}"),
        )
