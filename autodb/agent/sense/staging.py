"""The staged routines for an axis of a machine: its signs, its screw, the joint fit beside it.

P0's four steps for a linear drive, P2's stages for a ball screw. A linear drive is an axis whose
joint model has a load over the travel, cogging or a spring, and whose machine names no screw.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from autodb.agent.ingest.as_imported import signed
from autodb.agent.rows.machines import find_machine
from autodb.agent.sense.identifying import newest_model, refuse_faults, version_names
from autodb.records.tables import Recording
from autodb.sensing.drives.fit.axis_model import Identified
from autodb.sensing.drives.moves.prepared import effort_channel, prepared
from autodb.sensing.drives.staged import agreement, agreement_linear
from autodb.sensing.drives.staged.compared import Agreement
from autodb.sensing.drives.staged.linear import FourSteps, four_steps
from autodb.sensing.drives.staged.routine import Staged, staged
from autodb.store import Store

LOADS = frozenset({"cogging", "spring"})
"""Terms of a load over the travel, which P0's steps one and two tell."""


@dataclass(frozen=True)
class StagedMoves:
    """A recording with its machine's signs; the pitch that is given, mm, of a screw or of poles;
    whether the machine names a screw; and the terms that the joint fit is asked for.
    """

    moves: Recording
    pitch_mm: float | None
    screw: bool
    asked: frozenset[str]


def drive_of(
    store: Store,
    machine: str,
    moves: Recording,
    axis: str,
    *,
    terms: Sequence[str] | None,
    pitch_mm: float | None,
) -> StagedMoves:
    """Return moves with a machine's signs; a pitch that is given counts before its screw's.

    Without ``terms`` those of its newest version are asked for.
    """
    with store.reading() as session:
        owner = find_machine(session, machine)
        own_mm = next((a.screw_pitch_mm for a in owner.axes if a.name == axis), None)
        newest = newest_model(session, owner.id, effort_channel(moves, axis))
        asked = terms or (version_names(newest) if newest else ())
        return StagedMoves(
            signed(moves, owner), pitch_mm or own_mm, own_mm is not None, frozenset(asked)
        )


@dataclass(frozen=True)
class TriedStages:
    """A recording that the stages can do with, and what they found, nothing cold."""

    drive: StagedMoves
    axis: str
    found: Staged | FourSteps


def staged_fits(drive: StagedMoves, axis: str | None) -> TriedStages:
    """Run the routine that the terms asked for call for on moves, before a joint fit is at hand.

    Raises UnusableInput where the moves show a fault, and as ``staged`` and ``four_steps`` do.
    """
    refuse_faults(drive.moves, axis)
    rows = prepared(drive.moves, axis=axis)
    if drive.screw or not drive.asked & LOADS:
        return TriedStages(drive, rows.axis, staged(rows, pitch_mm=drive.pitch_mm, cold=False))
    return TriedStages(drive, rows.axis, four_steps(rows, pole_mm=drive.pitch_mm, cold=False))


def stages_beside(model: Identified, seen: TriedStages) -> tuple[Staged | FourSteps, Agreement]:
    """Return the stages of a joint fit's moves, and how the two agree.

    Friction is that of the cold axis where the joint fit has `warmup`. The pole is the joint fit's
    where none is given.
    """
    drive = seen.drive
    rows = prepared(drive.moves, axis=seen.axis)
    names = {term.term for term in model.terms}
    cold = "warmup" in {term.term for term in model.fitted}
    if drive.screw or not names & LOADS:
        found = staged(rows, pitch_mm=drive.pitch_mm, cold=cold)
        return found, agreement.screw_agreement(found, model, rows.inputs)
    steps = four_steps(rows, pole_mm=drive.pitch_mm or pole_of(model), cold=cold)
    return steps, agreement_linear.linear_agreement(steps, model, rows.inputs)


def pole_of(model: Identified) -> float | None:
    """Return the period of a joint fit's cogging, mm, the longest; None where it has none."""
    periods = [t.value for t in model.terms if (t.term, t.parameter) == ("cogging", "period")]
    return max(periods, default=None)
