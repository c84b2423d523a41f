"""`standard`: protocols of standard cuts, their reference forces and their NC programs."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import Columns, Json, say, say_json, show, table, working
from autodb.cli._reader import headed, shown_again
from autodb.wording import localized, msgid, phrase, shop_amount

if TYPE_CHECKING:
    from autodb.standard import CutProtocol, StandardCut
    from autodb.standard.protocol import ReferenceForce

standard = typer.Typer(
    help="Standard cuts: protocols, their reference forces, and NC programs that make them.",
    no_args_is_help=True,
)

WRITTEN = {True: msgid("written"), False: msgid("already there")}
"""What became of a file, by whether it is new."""
Name = Annotated[str, typer.Argument(help="Protocol: a name from `standard list`, or a file.")]


@standard.command("list")
def list_protocols_command(json: Json = False) -> None:
    """List the protocols that ship."""
    from autodb.standard import read_protocol, shipped

    if json:
        say_json([{"name": name, **read_protocol(name).model_dump()} for name in shipped()])
        return
    rows = table(
        phrase("Standard cuts"),
        *(phrase("name"), phrase("work"), phrase("tool"), phrase("operations")),
        *(headed(phrase("cuts")), headed(phrase("with reference"))),
    )
    for name in shipped():
        protocol = read_protocol(name)
        operations = ", ".join(dict.fromkeys(cut.operation for cut in protocol.cut))
        known = sum(bool(cut.reference) for cut in protocol.cut)
        rows.add_row(
            name, protocol.material, protocol.tool, operations, str(len(protocol.cut)), str(known)
        )
    show(rows)


@standard.command("show")
def show_protocol_command(name: Name, json: Json = False) -> None:
    """Show a protocol's cuts, their reference forces, and the order in which they are made."""
    from autodb.standard import read_protocol, run_order

    protocol = read_protocol(name)
    if json:
        order = [cut.name for cut in run_order(protocol)]
        say_json({**protocol.model_dump(), "order": order})
        return
    rows = table(
        f"{protocol.name}: {protocol.material} / {protocol.tool}",
        *(phrase("cut"), phrase("operation"), headed(phrase("rpm")), headed(phrase("feed"), "mm")),
        *(headed(phrase("depth"), "mm"), headed(phrase("repeats"))),
        phrase("reference, {unit} (95 %)", unit=shop_amount(1.0, "N")[1]),
    )
    for cut in protocol.cut:
        rows.add_row(*_row(cut))
    show(rows)
    if protocol.note:
        say(protocol.note)
    without = [cut.name for cut in protocol.cut if not cut.reference]
    if without:
        say(
            phrase(
                "{count} of {all} cuts have no reference force and calibrate nothing yet; take "
                "them from a dynamometer's file with 'autodb standard new'",
                count=len(without),
                all=len(protocol.cut),
            )
        )
    say(
        phrase(
            "order, seed {seed}: {names}",
            seed=protocol.seed,
            names=", ".join(cut.name for cut in run_order(protocol)),
        )
    )


def _row(cut: "StandardCut") -> list[str]:
    from autodb.standard.protocol import PASSIVE

    feed = _amount(cut.feed_mm, "mm")
    if cut.feed_mm_tooth is not None:
        feed = phrase("{feed} a tooth", feed=feed)
    direction = cut.feed_direction_deg
    what = cut.operation if direction is None else f"{cut.operation} {localized(f'{direction:g}')}°"
    depth_mm = cut.depth_mm or cut.length_mm
    depth = "" if depth_mm is None else _amount(depth_mm, "mm")
    known = (f"{c} {_reference(r)}" for c, r in cut.reference.items())
    still = PASSIVE.get(cut.operation)
    sensed = phrase("{cut}, {axis} stands still", cut=what, axis=still) if still else what
    return [
        cut.name, sensed, localized(f"{cut.speed_rpm:g}"), feed, depth,
        str(cut.repeats), "; ".join(known) or phrase("none"),
    ]  # fmt: skip


def _reference(force: "ReferenceForce") -> str:
    value, low, high = (_amount(end, "N") for end in (force.value, force.lower, force.upper))
    return phrase("{value} ({low} to {high})", value=value, low=low, high=high)


def _amount(value: float, unit: str) -> str:
    """Return a number in the reader's units, with as few digits as it has in ours."""
    factor, shown = shop_amount(1.0, unit)
    return localized(f"{value:g}" if shown == unit else f"{factor * value:.4g}")


@standard.command("new")
def new(
    name: Annotated[str, typer.Argument(help="Name of the new protocol.")],
    files: Annotated[
        list[Path],
        typer.Argument(readable=False, help="Cut tables, or recordings of one cut, with force.*."),
    ],
    like: Annotated[
        str | None,
        typer.Option(
            "--like", help="Protocol whose cuts were made [default: the cuts that repeat]."
        ),
    ] = None,
    date: Annotated[
        str | None,
        typer.Option(
            "--date", help="Day of the measurement [default: of the first file's last change]."
        ),
    ] = None,
    columns: Columns = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE", help="File to write [default: NAME.toml]."),
    ] = None,
) -> None:
    """Write a protocol with reference forces: means of repeats that a dynamometer measured."""
    from autodb.agent.sense.measuring import new_protocol, read_measured, with_references
    from autodb.standard import read_protocol
    from autodb.standard.writing import as_toml, write_once

    with working("reading"):
        tables = [read_measured(path, columns=columns) for path in files]
    day = _day(date, files[0])
    if like is None:
        done = new_protocol(name, tables, date=day)
    else:
        asked = read_protocol(like).model_copy(update={"name": name})
        done = with_references(asked, tables, date=day)
    path = out or Path(f"{name}.toml")
    new = write_once(as_toml(done.protocol), path)
    known = sum(bool(cut.reference) for cut in done.protocol.cut)
    said = phrase(
        "{file}: {what}, {known} of {count} cuts have a reference force",
        file=path,
        what=phrase(WRITTEN[new]),
        known=known,
        count=len(done.protocol.cut),
    )
    say(said)
    for sentence in done.without:
        say(phrase("no reference: {why}", why=shown_again(sentence)))


def _day(date: str | None, file: Path) -> str:
    """Return the day that was given, or that on which the file last changed, as YYYY-MM-DD."""
    from datetime import UTC, datetime

    from autodb.errors import UnusableInput

    if date is None:
        return datetime.fromtimestamp(file.stat().st_mtime, tz=UTC).date().isoformat()
    try:
        return datetime.strptime(date, "%Y-%m-%d").replace(tzinfo=UTC).date().isoformat()
    except ValueError:
        raise UnusableInput(phrase("--date {date}: write a day as 2026-01-31", date=date)) from None


@standard.command("program")
def program_command(
    name: Name,
    machine_file: Annotated[
        Path,
        typer.Option(
            "--machine-file",
            readable=False,
            metavar="FILE",
            help="Machine file (TOML) with limits and [setup].",
        ),
    ],
    dialect: Annotated[
        str, typer.Option("--dialect", help="Words of which control: fanuc or siemens.")
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE", help="File to write [default: it is printed]."),
    ] = None,
) -> None:
    """Make the NC program of a protocol's cuts, or refuse what the machine's limits do not allow.

    It is not proven on your machine: dry run it first.
    """
    text = _program(name, machine_file, dialect)
    if out is None:
        typer.echo(text, nl=False)
        return
    from autodb.standard.writing import write_once

    new = write_once(text, out)
    said = phrase(
        "{file}: {what}, {count} lines; not proven on your machine: dry run it",
        file=out,
        what=phrase(WRITTEN[new]),
        count=len(text.splitlines()),
    )
    say(said)


def _program(name: str, machine_file: Path, dialect: str) -> str:
    from autodb.files.machine import read_machine_file
    from autodb.nc import protocol_program
    from autodb.standard import read_protocol

    protocol: CutProtocol = read_protocol(name)
    return protocol_program(
        protocol, read_machine_file(machine_file), dialect=dialect, source=str(machine_file)
    )
