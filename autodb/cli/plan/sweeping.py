"""`sweep`: the NC program of the moves that an axis is identified from."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import Database, opened_store, say, show, table
from autodb.cli._reader import headed
from autodb.cli.plan.standard import WRITTEN
from autodb.wording import localized, phrase

if TYPE_CHECKING:
    from autodb.files.machine import MachineFile
    from autodb.sensing.drives.reconstruct import DriveModel
    from autodb.sensing.drives.sweep import Design

AxisName = Annotated[str, typer.Option("--axis", help="The axis that moves: x, y or z.")]
Dialect = Annotated[
    str, typer.Option("--dialect", help="Words of which control: fanuc or siemens.")
]
Owner = Annotated[
    str | None, typer.Option("--machine", help="Machine of the database: its limits and models.")
]
MachineFileOption = Annotated[
    Path | None,
    typer.Option("--machine-file", readable=False, metavar="FILE", help="Machine file (TOML)."),
]
Park = Annotated[
    str | None,
    typer.Option(
        "--park",
        metavar="AXIS=MM,…",
        help="Where the other axes stand meanwhile, in their travel [default: setup.retract].",
    ),
]
Safe = Annotated[
    float | None,
    typer.Option("--safe", metavar="MM", help="Lowest safe place of an axis that bears weight."),
]
Between = Annotated[
    tuple[float, float] | None,
    typer.Option("--between", metavar="LOW HIGH", help="Stretch of the travel to stay in, mm."),
]
Within = Annotated[
    float | None,
    typer.Option(
        "--within",
        metavar="PERCENT",
        min=0.01,
        help="Make it just long enough to know each term to ± PERCENT (95 %), by the axis' model.",
    ),
]
Minutes = Annotated[
    float, typer.Option("--minutes", min=0.1, help="Longest that --within may take.")
]
Out = Annotated[
    Path | None, typer.Option("--out", metavar="FILE", help="File to write [default: printed].")
]


def sweep(
    axis: AxisName,
    dialect: Dialect,
    machine: Owner = None,
    machine_file: MachineFileOption = None,
    park: Park = None,
    safe: Safe = None,
    between: Between = None,
    within: Within = None,
    minutes: Minutes = 30.0,
    out: Out = None,
    db: Database = None,
) -> None:
    """Make the NC program of the moves in air that an axis is identified from.

    One axis moves, the others are parked, the spindle is off. It is not proven on your machine.
    """
    from autodb.agent.sense.sweeping import plan_sweep, program_of
    from autodb.nc.sweep import sweep_stretch

    source, file, model = _machine(machine, machine_file, axis, db)
    on = sweep_stretch(file, axis, source=source, safe_mm=safe, between_mm=between)
    share = None if within is None else within / 100.0
    found = plan_sweep(on, model, within=share, longest_s=60.0 * minutes)
    planned = program_of(
        found, on, file, dialect=dialect, parked_mm=_parked(park, file, axis), source=source
    )
    if out is None:
        typer.echo(planned.text, nl=False)
        return
    from autodb.standard.writing import write_once

    new = write_once(planned.text, out)
    _show(found)
    said = phrase(
        "{file}: {what}, {count} passes, about {minutes} min; not proven on your machine: dry run "
        "it",
        file=out,
        what=phrase(WRITTEN[new]),
        count=len(found.passes),
        minutes=localized(f"{found.seconds / 60.0:.1f}"),
    )
    say(said)


def _machine(
    machine: str | None, machine_file: Path | None, axis: str, db: str | None
) -> "tuple[str, MachineFile, DriveModel | None]":
    """Return a name for messages, the machine's file, and the model of the axis if it has one."""
    from autodb.errors import UnusableInput
    from autodb.files.machine import read_machine_file

    if (machine is None) == (machine_file is None):
        raise UnusableInput(
            phrase("give either --machine NAME or --machine-file FILE: travel and limits")
        )
    if machine is None:
        assert machine_file is not None  # one of the two was given
        return str(machine_file), read_machine_file(machine_file), None
    from autodb.agent.sense.sweeping import machine_and_model

    with opened_store(db) as store:
        return phrase("machine '{machine}'", machine=machine), *machine_and_model(
            store, machine, axis
        )


def _parked(park: str | None, file: "MachineFile", axis: str) -> dict[str, float]:
    """Return where the other axes are parked: as given, else at the setup's retract position."""
    from autodb.errors import UnusableInput

    if park is None:
        retract = {} if file.setup is None else file.setup.retract.model_dump(exclude_none=True)
        places = {key.removesuffix("_mm"): mm for key, mm in retract.items()}
        return {name: mm for name, mm in places.items() if name != axis and name in file.axes}
    found: dict[str, float] = {}
    for part in park.split(","):
        name, _, mm = part.partition("=")
        try:
            found[name.strip()] = float(mm)
        except ValueError:
            raise UnusableInput(
                phrase("--park: '{part}' is not AXIS=MM; write x=150,z=300", part=part)
            ) from None
    return found


def _show(found: "Design") -> None:
    if not found.reached:
        return
    rows = table(
        phrase("Half width of 95 % intervals"),
        *(phrase("parameter"), headed(phrase("expected")), headed(phrase("asked for")), ""),
    )
    for name, half, wanted in found.reached:
        verdict = "" if half <= wanted else phrase("not reached")
        rows.add_row(name, localized(f"{half:.3g}"), localized(f"{wanted:.3g}"), verdict)
    show(rows)
    if not found.enough:
        say(
            phrase(
                "not every precision is reached; use a longer sweep (--minutes) or a wider limit "
                "(--within)"
            )
        )
