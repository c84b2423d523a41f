"""How often the staged routine calls a smooth speed sticking, and agrees with the joint fit.

`python -m benchmarks.staged_axes alarms` (a few minutes): levels of axes that do not stick, 300 of
`tests.helpers.staged_axis` and the x and y axes of the reference machines of development; and up to
which speed their z axes, which do, are seen to. `python -m benchmarks.staged_axes agree` (ten
minutes): each quantity that differs by more than 2.6 joint standard deviations, on 24 axes of the
tests and the 15 axes of five reference machines. `python -m benchmarks.staged_axes linear 101 115`
(a minute an axis): the same of the linear drives x and y of reference mills of these seeds, by P0's
four steps; and by how many of their own standard deviations line and mass are off the truth.
`python -m benchmarks.staged_axes steps` (two minutes): the same of all that the four steps tell, on
40 axes of the tests each from one, two and three sweeps.
"""

import sys
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from autodb.agent.sense.staging import pole_of
from autodb.proofs.machines.axis.reference_axis import recorded_axis
from autodb.proofs.machines.axis.reference_moves import PITCH_MM
from autodb.proofs.machines.mill.reference_mill import MillAxis, draw_mill, swept_axis
from autodb.proofs.runs.axis.axis_ours import TERMS, axis_recording
from autodb.proofs.runs.mill import mill_ours
from autodb.proofs.runs.mill.mill_run import SCORED
from autodb.records.tables import Recording
from autodb.sensing.drives.feed_axis import identify
from autodb.sensing.drives.fit.axis_model import Identified
from autodb.sensing.drives.moves.passes import passes_of
from autodb.sensing.drives.moves.prepared import effort_axis, prepared
from autodb.sensing.drives.staged import agreement_linear
from autodb.sensing.drives.staged.agreement import screw_agreement
from autodb.sensing.drives.staged.compared import Agreement
from autodb.sensing.drives.staged.linear import FourSteps, four_steps
from autodb.sensing.drives.staged.routine import staged
from autodb.sensing.drives.staged.sticking import StickingVerdict, sticking
from tests.helpers import staged_axis

Array = NDArray[np.float64]

SEEDS = range(101, 141)
"""Machines of development: none of the proof's."""
PAIRED = range(101, 106)


def simple_axes(count: int) -> Iterator[Recording]:
    """Return sweeps of axes of the tests, with and without Stribeck friction and a ripple."""
    for seed in range(1000, 1000 + count):
        axis = staged_axis.Axis(stribeck=0.3 * (seed % 3), ripple=0.03 * (seed % 2))
        yield staged_axis.recorded(axis, seed, repeats=2 + seed % 2)


def reference_axes(seeds: range, names: str) -> Iterator[Recording]:
    """Return sweeps of axes of the reference machines."""
    for seed in seeds:
        for name in names:
            yield axis_recording(recorded_axis(seed, name).sweep, name)


def verdicts(moves: Recording) -> list[StickingVerdict]:
    """Judge the levels of a sweep."""
    axis = effort_axis(moves, None)
    inputs = {"t": moves.t_s, "position": moves[f"{axis}.position"]}
    found = sticking(passes_of(inputs), inputs, moves[f"{axis}.current"])
    return [one for one in found.values() if one.tested]


def alarms() -> None:
    """Print how many smooth levels are called sticking, and up to which speed z is."""
    for what, axes in (("axes of the tests", simple_axes(300)),
                       ("reference x and y", reference_axes(SEEDS, "xy"))):  # fmt: skip
        said = [one.sticks for moves in axes for one in verdicts(moves)]
        print(f"{what}: {sum(said)} of {len(said)} smooth levels are called sticking")
    fastest = [
        60.0 * max((one.speed_mm_s for one in verdicts(moves) if one.sticks), default=0.0)
        for moves in reference_axes(SEEDS, "z")
    ]
    print(f"reference z: sticking up to {min(fastest):.0f} to {max(fastest):.0f} mm/min")


def compared(moves: Recording, terms: tuple[str, ...]) -> Agreement:
    """Identify a sweep in both ways."""
    model = identify(moves, terms=terms)
    rows = prepared(moves)
    cold = any(term.term == "warmup" for term in model.fitted)
    return screw_agreement(staged(rows, pitch_mm=PITCH_MM, cold=cold), model, rows.inputs)


def agree() -> None:
    """Print how many quantities differ, and on how many axes the two agree."""
    simple = ("inertia", "viscous", "coulomb", "gravity", "stribeck", "position_friction")
    for what, axes, terms in (
        ("axes of the tests", (staged_axis.recorded(staged_axis.Axis(), s) for s in range(1, 25)),
         simple),
        ("reference axes", reference_axes(PAIRED, "xyz"), TERMS),
    ):  # fmt: skip
        report(what, [compared(moves, terms) for moves in axes])


def report(what: str, found: list[Agreement]) -> None:
    """Print how many axes agree, and what differs."""
    rows = [row for one in found for row in one.rows]
    others = [row for row in rows if not row.name.startswith("friction")]
    print(f"{what}: {sum(one.agrees for one in found)} of {len(found)} agree, "
          f"{sum(row.differs for row in rows)} of {len(rows)} quantities differ; "
          f"other than friction: {sum(row.differs for row in others)} of "
          f"{len(others)}")  # fmt: skip
    for row in (row for row in rows if row.differs):
        print(f"  {row.name}: staged {row.staged:.4g}, joint {row.joint:.4g} {row.unit}")


def stepped(seed: int, axis: MillAxis, model: Identified) -> tuple[Agreement, list[float]]:
    """Return how the four steps and the joint fit of a mill's axis agree, and by how many of their
    standard deviations the steps' slope and mass are off the truth.
    """
    rows = prepared(mill_ours.mill_recording(swept_axis(seed, axis), axis.name))
    found = four_steps(rows, pole_mm=pole_of(model), cold=False)
    scale, (slope, slope_sd) = axis.newtons_per_ampere, found.load.slope
    off = [(slope - axis.spring_N_mm / scale) / slope_sd]
    if found.inertia is not None:
        true = axis.moved_kg / 1000.0 / scale
        off.append((found.inertia.value - true) / found.inertia.sd)
    return agreement_linear.linear_agreement(found, model, rows.inputs), off


def linear(first: int, last: int) -> None:
    """Print the same of the linear drives of reference mills."""
    found = []
    for seed in range(first, last + 1):
        mill = draw_mill(seed)
        for name in SCORED:
            both, off = stepped(seed, mill[name], mill_ours.identified_mill_axis(seed, mill[name]))
            print(f"{seed} {name}: {len(both.differing)} of {len(both.rows)} differ; slope and "
                  f"mass off the truth by {off[0]:+.1f}, {off[1]:+.1f} sd", flush=True)  # fmt: skip
            found.append(both)
    report("linear drives of reference mills", found)


STEPPED = staged_axis.Axis(stiffness=0.004, cogging=0.1, slope=0.0, ripple=0.0)
PROBED_MM_S = (1.0, 4.0, 30.0, 120.0)


def steps() -> None:
    """Print how far the four steps are off the truth, in standard deviations: rms and worst."""
    for repeats in (1, 2, 3):
        off: dict[str, list[float]] = {}
        for seed in range(500, 540):
            moves = staged_axis.recorded(STEPPED, seed, repeats=repeats)
            found = four_steps(prepared(moves), pole_mm=staged_axis.POLE_MM, cold=False)
            for name, values in deviations(found).items():
                off.setdefault(name, []).extend(values.tolist())
        said = (
            f"{name} {np.sqrt(np.mean(np.square(z))):.2f}, worst {np.abs(z).max():.1f} of {len(z)}"
            for name, z in off.items()
        )
        print(f"{repeats} sweeps: {'; '.join(said)}")


def deviations(found: FourSteps) -> dict[str, Array]:
    """Return by how many standard deviations the steps are off the truth of STEPPED."""
    (slope, slope_sd), (rest, rest_sd) = found.load.slope, found.load.rest
    nodes, nodes_sd = found.load.table
    place = staged_axis.POLE_MM * np.arange(len(nodes)) / len(nodes)
    rest_mm = staged_axis.MIDDLE_MM - STEPPED.weight / STEPPED.stiffness
    speed = np.array(PROBED_MM_S)
    true = STEPPED.size(np.full(len(speed), staged_axis.MIDDLE_MM), speed)
    sizes = [found.friction(speed, sense) for sense in (1, -1)]
    made = {
        "slope": np.array([(slope - STEPPED.stiffness) / slope_sd]),
        "rest": np.array([(rest - rest_mm) / rest_sd]),
        "nodes": (nodes - STEPPED.cogging * staged_axis.pole_shape(place)) / nodes_sd,
        "friction": np.concatenate([(size - true) / sd for size, sd in sizes]),
    }
    if found.inertia is not None:
        made["inertia"] = np.array([(found.inertia.value - STEPPED.inertia) / found.inertia.sd])
    return made


COMMANDS: dict[str, Callable[..., None]] = {
    "alarms": alarms,
    "agree": agree,
    "linear": linear,
    "steps": steps,
}

if __name__ == "__main__":
    COMMANDS[sys.argv[1]](*map(int, sys.argv[2:]))
