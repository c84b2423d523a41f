"""Plan a sweep of an axis: a ladder of speeds, or what its newest model says is enough."""

from collections.abc import Mapping
from dataclasses import dataclass

from autodb.agent.rows.machines import as_file, find_machine
from autodb.agent.sense.identifying import newest_model
from autodb.agent.sense.reconstructing import drive_model
from autodb.errors import UnusableInput
from autodb.files.machine import MachineFile
from autodb.nc.sweep import SweepStretch, SweepWay, sweep_program
from autodb.sensing.drives.reconstruct import DriveModel
from autodb.sensing.drives.sweep import REST_S, Design, candidates, shortest_sweep, speed_ladder
from autodb.store import Store
from autodb.wording import phrase

EFFORTS = ("current", "drive_force", "drive_torque")


@dataclass(frozen=True)
class PlannedSweep:
    """A sweep's program and what it is made of."""

    text: str
    design: Design


def machine_and_model(
    store: Store, machine: str, axis: str
) -> tuple[MachineFile, DriveModel | None]:
    """Return a machine's file and the newest model of an axis, None where there is none."""
    with store.reading() as session:
        owner = find_machine(session, machine)
        found = (newest_model(session, owner.id, f"{axis}.{effort}") for effort in EFFORTS)
        row = next((row for row in found if row is not None and row.errors is not None), None)
        return as_file(owner), drive_model(row) if row is not None else None


def plan_sweep(
    on: SweepStretch, model: DriveModel | None, *, within: float | None, longest_s: float
) -> Design:
    """Return the passes of a sweep; ``within`` is a share, and needs a model.

    Raises UnusableInput where there is none.
    """
    if within is None:
        passes = speed_ladder(on.low_mm, on.high_mm, fastest_mm_min=on.fastest_mm_min)
        return Design(passes, ())
    if model is None:
        raise UnusableInput(
            phrase(
                "--within: axis {axis} has no model yet; sweep it without --within, then run "
                "'autodb identify MOVES --machine NAME'",
                axis=on.axis,
            )
        )
    choices = candidates(on.low_mm, on.high_mm, fastest_mm_min=on.fastest_mm_min)
    return shortest_sweep(model, choices, within=within, longest_s=longest_s)


def program_of(
    found: Design,
    on: SweepStretch,
    machine: MachineFile,
    *,
    dialect: str,
    parked_mm: Mapping[str, float],
    source: str,
) -> PlannedSweep:
    """Return the NC program of a design. Raises UnusableInput as ``sweep_program``."""
    ways = [SweepWay(one.start_mm, one.end_mm, one.feed_mm_min, REST_S) for one in found.passes]
    text = sweep_program(
        ways, on, machine, dialect=dialect, parked_mm=parked_mm, source=source,
        name=f"sweep {on.axis}",
    )  # fmt: skip
    return PlannedSweep(text, found)
