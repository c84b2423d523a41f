"""The staged routine for an axis of a machine: its signs, its screw, the joint fit beside it."""

from dataclasses import dataclass

from autodb.agent.identifying import refuse_faults
from autodb.agent.machines import find_machine, signed
from autodb.records import Recording
from autodb.sensing.axis_model import Identified
from autodb.sensing.prepared import prepared
from autodb.sensing.staged.agreement import Agreement, agreement
from autodb.sensing.staged.routine import Staged, staged
from autodb.store import Store


@dataclass(frozen=True)
class Screw:
    """A recording with its machine's signs, and the pitch of the axis' screw, mm, where known."""

    moves: Recording
    pitch_mm: float | None


def screw_of(store: Store, machine: str, moves: Recording, axis: str) -> Screw:
    """Return moves with a machine's signs, and the pitch that its file gives for the axis."""
    with store.reading() as session:
        owner = find_machine(session, machine)
        pitch_mm = next((a.screw_pitch_mm for a in owner.axes if a.name == axis), None)
        return Screw(signed(moves, owner), pitch_mm)


@dataclass(frozen=True)
class Tried:
    """A recording that the stages can do with: its screw, and what they found, nothing cold."""

    screw: Screw
    axis: str
    found: Staged


def tried(screw: Screw, axis: str | None) -> Tried:
    """Run the staged routine on moves.

    Raises UnusableInput where the moves show a fault, and as ``staged`` does.
    """
    refuse_faults(screw.moves, axis)
    rows = prepared(screw.moves, axis=axis)
    return Tried(screw, rows.axis, staged(rows, pitch_mm=screw.pitch_mm, cold=False))


def beside(model: Identified, seen: Tried) -> tuple[Staged, Agreement]:
    """Return the stages of a joint fit's moves, and how the two agree.

    Friction is that of the cold axis where the joint fit has `warmup`.
    """
    rows, found = prepared(seen.screw.moves, axis=seen.axis), seen.found
    if any(term.term == "warmup" for term in model.fitted):
        found = staged(rows, pitch_mm=seen.screw.pitch_mm, cold=True)
    return found, agreement(found, model, rows.inputs)
