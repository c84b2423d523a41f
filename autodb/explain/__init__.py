"""Explain: what did the simulation leave out, where, and how does the fit improve?"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from autodb.errors import UnusableInput, first_names, near_words
from autodb.explain.answer import ChannelAnswer, ChannelTrace, Explained, Explanation
from autodb.files.channels import FORCES, axis_of, effort_channels, place_channel
from autodb.records.tables import CutTable, Recording
from autodb.records.timed import rows_of_file
from autodb.terms.vocabulary import vocabulary
from autodb.wording import localized, phrase, stored_msgid

if TYPE_CHECKING:
    from autodb.explain.long_recordings import LongRecording

Array = NDArray[np.float64]
Includes = list[str] | dict[str, dict[str, Array]] | None
"""Names of terms, or by channel the terms with what each contributes, (n,)."""
NOT_IN_RECORDING = stored_msgid("{file}: '{name}' is not in the recording, ignored")
DERIVED = stored_msgid(
    "{names} derived from {source}: 4th-order Butterworth at {cutoff} forwards and backwards, "
    "central differences"
)
DERIVED_LOWERED = stored_msgid(
    "{names} derived from {source}: 4th-order Butterworth at {cutoff} ({why}) forwards and "
    "backwards, central differences"
)
UNSEEN = stored_msgid(
    "{names} are not looked for: rows written on change do not show when a motion begins and ends; "
    "record {place} on every row, or {velocity} besides"
)
UNREAD = stored_msgid("{file}: not read, no channel names it: {names}")

__all__ = ["Explained", "explain"]


def explain(
    recording: Recording | CutTable,
    simulation: Recording | CutTable,
    *,
    includes: Includes = None,
) -> Explained:
    """Explain every effort or force channel that both the recording and the simulation have.

    ``includes``: the terms the simulation already has, of all channels; or, where its parts are
    known, what each contributes at every row of it, by channel and term. Without it they are read
    off.

    Raises UnusableInput when times or cut numbers differ, a name is not in the vocabulary, or no
    channel can be explained.
    """
    names = sorted(set().union(*includes.values())) if isinstance(includes, dict) else includes
    _check_names(names)
    order = _rows(recording, simulation)
    notes = [
        NOT_IN_RECORDING.format(file=simulation.path, name=name)
        for name in simulation.channels
        if name not in recording and name not in ("t", "cut")
    ]
    notes += [
        f"{message} Ignored." for name, message in recording.unusable.items() if name in simulation
    ]
    notes += [_unread(one) for one in (recording, simulation) if one.ignored]
    shared = [n for n in recording.channels if n in simulation]
    if isinstance(recording, Recording) and not recording.timing.is_even:
        notes.append(f"{recording.path}: t: {recording.timing}")
    if isinstance(recording, CutTable):
        found, lacks = _cuts(recording, simulation, shared, order, names)
        notes += lacks
    else:
        rows = _rows_over_time(recording, shared, order)
        found = _over_time(recording, simulation, shared, rows, includes)
        notes += [] if rows.long is None else [rows.long.note]
        for channel in effort_channels(list(found)):
            notes += _derived(rows, axis_of(channel), found[channel][1])
            notes += _unseen(recording, axis_of(channel))
            notes += [remark] if (remark := found[channel][1].remark) else []
    explanation = Explanation(
        recording=str(recording.path), channels={n: answer for n, (answer, _) in found.items()}
    )
    traces = {name: trace for name, (_, trace) in found.items()}
    if isinstance(recording, CutTable):
        written = {"cut": recording.cut, **{n: trace.corrected for n, trace in traces.items()}}
    else:
        written = _at_rows(recording, simulation, rows.at_every_row(traces, simulation))
    return Explained(explanation, traces, tuple(notes), written)


def _at_rows(
    recording: Recording, simulation: Recording | CutTable, traces: dict[str, ChannelTrace]
) -> dict[str, Array]:
    """Return each corrected channel at every row of the file: its simulation, as it is there, and
    the correction.
    """
    written = {"t": recording.written["t"]}
    for name, trace in traces.items():
        if recording.timing.layout is None:
            written[name] = trace.corrected
            continue
        own = _as_written(recording, simulation, name)
        if own is None:
            written[name] = rows_of_file(recording, trace.corrected)
        else:
            correction = trace.corrected - trace.simulation
            written[name] = own + rows_of_file(recording, correction, np.zeros_like(own))
    return written


def _as_written(recording: Recording, simulation: Recording | CutTable, name: str) -> Array | None:
    """Return a simulated channel at the rows of the recording's file; None where it has others."""
    if not isinstance(simulation, Recording) or simulation.as_written is None:
        return None
    theirs = simulation.as_written
    same = np.array_equal(theirs["t"], recording.written["t"], equal_nan=True)
    return theirs.get(name) if same else None


@dataclass(frozen=True)
class _Rows:
    """Which rows of a simulation are a recording's, and what its drive efforts are searched in."""

    recording: Recording
    order: NDArray[np.intp]
    long: "LongRecording | None"

    @property
    def searched(self) -> Recording:
        """The recording, or means of its rows where it is long."""
        return self.recording if self.long is None else self.long.means

    def of(self, simulated: Array) -> Array:
        """Return simulated values where they are searched in."""
        values = simulated[self.order]
        return values if self.long is None else self.long.rate.reduced(values)

    def at_every_row(
        self, traces: dict[str, ChannelTrace], simulation: Recording | CutTable
    ) -> dict[str, ChannelTrace]:
        """Return traces that have their correction at each row of the recording."""
        if self.long is None:
            return traces
        found = dict(traces)
        for name in effort_channels(list(traces)):
            one, simulated = traces[name], simulation[name][self.order]
            correction = self.long.at_every_row(one.corrected - one.simulation)
            found[name] = replace(one, simulation=simulated, corrected=simulated + correction)
        return found


def _rows_over_time(recording: Recording, shared: list[str], order: NDArray[np.intp]) -> _Rows:
    """Return how a recording over time is searched."""
    from autodb.explain.long_recordings import long_recording

    efforts = effort_channels(shared)
    return _Rows(recording, order, long_recording(recording, efforts) if efforts else None)


def _derived(rows: _Rows, axis: str, trace: ChannelTrace) -> list[str]:
    """Say what of an axis' motion was derived, from what, and with which filter."""
    from autodb.sensing.drives.moves.motion import DROWNED, protocol_of

    recording = rows.recording
    names = [f"{axis}.{what}" for what in ("velocity", "acceleration")]
    missing = [name for name in names if name not in recording]
    if not missing:
        return []
    source = place_channel(axis) if names[0] in missing else names[0]
    if rows.long is not None:
        protocol = rows.long.derived_with[axis]
    else:
        protocol = protocol_of(recording, axis, noise_share=DROWNED)
    if trace.cutoff_hz is not None and trace.lowered:
        protocol = replace(protocol, cutoff_hz=trace.cutoff_hz, lowered=f" ({trace.lowered})")
    derived, cutoff = " and ".join(missing), f"{protocol.cutoff_hz:g} Hz"
    why = protocol.lowered.removeprefix(" (").removesuffix(")")
    said = DERIVED_LOWERED if why else DERIVED
    return [said.format(names=derived, source=source, cutoff=cutoff, why=why)]


def _unseen(recording: Recording, axis: str) -> list[str]:
    """Say which terms were not looked for, since rows written on change cannot show them."""
    from autodb.explain.axis.look import unseen_terms

    names = sorted(unseen_terms(recording, axis))
    if not names:
        return []
    every = place_channel(axis)
    return [UNSEEN.format(names=", ".join(names), place=every, velocity=f"{axis}.velocity")]


def _check_names(includes: list[str] | None) -> None:
    for name in includes or ():
        if name not in (known := vocabulary()):
            raise UnusableInput(
                phrase(
                    "--includes: '{name}' is no term{hint}",
                    name=name,
                    hint=near_words(name, sorted(known)),
                )
            )


def _rows(recording: Recording | CutTable, simulation: Recording | CutTable) -> NDArray[np.intp]:
    """Return the simulation's row of each of the recording's rows."""
    key = "cut" if isinstance(recording, CutTable) else "t"
    if key not in simulation:
        raise UnusableInput(
            phrase(
                "{file}: no column '{key}', the recording has one", file=simulation.path, key=key
            )
        )
    ours, theirs = recording[key], simulation[key]
    place = np.minimum(np.searchsorted(theirs, ours), len(theirs) - 1)
    if key == "t":
        before = np.maximum(place - 1, 0)
        place = np.where(
            np.abs(theirs[before] - ours) < np.abs(theirs[place] - ours), before, place
        )
        allowed = 0.25 * float(np.median(np.diff(ours)))
    else:
        order = np.argsort(theirs)
        place = order[np.minimum(np.searchsorted(theirs[order], ours), len(theirs) - 1)]
        allowed = 0.0
    off = np.flatnonzero(np.abs(theirs[place] - ours) > allowed)
    if off.size:
        raise UnusableInput(
            phrase(
                "{file}: nothing at {key} = {ours} (row {off} of the recording); use the same "
                "'{key}' as the recording",
                file=simulation.path,
                key=key,
                ours=localized(f"{ours[off[0]]:g}"),
                off=off[0] + 1,
            )
        )
    return np.asarray(place, dtype=np.intp)


def _over_time(
    recording: Recording,
    simulation: Recording | CutTable,
    shared: list[str],
    rows: _Rows,
    includes: Includes,
) -> dict[str, tuple[ChannelAnswer, ChannelTrace]]:
    """Explain drive efforts each by itself, and the force components together."""
    efforts, forces = effort_channels(shared), [name for name in FORCES if name in shared]
    missing = [name for name in simulation.channels if name not in shared]
    wanted = [*effort_channels(missing), *(name for name in FORCES if name in missing)]
    if not efforts and not forces and wanted:
        raise _lacking(recording, wanted[0])
    if not efforts and not forces:
        raise UnusableInput(
            phrase(
                "{file}: no drive effort or force in common with the recording ({shared}); use an "
                "axis current, or force.x",
                file=simulation.path,
                shared=", ".join(shared) or phrase("nothing"),
            )
        )
    found = _axes(rows, simulation, efforts, includes) if efforts else {}
    if forces:
        from autodb.explain.waves.answers import explain_waves

        parts = {n: simulation[n][rows.order] for n in forces}
        names = sorted(set().union(*includes.values())) if isinstance(includes, dict) else includes
        found |= explain_waves(recording, parts, names)
    return found


def _lacking(recording: Recording | CutTable, wanted: str) -> UnusableInput:
    """Return the refusal of a recording without a channel that the simulation has."""
    return UnusableInput(
        phrase(
            "{file}: no channel '{wanted}', which the simulation has{hint}",
            file=recording.path,
            wanted=wanted,
            hint=recording.near(wanted),
        )
    )


def _unread(table: Recording | CutTable) -> str:
    """Say which columns of a file are no channel, the first few: one may be misspelt."""
    return UNREAD.format(file=table.path, names=first_names(table.ignored))


def _axes(
    rows: _Rows, simulation: Recording | CutTable, efforts: list[str], includes: Includes
) -> dict[str, tuple[ChannelAnswer, ChannelTrace]]:
    from autodb.explain.axis.look import explain_axis

    recording = rows.searched
    if not isinstance(includes, dict):
        return {n: explain_axis(recording, rows.of(simulation[n]), n, includes) for n in efforts}
    parts = {n: {term: rows.of(part) for term, part in includes[n].items()} for n in efforts}
    return {
        n: explain_axis(recording, rows.of(simulation[n]), n, list(parts[n]), parts[n])
        for n in efforts
    }


def _cuts(
    recording: CutTable,
    simulation: Recording | CutTable,
    shared: list[str],
    order: NDArray[np.intp],
    includes: list[str] | None,
) -> tuple[dict[str, tuple[ChannelAnswer, ChannelTrace]], list[str]]:
    """Explain the forces of cuts in the order in which they were made; with lines about what some
    cut lacks.
    """
    from autodb.explain.cuts.rows import (
        complete,
        in_table_order,
        lacking,
        made_in_order,
        rows_of_table,
    )

    simulated = {name: simulation[name][order] for name in FORCES if name in shared}
    forces = complete(recording, simulated)
    wanted = [name for name in FORCES if name in simulation and name not in shared]
    if not forces and wanted:
        raise _lacking(recording, wanted[0])
    if not forces:
        raise UnusableInput(
            phrase(
                "{file}: no force.x, force.y or force.z that the recording has in every cut",
                file=simulation.path,
            )
        )
    from autodb.explain.cuts.answers import explain_cuts

    rows = made_in_order(recording)
    parts = {name: force[rows] for name, force in forces.items()}
    found = explain_cuts(rows_of_table(recording, rows), parts, includes)
    back = {name: (said, in_table_order(trace, rows)) for name, (said, trace) in found.items()}
    return back, list(lacking(recording, simulated))
