"""A reference table: what P4's model, autodb and an oracle estimate of its cuts."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autodb.fitting.gaussian import NORMAL_95
from autodb.proofs.machines.mill.reference_ringing import draw_ringing, mill_ringing, tap_table
from autodb.proofs.machines.mill.reference_table import (
    AXIS_HZ,
    FIXED_KG,
    FORCE_HZ,
    REPEATS,
    TILTS_FIXED_DEG,
    WORK_KG,
    RecordedTable,
    TrueTable,
    draw_table,
    mill_on_table,
    record_tilted,
    turned_in_air,
)
from autodb.proofs.runs.mill.published_table import (
    AIR_HZ,
    CUT_HZ,
    RANGES_N,
    Model,
    between,
    envelope_errors,
    filtered,
    model,
    published_envelopes,
)
from autodb.proofs.runs.mill.table_oracle import (
    known_drift,
    known_force,
    mass_at_best,
    with_true_zeros,
)
from autodb.proofs.runs.mill.table_summary import (
    KNOWN,
    LAWS,
    LEFT_IN,
    OURS,
    PUBLISHED,
    WEIGHED,
    Judged,
    TableAir,
    TableDrift,
    TableGate,
    TableHeld,
    TableIdentified,
    TableMass,
    TableOff,
    TableRinging,
)
from autodb.records.tables import Recording
from autodb.sensing.table.engaged import engaged
from autodb.sensing.table.forces import table_forces
from autodb.sensing.table.identify import BareMoves, identify_table
from autodb.sensing.table.kinematics import Kinematics
from autodb.sensing.table.model import TableModel, table_motion
from autodb.sensing.table.resonance import NONE

Array = NDArray[np.float64]

TILTED = (1, 2)
"""Set-ups that are not upright."""
LONG = 8
"""Times that each pass is cut in a long cut."""


def run_table(seed: int) -> list[Judged]:
    """Tell the forces on a seed's table in every way."""
    table = draw_table(seed)
    alone = record_tilted(seed, table, added_kg=0.0)
    fixed = record_tilted(seed, table, added_kg=FIXED_KG, stops_deg=TILTS_FIXED_DEG)
    published = model(alone, fixed, FIXED_KG, table)
    loaded = record_tilted(seed, table, added_kg=WORK_KG)
    ours = identify_table([table_recording(loaded)], Kinematics(), cutoff_hz=AIR_HZ)
    cuts = [mill_on_table(seed, table, setup) for setup in TILTED]
    upright = [mill_on_table(seed, table, 0, repeat) for repeat in range(REPEATS)]
    return [
        *_gates(published, upright, cuts),
        *_cut(published, ours, table, cuts),
        *_airs(published, ours, table, turned_in_air(seed, table)),
        *_identified(ours, table),
        *_masses(published, ours, table, loaded, alone),
        *_ringing(seed, table, loaded),
        *_long_cut(seed, table, ours),
    ]


def table_recording(seen: RecordedTable) -> Recording:
    """Return what was recorded as a recording has it."""
    log = seen.log
    channels = {"t": log.t}
    for k, axis in enumerate("ac"):
        channels[f"{axis}.angle"] = log.angle[k]
        channels[f"{axis}.velocity"] = log.rate[k]
        channels[f"{axis}.acceleration"] = log.acceleration[k]
    channels |= {f"force.{axis}": seen.reading_N[k] for k, axis in enumerate("xyz")}
    return Recording(path=Path("table.csv"), channels=channels)


def _gates(
    published: Model, upright: Sequence[RecordedTable], cuts: Sequence[RecordedTable]
) -> Iterator[TableGate]:
    whole = upright[0].whole
    mean, repeats_N, _ = between([published.process_N(one) for one in upright], whole)
    errors = [repeats_N, *(envelope_errors(published.process_N(one), mean, whole) for one in cuts)]
    for setup, error in enumerate(errors):
        for envelope in range(2):
            for k in range(3):
                share = float(error[envelope, k]) / RANGES_N[k]
                yield TableGate(setup, envelope, k, share)


def _cut(
    published: Model, ours: TableModel, table: TrueTable, cuts: Sequence[RecordedTable]
) -> Iterator[TableOff | TableHeld]:
    for setup, seen in zip(TILTED, cuts, strict=True):
        true_N = filtered(seen.true_N, CUT_HZ, FORCE_HZ)
        seen_by_us = table_recording(seen)
        sensed = table_forces(ours, seen_by_us, engaged(seen_by_us), cutoff_hz=CUT_HZ)
        ways = {
            PUBLISHED: published.process_N(seen),
            OURS: sensed.force_N,
            KNOWN: known_force(table, seen),
        }
        for way, force_N in ways.items():
            errors = envelope_errors(force_N, published_envelopes(true_N), seen.whole)
            for envelope in range(2):
                for k in range(3):
                    yield TableOff(way, setup, envelope, k, float(errors[envelope, k]))
        half_N = NORMAL_95 * sensed.sd_N[:, seen.engaged]
        within = np.abs(sensed.force_N - true_N)[:, seen.engaged] <= half_N
        yield TableHeld(setup, float(within.mean()), float(np.median(half_N)))


def _airs(
    published: Model, ours: TableModel, table: TrueTable, seen: RecordedTable
) -> Iterator[TableAir]:
    read = filtered(seen.reading_N, AIR_HZ, AXIS_HZ)
    motion = table_motion(table_recording(seen), ours.kinematics, cutoff_hz=AIR_HZ)
    mine = ours.matrix @ ours.added_N(motion.columns()) + ours.zero_N[:, None]
    known = Model(*table.loaded(WORK_KG))
    ways = {
        PUBLISHED: published.added_N(seen.log),
        OURS: mine,
        KNOWN: table.matrix @ known.added_N(with_true_zeros(table, seen.log)),
    }
    for way, expected in ways.items():
        errors = np.abs(read - filtered(expected, AIR_HZ, AXIS_HZ)).mean(axis=1)
        for k in range(3):
            yield TableAir(way, k, float(errors[k] / np.ptp(read[k])))


def _masses(
    published: Model,
    ours: TableModel,
    table: TrueTable,
    loaded: RecordedTable,
    alone: RecordedTable,
) -> Iterator[TableMass]:
    """Tell the mass by rests with the work on the sensor, and by rests without it, too."""
    moves, bare = table_recording(loaded), BareMoves([table_recording(alone)], WORK_KG)
    weighed = identify_table([moves], Kinematics(), cutoff_hz=AIR_HZ, bare=bare)
    true_kg = table.loaded(WORK_KG)[0]
    ways_kg = {
        PUBLISHED: published.mass_kg,
        OURS: ours.mass_kg,
        LAWS: mass_at_best([(loaded, WORK_KG)]) + WORK_KG,
        OURS + WEIGHED: weighed.mass_kg,
        LAWS + WEIGHED: mass_at_best([(loaded, WORK_KG), (alone, 0.0)]) + WORK_KG,
    }
    for way, mass_kg in ways_kg.items():
        yield TableMass(way, abs(mass_kg / true_kg - 1.0))


def _ringing(seed: int, table: TrueTable, loaded: RecordedTable) -> Iterator[TableRinging]:
    """Tell the forces of a tilted cut on the same table with a dynamometer that rings."""
    ringing = draw_ringing(seed)
    taps = table_recording(tap_table(seed, table, ringing))
    model = identify_table([table_recording(loaded), taps], Kinematics(), cutoff_hz=AIR_HZ)
    seen = mill_ringing(seed, table, ringing, TILTED[0])
    true_N = filtered(seen.true_N, CUT_HZ, FORCE_HZ)
    recording = table_recording(seen)
    ways = {
        LEFT_IN: table_forces(
            replace(model, modes=NONE), recording, engaged(recording), cutoff_hz=CUT_HZ
        ).force_N,
        OURS: table_forces(model, recording, engaged(recording), cutoff_hz=CUT_HZ).force_N,
        KNOWN: known_force(table, seen, ringing),
    }
    for way, force_N in ways.items():
        off_N = np.sqrt(np.mean((force_N - true_N)[:, seen.whole] ** 2, axis=1))
        for k in range(3):
            yield TableRinging(way, k, float(off_N[k]))


def _long_cut(seed: int, table: TrueTable, ours: TableModel) -> Iterator[TableDrift]:
    """Tell the drift of z over the passes of P4's work, each LONG times."""
    seen = mill_ringing(seed, table, None, TILTED[0], times=LONG)
    true_N = np.linalg.solve(table.matrix, seen.heat_N)
    recording = table_recording(seen)
    heat = table_forces(ours, recording, engaged(recording), cutoff_hz=CUT_HZ).heat
    sensed = np.linalg.solve(table.matrix, filtered(seen.reading_N, CUT_HZ, FORCE_HZ))
    rest_N = sensed - Model(*table.loaded(WORK_KG)).added_N(with_true_zeros(table, seen.log))
    ways = {
        LEFT_IN: np.zeros_like(true_N),
        OURS: heat.drift_N,
        KNOWN: known_drift(table, seen, rest_N),
    }
    for way, drift_N in ways.items():
        off_N = float(np.sqrt(np.mean((drift_N - true_N)[2, seen.whole] ** 2)))
        yield TableDrift(way, off_N, len(heat.times_s) if way == OURS else 0)


def _identified(ours: TableModel, table: TrueTable) -> Iterator[TableIdentified]:
    mass_kg, lever_m = table.loaded(WORK_KG)
    yield TableIdentified("mass", mass_kg, ours.mass_kg, ours.mass_sd_kg)
    for k, axis in enumerate("xyz"):
        name = f"lever arm {axis}"
        yield TableIdentified(
            name, float(lever_m[k]), float(ours.lever_m[k]), float(ours.lever_sd_m[k])
        )
