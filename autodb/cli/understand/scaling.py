"""`scale`: what an ampere of a feed drive is, determined from a known load."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autodb.cli._common import (
    Columns,
    Database,
    Group,
    Json,
    MachineName,
    Resample,
    opened_machine,
    say,
    say_json,
    working,
)
from autodb.cli._reader import in_english, shown_again
from autodb.cli.understand.identifying import Axis
from autodb.cli.understand.over_time import moves_of
from autodb.wording import amount_words, localized, msgid, phrase

if TYPE_CHECKING:
    from collections.abc import Callable

    from autodb.agent.sense.reconstructing import Scale
    from autodb.agent.sense.scaling import DeterminedScale
    from autodb.records.tables import Recording as Moves
    from autodb.standard import ReferenceForce
    from autodb.store import Store

Recording = Annotated[
    Path, typer.Argument(readable=False, help="A recording of the axis under a known load.")
]
AddedMass = Annotated[
    float | None,
    typer.Option(
        "--added-mass", metavar="KG", min=0.001, help="The moves were made with so much clamped on."
    ),
]
StandardCut = Annotated[
    str | None,
    typer.Option(
        "--standard-cut",
        metavar="PROTOCOL:CUT",
        help="It is this standard cut, which begins in air: turning-aluminium:published.",
    ),
]

AGREES = msgid("{axis}: the machine's file agrees: {constant} by {source}")
DISAGREES = msgid("{axis}: the machine's file does not agree: {constant} by {source}")
KEPT = msgid("{axis}: scale {version} of machine '{machine}'; 'autodb reconstruct' uses it")
ALREADY = msgid(
    "{axis}: scale {version} of machine '{machine}', already there; 'autodb reconstruct' uses it"
)
APART_SDS = 2.6
"""Standard deviations by which two scales differ by chance in 1 of 100."""


def scale(
    recording: Recording,
    machine: MachineName = None,
    axis: Axis = None,
    added_mass: AddedMass = None,
    standard_cut: StandardCut = None,
    columns: Columns = None,
    group: Group = None,
    resample: Resample = None,
    json: Json = False,
    db: Database = None,
) -> None:
    """Determine the force constant (N/A) from a known mass, a measured push or a standard cut."""
    from autodb.agent.sense import scaling
    from autodb.errors import UnusableInput

    if added_mass is not None and standard_cut is not None:
        raise UnusableInput(phrase("give --added-mass or --standard-cut, not both"))
    known = _cut_named(standard_cut) if standard_cut else None
    with (
        in_english(),  # the source of what is found is kept
        opened_machine(db, machine) as (store, name),
        working(f"scaling by {recording.name}") as progress,
    ):
        loaded = moves_of(recording, axis, columns, group, resample)
        if added_mass is not None:
            found = scaling.by_mass(
                store, name, loaded, mass_kg=added_mass, axis=axis, progress=progress
            )
        else:
            found = _by_force(store, name, loaded, axis, standard_cut, known)
        stated = scaling.stated(store, name, found.axis)
        kept = scaling.keep_scale(store, name, found, recording, columns=columns)
        if json:
            stored = {"version": kept.version, "already_there": kept.already_there}
            say_json({**asdict(found), "percent": found.percent, **stored})
            return
    said = phrase(
        "{axis}: force constant {constant} ± {percent} % (95 %), by {source}",
        axis=found.axis, constant=amount_words(found.newtons_per_ampere, "N/A", ".4g"),
        percent=localized(f"{found.percent:.2g}"), source=shown_again(found.source)
    )  # fmt: skip
    say(said)
    _compare(found, stated)
    sentence = ALREADY if kept.already_there else KEPT
    say(phrase(sentence, axis=found.axis, version=kept.version, machine=name))


def _by_force(
    store: "Store",
    machine: str,
    loaded: "Moves",
    axis: str | None,
    name: str | None,
    known: "Callable[[str], ReferenceForce] | None",
) -> "DeterminedScale":
    from autodb.agent.sense import scaling

    if name is None or known is None:
        return scaling.by_measured_force(store, machine, loaded, axis=axis)
    return scaling.by_standard_cut(store, machine, loaded, known, name=name, axis=axis)


def _cut_named(words: str) -> "Callable[[str], ReferenceForce]":
    """Return the reference of `PROTOCOL:CUT` by axis; raises UnusableInput for what it lacks."""
    from autodb.errors import UnusableInput, near_words
    from autodb.standard import read_protocol

    protocol_name, _, cut_name = words.rpartition(":")
    if not protocol_name:
        raise UnusableInput(
            phrase("--standard-cut: '{words}' names no cut; write '{words}:CUT'", words=words)
        )
    protocol = read_protocol(protocol_name)
    cuts = {cut.name: cut for cut in protocol.cut}
    if cut_name not in cuts:
        raise UnusableInput(
            phrase(
                "--standard-cut: protocol '{protocol}' has no cut '{cut_name}'{hint}",
                protocol=protocol.name,
                cut_name=cut_name,
                hint=near_words(cut_name, list(cuts)),
            )
        )
    references = cuts[cut_name].reference

    def of(axis: str) -> "ReferenceForce":
        if axis not in references:
            has = ", ".join(references) or phrase("none yet")
            raise UnusableInput(
                phrase(
                    "--standard-cut: '{cut_name}' has no reference force of {axis}; it has: {has}",
                    cut_name=cut_name,
                    axis=axis,
                    has=has,
                )
            )
        return references[axis]

    return of


def _compare(found: "DeterminedScale", stated: "Scale | None") -> None:
    """Say whether the machine's file is borne out."""
    if stated is None:
        return
    off = found.newtons_per_ampere - stated.per_ampere
    sd = float(
        (
            (found.share * found.newtons_per_ampere) ** 2 + (stated.share * stated.per_ampere) ** 2
        ) ** 0.5
    )  # fmt: skip
    said = phrase(
        AGREES if abs(off) < APART_SDS * sd else DISAGREES,
        axis=found.axis, constant=amount_words(stated.per_ampere, "N/A", ".4g"),
        source=shown_again(stated.source)
    )  # fmt: skip
    say(said)
