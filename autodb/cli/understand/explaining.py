"""`explain`: what simulations of recordings leave out, one by one and together."""

from collections.abc import Callable
from dataclasses import dataclass
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
    default_machine,
    opened_store,
    read_one,
    say,
    working,
)
from autodb.cli._reader import in_english, shown_again
from autodb.wording import localized, phrase, shop_amount, significant

if TYPE_CHECKING:
    from autodb.agent.answer.explaining import AgainstMachine, KeptCause, Key
    from autodb.explain import Explained
    from autodb.explain.answer import ChannelAnswer, ChannelTrace
    from autodb.explain.several_recordings import RecordingSetup
    from autodb.records.tables import CutTable, Recording

RecordingFiles = Annotated[
    list[Path],
    typer.Argument(
        readable=False, help="The recording or cut table; several are explained together too."
    ),
]
Simulations = Annotated[
    list[Path] | None,
    typer.Option(
        "--simulation",
        readable=False,
        help="File with the same t or cut and its channels; once for each recording, in order.",
    ),
]
Includes = Annotated[
    str | None,
    typer.Option("--includes", help="Terms that the simulation already has, with commas between."),
]
ModelOf = Annotated[
    str | None,
    typer.Option(
        "--machine", help="Use this machine's own stored models [default: of the only one]"
    ),
]
OutFolder = Annotated[
    Path | None,
    typer.Option(
        "--out", help="Folder for the answer [default: ./NAME-explained, of several ./together]."
    ),
]


def explain_command(
    recordings: RecordingFiles,
    simulation: Simulations = None,
    includes: Includes = None,
    machine: ModelOf = None,
    columns: Columns = None,
    group: Group = None,
    resample: Resample = None,
    out: OutFolder = None,
    self_contained: SelfContained = False,
    json: Json = False,
    db: Database = None,
) -> None:
    """Say what a simulation of a recording leaves out, where, and how the fit improves.

    Of several recordings it also says whether the cause lies in machine, tool, material, sensor or
    calibration.
    """
    if simulation is None and machine is None:
        machine = default_machine(db)
    _check(recordings, simulation, includes, machine, group, resample)

    def one(number: int) -> "Looked":
        if simulation is not None:
            measured = read_one(
                recordings[number], columns=columns, group=group, resample_hz=resample
            )
            simulated = read_one(
                simulation[number], columns=None, group=group, resample_hz=resample, like=measured
            )
            with in_english():
                explained = _against_file(measured, simulated, includes)
            _say_doubts(measured)
            return _setup(measured, None), explained, {}
        with in_english():
            answer = _against_machine(str(machine), recordings[number], columns, db)
        measured = read_one(recordings[number], columns=columns, group=None, resample_hz=None)
        return _setup(measured, machine), answer.explained, answer.kept

    with working("explaining") as progress:
        if len(recordings) > 1:
            target = _Target(out or Path("together"), self_contained, json)
            _several(recordings, one, target, progress=progress)
        else:
            folder = out or Path(f"{recordings[0].stem}-explained")
            target = _Target(folder, self_contained, json)
            _alone(recordings[0], one, target, progress=progress)


Looked = tuple["RecordingSetup", "Explained", "dict[Key, KeptCause]"]
Look = Callable[[int], Looked]
Step = Callable[[str], None]


@dataclass(frozen=True)
class _Target:
    """Where an answer goes: a folder, whose pages may be self-contained; printed as JSON or not."""

    folder: Path
    self_contained: bool
    json: bool


def _check(
    recordings: list[Path], simulation: list[Path] | None, includes: str | None,
    machine: str | None, group: str | None, resample: float | None,
) -> None:  # fmt: skip
    from autodb.errors import UnusableInput

    if (simulation is None) == (machine is None):
        raise UnusableInput(phrase("give either --simulation FILE or --machine NAME"))
    if machine is not None and (group is not None or resample is not None):
        raise UnusableInput(phrase("--group and --resample go with --simulation"))
    if machine is not None and includes is not None:
        raise UnusableInput(
            phrase("--includes goes with --simulation: a stored model says what it has")
        )
    if simulation is not None and len(simulation) != len(recordings):
        raise UnusableInput(
            phrase(
                "{n} recordings and {n_2} simulations: give --simulation once for each "
                "recording, in their order",
                n=len(recordings),
                n_2=len(simulation),
            )
        )


def _alone(recording: Path, look: Look, target: _Target, *, progress: Step) -> None:
    from autodb.reports.explanation_files import check_folder, write_answer

    folder = target.folder
    check_folder(folder)
    progress(recording.name)
    _, explained, kept = look(0)
    progress("writing the report")
    write_answer(explained, folder, self_contained=target.self_contained)
    for note in explained.notes:
        typer.echo(shown_again(note), err=True)
    if target.json:
        say((folder / "explanation.json").read_text(encoding="utf-8").rstrip())
        return
    _say_causes(explained, kept)
    say(phrase("report: {file}", file=folder / "report.html"))
    if any(cause.status == "open" for cause in kept.values()):
        say(
            phrase(
                "confirm a cause that holds with 'autodb mismatch confirm NUMBER', or reject it "
                "with 'autodb mismatch reject NUMBER'"
            )
        )


def _several(recordings: list[Path], look: Look, target: _Target, *, progress: Step) -> None:
    from autodb.explain.several_recordings import explain_together
    from autodb.reports.explanation_files import check_folder, write_together

    folder = target.folder
    check_folder(folder, several=True)
    explained_all = []
    for number, recording in enumerate(recordings):
        progress(f"{recording.name}, {number + 1} of {len(recordings)}")
        explained_all.append(look(number))
    found = explain_together(
        [setup for setup, _, _ in explained_all],
        [explained.explanation.channels for _, explained, _ in explained_all],
    )
    progress("writing the reports")
    alone = [explained for _, explained, _ in explained_all]
    write_together(alone, found, folder, self_contained=target.self_contained)
    for explained in alone:
        for note in explained.notes:
            typer.echo(shown_again(note), err=True)
    if target.json:
        say((folder / "together.json").read_text(encoding="utf-8").rstrip())
        return
    for recording, (_, explained, kept) in zip(recordings, explained_all, strict=True):
        say(f"{recording}:")
        _say_causes(explained, kept)
    say(phrase("together:"))
    for effect in found.effects:
        say(f"  {shown_again(effect.statement)}")
        if effect.to_tell_apart:
            say(f"  {shown_again(effect.to_tell_apart)}")
    if not found.effects:
        nothing = phrase("no mismatch beyond noise in any of them")
        say(f"  {nothing}")
    say(phrase("report: {file}", file=folder / "together.html"))


def _setup(measured: "Recording | CutTable", machine: str | None) -> "RecordingSetup":
    from autodb.explain.several_recordings import setup_of

    setup = setup_of(measured)
    return setup if machine is None else setup.model_copy(update={"machine": machine})


def _say_doubts(measured: "Recording | CutTable") -> None:
    """Say what looks like a wrong unit or a clipped sensor; it is explained all the same."""
    from autodb.records.plausible import doubts
    from autodb.records.summary import summary_of

    for doubt in doubts(summary_of(measured), measured.side):
        said = phrase("doubtful: {file}: {what}", file=measured.path, what=shown_again(doubt))
        typer.echo(said, err=True)


def _against_file(
    measured: "Recording | CutTable", simulated: "Recording | CutTable", includes: str | None
) -> "Explained":
    from autodb.explain import explain

    names = None if includes is None else [n.strip() for n in includes.split(",") if n.strip()]
    return explain(measured, simulated, includes=names)


def _against_machine(
    machine: str, recording: Path, columns: Path | None, db: str | None
) -> "AgainstMachine":
    from autodb.agent.answer.explaining import explain_with_machine

    with opened_store(db) as store:
        return explain_with_machine(store, machine, recording, columns=columns)


def _say_causes(explained: "Explained", kept: "dict[Key, KeptCause]") -> None:
    """Print of each channel what its simulation leaves out, and what to check on the machine."""
    from autodb.terms.vocabulary import effect_called

    for channel, answer in explained.explanation.channels.items():
        if answer.mismatch:
            _say_mismatch(channel, answer, explained.traces.get(channel), kept)
            continue
        rms = f"{_size(answer.fit.rms_before, answer)} {shop_amount(1.0, answer.unit)[1]}"
        say(phrase("{channel}: no mismatch beyond noise (rms {size})", channel=channel, size=rms))
    answers = explained.explanation.channels.values()
    for term in dict.fromkeys(cause.term for answer in answers for cause in answer.missing):
        say(f"{term}: {shown_again(effect_called(term).check)}")


def _say_mismatch(
    channel: str,
    answer: "ChannelAnswer",
    trace: "ChannelTrace | None",
    kept: "dict[Key, KeptCause]",
) -> None:
    from autodb.reports.explanation import headline, open_words, smaller_words, statement_words

    fit = answer.fit
    said = phrase(
        "{channel}: held-out error {before} → {after} {unit} (noise {noise})",
        channel=channel,
        before=_size(fit.heldout_before, answer),
        after=_size(fit.heldout_after, answer),
        unit=shop_amount(1.0, answer.unit)[1],
        noise=_size(fit.noise_floor, answer),
    )
    say(said)
    say(f"  {' '.join(filter(None, (headline(answer, trace), smaller_words(answer, trace))))}")
    for cause in answer.missing:
        row = kept.get((channel, cause.term, cause.kind))
        name = phrase(
            "{term} ({kind}, {percent} % sure)",
            term=cause.term,
            kind=phrase(cause.kind),
            percent=f"{100 * cause.confidence:.0f}",
        )
        stated = " ".join(map(shown_again, statement_words(cause.statement)))
        say(f"  {_numbered(row)}{name}: {stated}")
    cannot_tell = open_words(answer, str)
    if cannot_tell:
        said = phrase("what this recording cannot tell: {said}", said=cannot_tell)
        say(f"  {said}")


def _size(value: float, answer: "ChannelAnswer") -> str:
    return localized(significant(shop_amount(value, answer.unit)[0]))


def _numbered(row: "KeptCause | None") -> str:
    """Return a mismatch' number, and its state where it is decided, before what it is."""
    if row is None:
        return ""
    said: str = phrase("mismatch {number}", number=row.number)
    if row.status != "open":
        said = f"{said}, {phrase(row.status)}"
    return f"{said}: "
