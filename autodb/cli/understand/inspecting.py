"""`inspect`: the passive force of a turned cut, from the finished part.

`sensors`: what a machine can sense, how well, since when.
"""

from pathlib import Path
from typing import Annotated

import typer

from autodb.cli._common import (
    Database,
    Json,
    MachineAlone,
    MachineName,
    OptionalMachine,
    complain,
    named_machine,
    opened_machine,
    opened_store,
    say,
    say_json,
    show,
    table,
)
from autodb.cli._reader import headed, in_english, shown_again
from autodb.wording import day, localized, msgid, phrase, shop_amount, significant

Part = Annotated[Path, typer.Argument(readable=False, help="A part file (TOML).")]
OfRecording = Annotated[
    Path | None,
    typer.Option(
        "--recording", readable=False, metavar="FILE", help="Imported file that the cut is in."
    ),
]
Cut = Annotated[float | None, typer.Option("--cut", metavar="NUMBER", help="Its number there.")]


KEPT = msgid("kept as force.x of cut {cut} of {file}; 'autodb refresh' learns from it")
ALREADY = msgid("already there as force.x of cut {cut} of {file}; 'autodb refresh' learns from it")


def inspect_command(
    part: Part,
    machine: OptionalMachine = None,
    recording: OfRecording = None,
    cut: Cut = None,
    json: Json = False,
    db: Database = None,
) -> None:
    """Estimate the passive force, which no current shows, from a part's diameters and stiffness.

    With --machine, --recording and --cut it is kept as that cut's force.x, which 'refresh' uses.
    """
    from autodb.agent.sense.inspecting import OfCut, inspect, keep_inspected
    from autodb.errors import UnusableInput
    from autodb.files.part import read_part
    from autodb.fitting.gaussian import NORMAL_95

    given = (machine is not None, recording is not None, cut is not None)
    if any(given) and not all(given):
        raise UnusableInput(
            phrase("--machine, --recording and --cut go together: they say which cut it is")
        )
    with in_english():  # it is kept
        file = read_part(part)
        found = inspect(file, where=str(part))
    tell = complain if json else say
    if json:
        say_json(found)
    elif found.why_not is not None:
        say(phrase("passive force: not sensed: {why}", why=shown_again(found.why_not)))
    else:
        scale, unit = shop_amount(1.0, "N")
        off, length = shop_amount(found.off_mm, "mm")
        off, length = (1e3 * off, "µm") if length == "mm" else (off, length)
        force, half = scale * found.force_N, scale * NORMAL_95 * found.sd_N
        said = phrase(
            "passive force: {force} ± {half} {unit} (95 %), outward; the radius was off by {off}",
            force=localized(f"{force:.1f}"), half=localized(f"{half:.1f}"), unit=unit,
            off=f"{localized(f'{off:.1f}' if length == 'µm' else f'{off:.2g}')} {length}"
        )  # fmt: skip
        say(said)
    if machine is None or recording is None or cut is None:
        tell(phrase("not stored: give --machine, --recording and --cut to keep it"))
        return
    with in_english(), opened_store(db) as store:
        new = keep_inspected(store, file, found, OfCut(machine, recording, cut))
    sentence = KEPT if new else ALREADY
    tell(phrase(sentence, cut=localized(f"{cut:g}"), file=recording.name))


def sensors_command(
    alone: MachineAlone = None,
    machine: MachineName = None,
    json: Json = False,
    db: Database = None,
) -> None:
    """List a machine's force sensors, the error of each, and since when they are in use."""
    from autodb.agent.sense.sensors import sensors_of

    asked = named_machine(machine, alone)
    with (
        in_english(json),
        opened_machine(db, asked) as (store, name),
        store.reading() as session,
    ):
        found, not_sensed = sensors_of(session, name)
    if json:
        say_json({"sensors": found, "not_sensed": not_sensed})
        return
    rows = table(
        phrase("Force sensors of {machine}", machine=name),
        *(phrase("force"), phrase("with"), phrase("of"), headed(phrase("version"))),
        *(headed(phrase("error")), phrase("in"), phrase("since"), ""),
    )
    for one in found:
        why = phrase("not used: {why}", why=shown_again(one.why_not)) if one.why_not else ""
        rows.add_row(
            one.force, phrase(one.kind), one.source, str(one.version), _error(one.error, one.unit),
            phrase(one.of), day(one.since[:10]), why,
        )  # fmt: skip
    if found:
        show(rows)
    if not_sensed:
        forces = ", ".join(not_sensed)
        say(phrase("{forces}: not sensed, and never taken as 0", forces=forces))


def _error(error: float | None, unit: str) -> str:
    """Return the error of a sensor in the reader's unit; empty where it is not known."""
    if error is None:
        return ""
    from autodb.agent.sense.sensors import OF_IT

    shown, name = shop_amount(error, unit)
    known = phrase(OF_IT) if unit == OF_IT else name
    return f"{localized(significant(shown))} {known}"
